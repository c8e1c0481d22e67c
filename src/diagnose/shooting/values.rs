//! A fit in one line.

use super::clock_skew::skews_of;
use crate::fit::problem::Problem;
use crate::fit::solve::point::Point;

/// Where a fit stands, for the log.
pub(crate) struct Values<'a>(pub &'a Problem, pub &'a Point);

impl std::fmt::Debug for Values<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(problem, point) = self;
        let values = problem.space.values(&point.x);
        for (entry, value) in problem.space.entries.iter().zip(values) {
            write!(f, "{} {value:.4e}, ", entry.id)?;
        }
        for skew in skews_of(problem, point) {
            write!(f, "{:.1} us, ", skew * 1e6)?;
        }
        let used = point.used.iter().filter(|used| **used).count();
        write!(f, "{used} of {} stretches", point.segments.len())
    }
}
