//! Contacts and impacts as the data show them, without a model.
//!
//! The mass *visits* the ground while it is no more than a hop (5 um) above the
//! contact level; hops below that do not end a visit. Within a visit it *touches*
//! where it is at the level to within the noise, or where straight lines through the
//! samples before and after a kink meet there (an impact between two samples).

pub mod events_csv;
pub(super) mod impact;
mod options;
mod parabola;
pub mod turning_points;

pub use self::impact::Impact;
pub use self::options::{EventOptions, HOP_HEIGHT, hop_height};

use rayon::prelude::*;

use self::impact::find_impacts;
use super::grid::TimeAxis;

/// A stay on the ground, small hops included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// First touch \[s\].
    pub start: f64,
    /// Last touch \[s\]; equal to `start` for a touch shorter than a sample.
    pub end: f64,
    /// Time of it on the ground, without the hops \[s\].
    pub touching: f64,
    /// Whether the recording (or a gap) cuts the contact, so that it may be longer.
    pub cut: bool,
}

impl Contact {
    /// `end - start` \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.end - self.start
    }
}

/// What happens at the ground.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Events {
    /// Contacts in order of time; between two of them the mass was higher than a hop.
    pub contacts: Vec<Contact>,
    /// Impacts in order of time.
    pub impacts: Vec<Impact>,
}

/// Finds contacts and impacts in `xp` \[m\] sampled at `time`. Missing samples and
/// gaps end a contact and mark it as cut. Empty results are no error: the mass may
/// never touch.
///
/// # Examples
/// ```
/// use impactscope::recording::TimeAxis;
/// use impactscope::recording::events::{EventOptions, HOP_HEIGHT, find_events};
///
/// // It falls from 20 um, bounces at 5 ms with half the speed, and never comes back.
/// let xp: Vec<f64> = (0..500)
///     .map(|i| 2e-5 * f64::from(i))
///     .map(|t| if t < 5e-3 { 4e-3 * (5e-3 - t) } else { 2e-3 * (t - 5e-3) })
///     .collect();
/// let time = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
/// let options = EventOptions { contact_level: 0.0, noise: 1e-9, hop: HOP_HEIGHT };
/// let events = find_events(time, &xp, &options);
/// assert_eq!(events.impacts.len(), 1);
/// assert!((events.impacts[0].v_after - 2e-3).abs() < 1e-6);
/// ```
#[must_use]
pub fn find_events(time: TimeAxis, xp: &[f64], options: &EventOptions) -> Events {
    let mut events = Events::default();
    if !time.covers(xp.len()) || !options.contact_level.is_finite() {
        return events;
    }
    // Taken once: the median over a long axis is not for each visit.
    let interval = time.interval(xp.len());
    let visits = visits(time, xp, options);
    let read = |(i, visit): (usize, &Visit)| {
        let limits = (
            i.checked_sub(1).map_or(0, |p| visits[p].last),
            visits.get(i + 1).map_or(xp.len() - 1, |v| v.first),
        );
        let impacts = find_impacts(
            (time, interval),
            xp,
            options,
            (visit.first, visit.last),
            limits,
        );
        let contact = contact_of(time, xp, options, visit, &impacts);
        (impacts, contact)
    };
    let all: Vec<_> = if visits.len() < MIN_PARALLEL_VISITS {
        visits.iter().enumerate().map(read).collect()
    } else {
        visits.par_iter().enumerate().map(read).collect()
    };
    for (impacts, contact) in all {
        events.impacts.extend(impacts);
        events.contacts.extend(contact);
    }
    events
}

/// Visits to the ground from which on they are read by several threads: some milliseconds of work.
const MIN_PARALLEL_VISITS: usize = 200;

/// Samples `first..=last` within a hop of the ground.
#[derive(Debug, Clone, Copy)]
struct Visit {
    first: usize,
    last: usize,
    cut: bool,
}

fn visits(time: TimeAxis, xp: &[f64], options: &EventOptions) -> Vec<Visit> {
    // Two thresholds, so that noise at the edge does not make a departure.
    let enter = options.contact_level + options.clear_hop();
    let leave = enter + 2.0 * options.noise;
    let gap = super::assemble::GAP_FACTOR * time.interval(xp.len());
    let mut found: Vec<Visit> = Vec::new();
    let mut open: Option<Visit> = None;
    for (i, &x) in xp.iter().enumerate() {
        let broken = !x.is_finite() || (i > 0 && time.at(i) - time.at(i - 1) > gap);
        if broken && let Some(visit) = open.take() {
            found.push(Visit { cut: true, ..visit });
        }
        if !x.is_finite() {
            continue;
        }
        match &mut open {
            Some(visit) if x <= leave => visit.last = i,
            Some(visit) => {
                found.push(*visit);
                open = None;
            }
            None if x <= enter => {
                open = Some(Visit {
                    first: i,
                    last: i,
                    cut: i == 0 || broken || !xp[i - 1].is_finite(),
                });
            }
            None => {}
        }
    }
    if let Some(visit) = open {
        found.push(Visit { cut: true, ..visit });
    }
    found
}

/// First to last touch of a visit; `None` if the mass turned above the ground.
fn contact_of(
    time: TimeAxis,
    xp: &[f64],
    options: &EventOptions,
    visit: &Visit,
    impacts: &[Impact],
) -> Option<Contact> {
    let touch = options.contact_level + options.tolerance();
    let low = |i: &usize| xp[*i] <= touch;
    let first = (visit.first..=visit.last).find(low);
    let last = (visit.first..=visit.last).rev().find(low);
    // Where the straight line between two samples crosses the touching height.
    let crossing = |i: usize, j: usize| {
        let (t_i, t_j) = (time.at(i), time.at(j));
        let share = (touch - xp[i]) / (xp[j] - xp[i]);
        if share.is_finite() {
            t_i + (t_j - t_i) * share.clamp(0.0, 1.0)
        } else {
            t_i
        }
    };
    let (mut start, mut end) = match (first, last) {
        (Some(first), Some(last)) => (
            if first > visit.first {
                crossing(first - 1, first)
            } else {
                time.at(first)
            },
            if last < visit.last {
                crossing(last, last + 1)
            } else {
                time.at(last)
            },
        ),
        // Only between samples.
        _ => (impacts.first()?.time, impacts.last()?.time),
    };
    if let (Some(a), Some(b)) = (impacts.first(), impacts.last()) {
        start = start.min(a.time);
        end = end.max(b.time);
    }
    // The visit may begin at the very sample that touches: the fall took one sample.
    let cut = visit.cut
        && (first.is_some_and(|i| i == visit.first) || last.is_some_and(|i| i == visit.last));
    let aloft = time_above(time, xp, touch, (visit.first, visit.last), (start, end));
    Some(Contact {
        start,
        end,
        touching: (end - start - aloft).max(0.0),
        cut,
    })
}

/// Time between `start` and `end` \[s\] in which straight lines through samples
/// `first..=last` lie above `touch`.
fn time_above(
    time: TimeAxis,
    xp: &[f64],
    touch: f64,
    (first, last): (usize, usize),
    (start, end): (f64, f64),
) -> f64 {
    let mut sum = 0.0;
    for i in first..last {
        let (from, to) = (time.at(i).max(start), time.at(i + 1).min(end));
        if to <= from {
            continue;
        }
        let (a, b) = (xp[i] - touch, xp[i + 1] - touch);
        let share = if a > 0.0 && b > 0.0 {
            1.0
        } else if a <= 0.0 && b <= 0.0 {
            0.0
        } else {
            a.max(b) / (a.max(b) - a.min(b))
        };
        sum += share * (to - from);
    }
    sum
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
