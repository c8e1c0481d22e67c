//! A level that changes once: all rests before one instant are at one height, all after it
//! at another.

use super::{block_size, quiet};
use crate::recording::features::Missing;
use crate::recording::grid::TimeAxis;
use crate::recording::level::estimate_contact_level;
use crate::recording::noise::NoiseEstimate;
use crate::recording::{Recording, extremes, quantile_in_place};

/// Rests are looked for within this height of the lowest samples \[m\].
const SEARCH_HEIGHT: f64 = 15e-6;
/// Fewest blocks of rest on either side of the step.
const MIN_BLOCKS_PER_SIDE: usize = 3;
/// Smallest step of the level \[m\].
const MIN_RISE: f64 = 0.05e-6;
/// The same in units of the noise of a sample. A rest has many samples; a smaller step moves no
/// sample out of a stay.
const MIN_RISE_NOISE: f64 = 3.0;
/// All rests of a side must agree within this share of the step ...
const MAX_DISAGREEMENT_SHARE: f64 = 0.1;
/// ... or within so many times the noise of a sample.
const MAX_DISAGREEMENT_NOISE: f64 = 1.5;
/// Largest share of the blocks that may be farther off.
const MAX_STRAY_SHARE: f64 = 0.05;
/// A mass that moves with the ground stays within so many times the noise of a sample of the two
/// levels.
const FOLLOWING_NOISE: f64 = 6.0;
/// Largest change of the voltage meanwhile, as a share of its range.
const STEADY_VOLTAGE_SHARE: f64 = 0.02;
/// Most samples by which the mass may follow the voltage later.
const MAX_RESPONSE_SAMPLES: usize = 20;
/// Share of what a straight line leaves of the levels' variance that two levels may leave.
const NO_LINE: f64 = 0.5;

/// A change of the ground's level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelStep {
    /// When, at a time at which the mass is far from the ground if there is one \[s\].
    pub time: f64,
    /// By how much the level is higher from then on \[m\].
    pub rise: f64,
}

/// A block of samples in which the reading rests.
pub struct Rest {
    first: usize,
    last: usize,
    /// Mean of the block \[m\].
    pub level: f64,
}

/// Rests of `xp` near its lowest samples, one every `interval` \[s\] with a noise `sigma` \[m\].
pub fn rests(xp: &[f64], interval: f64, sigma: f64) -> Vec<Rest> {
    let mut finite: Vec<f64> = xp.iter().copied().filter(|x| x.is_finite()).collect();
    let bottom = quantile_in_place(&mut finite, 2e-3);
    let size = block_size(interval);
    let still = |block: &[f64]| {
        let n = block.len() as f64;
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let level = mean(block);
        let spread = (block.iter().map(|x| (x - level).powi(2)).sum::<f64>() / n).sqrt();
        let (a, b) = block.split_at(block.len() / 2);
        let steady = (mean(a) - mean(b)).abs() < 4.0 * sigma * (4.0 / n).sqrt();
        (level < bottom + SEARCH_HEIGHT && quiet(spread, sigma, n) && steady).then_some(level)
    };
    let blocks = (0..xp.len().saturating_sub(size)).step_by(size / 2);
    blocks
        .filter_map(|first| {
            let last = first + size - 1;
            still(&xp[first..=last]).map(|level| Rest { first, last, level })
        })
        .collect()
}

/// Sum of squares that a straight line through `y` over `x` leaves.
fn left_by_line(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len().max(1) as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        xx += (x - mx).powi(2);
        xy += (x - mx) * (y - my);
        yy += (y - my).powi(2);
    }
    if xx > 0.0 { yy - xy * xy / xx } else { yy }
}

/// The change of the ground's level in `recording`, if there is one: on either side of it the
/// ground must show all its signs, on one if the mass lies on through it.
#[must_use]
pub fn find_level_step(recording: &Recording, noise: Option<NoiseEstimate>) -> Option<LevelStep> {
    let sigma = noise.filter(|n| n.sigma > 0.0)?.sigma;
    let (time, xp) = (&recording.time, &recording.proof_mass);
    let rests = rests(xp, recording.interval(), sigma);
    if rests.len() < 2 * MIN_BLOCKS_PER_SIDE {
        return None;
    }
    // The split that leaves least of the variance.
    let levels: Vec<f64> = rests.iter().map(|r| r.level).collect();
    let whole: f64 = levels.iter().sum();
    let n = levels.len();
    let mut sum = 0.0;
    let mut best = (f64::NEG_INFINITY, 0);
    for k in 1..n {
        sum += levels[k - 1];
        let between = sum * sum / k as f64 + (whole - sum).powi(2) / (n - k) as f64;
        if k >= MIN_BLOCKS_PER_SIDE && n - k >= MIN_BLOCKS_PER_SIDE && between > best.0 {
            best = (between, k);
        }
    }
    let k = best.1;
    let middle = |side: &[f64]| quantile_in_place(&mut side.to_vec(), 0.5);
    let (before, after) = (middle(&levels[..k]), middle(&levels[k..]));
    let rise = after - before;
    if rise.is_nan() || rise.abs() <= (MIN_RISE_NOISE * sigma).max(MIN_RISE) {
        return None;
    }
    // What goes on moving is no step.
    let about = |side: &[f64]| {
        let mean = side.iter().sum::<f64>() / side.len() as f64;
        side.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
    };
    let when: Vec<f64> = rests.iter().map(|r| time[r.first]).collect();
    if about(&levels[..k]) + about(&levels[k..]) > NO_LINE * left_by_line(&when, &levels) {
        return None;
    }
    let near = (MAX_DISAGREEMENT_SHARE * rise.abs()).max(MAX_DISAGREEMENT_NOISE * sigma);
    let astray = |side: &[f64], level: f64| {
        let far = side.iter().filter(|x| (**x - level).abs() > near).count();
        far as f64 > MAX_STRAY_SHARE * side.len() as f64
    };
    if astray(&levels[..k], before) || astray(&levels[k..], after) {
        return None;
    }
    // Between the last rest of the one side and the first of the other, far up if it flew.
    let (from, to) = (rests[k - 1].last, rests[k].first.max(rests[k - 1].last + 1));
    let between = from + 1..to.min(xp.len() - 1) + 1;
    let cut = between
        .filter(|&i| xp[i].is_finite())
        .max_by(|&i, &j| xp[i].total_cmp(&xp[j]))
        .unwrap_or(to);
    let voltage = recording.voltage.as_deref();
    // Whether a side shows its level with all signs of a ground, or another one; `None` where it
    // shows no sign.
    let has_ground_at = |range: std::ops::Range<usize>, level: f64| {
        let v = voltage.map(|v| &v[range.clone()]);
        let axis = TimeAxis::Samples(&time[range.clone()]);
        match estimate_contact_level(axis, v, &xp[range], noise) {
            Ok(found) => Some((found - level).abs() < near.max(3.0 * sigma).min(0.5 * rise.abs())),
            Err(Missing::NotAFloor { .. }) => Some(false),
            Err(_) => None,
        }
    };
    let lies_on = || {
        let size = block_size(recording.interval());
        let (low, high) = (before.min(after), before.max(after));
        let within = low - FOLLOWING_NOISE * sigma..=high + FOLLOWING_NOISE * sigma;
        // Blocks on either side may hold a part of the change.
        let about = from.saturating_sub(size + MAX_RESPONSE_SAMPLES)..(to + size).min(xp.len());
        to - from <= 2 * size
            && xp[from..=to].iter().all(|x| within.contains(x))
            && voltage.is_some_and(|v| {
                let ((low, high), (least, most)) = (extremes(v), extremes(&v[about.clone()]));
                most - least <= STEADY_VOLTAGE_SHARE * (high - low)
                    && v[about].iter().all(|v| v.is_finite())
            })
    };
    let is_step = match (
        has_ground_at(0..cut, before),
        has_ground_at(cut..xp.len(), after),
    ) {
        (Some(first), Some(second)) => first && second,
        // A single stay may show no sign of its own, but where the mass lies on through the
        // step, what it lies on is one and the same.
        (Some(known), None) | (None, Some(known)) => known && lies_on(),
        (None, None) => false,
    };
    is_step.then_some(LevelStep {
        time: time[cut],
        rise,
    })
}

#[cfg(test)]
mod tests {
    use super::super::step::*;
    use crate::recording::Channel;

    /// A mass that is on the ground half of each 10 ms and jumps 20 um between, with a
    /// stand-in for noise, even over `width` \[m\]; the ground's level at a time is `level`.
    fn jumps(width: f64, level: impl Fn(f64) -> f64) -> Recording {
        let n = 5000;
        let time: Vec<f64> = (0..n).map(|i| 2e-5 * f64::from(i)).collect();
        let noise = |i: usize| {
            let x = (i as f64 * 12.9898).sin() * 43758.5453;
            width * (x - x.floor() - 0.5)
        };
        let readings = time.iter().enumerate();
        let xp = readings.map(|(i, t)| level(*t) + height(*t) + noise(i));
        let voltage = time.iter().map(|t| 8.0 * (t / 0.01).fract()).collect();
        Recording::new("jumps", time.clone(), Some(voltage), xp.collect(), None).unwrap()
    }

    fn found(recording: &Recording) -> Option<LevelStep> {
        find_level_step(recording, recording.estimate_noise(Channel::ProofMass).ok())
    }

    #[test]
    fn a_level_that_changes_once_is_found_and_one_that_does_not_is_not() {
        // The last by four times the noise of a sample, the one before by what moves some of the
        // samples of a stay out of it.
        let steps = [
            (4e-8, 0.8e-6),
            (4e-8, -2e-6),
            (7e-8, -85e-9),
            (5e-7, 0.6e-6),
        ];
        for (width, rise) in steps {
            let recording = jumps(width, |t| if t < 0.05 { 0.0 } else { rise });
            let step = found(&recording).expect("a step");
            assert!((step.rise / rise - 1.0).abs() < 0.05, "{step:?}");
            assert!((0.045..0.0551).contains(&step.time), "{step:?}");
            let change = super::super::LevelChange::Step(step);
            let level = change.taken_out(&recording.time, &recording.proof_mass);
            let rest = |at: usize| level[at..at + 200].iter().sum::<f64>() / 200.0;
            assert!((rest(0) - rest(4500)).abs() < 2.5e-8 + 0.02 * rise.abs());
        }
        for width in [4e-8, 5e-7] {
            assert_eq!(found(&jumps(width, |_| 0.0)), None);
        }
    }

    /// When in [`lands_gently`] the mass begins to jump \[s\].
    const JUMP_TIME: f64 = 0.05;

    /// A mass that sinks so gently that its landing is no sign of the ground and lies there until
    /// it jumps as in [`jumps`]; at sample `at` the level changes by `rise` \[m\] and the voltage
    /// by `volts`, `ahead` samples before.
    fn lands_gently(rise: f64, at: usize, (volts, ahead): (f64, usize)) -> Recording {
        let time = |i: usize| 2e-5 * i as f64;
        let level = |t: f64| if t < time(at) - 1e-9 { 0.0 } else { rise };
        let mut recording = jumps(5e-7, level);
        let begun = recording
            .time
            .iter()
            .take_while(|t| **t < JUMP_TIME)
            .count();
        let voltage = recording.voltage.as_mut().unwrap();
        for (i, v) in voltage.iter_mut().enumerate().take(begun) {
            let t = time(i);
            let sinking = 20e-6 * (1.0 - t / 0.007).max(0.0);
            recording.proof_mass[i] += sinking - height(t);
            *v = if i + ahead < at { 8.0 } else { 8.0 - volts };
        }
        recording
    }

    /// Height over the ground in [`jumps`] \[m\].
    fn height(t: f64) -> f64 {
        let phase = (t / 0.01).fract();
        if phase < 0.5 {
            0.0
        } else {
            20e-6 * 16.0 * (phase - 0.5) * (1.0 - phase)
        }
    }

    #[test]
    fn a_step_under_a_resting_mass_is_found_even_after_a_gentle_landing() {
        for rise in [-0.9e-6, 0.9e-6] {
            let recording = lands_gently(rise, 1500, (0.0, 0));
            let begun = 0..1400;
            let axis = TimeAxis::Samples(&recording.time[begun.clone()]);
            let volts = &recording.voltage.as_ref().unwrap()[begun.clone()];
            let noise = recording.estimate_noise(Channel::ProofMass).ok();
            let landing = &recording.proof_mass[begun];
            let sign = estimate_contact_level(axis, Some(volts), landing, noise);
            assert!(matches!(sign, Err(Missing::NoArrival { .. })), "{sign:?}");
            let step = found(&recording).expect("a step");
            assert!((step.rise / rise - 1.0).abs() < 0.05, "{step:?}");
            assert!((step.time - 0.03).abs() < 2e-3, "{step:?}");
        }
    }

    #[test]
    fn motion_with_the_voltage_or_in_flight_or_unread_is_no_step_of_the_ground() {
        // It may as well have hung over the ground until the voltage changed, be that wherever it
        // is in a block of samples, and as long before as a mass is late.
        for rise in [-0.6e-6, -0.9e-6] {
            for at in 1500..1520 {
                for ahead in [0, 12] {
                    let recording = lands_gently(rise, at, (2.0, ahead));
                    assert_eq!(found(&recording), None, "{rise} {at} {ahead}");
                }
            }
        }
        let gap = |of: fn(f64) -> f64| {
            let mut recording = lands_gently(-0.9e-6, 1500, (0.0, 0));
            let readings = &mut recording.proof_mass[1490..1510];
            readings.iter_mut().for_each(|x| *x = of(*x));
            found(&recording)
        };
        assert!(gap(|x| x).is_some());
        assert_eq!(gap(|x| x + 2e-6), None);
        assert_eq!(gap(|_| f64::NAN), None);
    }

    #[test]
    fn a_side_with_another_ground_level_contradicts_the_step() {
        // It bounces at the level that it lies at later, and hangs over it in between.
        let mut recording = jumps(5e-7, |_| 0.0);
        for (i, x) in recording.proof_mass.iter_mut().enumerate().take(1500) {
            let t = 2e-5 * i as f64;
            let bounces = 20e-6 * (std::f64::consts::PI * t / 0.004).sin().abs();
            *x += if t < 0.02 { bounces } else { 0.9e-6 } - height(t);
        }
        let voltage = recording.voltage.as_mut().unwrap();
        voltage[900..1600].fill(8.0);
        assert_eq!(found(&recording), None);
    }

    #[test]
    fn a_level_that_goes_on_moving_is_no_step() {
        for rise in [0.4e-6, 0.8e-6, 0.9e-6, 1e-6, 3e-6] {
            assert_eq!(found(&jumps(5e-7, |t| rise * t / 0.1)), None, "{rise}");
            let settles = |t: f64| rise * (1.0 - (-t / 0.02).exp());
            assert_eq!(found(&jumps(5e-7, settles)), None, "{rise}");
        }
    }
}
