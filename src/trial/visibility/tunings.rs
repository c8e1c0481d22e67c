//! The baseline's parameters, and by how much each is changed for a finite difference.

use crate::trial::device::Device;
use crate::trial::device::structure::{Structure, dot};

/// With at most this many, the coordinates are coupled masses; with more, they are modes.
const MAX_COUPLED_COORDINATES: usize = 2;

/// How a parameter is changed.
pub(super) type Change = Box<dyn Fn(&mut Device, f64)>;

/// A change and the step for its difference.
pub(super) type Tuning = (Change, f64);

/// A parameter of the baseline: how to change it, and by how much for a difference.
pub(super) fn tunings(n: usize) -> Vec<Tuning> {
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
    let couples = n <= MAX_COUPLED_COORDINATES;
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
