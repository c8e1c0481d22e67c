//! Whether uneven times are those of uneven samples, or of an even clock read with jitter.
//!
//! The stamps of an even clock keep to a line: their distances from it do not grow with the
//! length of the recording, and one late stamp makes one interval longer and the next shorter.
//! Intervals that are uneven by themselves add up: the distance walks at random. A sampler that
//! is late and says so keeps to the line too; the readings tell the two apart, because they are
//! smooth against the true times only.

use super::even_grid::{Builder, EvenTimes, NEGLIGIBLE_CHANGE_SHARE};
use super::sample_index::SampleIndex;
use super::short_number::Interval;

/// Fewest rows for a judgement: with 100, a random walk of the same intervals lies 2.6 times as far
/// from its line as is allowed below.
const MIN_JITTER_ROWS: usize = 100;
/// Largest rms distance from the line, in rms deviations of an interval. Independent stamps have
/// 0.71; a random walk over n rows the square root of n / 15.
const MAX_WANDER: f64 = 1.0;
/// Largest rms distance of the stamps, in intervals: with more, neighbours change places.
const MAX_STAMP_JITTER: f64 = 0.25;
/// Least rms deviation of an interval, in intervals, that is called uneven: 1 %, as for
/// `Recording::is_uniform`.
const MIN_UNEVENNESS: f64 = 0.01;
/// Standard deviations of a sign test at which the readings decide: one chance in 30 000.
const READINGS_DECIDE_SIGMAS: f64 = 4.0;
/// Readings that take part in the sign test: enough for a difference of 1 % of them.
const MAX_TESTED_READINGS: usize = 200_000;
/// Standard errors of the interval within which it is taken to be a short number.
const INTERVAL_SIGMAS: f64 = 2.0;

/// What uneven times are.
#[derive(Debug, Clone)]
pub(in crate::recording) enum Sampling {
    /// Even samples with jittered stamps: the even times, rms jitter of the stamps \[s\], and what
    /// the readings say.
    Jittered(EvenTimes, f64, Readings),
    /// Uneven samples: their mean interval and its rms deviation \[s\].
    Uneven(f64, f64),
    /// Neither can be said, or the unevenness is too small to matter.
    Unknown,
}

/// Which times the readings are smoother against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) enum Readings {
    /// The even ones.
    Even,
    /// They do not show it.
    Silent,
}

/// Judges increasing times \[s\] with the readings taken at them.
pub(in crate::recording) fn judge(time: &[f64], readings: &[f64], index: &SampleIndex) -> Sampling {
    let Some(line) = Line::fit(time, index).filter(|_| time.len() >= MIN_JITTER_ROWS) else {
        return Sampling::Unknown;
    };
    let dt = line.interval;
    if line.steps <= NEGLIGIBLE_CHANGE_SHARE * dt {
        return Sampling::Unknown;
    }
    let uneven = if line.steps > MIN_UNEVENNESS * dt {
        Sampling::Uneven(dt, line.steps)
    } else {
        Sampling::Unknown
    };
    if line.rms > MAX_WANDER * line.steps || line.rms > MAX_STAMP_JITTER * dt {
        return uneven;
    }
    let Some(even) = line.even_times(time, index) else {
        return uneven;
    };
    let sigmas = smoother_when_even(time, &even.time, readings, index);
    if sigmas <= -READINGS_DECIDE_SIGMAS {
        return uneven;
    }
    let say = if sigmas >= READINGS_DECIDE_SIGMAS {
        Readings::Even
    } else {
        Readings::Silent
    };
    Sampling::Jittered(even, line.rms, say)
}

/// The line through the stamps, one slope and an intercept for each run, by least squares.
struct Line {
    /// Its slope \[s\].
    interval: f64,
    /// Standard error of the slope for independent stamps \[s\].
    uncertainty: f64,
    /// Intercept of each run, from its first stamp \[s\].
    intercepts: Vec<f64>,
    /// Rms distance of the stamps \[s\].
    rms: f64,
    /// Rms deviation of the intervals \[s\].
    steps: f64,
}

impl Line {
    /// `None` if no run has two rows.
    fn fit(time: &[f64], index: &SampleIndex) -> Option<Self> {
        // Distances from a line near by, so that nothing is lost to the size of the times.
        let mean = index.mean_interval(time);
        if !(mean.is_finite() && mean > 0.0) {
            return None;
        }
        let off =
            |begin: usize, i: usize| (-(index.tick(i) as f64)).mul_add(mean, time[i] - time[begin]);
        let mut centres = Vec::new();
        let (mut products, mut squares) = (0.0, 0.0);
        for run in index.runs() {
            let (begin, n) = (run.start, run.len() as f64);
            let tick = run.clone().map(|i| index.tick(i) as f64).sum::<f64>() / n;
            let distance = run.clone().map(|i| off(begin, i)).sum::<f64>() / n;
            for i in run {
                let k = index.tick(i) as f64 - tick;
                products += k * (off(begin, i) - distance);
                squares += k * k;
            }
            centres.push((tick, distance));
        }
        if squares == 0.0 {
            return None;
        }
        let slope = products / squares;
        let intercepts: Vec<f64> = centres.iter().map(|(k, d)| d - slope * k).collect();
        let (mut sum, mut steps, mut count) = (0.0, 0.0, 0usize);
        for (run, intercept) in index.runs().zip(&intercepts) {
            let mut before: Option<f64> = None;
            for i in run.clone() {
                let e = off(run.start, i) - intercept - slope * index.tick(i) as f64;
                sum += e * e;
                if let Some(before) = before {
                    steps += (e - before) * (e - before);
                    count += 1;
                }
                before = Some(e);
            }
        }
        let rms = (sum / time.len() as f64).sqrt();
        Some(Self {
            interval: mean + slope,
            uncertainty: rms / squares.sqrt(),
            intercepts,
            rms,
            steps: (steps / count.max(1) as f64).sqrt(),
        })
    }

    /// The ticks of the line; `None` if they do not increase.
    fn even_times(&self, time: &[f64], index: &SampleIndex) -> Option<EvenTimes> {
        let reach = INTERVAL_SIGMAS * self.uncertainty;
        let interval = Interval::within(self.interval - reach, self.interval + reach);
        let mut builder = Builder::new(time, interval.seconds());
        for (run, intercept) in index.runs().zip(&self.intercepts) {
            let begin = time[run.start] - time[0];
            // The middle of the run stays where the line has it.
            let middle = 0.5 * index.tick(run.end - 1) as f64;
            let shift = intercept + middle * (self.interval - interval.seconds());
            for i in run {
                builder.push(begin, shift, interval.times(index.tick(i)));
            }
        }
        builder.finish()
    }
}

/// Standard deviations by which more readings are nearer to the cubic through their four
/// neighbours with `even` times than with those of the `stamps`; negative where it is the other
/// way round.
fn smoother_when_even(stamps: &[f64], even: &[f64], readings: &[f64], index: &SampleIndex) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    // Neighbours share readings: every fifth is on its own.
    let stride = (readings.len() / MAX_TESTED_READINGS).max(5);
    for run in index.runs() {
        let mut i = run.start + 2;
        while i + 2 < run.end {
            let whole = index.tick(i + 2) - index.tick(i - 2) == 4;
            let (by_even, by_stamp) = (misfit(even, readings, i), misfit(stamps, readings, i));
            if whole && by_even.is_finite() && by_stamp.is_finite() && by_even != by_stamp {
                sum += if by_even < by_stamp { 1.0 } else { -1.0 };
                count += 1;
            }
            i += stride;
        }
    }
    sum / (count.max(1) as f64).sqrt()
}

/// Distance of reading `i` from the cubic through its four neighbours (Lagrange); NaN if one is
/// missing.
fn misfit(time: &[f64], readings: &[f64], i: usize) -> f64 {
    let at = [i - 2, i - 1, i + 1, i + 2];
    let cubic: f64 = at
        .iter()
        .map(|&j| {
            let others = at.iter().filter(|k| **k != j);
            let weight = others.fold(1.0, |w, &k| w * (time[i] - time[k]) / (time[j] - time[k]));
            weight * readings[j]
        })
        .sum();
    (readings[i] - cubic).abs()
}
