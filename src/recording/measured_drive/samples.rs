//! The samples of a measured voltage, their error, and the test that a curve is all there is in them.

use super::thresholds::{
    BLOCK_SAMPLES, MAX_BLOCK_EXCESS_SIGMAS, MAX_DIGITISER_ERROR_SHARE, MAX_LEVEL_NOISE_VOLTS,
    MAX_UNEVEN_SHARE, MIN_ERROR_SHARE, NOISE_ESTIMATE_ERROR_SHARE, ROUNDING_REACH_STEPS,
    SINGLE_SAMPLE_MARGIN_SIGMAS, UNEVEN_INTERVAL_SHARE,
};
use crate::recording::grid::TimeAxis;
use crate::recording::noise::estimate_noise;
use crate::recording::statistics::{extremes, median_interval};

/// A measured voltage.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Times \[s\], increasing.
    pub time: &'a [f64],
    /// Voltages \[V\], finite, as many.
    pub volts: &'a [f64],
    /// Standard deviation of a sample's error \[V\], rounding included, never zero.
    pub sigma: f64,
    /// Step of the digitiser \[V\] where it is the larger part of the error, else 0.
    pub quantum: f64,
    /// Typical interval \[s\].
    pub interval: f64,
    /// Lowest and highest sample \[V\].
    pub range: (f64, f64),
}

/// The span of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// First time \[s\].
    pub first: f64,
    /// Last time \[s\].
    pub last: f64,
    /// Typical interval \[s\].
    pub interval: f64,
}

impl<'a> Samples<'a> {
    /// Estimates the error of `volts`, taken at `time`, at least two of each.
    pub fn new(time: &'a [f64], volts: &'a [f64]) -> Self {
        let range = extremes(volts);
        let span = range.1 - range.0;
        let noise = estimate_noise(TimeAxis::Samples(time), volts).ok();
        let floor = (MIN_ERROR_SHARE * span).max(1e-12);
        Self {
            time,
            volts,
            sigma: noise.map_or(0.0, |n| n.sigma).max(floor),
            quantum: noise
                .filter(|n| n.quantised)
                .and_then(|n| n.step)
                .unwrap_or(0.0),
            interval: median_interval(time),
            range,
        }
    }

    /// Whether a digitiser may have taken them: at even times, most of them, and so near together that
    /// their error is small against their span. Corners that somebody typed are neither.
    pub fn are_of_a_digitiser(&self) -> bool {
        let intervals = self.time.windows(2).map(|pair| pair[1] - pair[0]);
        let off = |dt: &f64| (dt - self.interval).abs() > UNEVEN_INTERVAL_SHARE * self.interval;
        let uneven = intervals.filter(off).count();
        uneven as f64 <= MAX_UNEVEN_SHARE * self.len() as f64
            && (self.quantum > 0.0
                // A level has no span but that of its error.
                || (self.sigma <= MAX_LEVEL_NOISE_VOLTS && self.span() <= 2.0 * self.reach())
                || self.sigma <= MAX_DIGITISER_ERROR_SHARE * self.span())
    }

    /// Their first and last time and interval.
    pub fn in_time(&self) -> Span {
        Span {
            first: self.time[0],
            last: self.time[self.len() - 1],
            interval: self.interval,
        }
    }

    /// Highest minus lowest sample \[V\].
    pub fn span(&self) -> f64 {
        self.range.1 - self.range.0
    }

    /// Whether the samples show noise of their own.
    pub fn is_noisy(&self) -> bool {
        self.sigma > 1.5 * (MIN_ERROR_SHARE * self.span()).max(1e-12)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// The samples from `from` to before `to`, with the error of the whole.
    pub fn part(&self, from: usize, to: usize) -> Self {
        Self {
            time: &self.time[from..to],
            volts: &self.volts[from..to],
            ..*self
        }
    }

    /// Indices of at most about `most` samples, evenly picked over the whole span.
    pub fn thinned(&self, most: usize) -> impl Iterator<Item = usize> + Clone + use<> {
        let stride = self.len().div_ceil(most).max(1);
        (0..self.len()).step_by(stride)
    }

    /// Largest deviation of a sample from the true voltage that noise and rounding explain \[V\].
    pub fn reach(&self) -> f64 {
        let largest = (2.0 * (self.len().max(2) as f64).ln()).sqrt() + SINGLE_SAMPLE_MARGIN_SIGMAS;
        if self.quantum > 0.0 {
            // Rounding alone reaches half a step; the noise below it is not known, but is
            // less than the step.
            ROUNDING_REACH_STEPS * self.quantum + 1e-3 * self.sigma * largest
        } else {
            largest * self.sigma
        }
    }

    /// Whether `curve` (time to volts) is all there is in the samples but for their error: no sample
    /// is farther than the error reaches, and means over blocks, in which a small lasting deviation
    /// adds up, are as small as those of noise. Blocks say nothing of rounding, which lasts.
    pub fn are(&self, curve: impl Fn(f64) -> f64) -> bool {
        self.are_where_known(|t| Some(curve(t)))
    }

    /// As [`Samples::are`]; samples at which the curve has no value are not asked.
    pub fn are_where_known(&self, curve: impl Fn(f64) -> Option<f64>) -> bool {
        let reach = self.reach();
        let (mut blocks, mut sum_squares) = (0.0, 0.0);
        let full = self.len() / BLOCK_SAMPLES * BLOCK_SAMPLES;
        for start in (0..self.len()).step_by(BLOCK_SAMPLES) {
            let end = (start + BLOCK_SAMPLES).min(self.len());
            let mut sum = 0.0;
            for i in start..end {
                let Some(value) = curve(self.time[i]) else {
                    continue;
                };
                let off = self.volts[i] - value;
                if off.is_nan() || off.abs() > reach {
                    return false;
                }
                sum += off;
            }
            if start < full {
                blocks += 1.0;
                let mean = sum / (self.sigma * (BLOCK_SAMPLES as f64).sqrt());
                sum_squares += mean * mean;
            }
        }
        let allowed = (1.0 + NOISE_ESTIMATE_ERROR_SHARE).powi(2)
            * (blocks + MAX_BLOCK_EXCESS_SIGMAS * (2.0f64 * blocks).sqrt());
        self.quantum > 0.0 || blocks == 0.0 || sum_squares <= allowed
    }
}
