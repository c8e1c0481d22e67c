//! Where a reading moves so little that a straight line follows it within its noise.

use std::ops::Range;

use crate::recording::instrument_faults::signal::Signal;
use crate::recording::instrument_faults::thresholds::{
    MAX_QUIET_BLOCKS, MAX_QUIET_RMS, MAX_QUIET_SPEED_SHARE, QUIET_BLOCK_SAMPLES, STAY_MIN_BLOCKS,
};
use crate::recording::statistics::quantile_in_place;

/// Some samples in a row on a straight line.
#[derive(Debug, Clone)]
pub struct Block {
    /// Which samples.
    pub samples: Range<usize>,
    /// Middle \[s\].
    pub time: f64,
    /// Mean reading.
    pub mean: f64,
    /// Slope \[1/s\].
    pub slope: f64,
    /// Mean of the voltage, NaN where there is none.
    pub voltage: f64,
}

/// Stays: quiet blocks that follow one another, at least [`STAY_MIN_BLOCKS`] each, of
/// [`MAX_QUIET_BLOCKS`] blocks in all.
pub fn stays(signal: &Signal<'_>) -> Vec<Vec<Block>> {
    let sigma = signal.sigma();
    let count = signal.values.len() / QUIET_BLOCK_SAMPLES;
    if count < STAY_MIN_BLOCKS || sigma <= 0.0 {
        return Vec::new();
    }
    let all: Vec<Option<(Block, f64)>> = (0..count)
        .map(|k| {
            block(
                signal,
                k * QUIET_BLOCK_SAMPLES..(k + 1) * QUIET_BLOCK_SAMPLES,
            )
        })
        .collect();
    let mut speeds: Vec<f64> = all.iter().flatten().map(|(b, _)| b.slope.abs()).collect();
    let fast = quantile_in_place(&mut speeds, 0.9);
    let mut stays: Vec<Vec<Block>> = Vec::new();
    let mut blocks = 0;
    let mut last = None;
    for (k, found) in all.into_iter().enumerate() {
        let Some((block, rms)) = found else { continue };
        let quiet =
            rms <= MAX_QUIET_RMS * sigma && block.slope.abs() <= MAX_QUIET_SPEED_SHARE * fast;
        if !quiet || blocks >= MAX_QUIET_BLOCKS {
            continue;
        }
        blocks += 1;
        match stays.last_mut() {
            Some(stay) if last == Some(k.wrapping_sub(1)) => stay.push(block),
            _ => stays.push(vec![block]),
        }
        last = Some(k);
    }
    stays.retain(|stay| stay.len() >= STAY_MIN_BLOCKS);
    stays
}

/// The straight line through some samples, and the root mean square of what it leaves; `None` where one is
/// missing.
fn block(signal: &Signal<'_>, samples: Range<usize>) -> Option<(Block, f64)> {
    let n = samples.len() as f64;
    let time = &signal.time[samples.clone()];
    let values = &signal.values[samples.clone()];
    let middle = time.iter().sum::<f64>() / n;
    let mean = values.iter().sum::<f64>() / n;
    if !mean.is_finite() {
        return None;
    }
    let (mut tt, mut tx) = (0.0, 0.0);
    for (t, x) in time.iter().zip(values) {
        tt += (t - middle).powi(2);
        tx += (t - middle) * (x - mean);
    }
    let slope = tx / tt;
    let left = time.iter().zip(values);
    let square: f64 = left
        .map(|(t, x)| (x - mean - slope * (t - middle)).powi(2))
        .sum();
    let volts = signal.voltage.map(|v| &v[samples.clone()]);
    let block = Block {
        samples,
        time: middle,
        mean,
        slope,
        voltage: volts.map_or(f64::NAN, |v| v.iter().sum::<f64>() / n),
    };
    Some((block, (square / (n - 2.0)).sqrt()))
}
