//! Bounces as readings of a contact law: which of them are used, and their errors.

use super::robust_curve::Reading;
use crate::diagnose::thresholds::{
    BOUNCE_MAX_Z, BOUNCE_MIN_SPEED_SHARE, LANDING_MAX_RATIO_SHARE, RATIO_MAX_ERROR_SHARE,
    REBOUND_MIN_Z,
};
use crate::fit::contact_readings::Bounce;
use crate::recording::quantile_in_place;

/// Longest time of a bounce on a rigid ground \[s\].
const RIGID_BOUNCE_TIME: f64 = 1.5e-6;

/// Samples of flight after a bounce that determine the velocity.
const MIN_FLIGHT_SAMPLES: f64 = 4.0;

/// Standard error of the level of the ground as known from the stays on it \[m\].
pub(crate) const LEVEL_ERROR: f64 = 1e-7;

/// (speed, ratio, error) of the bounces that are used. A mass that lands, or hops too low to be seen,
/// reads as one that hardly leaves the ground, with an error that does not account for that: a ratio
/// far below the `usual` one is such. Bounces whose error is too large to distinguish the two are not
/// used. Nor are those that touch and leave at two instants, or fly on for a few samples only: an
/// event in them was misread.
pub(crate) fn ratios(bounces: &[Bounce], usual: f64) -> Vec<Reading> {
    let usable =
        |b: &Reading| b.2 < RATIO_MAX_ERROR_SHARE * usual && b.1 > LANDING_MAX_RATIO_SHARE * usual;
    read(bounces).into_iter().filter(usable).collect()
}

/// The usual ratio of bounces on both sides, the median of those that leave the ground; not a number
/// if none does. Landings, the majority under a drive of many periods, hardly leave it. They are
/// dropped as far below the median in which each bounce is weighted by its significance.
pub(crate) fn usual(sides: [&[Bounce]; 2]) -> f64 {
    let all = sides.into_iter().flat_map(read);
    let mut leave: Vec<Reading> = all.filter(|b| b.1 > REBOUND_MIN_Z * b.2).collect();
    leave.sort_by(|a, b| a.1.total_cmp(&b.1));
    let significance = |b: &Reading| b.1 / b.2;
    let half = 0.5 * leave.iter().map(significance).sum::<f64>();
    let mut below = 0.0;
    let middle = leave.iter().find(|b| {
        below += significance(b);
        below >= half
    });
    let least = LANDING_MAX_RATIO_SHARE * middle.map_or(0.0, |b| b.1);
    let mut bounces: Vec<f64> = leave.iter().map(|b| b.1).filter(|r| *r > least).collect();
    quantile_in_place(&mut bounces, 0.5)
}

/// (speed, ratio, error) of bounces in which no event was misread.
fn read(bounces: &[Bounce]) -> Vec<Reading> {
    let fastest = bounces.iter().fold(0.0f64, |a, b| a.max(b.approach));
    let quick = bounces
        .iter()
        .filter(|b| b.approach > BOUNCE_MIN_SPEED_SHARE * fastest);
    quick
        .filter(|b| b.flight > MIN_FLIGHT_SAMPLES)
        .filter_map(|b| {
            let level = level(bounces, b.recording);
            let off = (b.miss - level.0).powi(2);
            let once = off < BOUNCE_MAX_Z.powi(2) * (b.off_by(RIGID_BOUNCE_TIME) + level.1);
            let (ratio, error) = at_once(bounces, b);
            once.then_some((b.approach, ratio, error))
        })
        .filter(|b| b.1 < 1.5)
        .collect()
}

/// Height of a recording's ground above the model's level \[m\] by its own bounces, and its variance:
/// an offset that all of them share must not pass for a dependence on speed.
fn level(bounces: &[Bounce], recording: usize) -> (f64, f64) {
    let before = LEVEL_ERROR.powi(2);
    let (mut sum, mut weight) = (0.0, 1.0 / before);
    for b in bounces.iter().filter(|b| b.recording == recording) {
        let variance = b.off_by(RIGID_BOUNCE_TIME);
        if b.miss.powi(2) < BOUNCE_MAX_Z.powi(2) * (variance + before) {
            sum += b.miss / variance;
            weight += 1.0 / variance;
        }
    }
    (sum / weight, 1.0 / weight)
}

/// Ratio and standard error of `bounce`, one of `bounces`, on a rigid ground.
pub(crate) fn at_once(bounces: &[Bounce], bounce: &Bounce) -> (f64, f64) {
    bounce.at_once(RIGID_BOUNCE_TIME, level(bounces, bounce.recording))
}

/// (speed, height, error) of the bounces that show how long the mass stays below the level. A mass
/// that hardly leaves the ground has landed in hops too low to be seen, which take time.
pub(crate) fn misses(bounces: &[Bounce]) -> Vec<Reading> {
    let fast = bounces.iter().fold(0.0f64, |a, b| a.max(b.approach));
    let usable = bounces
        .iter()
        .filter(|b| b.approach > BOUNCE_MIN_SPEED_SHARE * fast && b.miss_error.is_finite())
        .filter(|b| b.ratio > REBOUND_MIN_Z * b.error && b.flight > MIN_FLIGHT_SAMPLES);
    usable
        .map(|b| (b.approach, b.miss, b.miss_error.hypot(2e-9)))
        .collect()
}
