//! A sine or a sweep with an offset, and sums of sines.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use realfft::RealFftPlanner;

use super::knots::ROUNDING_SIGMAS;
use super::least_squares::fit_curve;
use super::round_number::round_between;
use super::samples::{MAX_FIT_SAMPLES, Samples};

/// Share of half the span around the middle within which a crossing of it is not counted twice.
const CROSSING_HYSTERESIS: f64 = 0.15;
/// Part of a digitiser's step by which it falsifies amplitude and offset however many samples
/// there are.
const DIGITISER_BIAS: f64 = 0.02;
/// Fewest crossings of the middle: below, too little of a period is seen.
const MIN_CROSSINGS: usize = 3;
/// Most samples from which a start is looked for.
const MAX_SEARCH_SAMPLES: usize = 3000;
/// Reaches of a sample's error within which a curve fitted to few samples must lie.
const LIKELY_REACHES: f64 = 4.0;
/// Most sines in a sum.
const MAX_SINES: usize = 5;
/// Most samples of the spectrum in which a sum's frequencies are looked for.
const MAX_SPECTRUM_SAMPLES: usize = 1 << 16;
/// A sine smaller than this many standard deviations of its amplitude is not there.
const MIN_AMPLITUDE_SIGMAS: f64 = 6.0;

/// `amplitude sin(2 pi (phase + from t + rate t^2 / 2))`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sinusoid {
    /// \[V\]
    pub amplitude: f64,
    /// Phase at t = 0 in turns.
    pub phase: f64,
    /// Frequency at t = 0 \[Hz\].
    pub from: f64,
    /// Its change [Hz/s].
    pub rate: f64,
    /// Standard deviation of the instants of equal phase \[s\].
    pub time_sigma: f64,
}

impl Sinusoid {
    /// Turns since phase zero at `t` \[s\].
    pub fn turns(&self, t: f64) -> f64 {
        self.phase + t * (self.from + 0.5 * self.rate * t)
    }

    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        // Whole turns are taken away first: the sine of a large number is slow.
        let turns = self.turns(t);
        self.amplitude * (TAU * (turns - turns.floor())).sin()
    }

    /// Slope [V/s] at `t` \[s\].
    pub fn slope(&self, t: f64) -> f64 {
        let frequency = self.from + self.rate * t;
        self.amplitude * TAU * frequency * (TAU * self.turns(t)).cos()
    }
}

/// Sinusoids on an offset.
#[derive(Debug, Clone, PartialEq)]
pub struct Sinusoids {
    /// \[V\]
    pub offset: f64,
    /// Largest first.
    pub parts: Vec<Sinusoid>,
}

impl Sinusoids {
    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        self.offset + self.parts.iter().map(|s| s.voltage(t)).sum::<f64>()
    }

    /// Slope [V/s] at `t` \[s\].
    pub fn slope(&self, t: f64) -> f64 {
        self.parts.iter().map(|s| s.slope(t)).sum()
    }
}

/// The sinusoids that the samples follow; `None` if they are none.
pub fn find_sinusoids(samples: &Samples<'_>) -> Option<Sinusoids> {
    find_single(samples).or_else(|| find_sum(samples))
}

fn find_single(samples: &Samples<'_>) -> Option<Sinusoids> {
    let crossings = crossings(samples);
    if crossings.len() < MIN_CROSSINGS {
        return None;
    }
    let amplitude = 0.5 * samples.span();
    let offset = 0.5 * (samples.range.0 + samples.range.1);
    let duration = samples.time[samples.len() - 1] - samples.time[0];
    for degree in [1, 2] {
        let Some(turns) = phase_polynomial(&crossings, degree) else {
            continue;
        };
        let start = [amplitude, turns[0], turns[1], offset, 2.0 * turns[2]];
        // Changes of about a thousandth of a turn over the span.
        let all = [
            1e-3 * amplitude,
            1e-4,
            1e-4 / duration,
            1e-3 * amplitude,
            1e-4 / (duration * duration),
        ];
        let count = if degree == 1 { 4 } else { 5 };
        let of = |p: &[f64]| Sinusoid {
            amplitude: p[0],
            phase: p[1],
            from: p[2],
            rate: p.get(4).copied().unwrap_or(0.0),
            time_sigma: 0.0,
        };
        let curve = |p: &[f64], t: f64| p[3] + of(p).voltage(t);
        // Few samples tell whether it is one at all.
        let few = fit_curve(
            samples,
            &start[..count],
            &all[..count],
            MAX_SEARCH_SAMPLES,
            curve,
        );
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

/// Whether few samples do not deny a curve; the test of all decides after a fit to all.
fn is_likely(samples: &Samples<'_>, curve: impl Fn(f64) -> f64) -> bool {
    let reach = LIKELY_REACHES * samples.reach();
    let near = |i: usize| (samples.volts[i] - curve(samples.time[i])).abs() <= reach;
    samples.thinned(MAX_SEARCH_SAMPLES).all(near)
}

/// A single sinusoid with the settings a person would have chosen.
fn rounded(samples: &Samples<'_>, exact: &Sinusoids, sigmas: &[f64], duration: f64) -> Sinusoids {
    // Errors of a coarse digitiser are no noise: they do not average out.
    let coarse = DIGITISER_BIAS * samples.quantum;
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

/// The zero that rises nearest to t = 0 \[s\].
pub fn begin(part: &Sinusoid) -> f64 {
    let phase = part.phase - part.phase.round();
    let sign = part.amplitude.signum();
    let phase = if sign < 0.0 { phase - 0.5 } else { phase };
    -phase / part.from
}

/// Instants at which the samples cross their middle \[s\], and whether the first rises.
fn crossings(samples: &Samples<'_>) -> Vec<(f64, bool)> {
    let middle = 0.5 * (samples.range.0 + samples.range.1);
    let least = (CROSSING_HYSTERESIS * 0.5 * samples.span()).max(samples.reach());
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

/// A sum of sines, the strongest first.
fn find_sum(samples: &Samples<'_>) -> Option<Sinusoids> {
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
