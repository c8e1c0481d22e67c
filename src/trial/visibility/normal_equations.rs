//! One recording with its plain device, and the weighted least squares over all recordings.

use nalgebra::{DMatrix, DVector};

use crate::trial::device::Device;
use crate::trial::hybrid::Run;
use crate::trial::voltage::Piece;

/// One recording as it was made.
pub struct CaseRun<'a> {
    /// Motion with the effect, its readings as the instruments get them.
    pub run: &'a Run,
    /// The device without the effect.
    pub plain: &'a Device,
    /// Drive of the device without the effect.
    pub pieces: &'a [Piece],
    /// Times of the samples in the motion's own clock \[s\].
    pub times: &'a [f64],
}

/// NormalEquations equations with the parameters of all recordings.
pub(crate) struct NormalEquations {
    pub(super) matrix: DMatrix<f64>,
    pub(super) right: DVector<f64>,
    pub(super) energy: f64,
}

impl NormalEquations {
    pub(super) fn add(&mut self, columns: &[(usize, f64)], value: f64, weight: f64) {
        self.energy += weight * value * value;
        for (i, a) in columns {
            self.right[*i] += weight * a * value;
            for (j, b) in columns {
                self.matrix[(*i, *j)] += weight * a * b;
            }
        }
    }
}
