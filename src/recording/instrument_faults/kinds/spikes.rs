//! Single samples, or a few in a row, far off their neighbours.
//!
//! A spike leaves its neighbours and comes back to them. With it left out, the motion is smooth: its
//! distance from the straight line across it is then many times what the motion bends
//! elsewhere around. At an impact the motion bends as much with the sample left out.

use std::ops::Range;

use crate::recording::channel::Channel;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::signal::{Found, Signal};
use crate::recording::instrument_faults::thresholds::{
    ADJACENT_BENDS, BEND_NEIGHBOURHOOD, MAX_SPIKE_SAMPLES, MAX_SPIKE_SHARE, PULSE_SIZE_SPREAD,
    SPIKE_BENDS, SPIKE_FLATNESS, SPIKE_RETURNS, SPIKE_SIGMAS, SPIKE_TURNS,
};
use crate::recording::statistics::quantile_in_place;

/// A sample, or a few, that may be a spike.
struct Candidate {
    samples: Range<usize>,
    /// Distance from the line across it, with its sign.
    distance: f64,
}

/// Spikes. The size is the largest distance.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    signal.noise?;
    let mut values = signal.values.clone();
    let widest = match signal.channel {
        // A drive may have short pulses.
        Channel::Voltage => 1,
        Channel::ProofMass | Channel::Cantilever => MAX_SPIKE_SAMPLES,
    };
    let least = (SPIKE_SIGMAS * signal.sigma()).max(SPIKE_BENDS * usual_bend(&values));
    if !least.is_finite() {
        return None;
    }
    let mut candidates: Vec<Candidate> = (1..=widest)
        .flat_map(|width| (1..values.len().saturating_sub(width)).map(move |at| at..at + width))
        .filter_map(|samples| candidate(&values, samples))
        .filter(|c| c.distance.abs() > least && !signal.near_edge[c.samples.start])
        .collect();
    candidates.sort_by(|a, b| b.distance.abs().total_cmp(&a.distance.abs()));
    let mut spikes: Vec<Candidate> = Vec::new();
    for old in candidates {
        // Others around may have been left out meanwhile.
        let Some(new) = candidate(&values, old.samples) else {
            continue;
        };
        let reach = reach_of_motion(&values, &new.samples).max(least);
        if new.distance.abs() > reach {
            values[new.samples.clone()].fill(f64::NAN);
            spikes.push(new);
        }
    }
    let samples: usize = spikes.iter().map(|s| s.samples.len()).sum();
    if samples as f64 > MAX_SPIKE_SHARE * values.len() as f64 && spikes.len() > 1 {
        return None;
    }
    if signal.channel == Channel::Voltage && are_pulses(&spikes) {
        return None;
    }
    let largest = spikes.iter().map(|s| s.distance.abs()).fold(0.0, f64::max);
    let mut places: Vec<Range<usize>> = spikes.into_iter().map(|s| s.samples).collect();
    places.sort_unstable_by_key(|place| place.start);
    Some(Found {
        fault: signal.fault(FaultKind::Spikes, largest, &places)?,
        unusable: places.into_iter().flatten().collect(),
    })
}

/// Samples that lie on one side of the line between their neighbours, all about as far: what
/// rises and falls gradually is motion.
fn candidate(values: &[f64], samples: Range<usize>) -> Option<Candidate> {
    let (before, after) = (values[samples.start - 1], values[samples.end]);
    let width = samples.len() as f64 + 1.0;
    let off = |i: usize| {
        let share = (i + 1 - samples.start) as f64 / width;
        values[i] - (before + (after - before) * share)
    };
    let first = off(samples.start);
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    for i in samples.clone() {
        let distance = off(i) * first.signum();
        if distance.is_nan() || distance <= 0.0 {
            return None;
        }
        (least, most) = (least.min(distance), most.max(distance));
    }
    (least >= SPIKE_FLATNESS * most).then_some(Candidate {
        samples,
        distance: least * first.signum(),
    })
}

/// How far sample `i` lies off the middle of its neighbours, twice; NaN where one is missing.
fn bend(values: &[f64], i: usize) -> f64 {
    (values[i - 1] - 2.0 * values[i] + values[i + 1]).abs()
}

/// The bend that half of the samples exceed.
fn usual_bend(values: &[f64]) -> f64 {
    let mut all: Vec<f64> = (1..values.len().saturating_sub(1))
        .map(|i| bend(values, i))
        .filter(|b| b.is_finite())
        .collect();
    quantile_in_place(&mut all, 0.5)
}

/// How far a motion may lie off the line across `samples`, by what is known of it around: by how it
/// bends, and by the speeds before and after, between which it may turn suddenly. Infinite where
/// too little is known.
fn reach_of_motion(values: &[f64], samples: &Range<usize>) -> f64 {
    let width = samples.len() as f64 + 1.0;
    let curved = (0.5 * width).powi(2) * bend_around(values, samples);
    let (Some(a), Some(b)) = (samples.start.checked_sub(2), values.get(samples.end + 1)) else {
        return f64::INFINITY;
    };
    let (before, after) = (
        values[samples.start - 1] - values[a],
        b - values[samples.end],
    );
    let turn = after - before;
    // A reading that does not come back has stepped: the line across is half of the step off.
    let gone = values[samples.end] - values[samples.start - 1] - 0.5 * width * (before + after);
    // A sudden turn in the middle is a quarter of it off for each sample of the line.
    let turned = 0.25 * width * turn.abs();
    if turned.is_nan() {
        return f64::INFINITY;
    }
    (SPIKE_BENDS * curved)
        .max(SPIKE_TURNS * turned)
        .max(SPIKE_RETURNS * gone.abs())
}

/// How much the motion bends around samples that are left out: next to them at most, farther off at
/// the fourth strongest place, for another spike bends three. Infinite where too little is known.
fn bend_around(values: &[f64], samples: &Range<usize>) -> f64 {
    let from = samples.start.saturating_sub(BEND_NEIGHBOURHOOD).max(1);
    let to = (samples.end + BEND_NEIGHBOURHOOD).min(values.len() - 1);
    let apart = |i: &usize| i + 1 < samples.start || *i > samples.end;
    let next =
        |i: usize| i + 1 + ADJACENT_BENDS >= samples.start && i <= samples.end + ADJACENT_BENDS;
    let known = |i: usize| Some((next(i), bend(values, i))).filter(|(_, b)| b.is_finite());
    let all: Vec<(bool, f64)> = (from..to).filter(apart).filter_map(known).collect();
    if all.len() < BEND_NEIGHBOURHOOD / 2 {
        return f64::INFINITY;
    }
    let of = |adjacent: bool| all.iter().filter(move |b| b.0 == adjacent).map(|b| b.1);
    let mut far: Vec<f64> = of(false).collect();
    far.sort_unstable_by(|a, b| b.total_cmp(a));
    let usual = far.get(3).copied().unwrap_or(f64::INFINITY);
    of(true).fold(usual, f64::max)
}

/// Whether they are a drive's pulses: several of one height.
fn are_pulses(spikes: &[Candidate]) -> bool {
    let heights = || spikes.iter().map(|s| s.distance.abs());
    let (low, high) = heights().fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(x), h.max(x)));
    spikes.len() > 1 && high <= (1.0 + PULSE_SIZE_SPREAD) * low
}
