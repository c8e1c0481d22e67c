//! Turning points: instants at which a falling mass turns within a sample, without a level of the
//! ground that is known beforehand.
//!
//! A mass that bounces and never rests shows the ground by these alone. Each is where the parabolas
//! before and after it meet; the ground is the height at which most of them do.

use super::impact::{Impact, kinks, sharp_turns};
use crate::recording::grid::TimeAxis;
use crate::recording::median_in_place;

/// A turn leaves the ground with at least this speed [its standard errors]: else the mass may stay.
const MIN_FLIP_ERRORS: f64 = 3.0;
/// Largest share of the samples below the ground.
const MAX_SHARE_BELOW: f64 = 2e-3;
/// Readings this far below the ground are no noise [standard deviations].
const BELOW_SIGMAS: f64 = 5.0;

/// A ground found from turning points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnLevel {
    /// Its level \[m\].
    pub level: f64,
    /// Median distance of the turns from it \[m\].
    pub scatter: f64,
    /// How many turns are there.
    pub turns: usize,
}

/// Sudden turns of `xp` \[m\], whose noise has a standard deviation of `noise` \[m\], in order of time. A
/// turn counts if the motion is a parabola for some samples on either side.
///
/// # Examples
/// ```
/// use impactscope::recording::TimeAxis;
/// use impactscope::recording::events::turning_points::turning_points;
///
/// // A ball falls onto a ground at 0 with 2 m/s after 0.1 s and leaves it with 1.4 m/s.
/// let fall = |v: f64, t: f64| v * t - 4.9 * t * t;
/// let xp: Vec<f64> = (0..60)
///     .map(|i| 5e-3 * f64::from(i) - 0.1013)
///     .map(|t| if t < 0.0 { fall(-2.0, t) } else { fall(1.4, t) })
///     .collect();
/// let time = TimeAxis::Uniform { t0: 0.0, dt: 5e-3 };
/// let turns = turning_points(time, &xp, 1e-6);
/// assert_eq!(turns.len(), 1);
/// assert!(turns[0].height.abs() < 1e-6);
/// assert!((turns[0].v_after / turns[0].v_before + 0.7).abs() < 1e-4);
/// ```
#[must_use]
pub fn turning_points(time: TimeAxis, xp: &[f64], noise: f64) -> Vec<Impact> {
    if xp.len() < 3 || !time.covers(xp.len()) {
        return Vec::new();
    }
    let interval = time.interval(xp.len());
    let last = xp.len() - 1;
    let all = kinks(time, xp, noise, interval, (0, last));
    let turns = sharp_turns(time, xp, (noise, interval), &all, (0, last));
    let flips = |turn: &Impact| turn.v_after > MIN_FLIP_ERRORS * turn.v_error;
    let all = turns.into_iter().map(|(_, turn)| turn);
    all.filter(flips).collect()
}

/// The level at which most of the sudden turns are, if at least two are and nothing is below it.
#[must_use]
pub fn level_of_turns(time: TimeAxis, xp: &[f64], noise: f64) -> Option<TurnLevel> {
    let turns = turning_points(time, xp, noise);
    let interval = time.interval(xp.len());
    let reach = |turn: &Impact| BELOW_SIGMAS * noise + turn.height_blur(interval);
    let with = |one: &Impact| -> Vec<&Impact> {
        let near =
            |other: &&Impact| (other.height - one.height).abs() <= reach(one).max(reach(other));
        turns.iter().filter(near).collect()
    };
    let most = turns.iter().map(with).max_by_key(Vec::len)?;
    if most.len() < 2 {
        return None;
    }
    let mut heights: Vec<f64> = most.iter().map(|turn| turn.height).collect();
    let level = median_in_place(&mut heights);
    let mut off: Vec<f64> = heights
        .iter()
        .map(|height| (height - level).abs())
        .collect();
    let scatter = median_in_place(&mut off);
    let slack = most.iter().map(|turn| reach(turn)).fold(0.0, f64::max);
    let below = xp.iter().filter(|x| **x < level - slack).count();
    (below as f64 <= MAX_SHARE_BELOW * xp.len() as f64).then_some(TurnLevel {
        level,
        scatter,
        turns: most.len(),
    })
}

#[cfg(test)]
#[path = "turning_points_tests.rs"]
mod tests;
