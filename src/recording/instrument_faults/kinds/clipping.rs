//! Readings at the end of the sensor's range.

use std::ops::Range;

use crate::recording::channel::Channel;
use crate::recording::grid::TimeAxis;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::signal::{Found, Signal, runs_where};
use crate::recording::instrument_faults::thresholds::{
    CLIPPED_MIN_RUN, MAX_EQUAL_NEIGHBOUR_SHARE, MAX_NOISE_SHARE_OF_SPAN,
    MAX_NOISE_SHARE_OVER_GROUND, MIN_NOISE_SHARE_OF_SPAN,
};
use crate::recording::noise::estimate_noise;
use crate::recording::statistics::extremes;

/// Runs of readings at the exact highest or lowest value. A mass at rest on the ground gives such
/// runs too; they are no clipping unless everything else is noisy. A voltage may rest at its
/// extremes. The size is the value that is farthest out.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    if signal.channel == Channel::Voltage {
        return None;
    }
    let values = &signal.values;
    let (low, high) = extremes(values);
    let mut equal = 0usize;
    let mut pairs = 0usize;
    for pair in values.windows(2) {
        if pair[0].is_finite() && pair[0] != high && pair[0] != low {
            pairs += 1;
            equal += usize::from(pair[0] == pair[1]);
        }
    }
    // Where neighbours are equal everywhere, the reading is noiseless, coarse or held, and equal
    // extremes mean nothing.
    if pairs == 0 || equal as f64 > MAX_EQUAL_NEIGHBOUR_SHARE * pairs as f64 {
        return None;
    }
    let at = |extreme: f64| runs_where(values.len(), |i| values[i] == extreme);
    let share = noise_share_between(signal, low, high)?;
    let mut runs: Vec<Range<usize>> = Vec::new();
    if share < MAX_NOISE_SHARE_OVER_GROUND {
        runs.extend(at(low));
    }
    if high > low && share < MAX_NOISE_SHARE_OF_SPAN {
        runs.extend(at(high));
    }
    runs.retain(|run| run.len() >= CLIPPED_MIN_RUN);
    runs.sort_unstable_by_key(|run| run.start);
    let reached = runs.iter().map(|run| values[run.start]);
    let size = reached.reduce(|a, b| if b.abs() > a.abs() { b } else { a })?;
    Some(Found {
        fault: signal.fault(FaultKind::Clipping, size, &runs)?,
        unusable: runs.into_iter().flatten().collect(),
    })
}

/// Noise of the readings between the extremes as a share of the span, if there is any. Without it,
/// a mass may rest at the lowest reading exactly; and where it is large or coloured, fast motion
/// may pass for noise.
fn noise_share_between(signal: &Signal<'_>, low: f64, high: f64) -> Option<f64> {
    let mut between = signal.values.clone();
    for v in &mut between {
        if *v == low || *v == high {
            *v = f64::NAN;
        }
    }
    let noise = estimate_noise(TimeAxis::Samples(signal.time), &between).ok()?;
    let share = noise.sigma / (high - low);
    (noise.white && share > MIN_NOISE_SHARE_OF_SPAN).then_some(share)
}
