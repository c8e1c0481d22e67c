//! Stretches beside a fit: those that were misread are looked after, those of a device
//! with other modes take their unknowns over, and a few stand for all on the way.

use rayon::prelude::*;

use super::bench::LOSS;
use crate::fit::problem::Problem;
use crate::fit::robust::Huber;
use crate::fit::segment::Segment;
use crate::fit::solve::Point;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, StretchSimulator, StretchState};

/// A stretch this many times farther off than nine in ten of the others was misread.
const OFF: f64 = 2.5;
/// One in this many stretches is used on the way.
const THIN: usize = 3;
/// So many of each recording, in flight and held, are used at least.
const AT_LEAST: usize = 6;

/// Looks after stretches that are far off where the others are not: a new start from the
/// first guess, or no say, for then an event in them was overlooked. Whether anything
/// changed.
pub fn heal(problem: &Problem, point: &mut Point, first: &[Segment]) -> Result<bool, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&simulator, &point.segments);
    let fit = |i: usize, start: Vec<f64>, huber, rounds| {
        let segment = &point.segments[i];
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        problem.refine(
            segment, &states[i], &simulator, &nuisances, start, huber, rounds,
        )
    };
    let rows: Vec<usize> = point
        .segments
        .iter()
        .map(|s| problem.rows(s).len())
        .collect();
    let per_row = |i: usize, cost: f64| (cost / rows[i].max(1) as f64).sqrt();
    let now: Vec<(Vec<f64>, f64)> = (0..point.segments.len())
        .into_par_iter()
        .map(|i| fit(i, point.segments[i].locals.clone(), LOSS, 1))
        .collect();
    let mut known: Vec<f64> = (0..now.len())
        .filter(|&i| point.used[i])
        .map(|i| per_row(i, now[i].1))
        .filter(|c| c.is_finite())
        .collect();
    let usual = quantile_in_place(&mut known, 0.9).max(1.0);
    let off: Vec<usize> = (0..now.len())
        .filter(|&i| point.used[i] && per_row(i, now[i].1) > OFF * usual)
        .collect();
    let fresh: Vec<(Vec<f64>, f64)> = off
        .par_iter()
        .map(|&i| {
            let (loose, _) = fit(i, first[i].locals.clone(), Huber(1e4), 8);
            fit(i, loose, LOSS, 8)
        })
        .collect();
    for (&i, (locals, cost)) in off.iter().zip(fresh) {
        let best = cost.min(now[i].1);
        let left = per_row(i, best);
        if cost < now[i].1 {
            point.segments[i].locals = locals;
        }
        point.used[i] = left <= OFF * usual;
    }
    Ok(!off.is_empty())
}

/// Takes the unknowns of `known` over into `fresh`, the same stretches of a device with
/// other modes, of which those that both have come first. A new mode begins at rest.
pub fn adopt(
    known: &[Segment],
    fresh: Vec<Segment>,
    (old, new): (&StretchSimulator, &StretchSimulator),
    problem: &Problem,
) -> Vec<Segment> {
    if known.len() != fresh.len() {
        return fresh;
    }
    let one = |(k, mut f): (&Segment, Segment)| {
        let joints: usize = k.joints.iter().map(|j| j.unknowns()).sum();
        let states = k.locals.len() - joints;
        if k.samples != f.samples || k.joints.len() != f.joints.len() {
            return f;
        }
        let value = |i: usize| k.value(&k.locals, i);
        let mut state = StretchState {
            q: (0..states / 2).map(value).collect(),
            v: (states / 2..states).map(value).collect(),
            z: Vec::new(),
        };
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
        f.locals.extend_from_slice(&k.locals[states..]);
        f.joints.clone_from(&k.joints);
        f
    };
    known.iter().zip(fresh).map(one).collect()
}

/// Which stretches are used on the way: some of each recording, in flight and held.
pub fn thinned(segments: &[Segment]) -> Vec<bool> {
    let mut used = vec![false; segments.len()];
    let mut groups: std::collections::BTreeMap<(usize, bool), Vec<usize>> = Default::default();
    for (i, s) in segments.iter().enumerate() {
        groups
            .entry((s.recording, s.starts_held))
            .or_default()
            .push(i);
    }
    for group in groups.values() {
        let stride = THIN.min(group.len() / AT_LEAST).max(1);
        group.iter().step_by(stride).for_each(|&i| used[i] = true);
    }
    used
}
