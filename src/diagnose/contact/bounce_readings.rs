//! What bounces tell of the laws of the ground: which of them, and how well each is known.

use super::robust_curve::Reading;
use crate::diagnose::thresholds::{
    BOUNCE_MAX_Z, BOUNCE_MIN_SPEED_SHARE, LANDING_MAX_RATIO_SHARE, RATIO_MAX_ERROR_SHARE,
    REBOUND_MIN_Z,
};
use crate::fit::contact_readings::Bounce;
use crate::recording::quantile_in_place;

/// Time that a bounce may take on a hard ground \[s\].
const AT_ONCE: f64 = 1.5e-6;

/// Samples for which a mass must fly on for its velocity to be known.
const FLIGHT: f64 = 4.0;

/// How well the level of the ground is known from the stays on it \[m\].
pub(crate) const LEVEL: f64 = 1e-7;

/// (speed, ratio, error) of the bounces that tell the law. A mass that lands, or hops too
/// low to be seen, reads as one that hardly leaves the ground, with an error that knows
/// nothing of that: what is far below the `usual` ratio is such; and bounces that are known too
/// badly to tell the two apart say nothing.
/// Nor do those that come and leave at two instants, or hop for a few samples only: in them an
/// event was misread.
pub(crate) fn ratios(bounces: &[Bounce], usual: f64) -> Vec<Reading> {
    let telling =
        |b: &Reading| b.2 < RATIO_MAX_ERROR_SHARE * usual && b.1 > LANDING_MAX_RATIO_SHARE * usual;
    read(bounces).into_iter().filter(telling).collect()
}

/// The usual ratio of bounces on both sides, not a number if none leaves the ground: the median
/// of those that leave it. Landings, of which a drive of many periods may have most, hardly do,
/// and are none of them: they lie far below the median in which each counts by how surely it
/// leaves.
pub(crate) fn usual(sides: [&[Bounce]; 2]) -> f64 {
    let all = sides.into_iter().flat_map(read);
    let mut leave: Vec<Reading> = all.filter(|b| b.1 > REBOUND_MIN_Z * b.2).collect();
    leave.sort_by(|a, b| a.1.total_cmp(&b.1));
    let surely = |b: &Reading| b.1 / b.2;
    let half = 0.5 * leave.iter().map(surely).sum::<f64>();
    let mut below = 0.0;
    let middle = leave.iter().find(|b| {
        below += surely(b);
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
        .filter(|b| b.flight > FLIGHT)
        .filter_map(|b| {
            let level = level(bounces, b.recording);
            let off = (b.miss - level.0).powi(2);
            let once = off < BOUNCE_MAX_Z.powi(2) * (b.off_by(AT_ONCE) + level.1);
            let (ratio, error) = at_once(bounces, b);
            once.then_some((b.approach, ratio, error))
        })
        .filter(|b| b.1 < 1.5)
        .collect()
}

/// How far the ground of a recording lies beside the model's level \[m\], as its own bounces tell
/// it, and the variance of that: what all of them share must not pass for a law of speed.
fn level(bounces: &[Bounce], recording: usize) -> (f64, f64) {
    let before = LEVEL.powi(2);
    let (mut sum, mut weight) = (0.0, 1.0 / before);
    for b in bounces.iter().filter(|b| b.recording == recording) {
        let variance = b.off_by(AT_ONCE);
        if b.miss.powi(2) < BOUNCE_MAX_Z.powi(2) * (variance + before) {
            sum += b.miss / variance;
            weight += 1.0 / variance;
        }
    }
    (sum / weight, 1.0 / weight)
}

/// Ratio and standard error of `bounce`, one of `bounces`, on a hard ground.
pub(crate) fn at_once(bounces: &[Bounce], bounce: &Bounce) -> (f64, f64) {
    bounce.at_once(AT_ONCE, level(bounces, bounce.recording))
}

/// (speed, height, error) of the bounces that tell how long the mass stays below the level. A
/// mass that hardly leaves the ground has landed in hops too low to be seen: they take time.
pub(crate) fn misses(bounces: &[Bounce]) -> Vec<Reading> {
    let fast = bounces.iter().fold(0.0f64, |a, b| a.max(b.approach));
    let telling = bounces
        .iter()
        .filter(|b| b.approach > BOUNCE_MIN_SPEED_SHARE * fast && b.miss_error.is_finite())
        .filter(|b| b.ratio > REBOUND_MIN_Z * b.error && b.flight > FLIGHT);
    telling
        .map(|b| (b.approach, b.miss, b.miss_error.hypot(2e-9)))
        .collect()
}
