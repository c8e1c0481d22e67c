//! Size and colour of the readings' noise, estimated from contacts: there the mass is at rest, and
//! all that its reading does is the sensor's.

use std::ops::Range;

use super::event_free_segments::intervals;
use crate::diagnose::thresholds::{
    COLOURED_NOISE_MIN_GAIN, COMMON_NOISE_MAX_Z, OWN_NOISE_MIN_RATIO,
};
use crate::fit::residual::coloured_noise::Colour;
use crate::fit::segment::event_sequence::Timeline;
use crate::recording::Recording;

/// Length of the windows in which contacts are analysed \[s\].
const WINDOW_LENGTH: f64 = 12e-3;
/// Fewest samples of a window.
const MIN_WINDOW_SAMPLES: usize = 40;
/// Time after touchdown that is skipped, for the rest of the landing \[s\].
const LANDING_TIME: f64 = 5e-4;
/// Fewest windows from which a colour is estimated.
const MIN_WINDOWS: usize = 4;
/// Shares of the variance with a memory that are tried.
const COLOURED_SHARE_GRID: [f64; 12] = [
    0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.75, 0.9,
];
/// Memories that are tried \[samples\].
const MEMORY_GRID: [f64; 10] = [1.0, 1.5, 2.5, 4.0, 7.0, 12.0, 20.0, 35.0, 60.0, 120.0];
/// Neighbours of a grid point in share and memory, in steps.
const GRID_NEIGHBOURS: [(i32, i32); 8] = [
    (-1, -1),
    (-1, 0),
    (-1, 1),
    (0, -1),
    (0, 1),
    (1, -1),
    (1, 0),
    (1, 1),
];
/// Largest share of the variance with a memory.
const MAX_COLOURED_SHARE: f64 = 0.95;

/// Relative standard error of a noise estimate, times the root of the number of samples. Medians
/// of high-order differences discard most of the information in independent samples.
const NOISE_ESTIMATE_ERROR: f64 = 2.6;

/// Noise of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Factor on the noise estimated from differences of neighbouring samples, which do not
    /// see slow noise.
    pub factor: f64,
    /// Its colour.
    pub colour: Colour,
}

/// A recording with its events, from whose contacts the noise is estimated.
#[derive(Debug, Clone, Copy)]
pub struct ContactRecording<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Its events at the ground.
    pub timeline: &'a Timeline,
    /// Noise of the proof mass estimated from neighbouring samples \[m\].
    pub sigma: f64,
}

/// One instrument has one noise. Estimates from single recordings, each with its number of
/// samples, are replaced by the common one where they agree within their errors. Quick motion
/// passes for noise in neighbouring samples, so recordings far noisier than the quietest take the
/// common value too. Returns its relative standard error; infinite if there is none.
pub fn pool_noise(estimates: &mut [(usize, &mut f64)]) -> f64 {
    let known = |sigma: f64| sigma.is_finite() && sigma > 0.0;
    let error_of = |samples: f64| NOISE_ESTIMATE_ERROR / samples.max(1.0).sqrt();
    let quietest = estimates.iter().filter(|(_, s)| known(**s));
    let quietest = quietest.min_by(|a, b| a.1.total_cmp(&*b.1));
    let Some((own, least)) = quietest.map(|(n, s)| (*n as f64, **s)) else {
        return f64::INFINITY;
    };
    // Estimates from few samples scatter by more than noises differ.
    let near = |n: usize, sigma: f64| {
        let scatter = COMMON_NOISE_MAX_Z * error_of(own).hypot(error_of(n as f64));
        known(sigma) && sigma <= OWN_NOISE_MIN_RATIO.max(1.0 + scatter) * least
    };
    let (mut sum, mut samples) = (0.0, 0.0);
    for (n, sigma) in estimates.iter().filter(|(n, s)| near(*n, **s)) {
        sum += *n as f64 * **sigma;
        samples += *n as f64;
    }
    let common = sum / samples;
    for (n, sigma) in estimates {
        let error = error_of(*n as f64);
        let agrees = (**sigma / common - 1.0).abs() < COMMON_NOISE_MAX_Z * error;
        if agrees || !near(*n, **sigma) {
            **sigma = common;
        }
    }
    error_of(samples)
}

/// Size and colour of the noise of the proof mass's reading from the contacts of all recordings,
/// each with a level of its own. White if there are too few. The colour maximises the restricted
/// likelihood of an AR(1) plus white noise.
pub fn estimate_noise(stays: &[ContactRecording<'_>]) -> Noise {
    let windows: Vec<Vec<f64>> = stays.iter().flat_map(contact_windows).collect();
    let white = Noise {
        factor: 1.0,
        colour: Colour::WHITE,
    };
    if windows.len() < MIN_WINDOWS {
        return white;
    }
    let (mut best, mut likelihood) = fit_size(&windows, Colour::WHITE);
    likelihood += COLOURED_NOISE_MIN_GAIN;
    for share in COLOURED_SHARE_GRID {
        for memory in MEMORY_GRID {
            let colour = Colour::with_memory(share, (-1.0f64 / memory).exp());
            let (noise, l) = fit_size(&windows, colour);
            if l > likelihood {
                (best, likelihood) = (noise, l);
            }
        }
    }
    // Refined between the grid points in decreasing steps.
    for step in [1.25f64, 1.12, 1.06] {
        let Colour { share, keep, .. } = best.colour;
        if share <= 0.0 {
            break;
        }
        for (more, longer) in GRID_NEIGHBOURS {
            let colour = Colour::with_memory(
                (share * step.powi(more)).min(MAX_COLOURED_SHARE),
                keep.powf(step.powi(-longer)),
            );
            let (noise, l) = fit_size(&windows, colour);
            if l > likelihood {
                (best, likelihood) = (noise, l);
            }
        }
    }
    best
}

fn contact_windows(stays: &ContactRecording<'_>) -> Vec<Vec<f64>> {
    let r = stays.recording;
    let interval = r.interval();
    let length = ((WINDOW_LENGTH / interval) as usize).max(MIN_WINDOW_SAMPLES);
    let skip = (LANDING_TIME / interval).ceil() as usize;
    let mut out = Vec::new();
    let whole = 0..r.len();
    for stay in intervals(r, &r.proof_mass, stays.timeline, &whole, None) {
        if !stay.held {
            continue;
        }
        let Range { mut start, end } = stay.samples;
        start += skip;
        while start + MIN_WINDOW_SAMPLES <= end {
            let to = (start + length).min(end);
            let values: Vec<f64> = r.proof_mass[start..to]
                .iter()
                .filter(|x| x.is_finite())
                .map(|x| x / stays.sigma)
                .collect();
            if values.len() >= MIN_WINDOW_SAMPLES {
                out.push(values);
            }
            start = to;
        }
    }
    out
}

/// Best size of the noise for a colour, and its restricted log-likelihood; each window has a level
/// and a slope of its own.
fn fit_size(windows: &[Vec<f64>], colour: Colour) -> (Noise, f64) {
    let (mut sum, mut freedom, mut determinant) = (0.0, 0.0, 0.0);
    for window in windows {
        let n = window.len();
        let mut columns = [vec![1.0; n], (0..n).map(|i| i as f64 / n as f64).collect()];
        let mut values = window.clone();
        colour.whiten(&mut values);
        for i in 0..columns.len() {
            colour.whiten(&mut columns[i]);
            if i == 1 {
                let [first, second] = &mut columns;
                remove_component(first, second);
            }
            remove_component(&columns[i], &mut values);
            // Slow noise looks quieter around a line fitted to it: hence the
            // restricted likelihood.
            determinant += columns[i].iter().map(|c| c * c).sum::<f64>().ln();
        }
        sum += values.iter().map(|v| v * v).sum::<f64>();
        freedom += (n - columns.len()) as f64;
        determinant += colour.log_determinant(n);
    }
    let variance = (sum / freedom).max(1e-12);
    let noise = Noise {
        factor: variance.sqrt(),
        colour,
    };
    (noise, -0.5 * (freedom * variance.ln() + determinant))
}

/// Removes from `values` the component along `direction`.
fn remove_component(direction: &[f64], values: &mut [f64]) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let share = dot(direction, values) / dot(direction, direction).max(1e-300);
    for (v, d) in values.iter_mut().zip(direction) {
        *v -= share * d;
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise_model::*;
    use crate::trial::rng::TrialRng;

    const SIGMA: f64 = 20e-9;

    #[test]
    fn few_samples_do_not_make_the_quietest_recording_the_common_noise() {
        let (mut a, mut b, mut c) = (2.5, 3.5, 4.3);
        let error = pool_noise(&mut [(40, &mut a), (45, &mut b), (60, &mut c)]);
        assert!((3.2..3.8).contains(&a), "{a}");
        assert!(a == b && b == c, "{a} {b} {c}");
        assert!(error > 0.1, "{error}");
        // Many samples tell a louder instrument from motion that passes for noise.
        let (mut a, mut b) = (2.5, 4.3);
        pool_noise(&mut [(40_000, &mut a), (45_000, &mut b)]);
        assert!((a, b) == (2.5, 2.5), "{a} {b}");
    }

    /// A mass that is held for 20 ms and away for 20 ms in turn, read with noise of which
    /// `share` has a memory of so many samples.
    fn held(share: f64, memory: f64, seed: u64) -> Recording {
        let mut rng = TrialRng::new(seed, 0);
        let mut fresh = || rng.normal();
        let keep = (-1.0 / memory).exp();
        let mut slow = fresh();
        let time: Vec<f64> = (0..20_000).map(|i| 2e-5 * f64::from(i)).collect();
        let xp = time.iter().map(|t| {
            let level = if ((t / 20e-3) as usize).is_multiple_of(2) {
                -58e-6
            } else {
                40e-6
            };
            slow = keep * slow + (1.0 - keep * keep).sqrt() * fresh();
            level + SIGMA * (share.sqrt() * slow + (1.0 - share).sqrt() * fresh())
        });
        let xp = xp.collect();
        Recording::new("held", time, None, xp, None).unwrap()
    }

    /// Power of slow noise against that of white noise of the same size.
    fn slow_power(colour: Colour) -> f64 {
        1.0 + colour.share * 2.0 * colour.keep / (1.0 - colour.keep)
    }

    #[test]
    fn slow_noise_is_estimated_without_bias_despite_a_level_for_each_contact() {
        for (share, memory) in [(0.11, 42.0), (0.3, 15.0), (0.3, 4.0)] {
            let truth = slow_power(Colour::with_memory(share, (-1.0f64 / memory).exp()));
            let mut logarithms = Vec::new();
            for seed in 0..6 {
                let recording = held(share, memory, seed);
                let xp = &recording.proof_mass;
                let timeline = Timeline::new(&recording.time, xp, -58e-6, SIGMA);
                let stays = ContactRecording {
                    recording: &recording,
                    timeline: &timeline,
                    sigma: SIGMA,
                };
                let found = estimate_noise(&[stays]);
                assert!((found.factor - 1.0).abs() < 0.1, "{found:?}");
                logarithms.push((slow_power(found.colour) / truth).ln());
            }
            let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
            println!("{share} {memory}: {:.2} {logarithms:.2?}", mean.exp());
            assert!(mean.abs() < 0.25, "{:.2}", mean.exp());
        }
    }

    #[test]
    fn white_noise_has_no_colour() {
        let recording = held(0.0, 1.0, 7);
        let timeline = Timeline::new(&recording.time, &recording.proof_mass, -58e-6, SIGMA);
        let stays = ContactRecording {
            recording: &recording,
            timeline: &timeline,
            sigma: SIGMA,
        };
        assert_eq!(estimate_noise(&[stays]).colour, Colour::WHITE);
    }
}
