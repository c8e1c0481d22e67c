//! Spectral peaks of the residuals: a further mode shows as a narrow one.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, Matrix2, SymmetricEigen};
use rayon::prelude::*;

use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{KNOWN_MODE_FREQUENCY_RATIO, PEAK_MIN_SIGNIFICANCE};
use crate::fit::residual::coloured_noise::Colour;
use crate::fit::residual::residual_rows::Row;
use crate::fit::segment::Segment;
use crate::fit::solve::point::residuals_at;
use crate::sim::SimError;

/// Lowest frequency that is searched in a structure of several modes, over that of the slowest: a
/// structure is given with its lowest modes, and the errors of the slowest and its second harmonic
/// are below.
const LOWEST_OVER_SLOWEST: f64 = 2.4;
/// Periods of the slowest mode that is searched in the usual segment of a device of a single mode,
/// which may hang on something softer.
const MIN_PERIODS_IN_SEGMENT: f64 = 4.0;
/// Spacing of the frequencies, as a share of the lowest.
const SPACING_SHARE: f64 = 1.0 / 15.0;
/// Highest frequency, as a share of the sampling rate.
const HIGHEST_RATE_SHARE: f64 = 0.48;
/// Most frequencies of a spectrum.
const MAX_FREQUENCIES: usize = 4000;

/// Fewest samples of a segment that is used.
const MIN_SEGMENT_SAMPLES: usize = 40;
/// Length of the early part of a segment \[samples\]: a damped mode has decayed after it.
const EARLY_SAMPLES: usize = 60;

/// Where an aliased frequency may lie: multiples of the sampling rate, and the sign with which the
/// apparent frequency is added.
const ALIASES: [(f64, f64); 3] = [(1.0, -1.0), (1.0, 1.0), (2.0, -1.0)];
/// A peak is higher than this many frequencies on either side.
const FLANK_BINS: usize = 4;

/// A peak in the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralPeak {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Sampling rate of the recordings \[Hz\].
    pub rate: f64,
    /// Unit vector of proof mass and cantilever: their shares in the peak.
    pub shape: (f64, f64),
    /// Power above the noise, in standard deviations of its scatter.
    pub significance: f64,
    /// Approximate fall of chi2 if it were removed.
    pub gain: f64,
}

impl SpectralPeak {
    /// Higher frequencies that appear at this one by aliasing \[Hz\].
    pub fn aliases(&self) -> [f64; 3] {
        ALIASES.map(|(n, sign)| n * self.rate + sign * self.frequency)
    }
}

/// Residuals of a flight segment: proof mass and cantilever, in units of the noise.
pub(crate) struct SegmentResiduals {
    pub(crate) channels: [Vec<f64>; 2],
    /// Index of the recording.
    pub(crate) recording: usize,
    /// Time of its first sample \[s\].
    pub(crate) start: f64,
    /// Time between samples \[s\].
    pub(crate) interval: f64,
    /// Colour of the noise by which the residuals were whitened.
    pub(crate) colour: Colour,
}

/// Where a further mode is searched for, by the modes and the segments of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchBand {
    /// Lowest frequency \[Hz\].
    pub lowest: f64,
    /// Spacing of the frequencies \[Hz\].
    pub spacing: f64,
}

impl SearchBand {
    /// For a structure of several modes, whose slowest has the frequency `slowest` \[Hz\], or for a
    /// single mass, read in segments of the usual `length` \[s\].
    pub fn new(slowest: Option<f64>, length: f64) -> Self {
        let by_segments = MIN_PERIODS_IN_SEGMENT / length;
        let lowest = slowest.map_or(by_segments, |f| LOWEST_OVER_SLOWEST * f);
        Self {
            lowest,
            spacing: SPACING_SHARE * lowest,
        }
    }

    /// For the residuals `left` of a fit.
    pub(crate) fn of(fitted: &Fitted, left: &[SegmentResiduals]) -> Self {
        let structure = fitted.model.structure();
        let bound = structure.modes.iter().map(|m| m.frequency);
        let bound: Vec<f64> = bound.filter(|f| *f > 0.0).collect();
        let slowest = bound.iter().copied().reduce(f64::min);
        let slowest = slowest.filter(|_| bound.len() > 1);
        let length = |own: &SegmentResiduals| own.interval * own.channels[0].len() as f64;
        let mut lengths: Vec<f64> = left.iter().map(length).collect();
        // Without segments nothing limits it.
        let usual = match lengths.as_mut_slice() {
            [] => 0.0,
            lengths => crate::recording::quantile_in_place(lengths, 0.5),
        };
        Self::new(slowest, usual)
    }

    /// The frequencies of a spectrum of samples taken at `rate` \[Hz\].
    fn frequencies(&self, rate: f64) -> Vec<f64> {
        let count = (HIGHEST_RATE_SHARE * rate - self.lowest) / self.spacing;
        if !(count.is_finite() && count >= 5.0) {
            return Vec::new();
        }
        let count = (count.floor() as usize).min(MAX_FREQUENCIES);
        let at = |k: usize| self.lowest + k as f64 * self.spacing;
        (0..count).map(at).collect()
    }
}

/// Lowest sampling rate among the recordings of a fit \[Hz\]; `None` without any.
pub(crate) fn slowest_rate(fitted: &Fitted) -> Option<f64> {
    let data = fitted.problem.data.iter();
    data.map(|d| d.recording.sampling_rate()).reduce(f64::min)
}

/// The highest peak in the residuals of a fit, if there are enough for a spectrum: of whole
/// segments, in which a mode rings on, or of their early parts, after which it has decayed.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn strongest_peak(fitted: &Fitted) -> Result<Option<SpectralPeak>, SimError> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let Some(rate) = slowest_rate(fitted) else {
        return Ok(None);
    };
    let left = flight_residuals(fitted)?;
    let frequencies = SearchBand::of(fitted, &left).frequencies(rate);
    if left.len() < 5 || frequencies.is_empty() {
        return Ok(None);
    }
    let both = point
        .segments
        .first()
        .is_some_and(|s| problem.data[s.recording].recording.cantilever.is_some());
    // A peak next to a mode of the model belongs to that mode, unless nothing else stands out.
    let structure = fitted.model.structure_with_effects();
    let beside = |f: f64| {
        let known = structure.modes.iter().map(|m| m.frequency);
        known.filter(|known| *known > 0.0).any(|known| {
            f < KNOWN_MODE_FREQUENCY_RATIO * known && known < KNOWN_MODE_FREQUENCY_RATIO * f
        })
    };
    let humps = [usize::MAX, EARLY_SAMPLES]
        .map(|length| spectral_peaks(&left, (&frequencies, rate), length, both));
    let highest = |which: &dyn Fn(f64) -> bool| {
        let all = humps.iter().flatten();
        all.filter(|ring| which(ring.frequency) && ring.gain.is_finite())
            .max_by(|a, b| a.significance.total_cmp(&b.significance))
            .copied()
    };
    let elsewhere = highest(&|f| !beside(f)).filter(|r| r.significance > PEAK_MIN_SIGNIFICANCE);
    let ring = elsewhere.or_else(|| highest(&|_| true));
    log::debug!("highest peak: {ring:?}");
    Ok(ring)
}

/// Residuals of the flight segments that are long enough.
pub(crate) fn flight_residuals(fitted: &Fitted) -> Result<Vec<SegmentResiduals>, SimError> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let all = residuals_at(problem, point, |i, s| {
        point.used[i] && s.samples.len() >= MIN_SEGMENT_SAMPLES && !s.starts_held
    })?;
    let left = |(segment, r): (&Segment, Option<Vec<f64>>)| {
        let (rows, r) = (problem.rows(segment), r?);
        let of = |kind: Row| -> Vec<f64> {
            let own = rows.iter().zip(&r).filter(|(row, _)| **row == kind);
            own.map(|(_, r)| r.clamp(-5.0, 5.0)).collect()
        };
        let data = &problem.data[segment.recording];
        Some(SegmentResiduals {
            channels: [of(Row::ProofMass), of(Row::Cantilever)],
            recording: segment.recording,
            start: data.recording.time[segment.samples.start],
            interval: segment.interval,
            colour: data.sigmas.colour,
        })
    };
    Ok(point.segments.iter().zip(all).filter_map(left).collect())
}

/// Peaks of the power spectrum of the first `length` samples of all segments, averaged over them
/// and relative to its median, at the `frequencies` \[Hz\].
fn spectral_peaks(
    left: &[SegmentResiduals],
    (frequencies, rate): (&[f64], f64),
    length: usize,
    both: bool,
) -> Vec<SpectralPeak> {
    let spectrum = |own: &SegmentResiduals, f: f64| {
        own.channels.each_ref().map(|values| {
            let turn = Complex::from_polar(1.0, -TAU * f * own.interval);
            let mut phase = Complex::new(1.0, 0.0);
            let (mut sum, mut power) = (Complex::new(0.0, 0.0), 0.0);
            for (i, v) in values.iter().take(length).enumerate() {
                // A sharp cut would give the peak side lobes.
                let weight = match length {
                    usize::MAX => 1.0,
                    _ => (0.5 * PI * i as f64 / length as f64).cos().powi(2),
                };
                sum += phase * (weight * v);
                power += weight * weight;
                phase *= turn;
            }
            sum / power.max(1.0).sqrt()
        })
    };
    let n = left.len() as f64;
    // Largest share of the power that one direction of the two readings holds.
    let powers: Vec<(f64, (f64, f64))> = frequencies
        .par_iter()
        .map(|&f| {
            let mut m = Matrix2::zeros();
            for own in left {
                let [p, c] = spectrum(own, f);
                m[(0, 0)] += p.norm_sqr() / n;
                m[(1, 1)] += c.norm_sqr() / n;
                m[(0, 1)] += (p * c.conj()).re / n;
            }
            m[(1, 0)] = m[(0, 1)];
            if !both {
                return (m[(0, 0)], (1.0, 0.0));
            }
            let eigen = SymmetricEigen::new(m);
            let top = eigen.eigenvalues.imax();
            let v = eigen.eigenvectors.column(top);
            (eigen.eigenvalues[top], (v[0], v[1]))
        })
        .collect();
    let mut sorted: Vec<f64> = powers.iter().map(|p| p.0).collect();
    let usual = crate::recording::quantile_in_place(&mut sorted, 0.5);
    let spread = usual / n.sqrt();
    let top = |k: usize| {
        // A spectrum that only rises towards an end has its peak beyond it.
        let inside = k > 0 && k + 1 < powers.len();
        let around = k.saturating_sub(FLANK_BINS)..(k + FLANK_BINS + 1).min(powers.len());
        inside && powers[around].iter().all(|p| p.0 <= powers[k].0)
    };
    // The flank of a peak is not a peak.
    let tops = (0..powers.len()).filter(|k| top(*k));
    tops.map(|k| SpectralPeak {
        frequency: frequencies[k],
        rate,
        shape: powers[k].1,
        significance: (powers[k].0 - usual) / spread,
        gain: (powers[k].0 - usual) * n,
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::super::residual_spectrum::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const SAMPLING_RATE: f64 = 50e3;

    /// Stretches of white noise in which a mode of `frequency` rings, `decay` samples long, of
    /// `size` at the proof mass and half of that at the cantilever.
    fn stretches(frequency: f64, decay: f64, size: f64) -> Vec<SegmentResiduals> {
        let mut dice = ChaCha8Rng::seed_from_u64(3);
        (0..60)
            .map(|k| {
                let phase = 2.4 * k as f64;
                let mut channel = |share: f64| -> Vec<f64> {
                    let ring = |i: usize| {
                        let turn = TAU * frequency * i as f64 / SAMPLING_RATE + phase;
                        share * size * (-(i as f64) / decay).exp() * turn.sin()
                    };
                    (0..600)
                        .map(|i| {
                            let noise: f64 = (0..12).map(|_| dice.random_range(-0.5..0.5)).sum();
                            noise + ring(i)
                        })
                        .collect()
                };
                SegmentResiduals {
                    channels: [channel(1.0), channel(0.5)],
                    recording: 0,
                    start: 0.0,
                    interval: 1.0 / SAMPLING_RATE,
                    colour: Colour::WHITE,
                }
            })
            .collect()
    }

    fn highest(left: &[SegmentResiduals], length: usize) -> SpectralPeak {
        let frequencies: Vec<f64> = (15..240).map(|k| 100.0 * f64::from(k)).collect();
        let all = spectral_peaks(left, (&frequencies, SAMPLING_RATE), length, true);
        let top = all.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
        *top.expect("a spectrum")
    }

    #[test]
    fn the_searched_band_goes_with_the_device() {
        // The paper's device in segments of a millisecond.
        let band = SearchBand::new(Some(623.0), 1e-3);
        assert!((band.lowest - 1495.2).abs() < 1e-9, "{band:?}");
        let all = band.frequencies(50e3);
        assert!((220..240).contains(&all.len()), "{}", all.len());
        // Everything a thousand times slower: the same frequencies in other units.
        let slow = SearchBand::new(Some(0.623), 1.0).frequencies(50.0);
        assert_eq!(slow.len(), all.len());
        assert!((1e3 * slow[7] / all[7] - 1.0).abs() < 1e-12);
        // A spring at 1.37 Hz, read for 10 of its periods: a mode below it is in the band, too.
        let spring = SearchBand::new(None, 10.0 / 1.37);
        assert!(spring.lowest < 0.6, "{spring:?}");
        let highest = spring.frequencies(100.0).pop().unwrap();
        assert!(highest > 40.0, "{highest}");
        // Without segments nothing is searched.
        assert!(SearchBand::new(None, 0.0).frequencies(100.0).is_empty());
    }

    #[test]
    fn noise_has_no_peak() {
        let left = stretches(7e3, 100.0, 0.0);
        for length in [usize::MAX, EARLY_SAMPLES] {
            let ring = highest(&left, length);
            assert!(ring.significance < PEAK_MIN_SIGNIFICANCE, "{ring:?}");
        }
    }

    #[test]
    fn a_lightly_damped_mode_is_found_with_its_shape() {
        let ring = highest(&stretches(7e3, 400.0, 0.5), usize::MAX);
        assert!(ring.significance > 2.0 * PEAK_MIN_SIGNIFICANCE, "{ring:?}");
        assert!((ring.frequency - 7e3).abs() <= 100.0, "{ring:?}");
        assert!((ring.shape.1 / ring.shape.0 - 0.5).abs() < 0.1, "{ring:?}");
    }

    #[test]
    fn a_damped_mode_is_found_in_the_early_samples() {
        let left = stretches(18e3, 15.0, 1.2);
        let (whole, early) = (highest(&left, usize::MAX), highest(&left, EARLY_SAMPLES));
        assert!(
            early.significance > 1.5 * PEAK_MIN_SIGNIFICANCE,
            "{early:?}"
        );
        assert!(early.significance > 1.5 * whole.significance, "{whole:?}");
        assert!((early.frequency - 18e3).abs() <= 500.0, "{early:?}");
    }

    #[test]
    fn the_flank_of_a_peak_is_not_a_peak() {
        let left = stretches(7e3, 40.0, 4.0);
        let frequencies: Vec<f64> = (15..240).map(|k| 100.0 * f64::from(k)).collect();
        for length in [usize::MAX, EARLY_SAMPLES] {
            for ring in spectral_peaks(&left, (&frequencies, SAMPLING_RATE), length, true) {
                let beside = (ring.frequency - 7e3).abs() > 1e3;
                assert!(
                    !beside || ring.significance < PEAK_MIN_SIGNIFICANCE,
                    "{ring:?}"
                );
            }
        }
    }
}
