//! A first-order lag of the readings, from data alone.
//!
//! Readings that lag by `tau` go as `tau y' = x - y` after a mass at `x`, which is never below
//! the ground: above it, they fall no faster than by the share `exp(-t / tau)` in a time `t`,
//! and as fast where the mass lies there already. The quickest falls determine `tau`.

use super::level_change::step::rests;
use super::{Recording, quantile_in_place};

/// Smallest height above the ground that is used, in units of the noise: at this height the
/// noise is a few percent of a share.
const MIN_HEIGHT_NOISE: f64 = 30.0;
/// Ratio of the two heights that are compared: a lag falls by the same share from both, a slow
/// mass by less from the higher one.
const HEIGHT_RATIO: f64 = 2.0;
/// Largest ratio of the lags from the two heights.
const MAX_HEIGHT_DISAGREEMENT: f64 = 1.25;
/// Largest height that is used \[m\].
const MAX_HEIGHT: f64 = 20e-6;
/// Rests are on the ground within this height of the lowest \[m\], and within so many times the
/// noise.
const GROUND_TOLERANCE: (f64, f64) = (0.3e-6, 8.0);
/// Fewest rests on the ground.
const MIN_RESTS: usize = 5;
/// Largest share of the samples farther below the ground: spikes of a sensor.
const MAX_SHARE_BELOW: f64 = 2e-3;
/// So many of the quickest falls may be spikes of a sensor.
const MAX_SPIKES: usize = 2;
/// So many falls after them must agree about the lag.
const MIN_AGREEING_FALLS: usize = 10;
/// Largest ratio of the lags of falls that agree.
const MAX_FALL_RATIO: f64 = 1.5;
/// Shortest lag that is determined, in samples: a mass that stops between two of them falls as
/// fast.
const MIN_LAG_SAMPLES: f64 = 0.8;

/// The lag of all of `recordings` \[s\], each with its reading of the proof mass, changes of the
/// ground's level taken out, and its noise \[m\]; `None` where the mass stops within a sample.
#[must_use]
pub fn find_lag(recordings: &[(&Recording, &[f64], f64)]) -> Option<f64> {
    let mut all: Vec<Fall> = Vec::new();
    for (recording, xp, sigma) in recordings {
        all.extend(falls(recording, xp, *sigma));
    }
    let low = lag_above(&all, MIN_HEIGHT_NOISE)?;
    let high = lag_above(&all, HEIGHT_RATIO * MIN_HEIGHT_NOISE)?;
    (high.max(low) < MAX_HEIGHT_DISAGREEMENT * high.min(low)).then_some(low)
}

/// A fall near the ground from one sample to the next.
#[derive(Debug, Clone, Copy)]
struct Fall {
    /// Height from which, in units of the noise.
    from: f64,
    /// The lag that it would have if the mass lay on the ground \[s\].
    lag: f64,
    /// Time between samples of its recording \[s\].
    interval: f64,
}

/// The lag by falls from heights of `clear` times the noise and more.
fn lag_above(falls: &[Fall], clear: f64) -> Option<f64> {
    let high = || falls.iter().filter(|fall| fall.from > clear);
    let longest = high().fold(0.0f64, |longest, fall| longest.max(fall.interval));
    let mut all: Vec<f64> = high().map(|fall| fall.lag).collect();
    all.sort_by(f64::total_cmp);
    let quickest = all.get(MAX_SPIKES..MAX_SPIKES + MIN_AGREEING_FALLS)?;
    let (first, last) = (quickest[0], quickest[MIN_AGREEING_FALLS - 1]);
    let is_determined = first > MIN_LAG_SAMPLES * longest && last < MAX_FALL_RATIO * first;
    is_determined.then_some(quickest[MIN_AGREEING_FALLS / 2])
}

/// The falls in a recording that are high enough to be used.
fn falls(recording: &Recording, xp: &[f64], sigma: f64) -> Vec<Fall> {
    let interval = recording.interval();
    let mut levels: Vec<f64> = rests(xp, interval, sigma).iter().map(|r| r.level).collect();
    let lowest = quantile_in_place(&mut levels, 0.02);
    levels.retain(|level| *level < lowest + GROUND_TOLERANCE.0 + GROUND_TOLERANCE.1 * sigma);
    if levels.len() < MIN_RESTS {
        return Vec::new();
    }
    let level = quantile_in_place(&mut levels, 0.5);
    // A mass that moves below it has rested elsewhere.
    let below = xp
        .iter()
        .filter(|x| **x < level - GROUND_TOLERANCE.1 * sigma)
        .count();
    if below as f64 > MAX_SHARE_BELOW * xp.len() as f64 {
        return Vec::new();
    }
    let one = |i: usize| {
        let (from, to) = (xp[i] - level, xp[i + 1] - level);
        let share = to.max(f64::MIN_POSITIVE) / from;
        let there = to.is_finite() && !recording.is_gap(i);
        let falls = there && from > MIN_HEIGHT_NOISE * sigma && from < MAX_HEIGHT && share < 1.0;
        falls.then(|| Fall {
            from: from / sigma,
            lag: -(recording.time[i + 1] - recording.time[i]) / share.ln(),
            interval,
        })
    };
    (0..xp.len().saturating_sub(1)).filter_map(one).collect()
}

/// Reading `xp` \[m\] at `time` \[s\] as it was before a lag `tau` \[s\]; its ends as they are.
/// Exact where the mass lies and the reading still falls, so that none of it is below the ground.
#[must_use]
pub fn before_lag(time: &[f64], xp: &[f64], tau: f64) -> Vec<f64> {
    let rate = |i: usize| {
        let (a, b) = (i.checked_sub(1)?, i + 1);
        let half = 0.5 * (time.get(b)? - time[a]) / tau;
        // The slope of a decay by the samples on either side, times tau.
        Some((xp.get(b)? - xp[a]) / (2.0 * half.sinh()))
    };
    let one = |(i, x): (usize, &f64)| x + rate(i).unwrap_or(0.0);
    xp.iter().enumerate().map(one).collect()
}

/// Its noise, where `sigma` is that of the readings, one every `interval` \[s\].
#[must_use]
pub fn noise_before_lag(sigma: f64, interval: f64, tau: f64) -> f64 {
    let rate = if tau > 0.0 {
        0.5 / (interval / tau).sinh().powi(2)
    } else {
        0.0
    };
    sigma * (1.0 + rate).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::events::{EventOptions, find_events};
    use super::super::grid::TimeAxis;
    use super::super::lag::*;

    const INTERVAL: f64 = 2e-5;

    /// A mass that falls from 20 um every 10 ms and is thrown back with half its speed, read
    /// through a lag `tau` by small steps.
    fn taps(tau: f64) -> Recording {
        const FINE: usize = 50;
        let h = INTERVAL / FINE as f64;
        let (mut x, mut v, mut y) = (0.0f64, 0.0f64, 0.0f64);
        let (mut time, mut xp, mut volts) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..6000 * FINE {
            let t = i as f64 * h;
            let pulled = (t / 0.01).fract() < 0.15;
            let force = if pulled { 30.0 } else { -60.0 };
            v += force * h;
            x += v * h;
            if x < 0.0 {
                x = 0.0;
                v = if v < -1e-3 { -0.5 * v } else { 0.0 };
            }
            y += if tau > 0.0 {
                (x - y) * (1.0 - (-h / tau).exp())
            } else {
                x - y
            };
            if i % FINE == 0 {
                let noise = ((i / FINE) as f64 * 12.9898).sin() * 43758.5453;
                time.push(t);
                xp.push(y + 7e-8 * (noise - noise.floor() - 0.5));
                volts.push(if pulled { 8.0 } else { -8.0 });
            }
        }
        Recording::new("taps", time, Some(volts), xp, None).unwrap()
    }

    fn found(tau: f64) -> Option<f64> {
        let recording = taps(tau);
        find_lag(&[(&recording, &recording.proof_mass, 2e-8)])
    }

    #[test]
    fn a_lag_of_samples_is_determined_by_the_quickest_falls() {
        for tau in [3e-5, 5e-5, 1e-4] {
            let lag = found(tau).expect("a lag");
            assert!((lag / tau - 1.0).abs() < 0.1, "{tau}: {lag}");
        }
        // Missing samples are no falls.
        let mut gaps = taps(5e-5);
        gaps.proof_mass
            .iter_mut()
            .step_by(97)
            .for_each(|x| *x = f64::NAN);
        let lag = find_lag(&[(&gaps, &gaps.proof_mass, 2e-8)]).expect("a lag");
        assert!((lag / 5e-5 - 1.0).abs() < 0.1, "{lag}");
        assert_eq!(found(0.0), None);
        // Nor is a mass that falls slowly, to noise that hides its last samples.
        for noise in [1e-7, 2e-7, 4e-7] {
            let recording = taps(0.0);
            let lag = find_lag(&[(&recording, &recording.proof_mass, noise)]);
            assert_eq!(lag, None, "{noise}");
        }
        assert_eq!(found(5e-6), None);
    }

    #[test]
    fn after_removal_of_the_lag_the_mass_stops_suddenly() {
        let tau = 6e-5;
        let recording = taps(tau);
        let impacts = |xp: &[f64], noise: f64| {
            let options = EventOptions {
                contact_level: 0.0,
                noise,
                hop: 5e-6,
            };
            find_events(TimeAxis::Samples(&recording.time), xp, &options).impacts
        };
        let lags = impacts(&recording.proof_mass, 2e-8);
        let noise = noise_before_lag(2e-8, INTERVAL, tau);
        let clear = impacts(
            &before_lag(&recording.time, &recording.proof_mass, tau),
            noise,
        );
        let fast = |all: &[super::super::events::Impact]| {
            all.iter()
                .filter(|i| i.v_before < -0.03 && i.v_after > 0.01)
                .count()
        };
        assert!(
            fast(&clear) > 2 * fast(&lags),
            "{} {}",
            fast(&clear),
            fast(&lags)
        );
    }
}
