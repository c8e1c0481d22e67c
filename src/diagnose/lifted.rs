//! Recordings whose ground, as it was read, lies higher than that of the others: the mass may have
//! come to rest over it without touching it. Each recording has a zero of its own, so that a wrong
//! level hides in that, and only the flights before and after tell.

use super::bench::Fitted;
use super::explain::Stand;
use super::scan::{Linear, Scan};
use super::search::{BEFORE, always, promise_of};
use crate::sim::SimError;

/// Fall of chi2 by a higher ground in one recording from which it lies higher.
const HIGHER: f64 = 40.0;

/// Those of either side of `stand`.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn lifted(stand: &Stand) -> Result<(Vec<usize>, Vec<usize>), SimError> {
    let held_out = stand.held_out.as_ref();
    Ok((
        of(&stand.train, 0)?,
        held_out.map_or(Ok(Vec::new()), |fitted| {
            of(fitted, fitted.problem.space.len())
        })?,
    ))
}

/// Those of a fit, of which the first `locked` unknowns stay as they are.
fn of(fitted: &Fitted, locked: usize) -> Result<Vec<usize>, SimError> {
    let segments = &fitted.point.segments;
    let stays = |k: usize| {
        let own = segments.iter().zip(&fitted.point.used);
        own.filter(|(s, used)| **used && s.starts_held && s.recording == k)
            .count()
    };
    let mut asked: Vec<usize> = (0..fitted.problem.data.len()).collect();
    asked.retain(|k| stays(*k) >= BEFORE);
    if asked.is_empty() {
        return Ok(asked);
    }
    let linear = Linear::new(fitted)?;
    let products = linear.products(&fitted.model, &[always()])?;
    let Some(base) = Scan::gather(&linear, &products, 1).base_without(locked) else {
        return Ok(Vec::new());
    };
    let n = linear.problem().unknowns();
    asked.retain(|&k| {
        let own = products.iter().filter(|p| {
            let segment = &segments[p.segment];
            segment.starts_held && segment.recording == k
        });
        let promise = promise_of(&base, n, own);
        promise.is_some_and(|p| p.theta > 0.0 && p.gain > HIGHER)
    });
    Ok(asked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::made::{QUIET, bench, parts_of, stepping};

    #[test]
    fn the_recording_with_a_higher_ground_is_found() {
        let drives = [("square:40Hz:8V", 0.1), ("square:15Hz:8V", 0.2)];
        let last = [("sine:50Hz:8V", 0.1)];
        let higher = |by: f64| {
            let parts_on = |by: f64, drives: &[(&str, f64)]| {
                parts_of(&stepping(by, -1e9), drives, 25e3, 150e-9)
            };
            let parts = [parts_on(0.0, &drives), parts_on(by, &last)].concat();
            let plain = stepping(0.0, -1e9);
            of(&bench(&parts).baseline(&plain, &QUIET).unwrap(), 0).unwrap()
        };
        assert!(higher(0.0).is_empty());
        assert_eq!(higher(0.25e-6), [2]);
    }
}
