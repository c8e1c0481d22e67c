//! A sum of sines, from the strongest lines of the spectrum.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

use super::curve::{Sinusoid, Sinusoids, is_likely};
use crate::recording::measured_drive::least_squares::fit_curve;
use crate::recording::measured_drive::round_number::round_between;
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    MAX_FIT_SAMPLES, MAX_SEARCH_SAMPLES, MAX_SINES, MAX_SPECTRUM_SAMPLES, MIN_AMPLITUDE_SIGMAS,
    ROUNDING_SIGMAS,
};

/// A sum of sines, the strongest first.
pub fn find_sum(samples: &Samples<'_>) -> Option<Sinusoids> {
    let n = samples.len().min(MAX_SPECTRUM_SAMPLES);
    let part = samples.part(0, n);
    let uniform = (part.time[n - 1] - part.time[0]) / (n - 1) as f64;
    if (uniform / samples.interval - 1.0).abs() > 0.01 || n < 64 {
        return None;
    }
    let mean = part.volts.iter().sum::<f64>() / n as f64;
    let mut left: Vec<f64> = part.volts.iter().map(|v| v - mean).collect();
    // `[offset, then amplitude, phase, frequency of each]`.
    let mut parameters = vec![mean];
    let duration = part.time[n - 1] - part.time[0];
    for _ in 0..MAX_SINES {
        let frequency = strongest(&left, uniform)?;
        let (amplitude, phase) = quadratures(part.time, &left, frequency)?;
        parameters.extend([amplitude, phase, frequency]);
        let (fit, sigmas) = refine(&part, &parameters, duration, MAX_SEARCH_SAMPLES)?;
        parameters = fit;
        let least = MIN_AMPLITUDE_SIGMAS * sigmas[sigmas.len() - 3];
        if parameters[parameters.len() - 3].abs() < least {
            return None;
        }
        left = part
            .time
            .iter()
            .zip(part.volts)
            .map(|(&t, v)| v - sum_voltage(&parameters, t))
            .collect();
        let curve = |t: f64| sum_voltage(&parameters, t);
        if parameters.len() > 4 && is_likely(&part, curve) {
            return extend(samples, parameters, n);
        }
    }
    None
}

fn sum_voltage(p: &[f64], t: f64) -> f64 {
    let waves = p[1..].chunks_exact(3);
    p[0] + waves
        .map(|w| w[0] * (TAU * (w[1] + w[2] * t)).sin())
        .sum::<f64>()
}

fn refine(
    samples: &Samples<'_>,
    start: &[f64],
    duration: f64,
    most: usize,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let size = 1e-3 * samples.span();
    let mut scales = vec![size];
    for _ in start[1..].chunks_exact(3) {
        scales.extend([size, 1e-4, 1e-4 / duration]);
    }
    let fit = fit_curve(samples, start, &scales, most, sum_voltage)?;
    Some((fit.parameters, fit.sigmas))
}

/// From the first `n` samples to all: each window is four times the last, so that the phase is
/// never lost.
fn extend(samples: &Samples<'_>, mut parameters: Vec<f64>, mut n: usize) -> Option<Sinusoids> {
    let mut sigmas;
    loop {
        let part = samples.part(0, n);
        let duration = part.time[n - 1] - part.time[0];
        (parameters, sigmas) = refine(&part, &parameters, duration, MAX_FIT_SAMPLES)?;
        if n == samples.len() {
            break;
        }
        n = (4 * n).min(samples.len());
    }
    let near = |v: f64, sigma: f64| {
        let reach = ROUNDING_SIGMAS * sigma;
        round_between(v - reach, v + reach).unwrap_or(v)
    };
    let count = samples.len() as f64;
    let make = |round: bool| {
        let pick = |v: f64, sigma: f64| if round { near(v, sigma) } else { v };
        let parts = parameters[1..]
            .chunks_exact(3)
            .zip(sigmas[1..].chunks_exact(3));
        let mut parts: Vec<Sinusoid> = parts
            .map(|(p, s)| {
                let (from, turn) = (pick(p[2], s[2]), p[1].floor());
                Sinusoid {
                    amplitude: pick(p[0], s[0]),
                    phase: pick(p[1] - turn, s[1]),
                    from,
                    rate: 0.0,
                    time_sigma: samples.sigma
                        / (p[0].abs() * TAU * p[2].abs() * (0.5 * count).sqrt()),
                }
            })
            .collect();
        parts.sort_by(|a, b| b.amplitude.abs().total_cmp(&a.amplitude.abs()));
        Sinusoids {
            offset: pick(parameters[0], sigmas[0]),
            parts,
        }
    };
    let (rounded, exact) = (make(true), make(false));
    if samples.are(|t| rounded.voltage(t)) {
        Some(rounded)
    } else {
        samples.are(|t| exact.voltage(t)).then_some(exact)
    }
}

/// Frequency of the strongest line of the spectrum \[Hz\], between bins by a parabola.
fn strongest(values: &[f64], interval: f64) -> Option<f64> {
    let n = values.len();
    let mut planner = RealFftPlanner::<f64>::new();
    let padded = (2 * n).next_power_of_two();
    let forward = planner.plan_fft_forward(padded);
    let mut input = forward.make_input_vec();
    for (i, slot) in input.iter_mut().take(n).enumerate() {
        // Hann's window keeps strong lines from covering weak ones.
        let window = 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos();
        *slot = values[i] * window;
    }
    let mut output = forward.make_output_vec();
    forward.process(&mut input, &mut output).ok()?;
    let power: Vec<f64> = output.iter().map(|c| c.norm_sqr()).collect();
    let best = (1..power.len() - 1).max_by(|&a, &b| power[a].total_cmp(&power[b]))?;
    let (a, b, c) = (power[best - 1], power[best], power[best + 1]);
    let bend = a - 2.0 * b + c;
    let shift = if bend < 0.0 {
        0.5 * (a - c) / bend
    } else {
        0.0
    };
    Some((best as f64 + shift) / (padded as f64 * interval))
}

/// Amplitude and phase in turns of a sine of known frequency.
fn quadratures(time: &[f64], values: &[f64], frequency: f64) -> Option<(f64, f64)> {
    let (mut ss, mut sc, mut cc, mut sv, mut cv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (&t, v) in time.iter().zip(values) {
        let (s, c) = (TAU * frequency * t).sin_cos();
        ss += s * s;
        sc += s * c;
        cc += c * c;
        sv += s * v;
        cv += c * v;
    }
    let det = ss * cc - sc * sc;
    let (a, b) = ((sv * cc - cv * sc) / det, (cv * ss - sv * sc) / det);
    (det > 0.0).then(|| (a.hypot(b), b.atan2(a) / TAU))
}
