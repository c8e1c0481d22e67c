//! Sequences of events that differ from a segment's by one change, and segments split into
//! joints and joined again.

use super::event_trial::EventTrial;
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::segment::{Joint, JointKind, Segment};

/// A joint with its own unknowns.
pub(crate) type JointUnknowns = (Joint, Vec<f64>);

impl EventTrial<'_> {
    /// Sequences with one more impact, where the samples turn sharply near the ground.
    pub(crate) fn with_missed_impact(&self, segment: &Segment) -> Vec<Segment> {
        let data = &self.problem.data[segment.recording];
        let (time, xp) = (&data.recording.time, &data.recording.proof_mass);
        let nuisances = self.problem.nuisances_of(self.x, segment.recording);
        let (state, parts) = split_joints(segment);
        let interval = segment.interval;
        let mut out = Vec::new();
        for i in segment.samples.start + 2..segment.samples.end.saturating_sub(2) {
            let level =
                self.simulator.ground_level(time[i]) * nuisances.scale_p + nuisances.offset_p;
            let fall = (xp[i - 1] - xp[i]).max(xp[i - 2] - xp[i - 1]);
            let lowest = xp[i] < xp[i - 1] && xp[i] <= xp[i + 1];
            // An impact lies less than a sample's way below the lowest sample.
            let low = xp[i] - level < 1.5 * fall.abs() + 5.0 * data.sigmas.xp;
            let taken = |p: &JointUnknowns| (p.0.time - time[i]).abs() < 2.0 * interval;
            if !(lowest && low) || parts.iter().any(taken) {
                continue;
            }
            let rise = (xp[i + 1] - xp[i]).max(xp[i + 2] - xp[i + 1]);
            let v_after = (rise / interval).max(0.0);
            let joint = Joint {
                time: time[i],
                reach: 5.0 * interval,
                sigma: 2.0 * interval,
                what: JointKind::Event(GroundEvent::Bounce { v_after }),
            };
            let at = parts.partition_point(|p| p.0.time < time[i]);
            let mut all = parts.clone();
            all.insert(at, (joint, vec![0.0, v_after / segment.velocity_unit]));
            out.push(join_joints(segment, state, all));
        }
        out
    }
}

/// Other sequences of a segment's events, each with one change.
pub(crate) fn alternative_sequences(segment: &Segment) -> Vec<Segment> {
    let (state, parts) = split_joints(segment);
    let velocity_unit = segment.velocity_unit;
    let interval = segment.interval;
    let mut out = Vec::new();
    let mut add = |parts: Vec<JointUnknowns>| out.push(join_joints(segment, state, parts));
    for i in 0..parts.len() {
        let with = |new: Vec<JointUnknowns>, removed: usize| {
            let mut all = parts[..i].to_vec();
            all.extend(new);
            all.extend_from_slice(&parts[i + removed..]);
            all
        };
        let (joint, own) = &parts[i];
        let JointKind::Event(kind) = joint.what else {
            continue;
        };
        let at = joint.time + own[0] * segment.time_unit();
        let event = |kind, time: f64| Joint {
            time,
            what: JointKind::Event(kind),
            ..*joint
        };
        let next = parts.get(i + 1).map(|p| p.0.what);
        let brief = matches!(next, Some(JointKind::Event(GroundEvent::Release { .. })));
        let touch = || (event(GroundEvent::Touch, at), vec![0.0]);
        let release = |after: f64| {
            let kind = GroundEvent::Release {
                informative: after > 1.5 * interval,
            };
            (event(kind, at + after), vec![0.0])
        };
        match kind {
            GroundEvent::Bounce { .. } => {
                // No impact, or one without a bounce.
                add(with(Vec::new(), 1));
                for stay in [0.3, 2.0] {
                    add(with(vec![touch(), release(stay * interval)], 1));
                }
            }
            GroundEvent::Touch => {
                if brief {
                    let v_after = 0.02;
                    let bounce = event(GroundEvent::Bounce { v_after }, at);
                    add(with(vec![(bounce, vec![0.0, v_after / velocity_unit])], 2));
                    add(with(Vec::new(), 2));
                }
                // A hop before the stay.
                for hop in [3.0, 5.0, 8.0] {
                    let later = (event(GroundEvent::Touch, at + hop * interval), vec![0.0]);
                    add(with(vec![touch(), release(0.3 * interval), later], 1));
                }
            }
            GroundEvent::Release { .. } => {
                // Back on the ground at once, and off again.
                if i > 0
                    && matches!(parts[i - 1].0.what, JointKind::Event(GroundEvent::Touch))
                    && let Some(JointKind::Event(GroundEvent::Touch)) = next
                {
                    // There was no hop.
                    add(with(Vec::new(), 2));
                }
            }
        }
    }
    out
}

pub(crate) fn split_joints(segment: &Segment) -> (&[f64], Vec<JointUnknowns>) {
    let joints: usize = segment.joints.iter().map(Joint::unknowns).sum();
    let (state, mut rest) = segment.locals.split_at(segment.locals.len() - joints);
    let parts = segment.joints.iter().map(|joint| {
        let (own, after) = rest.split_at(joint.unknowns());
        rest = after;
        (*joint, own.to_vec())
    });
    let parts = parts.collect();
    (state, parts)
}

pub(crate) fn join_joints(segment: &Segment, state: &[f64], parts: Vec<JointUnknowns>) -> Segment {
    let mut units = segment.units[..state.len()].to_vec();
    let mut locals = state.to_vec();
    for (joint, own) in &parts {
        units.push(segment.time_unit());
        if joint.unknowns() == 2 {
            units.push(segment.velocity_unit);
        }
        locals.extend_from_slice(own);
    }
    Segment {
        joints: parts.into_iter().map(|p| p.0).collect(),
        locals,
        units,
        ..segment.clone()
    }
}
