//! Segments in which nothing happens at the ground: the mass flies throughout, or it is held
//! throughout.
//!
//! Simulated from free initial states, they show the forces of flight and the motion of the
//! structure without any contact law, and no mistimed impact can spoil them.

use std::ops::Range;

use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::{Prepared, prepare};
use crate::fit::segment::event_sequence::{GroundEvent, Timeline};
use crate::fit::segment::{Cut, Segment, cut};
use crate::fit::{FitError, FitOptions, Part};
use crate::model::Model;
use crate::recording::{Recording, quantile_in_place};
use crate::sim::StretchSimulator;

/// Fewest samples of a segment \[samples\]: a shorter one hardly determines more than its own
/// initial state.
const MIN_SEGMENT_SAMPLES: usize = 16;
/// Samples dropped on both sides of an event \[samples\]: its time is known to about one sample.
const EVENT_GUARD_SAMPLES: f64 = 1.6;
/// Flight is trusted from this height above the ground on, in standard deviations of the noise.
/// Lower down, a hop too small to be resolved would pass for flight.
const MIN_CLEARANCE_IN_NOISE: f64 = 8.0;
/// Flight is trusted from at least this height above the ground on \[m\].
const MIN_CLEARANCE: f64 = 0.25e-6;
/// Standard errors by which the variance of a reading must exceed that of the noise for the mass
/// to count as moving.
const MOTION_STD_ERRORS: f64 = 6.0;
/// Time after a landing in which the mass may still hop, too low for its bounces to be resolved
/// \[s\].
const HOPPING_TIME: f64 = 3e-3;
/// Samples averaged to detect such a hop \[samples\].
const HOP_BLOCK_SAMPLES: usize = 8;
/// Height of that average above the rest of the contact from which it is a hop, in standard
/// deviations of the noise.
const HOP_HEIGHT_IN_NOISE: f64 = 0.8;
/// Largest difference between the zeros of two recordings \[m\].
const ZERO_UNCERTAINTY: f64 = 5e-6;
/// The ground is looked for within this height of the lowest samples \[m\].
const GROUND_SEARCH_HEIGHT: f64 = 0.5e-6;

/// Recordings cut into segments without events at the ground.
#[derive(Debug, Clone)]
pub struct EventFreeSegments {
    /// The problem, with the segments in it.
    pub prepared: Prepared,
    /// What happens at the ground in each recording.
    pub timelines: Vec<Timeline>,
    /// Share of the samples of each recording that lie in segments.
    pub covered: Vec<f64>,
}

/// The samples between two events.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// Its samples, without those next to the events.
    pub samples: Range<usize>,
    /// Whether the mass is on the ground.
    pub held: bool,
}

/// The intervals of `recording` between the events of `timeline`. Where the level of the ground
/// and a clearance are known (`ground`, both \[m\]), flight stays above it by that clearance. `xp`
/// is the reading \[m\] with a lag and changes of that level removed.
pub fn intervals(
    recording: &Recording,
    xp: &[f64],
    timeline: &Timeline,
    samples: &Range<usize>,
    ground: Option<(f64, f64)>,
) -> Vec<Interval> {
    let time = &recording.time;
    let guard = EVENT_GUARD_SAMPLES * recording.interval();
    let mut out = Vec::new();
    // The drive before and after the recording is unknown. It may have jumped at either end,
    // and the first and last readings may lie beyond those by the drive's clock.
    let mut begin = time.first().copied().unwrap_or(f64::NEG_INFINITY);
    let last = time.last().copied().unwrap_or(f64::INFINITY);
    let mut held = timeline.starts_held;
    let ends = timeline.marks.iter().map(|m| (m.time, Some(m.kind)));
    let mut add = |samples: Range<usize>, held: bool| {
        if samples.len() >= MIN_SEGMENT_SAMPLES {
            out.push(Interval { samples, held });
        }
    };
    for (end, kind) in ends.chain([(last, None)]) {
        let from = time.partition_point(|&t| t < begin + guard);
        let to = time.partition_point(|&t| t <= end - guard);
        let (from, to) = (from.max(samples.start), to.min(samples.end));
        match ground {
            Some((level, clear)) if !held => {
                // Each run of samples clearly above the ground is an interval.
                let low = |i: usize| xp[i] < level + clear;
                let mut start = from;
                for i in from..to {
                    if low(i) {
                        add(start..i, held);
                        start = i + 1;
                    }
                }
                add(start..to.max(start), held);
            }
            _ => add(from..to.max(from), held),
        }
        begin = end;
        held = matches!(kind, Some(GroundEvent::Touch));
    }
    out
}

/// Whether a reading is a straight line plus noise. A mass at rest on the ground gives one. A mass
/// that still hops there, too low for its bounces to be resolved, does not.
fn is_at_rest(xp: &[f64], noise: f64) -> bool {
    let points = || xp.iter().enumerate().filter(|(_, x)| x.is_finite());
    let n = points().count() as f64;
    let mean =
        |f: &dyn Fn(f64, f64) -> f64| points().map(|(i, x)| f(i as f64, *x)).sum::<f64>() / n;
    let (i0, x0) = (mean(&|i, _| i), mean(&|_, x| x));
    let slope = mean(&|i, x| (i - i0) * (x - x0)) / mean(&|i, _| (i - i0).powi(2)).max(1e-12);
    let left = mean(&|i, x| (x - x0 - slope * (i - i0)).powi(2));
    left < (1.0 + MOTION_STD_ERRORS * (2.0 / n).sqrt()) * noise * noise
}

/// Number of samples at the start of a contact, `xp` \[m\] at every `interval` \[s\], in which the
/// mass still hops.
fn hopping_samples(xp: &[f64], interval: f64, noise: f64) -> usize {
    let finite =
        |xp: &[f64]| -> Vec<f64> { xp.iter().copied().filter(|x| x.is_finite()).collect() };
    let first = ((HOPPING_TIME / interval) as usize).min(xp.len() / 2);
    let rest = quantile_in_place(&mut finite(&xp[first..]), 0.5);
    let hops = |block: &[f64]| {
        let known = finite(block);
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        mean - rest > HOP_HEIGHT_IN_NOISE * noise
    };
    let starts = (0..first).step_by(HOP_BLOCK_SAMPLES / 2);
    let mut hopping = starts.filter(|&i| hops(&xp[i..(i + HOP_BLOCK_SAMPLES).min(xp.len())]));
    hopping
        .next_back()
        .map_or(0, |i| (i + 2 * HOP_BLOCK_SAMPLES).min(first))
}

/// The level at which low readings are most frequent \[m\]: the centre of the densest window of
/// four standard deviations of the noise.
fn ground_level(xp: &[f64], noise: f64) -> Option<f64> {
    let mut low: Vec<f64> = xp.iter().copied().filter(|x| x.is_finite()).collect();
    let bottom = quantile_in_place(&mut low, 2e-3);
    low.retain(|x| *x < bottom + GROUND_SEARCH_HEIGHT + 6.0 * noise);
    low.sort_unstable_by(f64::total_cmp);
    let mut first = 0;
    let mut best = (0, 0.0);
    for last in 0..low.len() {
        while low[last] - low[first] > 4.0 * noise {
            first += 1;
        }
        if last - first >= best.0 {
            best = (last - first, low[(first + last) / 2]);
        }
    }
    (best.0 > 0).then_some(best.1)
}

/// Cuts `parts` into event-free segments for the parameters of `space`, with initial values
/// guessed from `model`.
///
/// # Errors
/// [`FitError`] if the model makes no sense, a drive is missing or nothing can be used.
pub fn prepare_event_free(
    model: &Model,
    space: &Space,
    parts: &[Part],
    findings: &[RecordingSummary],
    options: &FitOptions,
) -> Result<EventFreeSegments, FitError> {
    let mut prepared = prepare(model, space, parts, findings, options)?;
    let simulator = StretchSimulator::new(model, &prepared.problem.options)?;
    let mut known: Vec<f64> = findings
        .iter()
        .filter_map(|f| f.level.clone().ok())
        .collect();
    let common = quantile_in_place(&mut known, 0.5);
    let mut segments: Vec<Segment> = Vec::new();
    let mut timelines = Vec::with_capacity(parts.len());
    let mut covered = Vec::with_capacity(parts.len());
    for (index, (part, finding)) in parts.iter().zip(findings).enumerate() {
        let data = &prepared.problem.data[index];
        let recording = &data.recording;
        let timeline = finding.timeline(recording, data.sigmas.xp);
        let (moved, noise) = (
            finding.as_moved(recording),
            finding.noise_of(data.sigmas.xp, recording),
        );
        let ground = if finding.level.is_ok() {
            ground_level(&moved[part.samples.clone()], noise)
                .map(|level| (level, (MIN_CLEARANCE_IN_NOISE * noise).max(MIN_CLEARANCE)))
        } else {
            // The mass may still touch the ground without being noticed.
            common.is_finite().then_some((common, ZERO_UNCERTAINTY))
        };
        let lone = recording.cantilever.is_none();
        let longest = options
            .longest
            .unwrap_or_else(|| crate::fit::problem::prepare::default_length(&simulator, lone));
        let mut samples = 0;
        for mut interval in intervals(recording, &moved, &timeline, &part.samples, ground) {
            let since = interval
                .held
                .then(|| recording.time[interval.samples.start]);
            if interval.held {
                let xp = &moved[interval.samples.clone()];
                interval.samples.start += hopping_samples(xp, recording.interval(), noise);
            }
            let quiet = Timeline {
                marks: Vec::new(),
                starts_held: interval.held,
            };
            let pieces = cut(
                &Cut {
                    index,
                    recording,
                    track: &data.track,
                    timeline: &quiet,
                    simulator: &simulator,
                    longest,
                    lone,
                    noise: data.sigmas.xp,
                },
                interval.samples,
            );
            for mut segment in pieces {
                let xp = &moved[segment.samples.clone()];
                if interval.held && !is_at_rest(xp, noise) {
                    continue;
                }
                // How the contact began is analysed elsewhere.
                segment.settled = false;
                segment.since = since;
                samples += segment.samples.len();
                segments.push(segment);
            }
        }
        covered.push(samples as f64 / part.samples.len().max(1) as f64);
        timelines.push(timeline);
    }
    prepared.segments = segments;
    Ok(EventFreeSegments {
        prepared,
        timelines,
        covered,
    })
}

#[cfg(test)]
mod tests {
    use super::super::event_free_segments::*;

    #[test]
    fn hops_after_a_landing_are_removed_from_a_contact_and_noise_and_drift_are_kept() {
        let (interval, noise) = (4e-5, 150e-9);
        let reading = |hop: f64, slope: f64| -> Vec<f64> {
            let one = |i: usize| {
                let t = i as f64 * interval;
                // A parabola of 0.4 ms, and a deterministic stand-in for noise.
                let hop = hop * (1.0 - (t / 2e-4 - 1.0).powi(2)).max(0.0);
                hop + slope * t + noise * 1.4 * (1.7 * i as f64 * i as f64).sin()
            };
            (0..400).map(one).collect()
        };
        assert_eq!(hopping_samples(&reading(0.0, 0.0), interval, noise), 0);
        assert_eq!(hopping_samples(&reading(0.0, 2e-6), interval, noise), 0);
        let left_out = hopping_samples(&reading(0.6e-6, 0.0), interval, noise) as f64 * interval;
        assert!((4e-4..HOPPING_TIME).contains(&left_out), "{left_out}");
        assert_eq!(hopping_samples(&[], interval, noise), 0);
    }
}
