//! How visible a concealed effect is: a Cramer-Rao bound on its own recordings.
//!
//! Each stretch between events is followed once more by the device without the effect,
//! from the true state at its start. What differs, in units of the noise, is the
//! effect's trace; what the baseline's parameters, the rig and the state at the start
//! of every stretch could absorb is projected out with the generator's own
//! sensitivities. Restitution, contact level and pull-off force at the events are rows
//! of their own. Noise is taken as white at its total rms. An effect is called
//! smallest visible where what is left has five standard deviations in all.

use super::device::{Device, Phase};
use super::hybrid::{Kind, Run, RunError, Stretch, follow};
use super::rig::Instruments;
use super::structure::Structure;
use super::voltage::Piece;
use nalgebra::{DMatrix, DVector};

/// Standard deviations at which an effect counts as just visible.
pub const JUST_VISIBLE: f64 = 5.0;
/// Time \[s\] that is followed; longer recordings are judged by a part of their stretches.
const FOLLOWED: f64 = 0.2;
/// Local error of positions \[m\]; differences of tens of nanometres are taken.
const TOLERANCE: f64 = 1e-11;
/// Samples after an event that are not looked at.
const GUARD: f64 = 4.0;
/// A step of the voltage from which it is a jump \[V\].
const LEAST_JUMP: f64 = 0.5;
/// Modes whose frequency and damping may be re-tuned.
const TUNED_MODES: usize = 3;

/// One recording as it was made.
pub struct Made<'a> {
    /// Motion with the effect, its readings as the instruments get them.
    pub run: &'a Run,
    /// The device without the effect.
    pub plain: &'a Device,
    /// Drive of the device without the effect.
    pub pieces: &'a [Piece],
    /// Times of the samples in the motion's own clock \[s\].
    pub times: &'a [f64],
}

/// Normal equations with the parameters of all recordings.
struct Normal {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    energy: f64,
}

impl Normal {
    fn add(&mut self, columns: &[(usize, f64)], value: f64, weight: f64) {
        self.energy += weight * value * value;
        for (i, a) in columns {
            self.right[*i] += weight * a * value;
            for (j, b) in columns {
                self.matrix[(*i, *j)] += weight * a * b;
            }
        }
    }
}

/// How a parameter is changed.
type Change = Box<dyn Fn(&mut Device, f64)>;
/// A change and the step for its difference.
type Tuning = (Change, f64);

/// A parameter of the baseline: how to change it, and by how much for a difference.
fn tunings(n: usize) -> Vec<Tuning> {
    type Plain = fn(&mut Device, f64);
    let plain: [(Plain, f64); 4] = [
        (|d, s| d.eta *= 1.0 + s, 2e-3),
        (|d, s| d.cs *= 1.0 + s, 5e-2),
        (|d, s| d.gp += s, 2e-7),
        (
            |d, s| {
                for i in 0..d.structure.n {
                    d.structure.push_drive[i] += s * d.structure.push_p[i];
                }
            },
            1e-3,
        ),
    ];
    let mut list: Vec<Tuning> = plain
        .into_iter()
        .map(|(f, s)| (Box::new(f) as Change, s))
        .collect();
    for i in 0..n.min(TUNED_MODES) {
        for j in 0..n.min(TUNED_MODES) {
            // Every entry of stiffness and damping that the leading coordinates have.
            if i != j && n > 2 {
                continue;
            }
            list.push((
                Box::new(move |d, s| retune(&mut d.structure, i, j, s, false)),
                2e-3,
            ));
            list.push((
                Box::new(move |d, s| retune(&mut d.structure, i, j, s, true)),
                5e-2,
            ));
        }
    }
    list
}

fn retune(structure: &mut Structure, i: usize, j: usize, s: f64, damping: bool) {
    let matrix = if damping {
        &mut structure.damping
    } else {
        &mut structure.stiffness
    };
    matrix[i][j] *= 1.0 + s;
}

/// Standard deviations by which the effect stands out of what re-tuning can absorb.
///
/// # Errors
/// [`RunError`] if the device without the effect cannot be followed.
pub fn deviations(made: &[Made<'_>], instruments: &Instruments) -> Result<f64, RunError> {
    let Some(n) = made.first().map(|m| m.plain.structure.n) else {
        return Ok(0.0);
    };
    let tunings = tunings(n);
    // After the tunings: dp, alpha, Ca, Ca0, skew, two scales, zeros.
    let base = tunings.len();
    let size = base + 7 + 2 * made.len();
    let mut normal = Normal {
        matrix: DMatrix::zeros(size, size),
        right: DVector::zeros(size),
        energy: 0.0,
    };
    // What is known of the rig beforehand, in the columns' units.
    for (column, sigma) in [(base + 4, 5e-6), (base + 5, 0.01), (base + 6, 0.01)] {
        normal.matrix[(column, column)] += 1.0 / (sigma * sigma);
    }
    let all: f64 = made.iter().flat_map(|m| &m.run.stretches).map(length).sum();
    let every = (all / FOLLOWED).ceil().max(1.0) as usize;
    for (number, recording) in made.iter().enumerate() {
        let zeros = base + 7 + 2 * number;
        for stretch in recording
            .run
            .stretches
            .iter()
            .skip(number % every)
            .step_by(every)
        {
            add_stretch(
                &mut normal,
                recording,
                stretch,
                &tunings,
                zeros,
                every as f64,
                instruments,
            )?;
        }
        add_events(&mut normal, recording, base, zeros, instruments);
    }
    // Columns of unit length, so that one small ridge serves all.
    let scale: Vec<f64> = (0..size)
        .map(|i| 1.0 / normal.matrix[(i, i)].max(1e-300).sqrt())
        .collect();
    let matrix = DMatrix::from_fn(size, size, |i, j| {
        normal.matrix[(i, j)] * scale[i] * scale[j] + if i == j { 1e-9 } else { 0.0 }
    });
    let right = DVector::from_fn(size, |i, _| normal.right[i] * scale[i]);
    let explained = matrix
        .cholesky()
        .map_or(0.0, |factor| right.dot(&factor.solve(&right)));
    Ok((normal.energy - explained).max(0.0).sqrt())
}

fn length(stretch: &Stretch) -> f64 {
    stretch.end - stretch.start
}

/// The stretch as the device without the effect can have it: its own coordinates, the
/// mass on its own ground.
fn plain_stretch(made: &Made<'_>, stretch: &Stretch) -> Stretch {
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

fn add_stretch(
    normal: &mut Normal,
    made: &Made<'_>,
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
    for i in jumps(made.pieces, stretch) {
        let mut moved = made.pieces.to_vec();
        let by = 0.02 / instruments.rate;
        moved[i - 1].end += by;
        moved[i].start += by;
        let [p, c] = follow(made.plain, &moved, &plain, times, TOLERANCE)?;
        let both = p.into_iter().chain(c).take(rows);
        local.push(DVector::from_iterator(rows, both) - &rest);
    }
    project(
        normal,
        &local,
        &global,
        &trace,
        weight / instruments.noise.powi(2),
    );
    Ok(())
}

/// Pieces within the stretch that begin with a jump of the voltage.
fn jumps(pieces: &[Piece], stretch: &Stretch) -> Vec<usize> {
    let jumps = |i: &usize| {
        let (before, after) = (&pieces[i - 1], &pieces[*i]);
        let at = after.start;
        let size = (after.shape.at(at) - before.shape.at(at)).abs();
        at > stretch.start && at < stretch.end && size > LEAST_JUMP
    };
    (1..pieces.len()).filter(jumps).collect()
}

/// Takes the stretch's own freedoms out and adds what is left to the normal equations.
fn project(
    normal: &mut Normal,
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

/// Rows of the events: restitution, level of the ground, pull-off force.
fn add_events(
    normal: &mut Normal,
    made: &Made<'_>,
    base: usize,
    zeros: usize,
    instruments: &Instruments,
) {
    let sigma = instruments.noise;
    let events = &made.run.events;
    for (i, event) in events.iter().enumerate() {
        let before = i.checked_sub(1).map_or(0.0, |j| events[j].time);
        let after = events.get(i + 1).map_or(f64::INFINITY, |e| e.time);
        let flight = (event.time - before).min(after - event.time).min(4e-4);
        let samples = flight * instruments.rate;
        if samples < 4.0 {
            continue;
        }
        let level_sigma = 2.0 * sigma / samples.sqrt();
        normal.add(
            &[(base, -1.0), (zeros, 1.0)],
            event.level + made.plain.dp,
            1.0 / level_sigma.powi(2),
        );
        match event.kind {
            Kind::Impact if event.before < -5e-3 => {
                // Slope at the end of a parabola through the samples.
                let slope = 4.0 * sigma * instruments.rate * (12.0 / samples.powi(3)).sqrt();
                let expected = -made.plain.alpha * event.before;
                let variance = slope * slope * (1.0 + made.plain.alpha.powi(2));
                let row = [(base + 1, -event.before)];
                normal.add(&row, event.after - expected, 1.0 / variance);
            }
            // Where a step of the drive tore it off, the pull says nothing of adhesion.
            Kind::Release if !event.torn => {
                // The held cantilever's stiffness against the mass is about 0.07 N/m.
                let force = (0.07 * sigma / samples.sqrt()).max(3e-10);
                let line = made.plain.ca * event.contact + made.plain.ca0;
                let row = [(base + 2, event.contact), (base + 3, 1.0)];
                normal.add(&row, event.pull - line, 1.0 / (force * force));
            }
            _ => {}
        }
    }
}
