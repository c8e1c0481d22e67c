//! Directions with a frequency or a time that is searched for: the best of very many is found
//! from the products of a few.

use nalgebra::DVector;
use rayon::prelude::*;

use super::scan::{Base, Linear, Products, Promise, Scan, UNTOLD};
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::sim::SimError;

/// Fewest stays on the ground before a step of it.
const BEFORE: usize = 3;
/// Most frequencies between two that are simulated, on either side.
const MOST_STEPS: f64 = 2000.0;

/// The frequency of a vibration of the base, and what it would bring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Amplitude \[m/s^2\].
    pub amplitude: f64,
    /// Phase at t = 0 \[rad\].
    pub phase: f64,
    /// Fall of chi2.
    pub gain: f64,
}

/// Looks for a vibration of the base between `low` and `high` \[Hz\]: coarse frequencies
/// are simulated, and between them the phase is turned stretch by stretch.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn find_line(
    linear: &Linear<'_>,
    model: &Model,
    vibration: &dyn Fn(f64, f64) -> ActiveEffect,
    (low, high): (f64, f64),
    spacing: f64,
) -> Result<Option<Line>, SimError> {
    let count = ((high - low) / spacing).ceil().max(1.0) as usize;
    let coarse: Vec<f64> = (0..count)
        .map(|i| low + (i as f64 + 0.5) * (high - low) / count as f64)
        .collect();
    let quarter = std::f64::consts::FRAC_PI_2;
    let effects: Vec<ActiveEffect> = coarse
        .iter()
        .flat_map(|&f| [vibration(f, 0.0), vibration(f, quarter)])
        .collect();
    let products = linear.products(model, &effects)?;
    let whole = Scan::gather(linear, &products, effects.len());
    let Some(base) = whole.base() else {
        return Ok(None);
    };
    let n = linear.problem().unknowns();
    let longest = products
        .iter()
        .fold(0.0f64, |a, p| a.max(p.middle))
        .max(1e-3);
    let fine = 0.2 / longest;
    let half = 0.5 * (high - low) / count as f64;
    let steps = (half / fine).ceil().min(MOST_STEPS) as i64;
    let weigh = |(c, d): (usize, i64)| {
        let shift = half * d as f64 / steps as f64;
        let mut cross = [DVector::zeros(n), DVector::zeros(n)];
        let mut gram = nalgebra::Matrix2::zeros();
        let mut slope = nalgebra::Vector2::zeros();
        for p in &products {
            let (sin, cos) = (std::f64::consts::TAU * shift * p.middle).sin_cos();
            // sin(w t + turn) and cos(w t + turn) from sin and cos.
            let turn = nalgebra::Matrix2::new(cos, sin, -sin, cos);
            let k = 2 * c;
            gram += turn * p.gram.fixed_view::<2, 2>(k, k) * turn.transpose();
            slope += turn * p.slope.fixed_view::<2, 1>(k, 0);
            for (i, &ci) in p.columns.iter().enumerate() {
                let own = nalgebra::Vector2::new(p.cross[(i, k)], p.cross[(i, k + 1)]);
                let turned = turn * own;
                cross[0][ci] += turned[0];
                cross[1][ci] += turned[1];
            }
        }
        let mut left = gram;
        for i in 0..2 {
            for j in 0..2 {
                left[(i, j)] -= base.inner(&cross[i], &cross[j]);
            }
        }
        let reduced = nalgebra::Vector2::new(
            base.slope(&cross[0], slope[0]),
            base.slope(&cross[1], slope[1]),
        );
        // A line that re-tuning imitates must not divide by next to nothing.
        let floor = UNTOLD * gram.trace();
        let solved = (left + nalgebra::Matrix2::identity() * floor).try_inverse()? * reduced;
        let gain = reduced.dot(&solved);
        let (s, c0) = (-solved[0], -solved[1]);
        Some(Line {
            frequency: coarse[c] + shift,
            amplitude: s.hypot(c0),
            phase: c0.atan2(s),
            gain,
        })
    };
    let all: Vec<(usize, i64)> = (0..count)
        .flat_map(|c| (-steps..=steps).map(move |d| (c, d)))
        .collect();
    let lines: Vec<Line> = all.into_par_iter().filter_map(weigh).collect();
    Ok(lines
        .into_iter()
        .filter(|l| l.gain.is_finite())
        .max_by(|a, b| a.gain.total_cmp(&b.gain)))
}

/// A step of the ground's level, and what it would bring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// By how much \[m\].
    pub height: f64,
    /// When \[s\]: in each recording, or through the series.
    pub time: f64,
    /// Beginning of the last stay before that \[s\]; the recordings do not tell when between
    /// the two it happens.
    pub since: f64,
    /// Whether it happens once in the series of recordings.
    pub series: bool,
    /// Fall of chi2.
    pub gain: f64,
}

/// Looks for a step of the ground's level, at the same time in each recording and once in
/// the series, where `epochs` are the recordings' beginnings in it; the best of either.
/// `step` is a step that was always there, of 1 in the unit of its height.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn find_step(
    linear: &Linear<'_>,
    model: &Model,
    step: &ActiveEffect,
    epochs: &[f64],
) -> Result<Vec<Step>, SimError> {
    let products = linear.products(model, std::slice::from_ref(step))?;
    let whole = Scan::gather(linear, &products, 1);
    let Some(base) = whole.base() else {
        return Ok(Vec::new());
    };
    let n = linear.problem().unknowns();
    let segments = &linear.point().segments;
    let begin = |p: &Products| {
        let s = &segments[p.segment];
        let time = &linear.problem().data[s.recording].recording.time;
        time[s.samples.start] - 0.5 * s.interval
    };
    let held: Vec<&Products> = products
        .iter()
        .filter(|p| segments[p.segment].starts_held)
        .collect();
    let weigh = |on: &dyn Fn(&Products) -> bool| {
        promise_of(&base, n, held.iter().copied().filter(|p| on(p)))
    };
    let mut best: [Option<Step>; 2] = [None, None];
    for at in &held {
        let t0 = begin(at);
        let k = segments[at.segment].recording;
        let later = |p: &Products, series: bool| {
            let r = segments[p.segment].recording;
            match series {
                true => r > k || (r == k && begin(p) >= t0),
                false => begin(p) >= t0,
            }
        };
        for (series, best) in [false, true].into_iter().zip(&mut best) {
            // A ground that has been elsewhere all the time has made no step.
            let before = || held.iter().filter(|p| !later(p, series));
            if before().count() < BEFORE {
                continue;
            }
            let Some(p) = weigh(&|p| later(p, series)) else {
                continue;
            };
            if best.is_none_or(|b| p.gain > b.gain) {
                let epoch = |k: usize| epochs.get(k).copied().filter(|_| series).unwrap_or(0.0);
                let in_series = |p: &Products| epoch(segments[p.segment].recording) + begin(p);
                *best = Some(Step {
                    height: p.theta,
                    time: in_series(at),
                    since: before()
                        .map(|p| in_series(p))
                        .fold(f64::NEG_INFINITY, f64::max),
                    series,
                    gain: p.gain,
                });
            }
        }
    }
    Ok(best.into_iter().flatten().collect())
}

/// What a direction would bring that is there in some stretches only, of `n` unknowns in all.
fn promise_of<'a>(
    base: &Base,
    n: usize,
    some: impl Iterator<Item = &'a Products>,
) -> Option<Promise> {
    let (mut cross, mut own, mut slope) = (DVector::zeros(n), 0.0, 0.0);
    for p in some {
        for (i, &c) in p.columns.iter().enumerate() {
            cross[c] += p.cross[(i, 0)];
        }
        own += p.gram[(0, 0)];
        slope += p.slope[0];
    }
    base.promise(&cross, own, slope)
}

/// Another level of the ground in the first of the recordings of `linear` in which the mass
/// stays on it, the model's parameters as they are: that recording and what it would bring
/// there, in units of `step`.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn first_level(
    linear: &Linear<'_>,
    model: &Model,
    step: &ActiveEffect,
) -> Result<Option<(usize, Promise)>, SimError> {
    let products = linear.products(model, std::slice::from_ref(step))?;
    let segments = &linear.point().segments;
    let count = |k: usize| {
        let own = products.iter().map(|p| &segments[p.segment]);
        own.filter(|s| s.recording == k && s.starts_held).count()
    };
    let recordings = 0..linear.problem().data.len();
    let Some(first) = recordings.into_iter().find(|&k| count(k) >= BEFORE) else {
        return Ok(None);
    };
    let whole = Scan::gather(linear, &products, 1);
    let stays = products.iter().filter(|p| {
        let s = &segments[p.segment];
        s.starts_held && s.recording == first
    });
    let n = linear.problem().unknowns();
    let base = whole.base_without(linear.problem().space.len());
    let promise = base.and_then(|base| promise_of(&base, n, stays));
    Ok(promise.map(|promise| (first, promise)))
}
