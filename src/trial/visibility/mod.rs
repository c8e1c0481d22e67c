//! How visible a concealed effect is: a Cramer-Rao bound on its own recordings.
//!
//! Each stretch between events is followed once more by the device without the effect,
//! from the true state at its start. What differs, in units of the noise, is the
//! effect's trace; what the baseline's parameters, the rig and the state at the start
//! of every stretch could absorb is projected out with the generator's own
//! sensitivities. Restitution, contact level and pull-off force at the events are rows
//! of their own. The readings' noise has the colour that it is made with; events are
//! judged by its total rms. An effect is called smallest visible where what is left has
//! five standard deviations in all.

pub(crate) mod events;
pub(crate) mod stretch;

use nalgebra::{DMatrix, DVector};

use self::events::add_events;
use self::stretch::add_stretch;
use super::device::Device;
use super::device::structure::{Structure, dot};
use super::hybrid::{Run, RunError, Stretch};
use super::instrument::Instruments;
use super::voltage::Piece;

/// Standard deviations at which an effect counts as just visible.
pub const JUST_VISIBLE: f64 = 5.0;
/// Time \[s\] that is followed; longer recordings are judged by a part of their stretches.
const FOLLOWED: f64 = 0.2;
/// Coordinates up to which they are no modes, but coupled.
const COUPLED: usize = 2;

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
pub(crate) struct Normal {
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
    let couples = n <= COUPLED;
    for i in 0..n {
        for j in 0..n {
            // Every entry of stiffness and damping; modes have none between them.
            if i != j && !couples {
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
    // Of modes, further ones as well, neither shapes nor coupling to the drive are known.
    for i in (0..n).filter(|_| !couples) {
        for which in [Shape::ProofMass, Shape::Cantilever, Shape::Drive] {
            list.push((
                Box::new(move |d, s| reshape(&mut d.structure, i, which, 1.0 + s)),
                1e-2,
            ));
        }
    }
    list
}

/// A number of a mode's shape.
#[derive(Clone, Copy)]
enum Shape {
    ProofMass,
    Cantilever,
    Drive,
}

fn reshape(structure: &mut Structure, i: usize, which: Shape, factor: f64) {
    let s = structure;
    match which {
        Shape::ProofMass => {
            s.read_p[i] *= factor;
            s.push_p[i] *= factor;
            s.mobility = dot(s.n, &s.read_p, &s.push_p);
        }
        Shape::Cantilever => {
            s.read_c[i] *= factor;
            s.push_c[i] *= factor;
        }
        Shape::Drive => s.push_drive[i] *= factor,
    }
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
