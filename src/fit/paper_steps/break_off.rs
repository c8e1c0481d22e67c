//! Break-offs in recordings: releases after a stay whose beginning was recorded, followed by a
//! ring long enough to show its decay.

use std::sync::Arc;

use crate::fit::contact_readings::GROUND_LAW_RELAXATION;
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::{Prepared, prepare};
use crate::fit::segment::JointKind;
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::thresholds::{MIN_RING_PERIODS, MIN_RING_SAMPLES, MIN_STAY_TIME};
use crate::model::Model;
use crate::recording::{Recording, extremes};

/// Samples on the ground before the break-off: they determine the zero of the reading.
const LEAD_SAMPLES: usize = 12;
/// How far the instant of release may be from the first guess, as a share of a period: the
/// mass leaves slowly, and a fast recording shows it with a delay.
const RELEASE_REACH_PERIODS: f64 = 0.06;
/// Samples between the end of the ring and the next touch or bounce, and the same as a
/// share of a period.
const RING_END_GUARD: (usize, f64) = (3, 0.01);
/// Length of a ring in periods of the slowest mode: what is left of it after that says
/// little of the film.
const RING_PERIODS: f64 = 5.0;
/// Taken for a period where there is no spring \[s\].
const SPRINGLESS_PERIOD: f64 = 2e-3;
/// Most rings that are read; more of them say the same again.
pub(crate) const MAX_RINGS: usize = 8;
/// Most samples of a ring; a faster recording is thinned.
const MAX_SAMPLES_PER_RING: usize = 800;

/// The ring after a break-off.
#[derive(Debug, Clone)]
pub(crate) struct BreakOff {
    /// Index of the part.
    of: usize,
    /// Its last samples on the ground, and the ring.
    window: Part,
    /// From the lowest to the highest reading \[m\], to prefer the larger rings.
    height: f64,
}

/// Period of the slowest mode \[s\]; something as long without a spring.
fn period(model: &Model) -> f64 {
    let structure = model.structure();
    let modes = structure.modes.iter().map(|m| m.omega());
    let slowest = modes.filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
    if slowest.is_finite() {
        std::f64::consts::TAU / slowest
    } else {
        SPRINGLESS_PERIOD
    }
}

/// The break-offs in `parts`, at most [`MAX_RINGS`] of them, taken from the recordings in turn,
/// the largest rings first.
pub(crate) fn break_offs(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
) -> Vec<BreakOff> {
    let period = period(model);
    let mut found: Vec<(usize, BreakOff)> = Vec::new();
    for (of, (part, summary)) in parts.iter().zip(summaries).enumerate() {
        let mut own = break_offs_of_part(part, summary, period);
        for b in &mut own {
            b.of = of;
            let ring = &b.window.recording.proof_mass[b.window.samples.clone()];
            let (low, high) = extremes(ring);
            b.height = high - low;
        }
        // The sort keeps the order of time among equals.
        own.sort_by(|a, b| b.height.total_cmp(&a.height));
        found.extend(own.into_iter().enumerate());
    }
    found.sort_by_key(|(turn, _)| *turn);
    found.truncate(MAX_RINGS);
    let mut chosen: Vec<BreakOff> = found.into_iter().map(|(_, b)| b).collect();
    chosen.sort_by_key(|b| (b.of, b.window.samples.start));
    chosen
}

fn break_offs_of_part(part: &Part, summary: &RecordingSummary, period: f64) -> Vec<BreakOff> {
    let r = &part.recording;
    let time = &r.time;
    let interval = r.interval();
    let contacts = summary.events(r).contacts;
    let marks = summary.timeline(r, summary.noise.0).marks;
    // More than the instant of release may move, so that the mass is on the ground first.
    let lead = (LEAD_SAMPLES as f64 * interval).max(1.5 * RELEASE_REACH_PERIODS * period);
    let clear = (RING_END_GUARD.0 as f64 * interval).max(RING_END_GUARD.1 * period);
    let mut found = Vec::new();
    for contact in contacts
        .iter()
        .filter(|c| !c.cut && c.touching > MIN_STAY_TIME)
    {
        let past = marks.partition_point(|m| m.time <= contact.end + 1.5 * interval);
        // The touch must be in the recording: rest at its beginning is no contact.
        let Some([touch, release]) = past.checked_sub(2).map(|i| [marks[i], marks[i + 1]]) else {
            continue;
        };
        let left =
            matches!(release.kind, GroundEvent::Release { .. }) && touch.kind == GroundEvent::Touch;
        if !left || release.time < contact.start {
            continue;
        }
        let before = time.partition_point(|&t| t <= touch.time) + 1;
        let at = time.partition_point(|&t| t <= release.time);
        let first = time.partition_point(|&t| t < release.time - lead);
        let first = first.max(before).max(part.samples.start);
        let until = marks.get(past).map_or(f64::INFINITY, |m| m.time - clear);
        let last = time.partition_point(|&t| t < until.min(release.time + RING_PERIODS * period));
        let mut last = last.min(part.samples.end);
        if let Some(gap) = (first..last.saturating_sub(1)).find(|&i| r.is_gap(i)) {
            last = gap + 1;
        }
        let long_enough = first < at && at + MIN_RING_SAMPLES <= last;
        if long_enough && time[last - 1] - release.time >= MIN_RING_PERIODS * period {
            found.push(BreakOff {
                of: 0,
                window: Part {
                    recording: Arc::clone(r),
                    samples: first..last,
                },
                height: 0.0,
            });
        }
    }
    found
}

/// The fitting problem of the rings alone: each is one segment, from the held mass on, with a free
/// instant of release. The laws of the ground are switched off.
///
/// # Errors
/// [`FitError`] if the model makes no sense or a drive is missing.
pub(crate) fn ring_problem(
    model: &Model,
    space: &Space,
    found: &[BreakOff],
    summaries: &[RecordingSummary],
    options: &FitOptions,
) -> Result<Prepared, FitError> {
    let windows: Vec<Part> = found.iter().map(|b| b.window.clone()).collect();
    let own: Vec<RecordingSummary> = found.iter().map(|b| summaries[b.of].clone()).collect();
    let whole = FitOptions {
        longest: Some(f64::INFINITY),
        ..options.clone()
    };
    let mut prepared = prepare(model, space, &windows, &own, &whole)?;
    // One copy of each recording, however many of its rings are thinned: they do not overlap.
    let mut thinned: Vec<(Arc<Recording>, Recording)> = Vec::new();
    for (data, window) in prepared.problem.data.iter_mut().zip(&windows) {
        data.sigmas.velocity *= GROUND_LAW_RELAXATION;
        data.sigmas.force *= GROUND_LAW_RELAXATION;
        let dense = window.samples.start + 2 * LEAD_SAMPLES;
        let step = window.samples.len().div_ceil(MAX_SAMPLES_PER_RING);
        if step > 1 {
            let known = thinned
                .iter()
                .position(|(of, _)| Arc::ptr_eq(of, &data.recording));
            let known = known.unwrap_or_else(|| {
                thinned.push((Arc::clone(&data.recording), (*data.recording).clone()));
                thinned.len() - 1
            });
            let thin = &mut thinned[known].1;
            for i in (dense..window.samples.end).filter(|i| !(i - dense).is_multiple_of(step)) {
                thin.proof_mass[i] = f64::NAN;
                if let Some(xc) = &mut thin.cantilever {
                    xc[i] = f64::NAN;
                }
            }
        }
    }
    for (of, thin) in thinned {
        let thin = Arc::new(thin);
        for data in &mut prepared.problem.data {
            if Arc::ptr_eq(&data.recording, &of) {
                data.recording = Arc::clone(&thin);
            }
        }
    }
    let leaving = RELEASE_REACH_PERIODS * period(model);
    for joint in prepared.segments.iter_mut().flat_map(|s| &mut s.joints) {
        if let JointKind::Event(_) = joint.what {
            joint.reach = joint.reach.max(leaving);
            joint.sigma = joint.sigma.max(0.4 * leaving);
        }
    }
    prepared.segments.retain(|segment| {
        let mut events = segment.joints.iter().filter_map(|joint| match joint.what {
            JointKind::Event(kind) => Some(kind),
            JointKind::Edge(_) => None,
        });
        let leaves = matches!(events.next(), Some(GroundEvent::Release { .. }));
        segment.starts_held && leaves && events.next().is_none()
    });
    Ok(prepared)
}

#[cfg(test)]
mod tests {
    use super::super::break_off::*;
    use super::super::tests::{made, recording};
    use crate::fit::inspect::recording_summary::summarize;
    use crate::model::preset::Preset;

    fn found(recordings: &[Arc<Recording>]) -> Vec<BreakOff> {
        let model = Preset::default().model;
        let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
        break_offs(&model, &parts, &summarize(&model, &parts))
    }

    #[test]
    fn each_begins_on_the_ground_and_rings_freely() {
        let square = recording("square:15Hz:8V", 0.2);
        let found_here = found(std::slice::from_ref(&square));
        // The drive turns upwards after half a period, and then once a period.
        let times: Vec<f64> = found_here
            .iter()
            .map(|b| 15.0 * square.time[b.window.samples.start])
            .collect();
        assert_eq!(times.len(), 3, "{times:?}");
        for (k, t) in times.iter().enumerate() {
            assert!((t - 0.5 - k as f64).abs() < 0.02, "{times:?}");
        }
        for b in &found_here {
            let ring = &square.proof_mass[b.window.samples.clone()];
            assert!(ring[..4].iter().all(|x| (x + 58e-6).abs() < 0.2e-6));
            let lowest = ring.iter().copied().fold(0.0, f64::min);
            assert!(lowest > -58.2e-6, "{lowest}");
        }
    }

    #[test]
    fn rings_of_a_fast_recording_share_one_thinned_copy() {
        let fast = made("square:15Hz:8V", 0.2, 400e3, 0.0, &[]);
        let model = Preset::default().model;
        let parts = [Part::whole(Arc::clone(&fast))];
        let summaries = summarize(&model, &parts);
        let found = break_offs(&model, &parts, &summaries);
        assert!(found.len() > 1);
        let options = FitOptions::for_model(&model);
        let space = Space::new(&model, &["Cs".to_owned(), "gp".to_owned()]).unwrap();
        let prepared = ring_problem(&model, &space, &found, &summaries, &options).unwrap();
        let data = &prepared.problem.data;
        assert!(
            data.iter()
                .all(|d| Arc::ptr_eq(&d.recording, &data[0].recording))
        );
        for ring in &found {
            let samples = ring.window.samples.clone();
            let kept = data[0].recording.proof_mass[samples.clone()].iter();
            let kept = kept.filter(|x| x.is_finite()).count();
            assert!(samples.len() > 2 * MAX_SAMPLES_PER_RING);
            assert!(kept <= MAX_SAMPLES_PER_RING + 2 * LEAD_SAMPLES, "{kept}");
            assert!(kept > MAX_SAMPLES_PER_RING / 2, "{kept}");
        }
    }

    #[test]
    fn a_contact_without_its_touch_does_not_count() {
        let square = recording("square:15Hz:8V", 0.2);
        let from = square.time.partition_point(|&t| t < 0.02);
        let cut = |values: &[f64]| values[from..].to_vec();
        let voltage = square.voltage.as_deref().map(cut);
        let xc = square.cantilever.as_deref().map(cut);
        let xp = cut(&square.proof_mass);
        let late = Recording::new("late", cut(&square.time), voltage, xp, xc).unwrap();
        assert_eq!(found(&[Arc::new(late)]).len(), 2);
    }

    #[test]
    fn the_number_is_bounded_and_all_recordings_contribute() {
        let drives = ["square:15Hz:8V", "ramped:5Hz:8V:0.25", "square:15Hz:7.5V"];
        let all = drives.map(|d| made(d, 0.8, 50e3, 0.0, &[]));
        let found = found(&all);
        assert_eq!(found.len(), MAX_RINGS);
        for of in 0..3 {
            assert!(found.iter().filter(|b| b.of == of).count() >= 2);
        }
    }
}
