//! Frequency responses by windowed spectra (P. Welch, IEEE Trans. Audio 15 (1967) 70), with the
//! estimators H1, H2 and Hv and the coherence (J. Bendat, A. Piersol, Random Data, 2010, ch. 6, 9).
//!
//! The input jumps between samples where the hysteresis branch changes. It is therefore transformed
//! from means over eighths of a sample, so that its aliases stay below 1e-3.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::fit::modal::time_domain::data::{Data, Intervals, Stretch};
use crate::fit::modal::time_domain::input::Input;

/// Parts of a sample over which the input is averaged.
const OVERSAMPLING: usize = 8;
/// First line that a constant under the window does not reach.
const FIRST_LINE: usize = 3;
/// Shortest and longest block \[samples\].
const BLOCK_LIMITS: (usize, usize) = (64, 1 << 18);

/// A frequency response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResponsePoint {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Cross-spectrum over the input's, real and imaginary part \[m per input\]: no bias from noise of the
    /// reading.
    pub h1: [f64; 2],
    /// Reading's spectrum over the cross-spectrum: no bias from noise of the input.
    pub h2: [f64; 2],
    /// Geometric mean of both.
    pub hv: [f64; 2],
    /// Coherence, 0 to 1; 1 without meaning where only one block holds the input.
    pub coherence: f64,
}

/// Averaged spectra of the input and one reading.
#[derive(Debug, Clone)]
pub struct Spectra {
    /// Distance of the lines \[Hz\].
    pub resolution: f64,
    /// Blocks averaged.
    pub blocks: usize,
    /// Power of the input, by line from 0 Hz.
    pub input: Vec<f64>,
    /// Power of the reading.
    pub reading: Vec<f64>,
    /// Conjugate of the input times the reading.
    pub cross: Vec<Complex<f64>>,
}

impl Spectra {
    /// Lines whose input is above `share` of its largest.
    pub fn driven(&self, share: f64) -> Vec<usize> {
        let most = self
            .input
            .iter()
            .skip(FIRST_LINE)
            .copied()
            .fold(0.0, f64::max);
        let lines = FIRST_LINE..self.input.len();
        lines
            .filter(|&k| self.input[k] > share * most && self.input[k] > 0.0)
            .collect()
    }

    /// The response at line `k`.
    #[must_use]
    pub fn at(&self, k: usize) -> Option<ResponsePoint> {
        let (u, y, cross) = (
            *self.input.get(k)?,
            *self.reading.get(k)?,
            *self.cross.get(k)?,
        );
        if !(u > 0.0 && y > 0.0 && cross.norm_sqr() > 0.0) {
            return None;
        }
        let h1 = cross / u;
        let h2 = Complex::from(y) / cross.conj();
        let hv = cross / cross.norm() * (y / u).sqrt();
        let pair = |c: Complex<f64>| [c.re, c.im];
        Some(ResponsePoint {
            frequency: k as f64 * self.resolution,
            h1: pair(h1),
            h2: pair(h2),
            hv: pair(hv),
            coherence: (cross.norm_sqr() / (u * y)).min(1.0),
        })
    }
}

/// Length of blocks for a resolution \[Hz\]: a power of two that the longest stretch holds.
#[must_use]
pub fn block_length(data: &Data, resolution: f64) -> usize {
    let wanted = 1.0 / (resolution * data.interval);
    let most = data.longest_stretch().min(BLOCK_LIMITS.1);
    let mut length = BLOCK_LIMITS.0;
    while 2 * length <= most && (length as f64) < wanted {
        length *= 2;
    }
    length
}

/// Spectra of the input and of `readings` (by stretch; those of the data or what a model leaves of
/// them), Hann windows half overlapping.
#[must_use]
pub fn spectra(
    data: &Data,
    readings: &[[Option<Vec<f64>>; 2]],
    length: usize,
    use_recorded_voltage: bool,
) -> [Option<Spectra>; 2] {
    let lines = length / 2 + 1;
    let resolution = 1.0 / (length as f64 * data.interval);
    let mut found = [None, None];
    for (c, found) in found.iter_mut().enumerate() {
        let has = readings.iter().any(|r| r[c].is_some());
        *found = has.then(|| Spectra {
            resolution,
            blocks: 0,
            input: vec![0.0; lines],
            reading: vec![0.0; lines],
            cross: vec![Complex::from(0.0); lines],
        });
    }
    let mut planner = RealFftPlanner::<f64>::new();
    let fine = planner.plan_fft_forward(length * OVERSAMPLING);
    let coarse = planner.plan_fft_forward(length);
    for (stretch, own) in data.stretches.iter().zip(readings) {
        // Blocks need one clock: that of a stretch with uneven times is its mean.
        if stretch.samples() < length {
            continue;
        }
        let mut from = 0;
        while from + length <= stretch.samples() {
            let mut fine_values = fine_input(data, stretch, from, length, use_recorded_voltage);
            window(&mut fine_values);
            let mut spectrum = fine.make_output_vec();
            if fine.process(&mut fine_values, &mut spectrum).is_err() {
                return found;
            }
            let input = corrected(&spectrum, lines, length);
            for (c, sums) in found.iter_mut().enumerate() {
                let (Some(sums), Some(values)) = (sums.as_mut(), &own[c]) else {
                    continue;
                };
                let mut block = values[from..from + length].to_vec();
                if !complete(&mut block) {
                    continue;
                }
                window(&mut block);
                let mut spectrum = coarse.make_output_vec();
                if coarse.process(&mut block, &mut spectrum).is_err() {
                    continue;
                }
                sums.blocks += 1;
                for (k, (u, y)) in input.iter().zip(&spectrum).enumerate() {
                    sums.input[k] += u.norm_sqr();
                    sums.reading[k] += y.norm_sqr();
                    sums.cross[k] += u.conj() * y;
                }
            }
            from += length / 2;
        }
    }
    found
}

/// Removes the mean, and joins missing samples by straight lines; false if more than a tenth is missing.
fn complete(values: &mut [f64]) -> bool {
    let finite: Vec<usize> = (0..values.len())
        .filter(|&i| values[i].is_finite())
        .collect();
    if 10 * finite.len() < 9 * values.len() {
        return false;
    }
    let mean = finite.iter().map(|&i| values[i]).sum::<f64>() / finite.len() as f64;
    let mut last = mean;
    for value in values.iter_mut() {
        if !value.is_finite() {
            *value = last;
        }
        last = *value;
        *value -= mean;
    }
    true
}

/// Hann's window over equal cells, after the mean under the window is taken out: any other constant
/// would leak into the lowest lines.
fn window(values: &mut [f64]) {
    let n = values.len() as f64;
    let weight = |i: usize| 0.5 * (1.0 - (std::f64::consts::TAU * i as f64 / n).cos());
    let sum: f64 = values.iter().enumerate().map(|(i, v)| weight(i) * v).sum();
    let mean = sum / (0.5 * n);
    for (i, value) in values.iter_mut().enumerate() {
        *value = (*value - mean) * weight(i);
    }
}

/// The input's means over the parts of `length` samples from sample `from` on, each part around its
/// instant.
fn fine_input(
    data: &Data,
    stretch: &Stretch,
    from: usize,
    length: usize,
    recorded: bool,
) -> Vec<f64> {
    let Some(source) = data.sources.get(stretch.recording) else {
        return vec![0.0; length * OVERSAMPLING];
    };
    let input = Input {
        pieces: &source.drive.pieces,
        piezo: data.piezo,
        skew: data.skew,
    };
    let h = data.interval / OVERSAMPLING as f64;
    let start = match &stretch.intervals {
        Intervals::Even(own) => stretch.start + from as f64 * own,
        Intervals::Each(all) => stretch.start + all.iter().take(from).sum::<f64>(),
    };
    if recorded {
        // The samples themselves, with their noise, joined by straight lines.
        let recording = &source.recording;
        let at = |i: usize| {
            let t = start + i as f64 * h - data.skew;
            let value = recording.value_at(crate::recording::Channel::Voltage, t);
            value.unwrap_or(0.0)
        };
        return (0..length * OVERSAMPLING).map(at).collect();
    }
    let mut piece = input.piece_at(start - 0.5 * h);
    (0..length * OVERSAMPLING)
        .map(|i| {
            let t = start + i as f64 * h;
            input.mean(t - 0.5 * h, t + 0.5 * h, &mut piece)
        })
        .collect()
}

/// The first lines of the fine spectrum on the scale of the coarse one, without the means' roll-off.
fn corrected(spectrum: &[Complex<f64>], lines: usize, length: usize) -> Vec<Complex<f64>> {
    let cells = (length * OVERSAMPLING) as f64;
    let lines = spectrum.iter().take(lines).enumerate();
    lines
        .map(|(k, value)| {
            let x = std::f64::consts::PI * k as f64 / cells;
            let roll_off = if k == 0 { 1.0 } else { x.sin() / x };
            value / (OVERSAMPLING as f64 * roll_off)
        })
        .collect()
}
