//! Impacts: kinks of the sampled position, timed between samples, with the speeds on
//! both sides.
//!
//! Each side is fitted by a polynomial of its own samples only; the impact is where
//! the two meet. The polynomial is as high as the noise allows, for the second mode
//! of the device (6.4 kHz) goes through half a cycle within the window.

use std::ops::RangeInclusive;

use nalgebra::{DMatrix, DVector};

use super::options::EventOptions;
use super::parabola::{Meeting, Parabola, turn_between};
use crate::recording::grid::TimeAxis;

/// Time on each side of an impact from which the speeds are fitted \[s\].
const FIT_SPAN: f64 = 1e-4;
/// Intervals longer than this share of that span are too long for it to show how the mass moves:
/// there the sides are parabolas, as long as the motion is one.
const COARSE_SHARE: f64 = 0.5;
/// Fewest and most samples on each side.
const FIT_SAMPLES: (usize, usize) = (3, 50);
/// Highest degree of a side's polynomial.
const MAX_DEGREE: usize = 4;
/// Degrees above one must leave the velocity certain to this share.
const MAX_SLOPE_ERROR: f64 = 0.03;
/// A side whose samples lie farther from its polynomial than this needs a higher degree [standard
/// deviations of the noise].
const MAX_MISS_SIGMAS: f64 = 4.0;
/// Samples for each coefficient of that degree: fewer would be followed one by one.
const SAMPLES_PER_COEFFICIENT: usize = 2;
/// The slope must differ by so much for that [its standard deviations].
const MIN_BEND_SIGMAS: f64 = 6.0;
/// The mass turns no farther below its lowest samples than this many times the way from one sample to
/// the next.
const MAX_DIP_WAYS: f64 = 2.0;
/// A change of speed below this share of the arriving speed is no impact.
const MIN_CHANGE_SHARE: f64 = 0.3;
/// How uncertain the height is at which two sides meet, as a share of the way from one sample to the
/// next.
const MEETING_SHARE: f64 = 0.2;
/// Departures faster than this share of the arrival are thrown, not bounced.
const MAX_RESTITUTION: f64 = 1.2;

/// A sudden change of speed at the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// When \[s\], between samples.
    pub time: f64,
    /// Speed just before \[m/s\], negative (downwards).
    pub v_before: f64,
    /// Speed just after \[m/s\]; near zero if the mass stays.
    pub v_after: f64,
    /// By how much the speeds are uncertain \[m/s\]: from the noise, and from what one
    /// degree less of the fits would change. Ringing faster than the samples resolve
    /// is not in it.
    pub v_error: f64,
    /// Height at which both sides meet \[m\].
    pub height: f64,
}

impl Impact {
    /// The turn at which two parabolas of origin `t` \[s\] meet.
    fn of_parabolas(t: f64, Meeting { at, before, after }: &Meeting) -> Self {
        let at = *at;
        Self {
            time: t + at,
            v_before: before.slope(at),
            v_after: after.slope(at),
            v_error: before.slope_error(at).max(after.slope_error(at)),
            height: 0.5 * (before.value(at) + after.value(at)),
        }
    }

    /// Whether it is a sudden turn at the ground: down before, up or at rest after, no faster than
    /// it came.
    fn is_sudden(&self, blur: f64) -> bool {
        let change = self.v_after - self.v_before;
        let sudden = change > (MIN_CHANGE_SHARE * self.v_before.abs()).max(3.0 * blur);
        // Nothing leaves the ground faster than it came: that would be a push.
        let thrown = self.v_after > MAX_RESTITUTION * self.v_before.abs() + 2.0 * blur;
        self.v_before < -blur && sudden && !thrown
    }

    /// How far from the ground the sides may meet that are `interval` \[s\] from sample to sample: a
    /// share of the way of a sample \[m\].
    pub(super) fn height_blur(&self, interval: f64) -> f64 {
        MEETING_SHARE * (self.v_after - self.v_before).abs() * interval
    }

    /// Whether the sides meet at the ground. A ring above the ground turns as sharply, but higher.
    fn is_near(&self, options: &EventOptions, interval: f64) -> bool {
        let slack = options.tolerance() + self.height_blur(interval);
        (self.height - options.contact_level).abs() <= slack.min(options.clear_hop())
    }
}

/// Impacts among samples `first..=last`, which are near the ground. `limits`: the
/// last sample of the stay before and the first of the next, which no fit may cross. The
/// times come with their median `interval` \[s\].
pub(crate) fn find_impacts(
    (time, interval): (TimeAxis, f64),
    xp: &[f64],
    options: &EventOptions,
    (first, last): (usize, usize),
    limits: (usize, usize),
) -> Vec<Impact> {
    let candidates = kinks(time, xp, options.noise, interval, (first, last));
    let reach = ((FIT_SPAN / interval).round() as usize).clamp(FIT_SAMPLES.0, FIT_SAMPLES.1);
    let fits = |k: usize, i: usize, sides: Sides| {
        // A fit stays on its own side of the neighbouring kinks.
        let from = k.checked_sub(1).map_or(limits.0, |p| candidates[p] + 1);
        let to = candidates.get(k + 1).map_or(limits.1, |next| next - 1);
        let from = from.min(i - 1).max((i - 1).saturating_sub(reach - 1));
        let to = to.max(i + 1).min(i + reach).min(xp.len() - 1);
        let meet = |left, right| meet(time, xp, (options.noise, sides), i, left, right);
        meet(from..=i - 1, i + 1..=to)
            // The sample in the middle belongs to one of the sides.
            .and_then(|(at, before, after)| match at {
                _ if at > 0.1 * interval => meet(from + 1..=i, i + 1..=to),
                _ if at < -0.1 * interval => meet(from..=i - 1, i..=to - 1),
                _ => Some((at, before, after)),
            })
            .filter(|(at, before, _)| is_within_reach(xp, i, before.value(*at)))
            .and_then(|(at, before, after)| {
                judge(options, interval, time.at(i), at, &before, &after)
            })
    };
    let turns = if interval > COARSE_SHARE * FIT_SPAN {
        let mut turns = sharp_turns(time, xp, (options.noise, interval), &candidates, limits);
        turns.retain(|(_, turn)| turn.is_near(options, interval));
        turns
    } else {
        Vec::new()
    };
    candidates
        .iter()
        .enumerate()
        .filter_map(|(k, &i)| {
            // Other kinks so close to a turn between parabolas are a part of it.
            let close = |(at, _): &&(usize, Impact)| at.abs_diff(i) < Parabola::MIN_SAMPLES;
            match turns.iter().find(close) {
                Some((at, turn)) => (*at == i).then_some(*turn),
                None => fits(k, i, Sides::Certain).or_else(|| fits(k, i, Sides::Bent)),
            }
        })
        .collect()
}

/// The sudden turns between parabolas among `kinks`, each with its sample. `limits`: the first and the
/// last sample that may belong to a side, or is next to one.
pub(super) fn sharp_turns(
    time: TimeAxis,
    xp: &[f64],
    (noise, interval): (f64, f64),
    kinks: &[usize],
    limits: (usize, usize),
) -> Vec<(usize, Impact)> {
    let kinks = strongest(time, xp, kinks);
    let turn = |(k, &i): (usize, &usize)| {
        // The samples next to another kink or stay may be in the midst of that.
        let from = k.checked_sub(1).map_or(limits.0, |p| kinks[p]) + 2;
        let next = kinks.get(k + 1).map_or(limits.1, |next| *next);
        let meeting = turn_between(
            time,
            xp,
            (noise, interval),
            i,
            from..=next.saturating_sub(2),
        )?;
        let turn = Impact::of_parabolas(time.at(i), &meeting);
        turn.is_sudden(turn.v_error).then_some((i, turn))
    };
    kinks.iter().enumerate().filter_map(turn).collect()
}

/// Of kinks so close to each other that no side of samples lies between, the strongest: a reading
/// that is smoothed over some samples shows one impact as several.
fn strongest(time: TimeAxis, xp: &[f64], kinks: &[usize]) -> Vec<usize> {
    let slope = |i: usize| (xp[i + 1] - xp[i]) / (time.at(i + 1) - time.at(i));
    let kink = |i: usize| slope(i) - slope(i - 1);
    let mut found: Vec<usize> = Vec::new();
    for &i in kinks {
        match found.last_mut() {
            Some(last) if i - *last < Parabola::MIN_SAMPLES => {
                if kink(i) > kink(*last) {
                    *last = i;
                }
            }
            _ => found.push(i),
        }
    }
    found
}

/// Samples at which the slope jumps up most, compared with the noise and with their
/// neighbours.
pub(super) fn kinks(
    time: TimeAxis,
    xp: &[f64],
    noise: f64,
    interval: f64,
    (first, last): (usize, usize),
) -> Vec<usize> {
    let n = xp.len();
    let slope = |i: usize| (xp[i + 1] - xp[i]) / (time.at(i + 1) - time.at(i));
    let kink = |i: usize| {
        if i == 0 || i + 1 >= n {
            f64::NAN
        } else {
            slope(i) - slope(i - 1)
        }
    };
    let threshold = 6.0 * noise * 6f64.sqrt() / interval;
    let from = first.saturating_sub(1).max(1);
    let to = (last + 1).min(n.saturating_sub(2));
    let mut found: Vec<usize> = Vec::new();
    for i in from..=to {
        let here = kink(i);
        // A kink between two samples shows at both; the larger one stands for it.
        let largest = !(kink(i - 1) > here || kink(i + 1) > here);
        let clear = here > threshold && here > 0.0;
        if clear && largest && found.last().is_none_or(|last| i - last >= 2) {
            found.push(i);
        }
    }
    found
}

/// Whether the mass can have been at height `meeting` between samples around `i`: no farther below
/// the lowest of them than twice the way from one sample to the next there. Sides of few samples meet
/// anywhere, so that a dip of the ring well above the ground would become an impact.
fn is_within_reach(xp: &[f64], i: usize, meeting: f64) -> bool {
    let around = &xp[i.saturating_sub(2)..(i + 3).min(xp.len())];
    let way = around
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|way| way.is_finite())
        .fold(0.0, f64::max);
    let near = &xp[i.saturating_sub(1)..(i + 2).min(xp.len())];
    let lowest = near.iter().copied().filter(|x| x.is_finite());
    lowest.fold(f64::INFINITY, f64::min) - meeting <= MAX_DIP_WAYS * way
}

/// Whether two sides that meet at `at` (from sample time `t`) are an impact.
fn judge(
    options: &EventOptions,
    interval: f64,
    t: f64,
    at: f64,
    before: &Curve,
    after: &Curve,
) -> Option<Impact> {
    let impact = Impact {
        time: t + at,
        v_before: before.slope(at),
        v_after: after.slope(at),
        v_error: before.doubt.max(after.doubt),
        height: before.value(at),
    };
    let blur = before.slope_error.max(after.slope_error);
    (impact.is_sudden(blur) && impact.is_near(options, interval)).then_some(impact)
}

/// How the sides of an impact are followed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sides {
    /// By polynomials whose slope is certain.
    Certain,
    /// Where these plainly miss their samples, by higher ones: the ring of the second mode bends a side
    /// within the window. The slope is less certain, so only where there is no impact else.
    Bent,
}

/// Fits both sides and finds where they meet, as time from sample `i` \[s\].
fn meet(
    time: TimeAxis,
    xp: &[f64],
    (noise, sides): (f64, Sides),
    i: usize,
    left: RangeInclusive<usize>,
    right: RangeInclusive<usize>,
) -> Option<(f64, Curve, Curve)> {
    let origin = time.at(i);
    let before = Curve::fit(time, xp, left, origin, (noise, sides))?;
    let after = Curve::fit(time, xp, right, origin, (noise, sides))?;
    let (lower, upper) = (time.at(i - 1) - origin, time.at(i + 1) - origin);
    let mut at = 0.0;
    // Newton's steps on the distance; two are enough, and it cannot leave the bounds.
    for _ in 0..4 {
        let distance = before.value(at) - after.value(at);
        let next = at + distance / (after.slope(at) - before.slope(at));
        if !next.is_finite() {
            break;
        }
        at = next.clamp(lower, upper);
    }
    Some((at, before, after))
}

/// A polynomial in time from an origin.
#[derive(Debug, Clone)]
struct Curve {
    /// Coefficients, constant first, of time over `unit`.
    coefficients: Vec<f64>,
    unit: f64,
    /// Standard deviation of the slope at the origin from the noise \[m/s\].
    slope_error: f64,
    /// That, and how much one degree less would change the slope \[m/s\].
    doubt: f64,
}

impl Curve {
    /// Least squares through some samples; the degree is the highest that leaves the
    /// slope certain. `None` below two finite samples.
    fn fit(
        time: TimeAxis,
        xp: &[f64],
        range: RangeInclusive<usize>,
        origin: f64,
        (noise, sides): (f64, Sides),
    ) -> Option<Self> {
        let points: Vec<(f64, f64)> = range
            .filter_map(|i| xp.get(i).map(|x| (time.at(i) - origin, *x)))
            .filter(|(t, x)| t.is_finite() && x.is_finite())
            .collect();
        let n = points.len();
        // Time in units of the window keeps the equations well conditioned.
        let unit = points.iter().fold(0.0, |m: f64, p| m.max(p.0.abs()));
        if n < 2 || unit <= 0.0 {
            return None;
        }
        let values = DVector::from_fn(n, |i, _| points[i].1);
        let of_degree = |degree: usize| {
            if degree == 0 {
                return None;
            }
            let design =
                DMatrix::from_fn(n, degree + 1, |i, j| (points[i].0 / unit).powi(j as i32));
            let inverse = design.pseudo_inverse(1e-12).ok()?;
            let solved = &inverse * &values;
            Some(Curve {
                coefficients: solved.iter().copied().collect(),
                unit,
                slope_error: noise * inverse.row(1).norm() / unit,
                doubt: 0.0,
            })
        };
        // Degrees above the line need one sample more than coefficients, or a bad
        // sample would be followed exactly.
        let highest = MAX_DEGREE.min(n.saturating_sub(1)).max(1);
        let certain = |d: &usize| {
            of_degree(*d).is_some_and(|c| c.slope_error <= MAX_SLOPE_ERROR * c.slope(0.0).abs())
        };
        let fallback = if n >= 4 { 2 } else { 1 };
        let mut degree = (2..=highest).rev().find(certain).unwrap_or(fallback);
        let mut chosen = of_degree(degree)?;
        while sides == Sides::Bent
            && degree < highest
            && SAMPLES_PER_COEFFICIENT * (degree + 2) <= n
        {
            let misses: f64 = points
                .iter()
                .map(|p| (chosen.value(p.0) - p.1).powi(2))
                .sum();
            let freedom = (n - degree - 1) as f64;
            if (misses / freedom).sqrt() <= MAX_MISS_SIGMAS * noise {
                break;
            }
            let higher = of_degree(degree + 1)?;
            // Without a bend that counts it would follow noise.
            let bend = (higher.slope(0.0) - chosen.slope(0.0)).abs();
            if bend < MIN_BEND_SIGMAS * higher.slope_error {
                break;
            }
            degree += 1;
            chosen = higher;
        }
        let lower = of_degree(degree - 1).map_or(f64::NAN, |c| c.slope(0.0));
        let change = chosen.slope(0.0) - lower;
        chosen.doubt = if change.is_finite() {
            chosen.slope_error.hypot(change)
        } else {
            chosen.slope_error
        };
        Some(chosen)
    }

    fn value(&self, t: f64) -> f64 {
        let s = t / self.unit;
        self.coefficients
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * s + c)
    }

    fn slope(&self, t: f64) -> f64 {
        let s = t / self.unit;
        let terms = self.coefficients.iter().enumerate().skip(1).rev();
        terms.fold(0.0, |sum, (k, c)| sum * s + k as f64 * c) / self.unit
    }
}
