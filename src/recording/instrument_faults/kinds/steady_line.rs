//! Mains hum, or another line at one frequency in the reading itself.
//!
//! It is looked for while the ground holds the mass: nothing that moves the device moves the reading
//! then, so that a vibration of the base does not show and a line of the instrument does. A line at
//! a multiple of the drive's frequency, or of half of it, may be motion after all and has no name.
//! Neither has one in a device that nothing holds.

use crate::recording::channel::Channel;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::kinds::quiet::{Block, stays};
use crate::recording::instrument_faults::signal::{Found, Signal};
use crate::recording::instrument_faults::thresholds::{
    DRIVE_LINE_RESOLUTIONS, GROUND_MAX_HEIGHT_SHARE, LINE_MIN_EXPLAINED, LINE_MIN_PERIODS,
    LINE_SIGMAS, LINES_PER_RESOLUTION, QUIET_BLOCK_SAMPLES,
};
use crate::recording::statistics::{extremes, median_in_place};

/// The strongest line. The size is its amplitude.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    if signal.channel != Channel::ProofMass {
        return None;
    }
    let (low, high) = extremes(&signal.values);
    let height = low + GROUND_MAX_HEIGHT_SHARE * (high - low);
    let mut held = stays(signal);
    held.retain(|stay| stay.iter().all(|block| block.mean < height));
    let (first, last) = (held.first()?.first()?, held.last()?.last()?);
    let long = last.time - first.time;
    let longest = held.iter().map(|s| s[s.len() - 1].time - s[0].time);
    let longest = longest.fold(0.0, f64::max);
    let between = median_gap(&held);
    if between.is_nan() || between <= 0.0 || longest <= 0.0 {
        return None;
    }
    let (from, to) = (LINE_MIN_PERIODS / longest, 0.25 / between);
    let step = 1.0 / (LINES_PER_RESOLUTION * long);
    let period = voltage_period(signal);
    let count = ((to - from) / step).max(0.0) as usize + 1;
    let lines = (0..count).map(|k| line_at(&held, from + k as f64 * step));
    let coarse = lines.max_by(|a, b| a.explained.total_cmp(&b.explained))?;
    let finer = (-LINE_REFINEMENT..=LINE_REFINEMENT).map(|k| {
        let share = f64::from(k) / f64::from(LINE_REFINEMENT);
        line_at(&held, coarse.frequency + share * step)
    });
    let best = finer.max_by(|a, b| a.explained.total_cmp(&b.explained))?;
    let blocks: usize = held.iter().map(Vec::len).sum();
    let error = signal.sigma() / (0.5 * (blocks * QUIET_BLOCK_SAMPLES) as f64).sqrt();
    let of_drive = period.is_some_and(|period| {
        let times = 2.0 * period * best.frequency;
        (times - times.round()).abs() < DRIVE_LINE_RESOLUTIONS * 2.0 * period / long
    });
    if best.amplitude < LINE_SIGMAS * error || best.explained < LINE_MIN_EXPLAINED || of_drive {
        return None;
    }
    let kind = FaultKind::SteadyLine {
        frequency: best.frequency,
    };
    let whole = 0..signal.values.len();
    Some(Found {
        fault: signal.fault(kind, best.amplitude, std::slice::from_ref(&whole))?,
        unusable: Vec::new(),
    })
}

/// Steps on either side in which the best frequency is refined.
const LINE_REFINEMENT: i32 = 12;

/// A sinusoid through all stays, each with a level of its own.
struct Line {
    frequency: f64,
    amplitude: f64,
    /// Share of the blocks' variance around their levels that it explains.
    explained: f64,
}

fn line_at(stays: &[Vec<Block>], frequency: f64) -> Line {
    let omega = std::f64::consts::TAU * frequency;
    // Levels are eliminated: each stay's means are subtracted from its columns.
    let (mut cc, mut cs, mut ss, mut cx, mut sx, mut xx) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for stay in stays {
        let n = stay.len() as f64;
        let (mut c0, mut s0, mut x0) = (0.0, 0.0, 0.0);
        for block in stay {
            let (s, c) = (omega * block.time).sin_cos();
            c0 += c / n;
            s0 += s / n;
            x0 += block.mean / n;
        }
        for block in stay {
            let (s, c) = (omega * block.time).sin_cos();
            let (c, s, x) = (c - c0, s - s0, block.mean - x0);
            cc += c * c;
            cs += c * s;
            ss += s * s;
            cx += c * x;
            sx += s * x;
            xx += x * x;
        }
    }
    let determinant = cc * ss - cs * cs;
    let (a, b) = (
        (cx * ss - sx * cs) / determinant,
        (sx * cc - cx * cs) / determinant,
    );
    let explained = (a * cx + b * sx) / xx;
    Line {
        frequency,
        amplitude: a.hypot(b),
        explained: if explained.is_finite() {
            explained
        } else {
            0.0
        },
    }
}

/// Median time between neighbouring blocks \[s\].
fn median_gap(stays: &[Vec<Block>]) -> f64 {
    let pairs = stays.iter().flat_map(|stay| stay.windows(2));
    median_in_place(&mut pairs.map(|w| w[1].time - w[0].time).collect::<Vec<f64>>())
}

/// Median time between rising crossings of the voltage's middle \[s\].
fn voltage_period(signal: &Signal<'_>) -> Option<f64> {
    let volts = signal.voltage?;
    let (low, high) = extremes(volts);
    let middle = 0.5 * (low + high);
    let rises = (1..volts.len()).filter(|&i| volts[i - 1] < middle && volts[i] >= middle);
    let times: Vec<f64> = rises.map(|i| signal.time[i]).collect();
    let mut periods: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    (!periods.is_empty()).then(|| median_in_place(&mut periods))
}
