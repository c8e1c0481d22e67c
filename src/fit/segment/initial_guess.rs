//! First guesses of a segment's unknowns, and their units.

use nalgebra::{DMatrix, DVector};

use super::event_sequence::GroundEvent;
use super::{Cut, JointKind, Segment};
use crate::sim::{StretchSimulator, StretchState};

/// Units of coordinates, then velocities, of a segment of `span` \[s\]: motions as large as
/// the `noise` \[m\].
pub fn state_units(sim: &StretchSimulator, held: bool, noise: f64, span: f64) -> Vec<f64> {
    let (shapes, omega2): (Vec<f64>, Vec<f64>) = if held {
        let structure = sim.held_structure();
        (structure.cantilever.clone(), structure.omega2.clone())
    } else {
        let (p, c) = sim.flight_shapes();
        let both = p.iter().zip(c).map(|(p, c)| p.hypot(*c)).collect();
        (both, sim.flight_omega2().collect())
    };
    let size = |shape: &f64| noise / shape.abs().max(1e-300);
    let speeds = shapes
        .iter()
        .zip(&omega2)
        .map(|(shape, omega2)| size(shape) * omega2.sqrt().max(1.0 / span));
    shapes.iter().map(size).chain(speeds).collect()
}

/// First guess of the unknowns, and their units: motions as large as the noise.
pub(super) fn guess(c: &Cut<'_>, segment: &mut Segment) {
    let sim = c.simulator;
    let start = c.recording.time[segment.samples.start];
    let level = sim.ground_level(start);
    let held = segment.starts_held.then_some(level);
    let mut state = sim.rest_state(&segment.pieces, start, held);
    let n = state.q.len();
    let span = c.recording.time[segment.samples.end - 1] - start;
    let mut units = state_units(sim, segment.starts_held, c.noise, span);
    if !segment.starts_held {
        follow_data(c, segment, &mut state);
    }
    let mut locals: Vec<f64> = state.q.iter().chain(&state.v).copied().collect();
    let interval = c.recording.interval();
    for joint in &segment.joints {
        locals.push(joint.time);
        units.push(0.02 * interval);
        if let JointKind::Event(GroundEvent::Bounce { v_after }) = joint.what {
            locals.push(v_after);
            units.push(c.noise / interval * 0.05);
        }
    }
    // Times are counted from the guess: a difference of two instants far from zero is exact.
    let mut k = 2 * n;
    for joint in &segment.joints {
        locals[k] -= joint.time;
        k += 1 + usize::from(matches!(
            joint.what,
            JointKind::Event(GroundEvent::Bounce { .. })
        ));
    }
    segment.locals = locals.iter().zip(&units).map(|(x, u)| x / u).collect();
    segment.units = units;
}

/// Brings the modes to where the first samples lie, with their mean slope.
fn follow_data(c: &Cut<'_>, segment: &Segment, state: &mut StretchState) {
    let (phi_p, phi_c) = c.simulator.flight_shapes();
    let n = state.q.len();
    let first = segment.samples.start;
    let few = first..(first + 4).min(segment.samples.end);
    let line = |values: &[f64]| -> Option<(f64, f64)> {
        let points: Vec<(f64, f64)> = few
            .clone()
            .map(|i| (c.recording.time[i] - c.recording.time[first], values[i]))
            .filter(|p| p.1.is_finite())
            .collect();
        let count = points.len() as f64;
        if points.len() < 2 {
            return None;
        }
        let (mt, mx) = points
            .iter()
            .fold((0.0, 0.0), |m, p| (m.0 + p.0, m.1 + p.1));
        let (mt, mx) = (mt / count, mx / count);
        let (mut xy, mut xx) = (0.0, 0.0);
        for (t, x) in &points {
            xy += (t - mt) * (x - mx);
            xx += (t - mt) * (t - mt);
        }
        Some((mx - xy / xx * mt, xy / xx))
    };
    let xp = line(&c.recording.proof_mass);
    let xc = c.recording.cantilever.as_deref().and_then(line);
    // The smallest change of the modes that meets the readings.
    let rows: Vec<(&[f64], (f64, f64))> = [(phi_p, xp), (phi_c, xc)]
        .into_iter()
        .filter_map(|(phi, x)| x.map(|x| (phi, x)))
        .filter(|(phi, _)| phi.iter().any(|p| *p != 0.0))
        .collect();
    // A stretch that begins with missing readings says nothing of where it begins.
    if rows.is_empty() {
        return;
    }
    let phi = DMatrix::from_fn(rows.len(), n, |i, j| rows[i].0[j]);
    let Ok(inverse) = phi.clone().pseudo_inverse(1e-12) else {
        return;
    };
    let want = |pick: fn(&(f64, f64)) -> f64, now: &[f64]| {
        let now = DVector::from_column_slice(now);
        let miss = DVector::from_fn(rows.len(), |i, _| pick(&rows[i].1)) - &phi * &now;
        now + &inverse * miss
    };
    let (q, v) = (want(|x| x.0, &state.q), want(|x| x.1, &state.v));
    state.q.copy_from_slice(q.as_slice());
    state.v.copy_from_slice(v.as_slice());
}
