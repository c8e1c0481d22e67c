//! The sequence of a segment's events that the model itself predicts.

use std::sync::Arc;

use super::event_alternatives::{JointUnknowns, join_joints, split_joints};
use super::event_trial::EventTrial;
use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::fit::thresholds::MIN_SAMPLES_BEFORE_EVENT;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::ParameterId;
use crate::sim::{EventKind, Options, Runner, StretchState};

impl EventTrial<'_> {
    /// The sequence that the model predicts from the state at the segment's start, which is fitted
    /// to the samples before its first event. `factor` is on the restitution.
    pub(crate) fn predicted(&self, segment: &Segment, factor: f64) -> Option<Segment> {
        let data = &self.problem.data[segment.recording];
        let time = &data.recording.time;
        let nuisances = self.problem.nuisances_of(self.x, segment.recording);
        let (_, parts) = split_joints(segment);
        let is_event = |p: &JointUnknowns| matches!(p.0.what, JointKind::Event(_));
        let before = match parts.iter().find(|p| is_event(p)) {
            Some(p) => time.partition_point(|&t| t < p.0.time - 0.5 * segment.interval),
            None => {
                (segment.samples.start + 2 * MIN_SAMPLES_BEFORE_EVENT).min(segment.samples.end - 1)
            }
        };
        let mut state = segment.clone();
        if before > segment.samples.start + MIN_SAMPLES_BEFORE_EVENT {
            state.samples = segment.samples.start..before;
            let quiet = |p: &&JointUnknowns| !is_event(p) && p.0.time < time[before];
            let (own, _) = split_joints(segment);
            state = join_joints(&state, own, parts.iter().filter(quiet).cloned().collect());
            self.fit(&mut state);
        }
        let (own, known) = split_joints(&state);
        let edges: Vec<JointUnknowns> = parts
            .iter()
            .filter(|p| !is_event(p))
            .map(|p| {
                known
                    .iter()
                    .find(|k| k.0.time == p.0.time)
                    .unwrap_or(p)
                    .clone()
            })
            .collect();
        let start = time[segment.samples.start] + nuisances.skew;
        let end = time[segment.samples.end - 1] + nuisances.skew;
        let mut pieces = segment.pieces.clone();
        for (joint, unknowns) in &edges {
            if let JointKind::Edge(piece) = joint.what {
                let at = joint.time + unknowns[0] * segment.time_unit();
                pieces[piece - 1].end = at;
                pieces[piece].start = at;
            }
        }
        let table = VoltageTable::of_pieces("segment", pieces, String::new());
        let drive = Waveform::Table(Arc::new(table));
        let n = own.len() / 2;
        let value = |i: usize| own[i] * segment.units[i];
        let from = StretchState {
            q: (0..n).map(value).collect(),
            v: (n..2 * n).map(value).collect(),
            z: self.states.to_vec(),
        };
        let since = segment.starts_held.then(|| segment.since.unwrap_or(start));
        let options = Options {
            max_events: 200,
            ..self.problem.options
        };
        let mut model = self.model.clone();
        let alpha = model.parameters[ParameterId::Alpha];
        model
            .parameters
            .set(ParameterId::Alpha, (factor * alpha).min(1.0));
        let runner = Runner::from_state(&model, &drive, &options, start, &from, since);
        let mut runner = runner.ok()?;
        let mut trace = runner.new_trace();
        runner.advance(end, &mut trace).ok()?;
        let mut all = edges;
        for e in trace.events.iter().filter(|e| e.time < end) {
            let kind = match e.kind {
                EventKind::Impact => GroundEvent::Bounce {
                    v_after: e.velocity_after,
                },
                EventKind::Stick => GroundEvent::Touch,
                EventKind::Release => GroundEvent::Release {
                    informative: e.contact_duration > 1.5 * segment.interval
                        && (!segment.starts_held || segment.since.is_some()),
                },
                EventKind::DriveStep => continue,
            };
            let joint = Joint {
                time: e.time - nuisances.skew,
                reach: 5.0 * segment.interval,
                sigma: 2.0 * segment.interval,
                what: JointKind::Event(kind),
            };
            let mut unknowns = vec![0.0];
            if let GroundEvent::Bounce { v_after } = kind {
                unknowns.push(v_after / segment.velocity_unit);
            }
            all.push((joint, unknowns));
        }
        all.sort_by(|a, b| a.0.time.total_cmp(&b.0.time));
        Some(join_joints(segment, own, all))
    }
}
