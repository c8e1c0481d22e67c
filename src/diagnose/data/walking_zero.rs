//! A zero that walks: how far the reading of a resting mass wanders from contact to contact.
//!
//! A laser spot that warms up, a lamp or an amplifier lets the zero of a reading wander at random.
//! While the mass is held, its reading tells where the zero is. A random walk is taken for the cause
//! where it makes the mean readings likelier than noise alone does, and than each of what is steadier:
//! a drift along a line, a drift that settles, a ground that shifts once, a contact that was misread.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::event_free_segments::intervals;
use super::noise_model::ContactRecording;
use crate::diagnose::thresholds::{WALKING_ZERO_MIN_GAIN, WALKING_ZERO_MIN_LEAD};
use crate::fit::residual::coloured_noise::Colour;

/// Longest part of a contact whose mean is taken \[s\].
const MAX_WINDOW_LENGTH: f64 = 12e-3;
/// Fewest samples of a mean.
const MIN_WINDOW_SAMPLES: usize = 20;
/// Time after touchdown that is skipped, for the rest of the landing \[s\].
const LANDING_TIME: f64 = 5e-4;
/// Fewest contacts of a recording that tell a walk from a steady drift, which follows any two.
const MIN_CONTACTS: usize = 3;
/// Walks over a recording that are tried, in units of a sample's noise: least, most, and how many for
/// each factor of ten.
const WALKS: (f64, f64, i32) = (0.05, 50.0, 8);
/// Times in which a drift settles that are tried, as shares of the time from the first contact to the
/// last.
const SETTLING_SHARES: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];
/// Variance of a walk about its mean, as a share of that of its whole length.
const SPREAD_SHARE: f64 = 1.0 / 6.0;

/// Mean reading in a part of a contact.
struct RestingMean {
    samples: Range<usize>,
    /// In units of the noise.
    value: f64,
}

impl RestingMean {
    /// Middle of its samples.
    fn middle(&self) -> f64 {
        self.samples.start as f64 + 0.5 * self.samples.len() as f64
    }
}

/// The colour of the noise with the walk that the contacts show; as it is where they show none.
pub fn with_walk(stays: &[ContactRecording<'_>], colour: Colour) -> Colour {
    let slow = 1.0 + 2.0 * colour.share * colour.keep / (1.0 - colour.keep).max(1e-6);
    let mut means: Vec<Vec<RestingMean>> = stays.iter().map(resting_means).collect();
    means.retain(|own| own.len() >= MIN_CONTACTS);
    let total = |of: &dyn Fn(&[RestingMean]) -> f64| means.iter().map(|own| of(own)).sum::<f64>();
    let samples: usize = stays.iter().map(|s| s.recording.len()).sum();
    let length = samples as f64 / stays.len() as f64;
    let (low, high, steps) = WALKS;
    let count = (f64::from(steps) * (high / low).log10()) as i32;
    let tried = (0..=count).map(|k| {
        let over_recording = low * 10f64.powf(f64::from(k) / f64::from(steps));
        let walk = over_recording.powi(2) / length;
        // One number for the size of the walk.
        (total(&|own| log_likelihood(own, slow, walk)) - 1.0, walk)
    });
    let Some((likelihood, walk)) = tried.max_by(|a, b| a.0.total_cmp(&b.0)) else {
        return colour;
    };
    let still = total(&|own| log_likelihood(own, slow, 0.0));
    let rivals: [Shapes; 4] = [line, settling, one_shift, one_aside];
    let steadiest = rivals.iter().map(|&shapes| {
        total(&|own| {
            let of_shape =
                |(shape, numbers): (Vec<f64>, f64)| with_shape(own, slow, &shape) - numbers;
            shapes(own)
                .into_iter()
                .map(of_shape)
                .fold(f64::NEG_INFINITY, f64::max)
        })
    });
    let steadiest = steadiest.fold(f64::NEG_INFINITY, f64::max);
    log::debug!("zero: walks {likelihood:.1}, is still {still:.1}, or steadier {steadiest:.1}");
    if likelihood < still + WALKING_ZERO_MIN_GAIN || likelihood < steadiest + WALKING_ZERO_MIN_LEAD
    {
        return colour;
    }
    log::debug!(
        "zero walks by {:.2} of the noise in a recording",
        (walk * length).sqrt()
    );
    Colour {
        walk,
        level: SPREAD_SHARE * walk * length,
        ..colour
    }
}

/// What else the means of a recording may follow: shapes, each with the count of the numbers it has.
type Shapes = fn(&[RestingMean]) -> Vec<(Vec<f64>, f64)>;

fn line(means: &[RestingMean]) -> Vec<(Vec<f64>, f64)> {
    vec![(means.iter().map(RestingMean::middle).collect(), 1.0)]
}

fn settling(means: &[RestingMean]) -> Vec<(Vec<f64>, f64)> {
    let first = means.first().map_or(0.0, RestingMean::middle);
    let span = means.last().map_or(1.0, |m| m.middle() - first);
    let of = |share: &f64| {
        let decay = |m: &RestingMean| (-(m.middle() - first) / (share * span)).exp();
        (means.iter().map(decay).collect(), 2.0)
    };
    SETTLING_SHARES.iter().map(of).collect()
}

fn one_shift(means: &[RestingMean]) -> Vec<(Vec<f64>, f64)> {
    let of = |at: usize| {
        let later = |i: usize| f64::from(u8::from(i >= at));
        ((0..means.len()).map(later).collect(), 2.0)
    };
    (1..means.len()).map(of).collect()
}

fn one_aside(means: &[RestingMean]) -> Vec<(Vec<f64>, f64)> {
    let of = |at: usize| {
        let that = |i: usize| f64::from(u8::from(i == at));
        ((0..means.len()).map(that).collect(), 2.0)
    };
    (0..means.len()).map(of).collect()
}

/// Logarithm of the likelihood of the means of a recording, but for a constant, with a zero of any
/// size that walks by the variance `walk` from sample to sample, in units of the noise; a mean is as
/// uncertain as `slow` times as little white noise makes it.
fn log_likelihood(means: &[RestingMean], slow: f64, walk: f64) -> f64 {
    let first = means.first().map_or(0.0, RestingMean::middle);
    let covariance = DMatrix::from_fn(means.len(), means.len(), |i, j| {
        let earlier = means[i.min(j)].middle() - first;
        if i == j {
            let own = means[i].samples.len() as f64;
            // Two samples of one window have on average a third of it in common.
            slow / own + walk * (earlier + own / 6.0)
        } else {
            walk * earlier
        }
    });
    let ones = DMatrix::from_element(means.len(), 1, 1.0);
    of_residuals(means, covariance, &ones)
}

/// The same without a walk, with a multiple of `shape` beside the constant.
fn with_shape(means: &[RestingMean], slow: f64, shape: &[f64]) -> f64 {
    let variances = means.iter().map(|m| slow / m.samples.len() as f64);
    let covariance = DMatrix::from_diagonal(&DVector::from_iterator(means.len(), variances));
    let design = DMatrix::from_fn(means.len(), 2, |i, k| if k == 0 { 1.0 } else { shape[i] });
    of_residuals(means, covariance, &design)
}

/// Logarithm of the likelihood with the best multiples of the columns of `design` taken out.
fn of_residuals(means: &[RestingMean], covariance: DMatrix<f64>, design: &DMatrix<f64>) -> f64 {
    let Some(cholesky) = covariance.cholesky() else {
        return f64::NEG_INFINITY;
    };
    let values =
        DVector::from_iterator(means.len(), means.iter().map(|m| m.value - means[0].value));
    // Whitened, the best multiples are those of least squares.
    let white = |m: &DMatrix<f64>| cholesky.l().solve_lower_triangular(m);
    let (Some(rows), Some(columns)) = (cholesky.l().solve_lower_triangular(&values), white(design))
    else {
        return f64::NEG_INFINITY;
    };
    let Ok(best) = columns.clone().svd(true, true).solve(&rows, 1e-12) else {
        return f64::NEG_INFINITY;
    };
    let left = (rows - columns * best).norm_squared();
    let logs: f64 = cholesky.l().diagonal().iter().map(|d| d.ln()).sum();
    -0.5 * left - logs
}

/// One mean for each contact, from its beginning, so that a ground that gives way is pressed alike in
/// each period.
fn resting_means(stays: &ContactRecording<'_>) -> Vec<RestingMean> {
    let r = stays.recording;
    let most = (MAX_WINDOW_LENGTH / r.interval()) as usize;
    let skip = (LANDING_TIME / r.interval()).ceil() as usize;
    let held = intervals(r, &r.proof_mass, stays.timeline, &(0..r.len()), None);
    let held = held.into_iter().filter(|stay| stay.held);
    held.filter_map(|stay| {
        let start = (stay.samples.start + skip).min(stay.samples.end);
        let samples = start..stay.samples.end.min(start + most);
        let values = r.proof_mass[samples.clone()].iter();
        let finite: Vec<f64> = values.copied().filter(|x| x.is_finite()).collect();
        let sum: f64 = finite.iter().sum();
        (finite.len() >= MIN_WINDOW_SAMPLES).then(|| RestingMean {
            samples,
            value: sum / (finite.len() as f64 * stays.sigma),
        })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::super::walking_zero::*;
    use crate::fit::segment::event_sequence::Timeline;
    use crate::recording::Recording;
    use crate::trial::rng::TrialRng;

    const SIGMA: f64 = 20e-9;
    const SAMPLES: u32 = 10_000;

    /// A mass that is held and away in turn for 9 ms, read with white noise while its ground moves as
    /// `zero` says of the share of the recording that is over, and its zero walks by `walk` \[m\].
    fn held(walk: f64, zero: &dyn Fn(f64) -> f64, seed: u64) -> Recording {
        let mut rng = TrialRng::new(seed, 0);
        let time: Vec<f64> = (0..SAMPLES).map(|i| 2e-5 * f64::from(i)).collect();
        let step = walk / f64::from(SAMPLES).sqrt();
        let mut walked = 0.0;
        let xp = time.iter().map(|t| {
            let level = if ((t / 9e-3) as usize).is_multiple_of(2) {
                -58e-6
            } else {
                40e-6
            };
            walked += step * rng.normal();
            level + walked + zero(t / 0.2) + SIGMA * rng.normal()
        });
        let xp = xp.collect();
        Recording::new("held", time, None, xp, None).unwrap()
    }

    /// The walk over a whole recording that three such recordings show \[m\].
    fn found(walk: f64, zero: &dyn Fn(f64) -> f64, seed: u64) -> f64 {
        let all: Vec<Recording> = (0..3).map(|k| held(walk, zero, 10 * seed + k)).collect();
        let timelines: Vec<Timeline> = all
            .iter()
            .map(|r| Timeline::new(&r.time, &r.proof_mass, -58e-6, SIGMA))
            .collect();
        let both = all.iter().zip(&timelines);
        let stays: Vec<ContactRecording<'_>> = both
            .map(|(recording, timeline)| ContactRecording {
                recording,
                timeline,
                sigma: SIGMA,
            })
            .collect();
        let colour = with_walk(&stays, Colour::WHITE);
        SIGMA * (colour.walk * f64::from(SAMPLES)).sqrt()
    }

    #[test]
    fn a_walk_is_estimated_and_nothing_else_passes_for_one() {
        let mut logarithms = Vec::new();
        for seed in 0..6 {
            assert_eq!(found(0.0, &|_| 0.0, seed), 0.0);
            let drift = |share: f64| 2e-6 * (1.0 - (-3.0 * share).exp());
            assert_eq!(found(0.0, &drift, seed), 0.0);
            let shift = |share: f64| if share > 0.4 { 1e-6 } else { 0.0 };
            assert_eq!(found(0.0, &shift, seed), 0.0);
            logarithms.push((found(30e-9, &|_| 0.0, seed) / 30e-9).ln());
        }
        let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
        assert!(mean.abs() < 0.25, "{logarithms:?}");
    }
}
