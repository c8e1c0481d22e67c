//! Warm starts: the unknowns of segments carried over to a model with other modes, and the subset
//! of segments that fits use on the way.

use crate::diagnose::data::misread_segments::start_state;
use crate::fit::problem::Problem;
use crate::fit::segment::Segment;
use crate::sim::StretchSimulator;

/// One in this many segments is used on the way.
const SUBSET_STRIDE: usize = 3;
/// Fewest segments used of each recording, in flight and held.
const MIN_SUBSET_SEGMENTS: usize = 6;

/// Carries the unknowns of the segments `known` over into `fresh`, the same segments of a device
/// with other modes, of which the common ones come first. A new mode starts at rest.
pub fn warm_start(
    known: &[Segment],
    fresh: Vec<Segment>,
    (old, new): (&StretchSimulator, &StretchSimulator),
    problem: &Problem,
) -> Vec<Segment> {
    if known.len() != fresh.len() {
        return fresh;
    }
    let one = |(k, mut f): (&Segment, Segment)| {
        if k.samples != f.samples {
            return f;
        }
        let (mut state, states) = start_state(k);
        let data = &problem.data[k.recording];
        let level = old.ground_level(data.recording.time[k.samples.start] + data.epoch);
        if k.starts_held {
            old.lift(level, &mut state);
        }
        state.q.resize(new.modes(), 0.0);
        state.v.resize(new.modes(), 0.0);
        if f.starts_held {
            new.land(level, &mut state);
        }
        let own = state.q.iter().chain(&state.v);
        f.locals = own.zip(&f.units).map(|(x, unit)| x / unit).collect();
        f.units.truncate(f.locals.len());
        f.locals.extend_from_slice(&k.locals[states..]);
        f.units.extend_from_slice(&k.units[states..]);
        f.joints.clone_from(&k.joints);
        f
    };
    known.iter().zip(fresh).map(one).collect()
}

/// The segments used on the way: some of each recording, in flight and held.
pub fn subset_mask(segments: &[Segment]) -> Vec<bool> {
    let mut used = vec![false; segments.len()];
    let mut groups: std::collections::BTreeMap<(usize, bool), Vec<usize>> = Default::default();
    for (i, s) in segments.iter().enumerate() {
        groups
            .entry((s.recording, s.starts_held))
            .or_default()
            .push(i);
    }
    for group in groups.values() {
        let stride = SUBSET_STRIDE.min(group.len() / MIN_SUBSET_SEGMENTS).max(1);
        group.iter().step_by(stride).for_each(|&i| used[i] = true);
    }
    used
}
