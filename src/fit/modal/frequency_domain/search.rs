//! Where a resonance is likely: the oscillator that explains most of what is left of the readings.

use realfft::num_complex::Complex;

use super::spectra::Spectra;
use crate::fit::modal::time_domain::kernel::Pole;

/// Damping ratios that are tried.
const ZETAS: [f64; 6] = [0.001, 0.004, 0.012, 0.035, 0.1, 0.3];
/// Steps of frequency over the damping ratio.
const FREQUENCY_STEP: f64 = 0.7;
/// How far beyond the driven band resonances are looked for, as factors.
const BEYOND_BAND: (f64, f64) = (0.5, 1.6);
/// Half-widths of a resonance within which another peak is the same one.
const SAME_PEAK_WIDTHS: f64 = 2.0;
/// Lines of the spectrum that are looked at for one oscillator, at most.
const MAX_LINES: usize = 1500;
/// Lines on a resonance's half-width that are enough.
const LINES_PER_WIDTH: f64 = 20.0;

/// A likely resonance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Its pole.
    pub pole: Pole,
    /// Log-likelihood per sample that it would gain, roughly.
    pub score: f64,
}

/// Likely resonances in what `left` holds, the best first, at most `count`. `band` is driven \[Hz\].
#[must_use]
pub fn candidates(left: &[Option<Spectra>; 2], band: (f64, f64), count: usize) -> Vec<Candidate> {
    let Some(any) = left.iter().flatten().next() else {
        return Vec::new();
    };
    let nyquist = 0.5 * any.resolution * (2 * (any.input.len() - 1)) as f64;
    let (low, high) = (
        BEYOND_BAND.0 * band.0,
        (BEYOND_BAND.1 * band.1).min(0.8 * nyquist),
    );
    let mut all: Vec<Candidate> = Vec::new();
    for zeta in ZETAS {
        let mut f = low;
        while f < high {
            let pole = Pole {
                omega: std::f64::consts::TAU * f,
                zeta,
            };
            let score = left.iter().flatten().map(|s| gained(s, pole, band)).sum();
            all.push(Candidate { pole, score });
            // Not finer than the lines of the spectrum tell.
            f += (FREQUENCY_STEP * zeta * f).max(0.5 * any.resolution);
        }
    }
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut picked: Vec<Candidate> = Vec::new();
    for candidate in all {
        let is_same = |other: &Candidate| {
            let apart = (candidate.pole.omega - other.pole.omega).abs();
            let zeta = candidate.pole.zeta.max(other.pole.zeta);
            apart < SAME_PEAK_WIDTHS * zeta * other.pole.omega
        };
        if !picked.iter().any(is_same) {
            picked.push(candidate);
            if picked.len() == count {
                break;
            }
        }
    }
    picked
}

/// Log-likelihood per line that an oscillator would gain.
fn gained(spectra: &Spectra, pole: Pole, band: (f64, f64)) -> f64 {
    let first = ((band.0 / spectra.resolution).floor() as usize).max(1);
    let last = ((band.1 / spectra.resolution).ceil() as usize).min(spectra.input.len() - 1);
    let center = pole.omega / std::f64::consts::TAU / spectra.resolution;
    let near = (6.0 * pole.zeta * center).max(6.0);
    let thin = ((last.saturating_sub(first)) / MAX_LINES).max(1);
    let fine = ((pole.zeta * center / LINES_PER_WIDTH) as usize).clamp(1, thin);
    let (mut inner, mut own, mut whole) = (0.0, 0.0, 0.0);
    let mut k = first;
    while k <= last {
        // Far from the resonance, or where it is broad, a few lines stand for all.
        let step = if (k as f64 - center).abs() <= near {
            fine
        } else {
            thin.max(fine)
        };
        let weight = step as f64;
        let response: Complex<f64> = pole.receptance(k as f64 * spectra.resolution);
        inner += weight * (response.conj() * spectra.cross[k]).re;
        own += weight * response.norm_sqr() * spectra.input[k];
        whole += weight * spectra.reading[k];
        k += step;
    }
    if own <= 0.0 || whole <= 0.0 {
        return 0.0;
    }
    let share = (inner * inner / own / whole).clamp(0.0, 1.0 - 1e-12);
    -(1.0 - share).ln()
}

/// By how much noise around a resonance exceeds white noise, in the worse of the readings' spectra
/// \[-\]; 1 or more.
#[must_use]
pub fn worst_local_excess(left: &[Option<Spectra>; 2], pole: Pole) -> f64 {
    let excesses = left.iter().flatten().map(|s| local_excess(s, pole));
    excesses.fold(1.0, f64::max)
}

/// Power of a reading's spectrum around a resonance over its mean \[-\].
fn local_excess(left: &Spectra, pole: Pole) -> f64 {
    let center = pole.omega / std::f64::consts::TAU / left.resolution;
    let half = (3.0 * pole.zeta * center).max(8.0);
    let count = left.reading.len();
    let from = ((center - half).max(1.0) as usize).min(count.saturating_sub(1));
    let to = ((center + half).ceil() as usize + 1).clamp(from + 1, count);
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len().max(1) as f64;
    let whole = mean(&left.reading[1..]);
    let here = mean(&left.reading[from..to]);
    if whole > 0.0 {
        (here / whole).max(1.0)
    } else {
        1.0
    }
}
