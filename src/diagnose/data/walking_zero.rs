//! A zero that walks: how far the reading of a resting mass wanders from contact to contact.
//!
//! A laser spot that warms up, a lamp or an amplifier lets the zero of a reading wander at random.
//! While the mass is held, its reading tells where the zero is. Two kinds of contrasts of the mean
//! readings are compared with what noise and a walk give: steps from one contact to the next, which a
//! single shift of the ground hardly changes, and deviations from the line between both neighbours,
//! which a steady drift hardly changes. A walk shows in both.

use std::ops::Range;

use super::event_free_segments::intervals;
use super::noise_model::ContactRecording;
use crate::diagnose::thresholds::WALKING_ZERO_MIN_Z;
use crate::fit::residual::coloured_noise::Colour;
use crate::recording::median_in_place;

/// Longest part of a contact whose mean is taken \[s\].
const MAX_WINDOW_LENGTH: f64 = 12e-3;
/// Fewest samples of a mean.
const MIN_WINDOW_SAMPLES: usize = 20;
/// Time after touchdown that is skipped, for the rest of the landing \[s\].
const LANDING_TIME: f64 = 5e-4;
/// Fewest contrasts of either kind.
const MIN_CONTRASTS: usize = 8;
/// Median of the square of a standard normal number.
const MEDIAN_OF_SQUARE: f64 = 0.4549;
/// Relative standard error of the median of such squares, times the root of their number.
const MEDIAN_ERROR: f64 = 2.3;
/// Halvings in which the size of the walk is found.
const BISECTIONS: usize = 60;
/// Variance of a walk about its mean, as a share of that of its whole length.
const SPREAD_SHARE: f64 = 1.0 / 6.0;

/// Mean reading in a part of a contact.
struct RestingMean {
    samples: Range<usize>,
    /// In units of the noise.
    value: f64,
}

/// A weighted sum of means that is zero on average, with the variances that noise gives it and
/// that a walk of one unit a sample gives it.
struct Contrast {
    value: f64,
    noise: f64,
    per_walk: f64,
}

/// The colour of the noise with the walk that the contacts show; as it is where they show none.
pub fn with_walk(stays: &[ContactRecording<'_>], colour: Colour) -> Colour {
    let slow = 1.0 + 2.0 * colour.share * colour.keep / (1.0 - colour.keep).max(1e-6);
    let means: Vec<Vec<RestingMean>> = stays.iter().map(resting_means).collect();
    let of_windows = |count: usize, weights: &dyn Fn(&[RestingMean]) -> Vec<f64>| {
        let all = means.iter().flat_map(|own| own.windows(count));
        all.map(|own| contrast(own, &weights(own), slow))
            .collect::<Vec<Contrast>>()
    };
    let steps = of_windows(2, &|_| vec![-1.0, 1.0]);
    let bends = of_windows(3, &|own| {
        let middle = |k: usize| own[k].samples.start as f64 + 0.5 * own[k].samples.len() as f64;
        let share = (middle(1) - middle(0)) / (middle(2) - middle(0));
        vec![share - 1.0, 1.0, -share]
    });
    let walk = size_of_walk(&steps).min(size_of_walk(&bends));
    if walk <= 0.0 {
        return colour;
    }
    let samples: usize = stays.iter().map(|s| s.recording.len()).sum();
    let length = samples as f64 / stays.len() as f64;
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

/// The contrast of consecutive means with `weights`; a mean is as uncertain as `slow` times as little
/// white noise makes it.
fn contrast(means: &[RestingMean], weights: &[f64], slow: f64) -> Contrast {
    let both = || means.iter().zip(weights);
    let value = both().map(|(m, w)| w * m.value).sum();
    let noise = both()
        .map(|(m, w)| slow * w * w / m.samples.len() as f64)
        .sum();
    // A step of the walk moves all later samples: the variance is the sum of the squares of the
    // weights from each sample on.
    let (mut per_walk, mut later) = (0.0, 0.0);
    let mut begin: Option<usize> = None;
    for (m, w) in both().rev() {
        let gap = begin.map_or(0, |begin| begin.saturating_sub(m.samples.end));
        per_walk += later * later * gap as f64;
        let each = w / m.samples.len() as f64;
        for _ in m.samples.clone() {
            later += each;
            per_walk += later * later;
        }
        begin = Some(m.samples.start);
    }
    Contrast {
        value,
        noise,
        per_walk,
    }
}

/// Variance of the walk from one sample to the next that the contrasts show, in units of that of the
/// noise; 0 where noise explains them. Medians do not see single contrasts that are off.
fn size_of_walk(contrasts: &[Contrast]) -> f64 {
    if contrasts.len() < MIN_CONTRASTS {
        return 0.0;
    }
    let typical = |walk: f64| {
        let squares = contrasts.iter();
        let squares = squares.map(|c| c.value * c.value / (c.noise + walk * c.per_walk));
        let mut squares: Vec<f64> = squares.collect();
        median_in_place(&mut squares) / MEDIAN_OF_SQUARE
    };
    let error = MEDIAN_ERROR / (contrasts.len() as f64).sqrt();
    if typical(0.0) < 1.0 + WALKING_ZERO_MIN_Z * error {
        return 0.0;
    }
    let largest = contrasts.iter().map(|c| c.value * c.value / c.per_walk);
    let (mut low, mut high) = (0.0, largest.fold(0.0, f64::max) / MEDIAN_OF_SQUARE);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if typical(middle) > 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
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
