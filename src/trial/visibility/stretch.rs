//! What one stretch adds: the effect's trace with the stretch's own freedoms taken out.

use nalgebra::DVector;

use super::normal_equations::{CaseRun, NormalEquations};
use super::tunings::Tuning;
use crate::fit::residual::coloured_noise::Colour;
use crate::trial::device::{Device, Phase};
use crate::trial::hybrid::follow::follow;
use crate::trial::hybrid::{RunError, Stretch};
use crate::trial::instrument::Instruments;
use crate::trial::voltage::Piece;

/// Local error of positions \[m\]; differences of tens of nanometres are taken.
const TOLERANCE: f64 = 1e-11;
/// Samples after an event that are not looked at.
const GUARD: f64 = 4.0;
/// A step of the voltage from which it is a jump \[V\].
const LEAST_JUMP: f64 = 0.5;

/// The stretch as the device without the effect can have it: its own coordinates, the
/// mass on its own ground.
fn plain_stretch(made: &CaseRun<'_>, stretch: &Stretch) -> Stretch {
    let n = made.plain.structure.n;
    let mut plain = *stretch;
    // The run may have more coordinates behind the device's own.
    let more = made.run.coordinates;
    for i in 0..n {
        plain.state[i] = stretch.state[i];
        plain.state[n + i] = stretch.state[more + i];
    }
    plain.state[2 * n..].fill(0.0);
    plain.phase = if stretch.phase.in_contact() {
        let [xp, vp, ..] = made.plain.points(&plain.state);
        made.plain.shift(&mut plain.state, -made.plain.dp - xp);
        made.plain.kick(&mut plain.state, -vp);
        Phase::Held {
            since: stretch.start,
        }
    } else {
        Phase::Flight { direction: 0.0 }
    };
    plain
}

pub(crate) fn add_stretch(
    normal: &mut NormalEquations,
    made: &CaseRun<'_>,
    stretch: &Stretch,
    tunings: &[Tuning],
    zeros: usize,
    weight: f64,
    instruments: &Instruments,
) -> Result<(), RunError> {
    // Late readings still show what was before an event; when the event was, is not known
    // beforehand, so that this tells nothing.
    let begin = stretch.start + GUARD / instruments.rate;
    let first = made.times.partition_point(|t| *t < begin);
    let last = made.times.partition_point(|t| *t < stretch.end);
    if last < first + 6 {
        return Ok(());
    }
    let times = &made.times[first..last];
    let plain = plain_stretch(made, stretch);
    let channels = if instruments.cantilever { 2 } else { 1 };
    let flat = |device: &Device, from: &Stretch| -> Result<DVector<f64>, RunError> {
        let [p, c] = follow(device, made.pieces, from, times, TOLERANCE)?;
        let both = p.into_iter().chain(c).take(channels * times.len());
        Ok(DVector::from_iterator(channels * times.len(), both))
    };
    let rest = flat(made.plain, &plain)?;
    let rows = rest.len();
    let m = times.len();
    let measured = made.run.proof_mass[first..last]
        .iter()
        .chain(&made.run.cantilever[first..last])
        .copied();
    let trace = DVector::from_iterator(rows, measured.take(rows)) - &rest;

    let mut global: Vec<(usize, DVector<f64>)> = Vec::new();
    for (i, (change, step)) in tunings.iter().enumerate() {
        let mut device = made.plain.clone();
        change(&mut device, *step);
        global.push((i, (flat(&device, &plain)? - &rest) / *step));
    }
    let base = tunings.len();
    let held = plain.phase.in_contact();
    let nudged = |change: &dyn Fn(&mut Stretch)| -> Result<DVector<f64>, RunError> {
        let mut from = plain;
        change(&mut from);
        Ok(flat(made.plain, &from)? - &rest)
    };
    if held {
        let step = 1e-7;
        let lower = nudged(&|from| made.plain.shift(&mut from.state, -step))?;
        global.push((base, lower / step));
    }
    let rate = instruments.rate;
    let part = |from: usize, to: usize, f: &dyn Fn(usize) -> f64| {
        DVector::from_fn(rows, |i, _| if i >= from && i < to { f(i) } else { 0.0 })
    };
    // Neighbouring samples are too far apart for the slope of the quick modes.
    let soon = 0.01 / rate;
    let later: Vec<f64> = times.iter().map(|t| t + soon).collect();
    let [p, c] = follow(made.plain, made.pieces, &plain, &later, TOLERANCE)?;
    let both = p.into_iter().chain(c).take(rows);
    let slope = (DVector::from_iterator(rows, both) - &rest) / soon;
    global.push((base + 4, slope));
    global.push((base + 5, part(0, m, &|i| rest[i])));
    global.push((base + 6, part(m, rows, &|i| rest[i])));
    global.push((zeros, part(0, m, &|_| 1.0)));
    global.push((zeros + 1, part(m, rows, &|_| 1.0)));

    let n = made.plain.structure.n;
    let bounds = made.plain.tolerances(1e-7);
    let mut local = Vec::with_capacity(2 * n);
    for i in 0..2 * n {
        let column = nudged(&|from| {
            from.state[i] += bounds[i];
            if held {
                let [xp, vp, ..] = made.plain.points(&from.state);
                let level = -made.plain.dp;
                made.plain.shift(&mut from.state, level - xp);
                made.plain.kick(&mut from.state, -vp);
            }
        })?;
        local.push(column);
    }
    // A sampled voltage says between which samples a jump is, not where.
    for i in jumps_within(made.pieces, stretch.start, stretch.end) {
        let mut moved = made.pieces.to_vec();
        let by = 0.02 / instruments.rate;
        moved[i - 1].end += by;
        moved[i].start += by;
        let [p, c] = follow(made.plain, &moved, &plain, times, TOLERANCE)?;
        let both = p.into_iter().chain(c).take(rows);
        local.push(DVector::from_iterator(rows, both) - &rest);
    }
    let colour = Colour {
        share: instruments.coloured_share,
        keep: (-1.0 / (instruments.rate * instruments.coloured_time)).exp(),
    };
    // Slow noise hides what is slow.
    let whiten = |mut v: DVector<f64>| {
        for channel in v.as_mut_slice().chunks_mut(m) {
            colour.whiten(channel);
        }
        v
    };
    let local: Vec<_> = local.into_iter().map(whiten).collect();
    let global: Vec<_> = global.into_iter().map(|(i, v)| (i, whiten(v))).collect();
    project(
        normal,
        &local,
        &global,
        &whiten(trace),
        weight / instruments.noise.powi(2),
    );
    Ok(())
}

/// Pieces between two times \[s\] that begin with a jump of the voltage.
pub(crate) fn jumps_within(pieces: &[Piece], from: f64, to: f64) -> Vec<usize> {
    let jumps = |i: &usize| {
        let (before, after) = (&pieces[i - 1], &pieces[*i]);
        let at = after.start;
        let size = (after.shape.at(at) - before.shape.at(at)).abs();
        at > from && at < to && size > LEAST_JUMP
    };
    (1..pieces.len()).filter(jumps).collect()
}

/// Takes the stretch's own freedoms out and adds what is left to the normal equations.
fn project(
    normal: &mut NormalEquations,
    local: &[DVector<f64>],
    global: &[(usize, DVector<f64>)],
    trace: &DVector<f64>,
    weight: f64,
) {
    let mut basis: Vec<DVector<f64>> = Vec::with_capacity(local.len());
    let remove = |basis: &[DVector<f64>], v: &mut DVector<f64>| {
        // Twice: once leaves rounding of the size of the nuisance.
        for _ in 0..2 {
            for b in basis {
                let share = b.dot(v);
                v.axpy(-share, b, 1.0);
            }
        }
    };
    for column in local {
        let mut v = column.clone();
        let before = v.norm();
        remove(&basis, &mut v);
        let after = v.norm();
        if after > 1e-5 * before && after > 0.0 {
            basis.push(v / after);
        }
    }
    let mut rest = trace.clone();
    remove(&basis, &mut rest);
    normal.energy += weight * rest.norm_squared();
    let columns: Vec<(usize, DVector<f64>)> = global
        .iter()
        .map(|(i, column)| {
            let mut v = column.clone();
            remove(&basis, &mut v);
            (*i, v)
        })
        .collect();
    for (i, a) in &columns {
        normal.right[*i] += weight * a.dot(&rest);
        for (j, b) in &columns {
            normal.matrix[(*i, *j)] += weight * a.dot(b);
        }
    }
}
