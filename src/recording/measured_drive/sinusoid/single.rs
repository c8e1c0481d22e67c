//! A single sine or sweep, from the instants at which it crosses its middle.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::curve::{Sinusoid, Sinusoids, begin, is_likely};
use crate::recording::measured_drive::least_squares::fit_curve;
use crate::recording::measured_drive::round_number::round_between;
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CROSSING_HYSTERESIS_SHARE, DIGITISER_BIAS_STEPS, MAX_FIT_SAMPLES, MAX_SEARCH_SAMPLES,
    MIN_CROSSINGS, ROUNDING_SIGMAS, SLOW_SEARCH_SAMPLES, SLOW_SEARCH_STEP,
};

pub fn find_single(samples: &Samples<'_>) -> Option<Sinusoids> {
    let crossings = crossings(samples);
    let amplitude = 0.5 * samples.span();
    let offset = 0.5 * (samples.range.0 + samples.range.1);
    let duration = samples.time[samples.len() - 1] - samples.time[0];
    // Amplitude, phase, frequency, offset, and a sweep's rate.
    let starts: Vec<Vec<f64>> = if crossings.len() < MIN_CROSSINGS {
        slow_sine(samples).into_iter().collect()
    } else {
        let start = |degree: usize| {
            let turns = phase_polynomial(&crossings, degree)?;
            let mut start = vec![amplitude, turns[0], turns[1], offset];
            start.extend((degree == 2).then_some(2.0 * turns[2]));
            Some(start)
        };
        [1, 2].into_iter().filter_map(start).collect()
    };
    for start in starts {
        let count = start.len();
        // Changes of about a thousandth of a turn over the span.
        let all = [
            1e-3 * amplitude,
            1e-4,
            1e-4 / duration,
            1e-3 * amplitude,
            1e-4 / (duration * duration),
        ];
        let of = |p: &[f64]| Sinusoid {
            amplitude: p[0],
            phase: p[1],
            from: p[2],
            rate: p.get(4).copied().unwrap_or(0.0),
            time_sigma: 0.0,
        };
        let curve = |p: &[f64], t: f64| p[3] + of(p).voltage(t);
        // Few samples tell whether it is one at all.
        let few = fit_curve(samples, &start, &all[..count], MAX_SEARCH_SAMPLES, curve);
        let Some(few) = few.filter(|few| is_likely(samples, |t| curve(&few.parameters, t))) else {
            continue;
        };
        let fit = fit_curve(
            samples,
            &few.parameters,
            &all[..count],
            MAX_FIT_SAMPLES,
            curve,
        );
        let Some(fit) = fit else { continue };
        let mut part = of(&fit.parameters);
        let middle = 0.5 * (samples.time[0] + samples.time[samples.len() - 1]);
        let frequency = (part.from + part.rate * middle).abs();
        part.time_sigma = samples.sigma
            / (part.amplitude.abs() * TAU * frequency * (0.5 * samples.len() as f64).sqrt());
        let exact = Sinusoids {
            offset: fit.parameters[3],
            parts: vec![part],
        };
        if !samples.are(|t| exact.voltage(t)) {
            continue;
        }
        let rounded = rounded(samples, &exact, &fit.sigmas, duration);
        return Some(if samples.are(|t| rounded.voltage(t)) {
            rounded
        } else {
            exact
        });
    }
    None
}

/// Amplitude, phase, frequency and offset of the sine of so few periods that its crossings do not
/// tell its frequency: the one among many nearest to the samples. `None` where none is near.
fn slow_sine(samples: &Samples<'_>) -> Option<Vec<f64>> {
    let picked = || samples.thinned(SLOW_SEARCH_SAMPLES);
    let (first, last) = (samples.time[0], samples.time[samples.len() - 1]);
    let of = |k: usize| {
        let frequency = SLOW_SEARCH_STEP * k as f64 / (last - first);
        let row = |i: usize| {
            let (sin, cos) = (TAU * frequency * samples.time[i]).sin_cos();
            [1.0, sin, cos]
        };
        let design = DMatrix::from_row_iterator(picked().count(), 3, picked().flat_map(row));
        let volts = DVector::from_iterator(design.nrows(), picked().map(|i| samples.volts[i]));
        let normal = design.transpose() * &design;
        let c = normal.cholesky()?.solve(&(design.transpose() * &volts));
        let left = (volts - design * &c).norm_squared();
        let start = vec![c[1].hypot(c[2]), c[2].atan2(c[1]) / TAU, frequency, c[0]];
        Some((left, start))
    };
    // As many periods as `MIN_CROSSINGS` crossings may lack.
    let most = (0.5 * (MIN_CROSSINGS + 1) as f64 / SLOW_SEARCH_STEP) as usize;
    let tried = (1..=most).filter_map(of);
    tried.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

/// A single sinusoid with the settings a person would have chosen.
fn rounded(samples: &Samples<'_>, exact: &Sinusoids, sigmas: &[f64], duration: f64) -> Sinusoids {
    // Errors of a coarse digitiser are no noise: they do not average out.
    let coarse = DIGITISER_BIAS_STEPS * samples.quantum;
    let near = |v: f64, sigma: f64| {
        let reach = ROUNDING_SIGMAS * sigma;
        round_between(v - reach, v + reach)
    };
    let near_volts = |v: f64, sigma: f64| near(v, sigma.hypot(coarse));
    let mut part = exact.parts[0];
    let relative = coarse / part.amplitude.abs();
    let (first, last) = (samples.time[0], samples.time[samples.len() - 1]);
    if part.rate == 0.0 {
        if let Some(frequency) = near(part.from, sigmas[2].hypot(0.1 * relative / duration)) {
            part = with_frequencies(part, frequency, 0.0, 0.5 * (first + last));
        }
    } else {
        let start = near(part.from, sigmas[2].hypot(relative / duration));
        let rate = near(part.rate, sigmas[4].hypot(relative / (duration * duration)));
        if let (Some(start), Some(rate)) = (start, rate) {
            part = with_frequencies(part, start, rate, first);
        }
    }
    // The phase as the time of a zero that rises, near t = 0.
    let begin = begin(&part);
    let turn_sigma = sigmas[1].hypot(relative / TAU);
    let reach = ROUNDING_SIGMAS * part.time_sigma.max(turn_sigma / part.from.abs());
    if let Some(time) = round_between(begin - reach, begin + reach) {
        part.phase = -time * (part.from + 0.5 * part.rate * time);
    }
    if let Some(amplitude) = near_volts(part.amplitude, sigmas[0]) {
        part.amplitude = amplitude;
    }
    Sinusoids {
        offset: near_volts(exact.offset, sigmas[3]).unwrap_or(exact.offset),
        parts: vec![part],
    }
}

/// The same phase at `kept` \[s\] with other frequencies.
fn with_frequencies(part: Sinusoid, from: f64, rate: f64, kept: f64) -> Sinusoid {
    Sinusoid {
        phase: part.turns(kept) - kept * (from + 0.5 * rate * kept),
        from,
        rate,
        ..part
    }
}

/// Instants at which the samples cross their middle \[s\], and whether the first rises.
fn crossings(samples: &Samples<'_>) -> Vec<(f64, bool)> {
    let middle = 0.5 * (samples.range.0 + samples.range.1);
    let least = (CROSSING_HYSTERESIS_SHARE * 0.5 * samples.span()).max(samples.reach());
    let mut found = Vec::new();
    let mut side = 0i8;
    let mut cut = 0.0;
    for i in 0..samples.len() {
        let off = samples.volts[i] - middle;
        if i > 0 {
            let before = samples.volts[i - 1] - middle;
            if (before < 0.0) != (off < 0.0) {
                let share = before / (before - off);
                cut = samples.time[i - 1] + share * (samples.time[i] - samples.time[i - 1]);
            }
        }
        let now = if off > least {
            1
        } else if off < -least {
            -1
        } else {
            continue;
        };
        if side != 0 && now != side {
            found.push((cut, now > 0));
        }
        side = now;
    }
    found
}

/// Phase in turns as a polynomial of time, from instants half a turn apart, constant first.
fn phase_polynomial(crossings: &[(f64, bool)], degree: usize) -> Option<[f64; 3]> {
    let stride = crossings.len().div_ceil(20_000).max(1);
    let first = if crossings[0].1 { 0.0 } else { 0.5 };
    let picked: Vec<(f64, f64)> = crossings
        .iter()
        .enumerate()
        .step_by(stride)
        .map(|(k, c)| (c.0, first + 0.5 * k as f64))
        .collect();
    let (t0, t1) = (picked[0].0, picked[picked.len() - 1].0);
    let (at, unit) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
    let n = degree + 1;
    if picked.len() < n {
        return None;
    }
    let design = DMatrix::from_fn(picked.len(), n, |i, k| {
        ((picked[i].0 - at) / unit).powi(k as i32)
    });
    let right = DVector::from_iterator(picked.len(), picked.iter().map(|p| p.1));
    let c = (design.transpose() * &design)
        .cholesky()?
        .solve(&(design.transpose() * right));
    // Back from the scaled time.
    let (a, b) = (
        c[1] / unit,
        c.get(2).copied().unwrap_or(0.0) / (unit * unit),
    );
    Some([c[0] - a * at + b * at * at, a - 2.0 * b * at, b])
}
