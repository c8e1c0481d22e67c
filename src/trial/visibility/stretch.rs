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
const GUARD_SAMPLES: f64 = 4.0;
/// A step of the voltage from which it is a jump \[V\].
const MIN_JUMP: f64 = 0.5;

/// The stretch as the device without the effect can have it: its own coordinates, the
/// mass on its own ground.
fn plain_stretch(case: &CaseRun<'_>, stretch: &Stretch) -> Stretch {
    let n = case.plain.structure.n;
    let mut plain = *stretch;
    // The run may have more coordinates behind the device's own.
    let more = case.run.coordinates;
    for i in 0..n {
        plain.state[i] = stretch.state[i];
        plain.state[n + i] = stretch.state[more + i];
    }
    plain.state[2 * n..].fill(0.0);
    plain.phase = if stretch.phase.in_contact() {
        let [xp, vp, ..] = case.plain.points(&plain.state);
        case.plain.shift(&mut plain.state, -case.plain.dp - xp);
        case.plain.kick(&mut plain.state, -vp);
        Phase::Held {
            since: stretch.start,
        }
    } else {
        Phase::Flight { direction: 0.0 }
    };
    plain
}

/// Adds one stretch to the normal equations: the effect's trace, the columns of the shared
/// parameters, with the freedoms of the stretch itself projected out.
///
/// # Errors
/// [`RunError`] if the device without the effect cannot be followed.
pub(crate) fn add_stretch(
    normal: &mut NormalEquations,
    case: &CaseRun<'_>,
    stretch: &Stretch,
    tunings: &[Tuning],
    zeros: usize,
    weight: f64,
    instruments: &Instruments,
) -> Result<(), RunError> {
    // Late readings still show what was before an event; when the event was, is not known
    // beforehand, so that this tells nothing.
    let begin = stretch.start + GUARD_SAMPLES / instruments.rate;
    let first = case.times.partition_point(|t| *t < begin);
    let last = case.times.partition_point(|t| *t < stretch.end);
    if last < first + 6 {
        return Ok(());
    }
    let mut followed = Followed {
        case,
        start: plain_stretch(case, stretch),
        times: &case.times[first..last],
        rows: (if instruments.cantilever { 2 } else { 1 }) * (last - first),
        reference: DVector::zeros(0),
    };
    followed.reference =
        followed.readings(case.plain, case.pieces, &followed.start, followed.times)?;
    let rows = followed.rows;
    let measured = case.run.proof_mass[first..last]
        .iter()
        .chain(&case.run.cantilever[first..last])
        .copied();
    let trace = DVector::from_iterator(rows, measured.take(rows)) - &followed.reference;

    let global = followed.shared_columns(tunings, zeros, instruments)?;
    let mut local = followed.state_columns()?;
    local.extend(followed.jump_columns(stretch, instruments.rate)?);
    let memory = instruments.rate * instruments.coloured_time;
    let colour = Colour::with_memory(instruments.coloured_share, (-1.0 / memory).exp());
    // Slow noise hides what is slow.
    let samples = followed.times.len();
    let whiten = |mut v: DVector<f64>| {
        for channel in v.as_mut_slice().chunks_mut(samples) {
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

/// The stretch as the device without the effect goes through it, and its finite differences.
struct Followed<'a> {
    case: &'a CaseRun<'a>,
    start: Stretch,
    times: &'a [f64],
    /// Readings in all: the proof mass's, then the cantilever's if it is read.
    rows: usize,
    /// The readings without any change.
    reference: DVector<f64>,
}

impl Followed<'_> {
    /// The readings of both points in one column \[m\].
    fn readings(
        &self,
        device: &Device,
        pieces: &[Piece],
        from: &Stretch,
        times: &[f64],
    ) -> Result<DVector<f64>, RunError> {
        let [p, c] = follow(device, pieces, from, times, TOLERANCE)?;
        let both = p.into_iter().chain(c).take(self.rows);
        Ok(DVector::from_iterator(self.rows, both))
    }

    /// By how much the readings change if the start is changed.
    fn nudged(&self, change: &dyn Fn(&mut Stretch)) -> Result<DVector<f64>, RunError> {
        let mut from = self.start;
        change(&mut from);
        Ok(self.readings(self.case.plain, self.case.pieces, &from, self.times)? - &self.reference)
    }

    /// Columns of the parameters that all stretches share, with their numbers: the tunings, the
    /// ground's level, the clocks' skew, the scales and the zeros.
    fn shared_columns(
        &self,
        tunings: &[Tuning],
        zeros: usize,
        instruments: &Instruments,
    ) -> Result<Vec<(usize, DVector<f64>)>, RunError> {
        let (plain, pieces, reference) = (self.case.plain, self.case.pieces, &self.reference);
        let mut global: Vec<(usize, DVector<f64>)> = Vec::new();
        for (i, (change, step)) in tunings.iter().enumerate() {
            let mut device = plain.clone();
            change(&mut device, *step);
            let changed = self.readings(&device, pieces, &self.start, self.times)?;
            global.push((i, (changed - reference) / *step));
        }
        let base = tunings.len();
        if self.start.phase.in_contact() {
            let step = 1e-7;
            let lower = self.nudged(&|from| plain.shift(&mut from.state, -step))?;
            global.push((base, lower / step));
        }
        let (m, rows) = (self.times.len(), self.rows);
        let part = |from: usize, to: usize, f: &dyn Fn(usize) -> f64| {
            DVector::from_fn(rows, |i, _| if i >= from && i < to { f(i) } else { 0.0 })
        };
        // Neighbouring samples are too far apart for the velocity of the quick modes.
        let soon = 0.01 / instruments.rate;
        let later: Vec<f64> = self.times.iter().map(|t| t + soon).collect();
        let moved = self.readings(plain, pieces, &self.start, &later)?;
        global.push((base + 4, (moved - reference) / soon));
        global.push((base + 5, part(0, m, &|i| reference[i])));
        global.push((base + 6, part(m, rows, &|i| reference[i])));
        global.push((zeros, part(0, m, &|_| 1.0)));
        global.push((zeros + 1, part(m, rows, &|_| 1.0)));
        if instruments.imperfections.scale_spread > 0.0 {
            global.push((zeros + 2, part(0, m, &|i| reference[i])));
            global.push((zeros + 3, part(m, rows, &|i| reference[i])));
        }
        Ok(global)
    }

    /// Columns of the state at the start; a held mass stays on its ground.
    fn state_columns(&self) -> Result<Vec<DVector<f64>>, RunError> {
        let plain = self.case.plain;
        let n = plain.structure.n;
        let held = self.start.phase.in_contact();
        let bounds = plain.tolerances(1e-7);
        let mut local = Vec::with_capacity(2 * n);
        for i in 0..2 * n {
            let column = self.nudged(&|from| {
                from.state[i] += bounds[i];
                if held {
                    let [xp, vp, ..] = plain.points(&from.state);
                    let level = -plain.dp;
                    plain.shift(&mut from.state, level - xp);
                    plain.kick(&mut from.state, -vp);
                }
            })?;
            local.push(column);
        }
        Ok(local)
    }

    /// Columns of the instants of the voltage's jumps: a sampled voltage says between which
    /// samples a jump is, not where.
    fn jump_columns(&self, stretch: &Stretch, rate: f64) -> Result<Vec<DVector<f64>>, RunError> {
        let pieces = self.case.pieces;
        let mut local = Vec::new();
        for i in jumps_within(pieces, stretch.start, stretch.end) {
            let mut moved = pieces.to_vec();
            let by = 0.02 / rate;
            moved[i - 1].end += by;
            moved[i].start += by;
            let changed = self.readings(self.case.plain, &moved, &self.start, self.times)?;
            local.push(changed - &self.reference);
        }
        Ok(local)
    }
}

/// Pieces between two times \[s\] that begin with a jump of the voltage.
pub(crate) fn jumps_within(pieces: &[Piece], from: f64, to: f64) -> Vec<usize> {
    let jumps = |i: &usize| {
        let (before, after) = (&pieces[i - 1], &pieces[*i]);
        let at = after.start;
        let size = (after.shape.at(at) - before.shape.at(at)).abs();
        at > from && at < to && size > MIN_JUMP
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
    let mut residual = trace.clone();
    remove(&basis, &mut residual);
    normal.energy += weight * residual.norm_squared();
    let columns: Vec<(usize, DVector<f64>)> = global
        .iter()
        .map(|(i, column)| {
            let mut v = column.clone();
            remove(&basis, &mut v);
            (*i, v)
        })
        .collect();
    for (i, a) in &columns {
        normal.right[*i] += weight * a.dot(&residual);
        for (j, b) in &columns {
            normal.matrix[(*i, *j)] += weight * a.dot(b);
        }
    }
}
