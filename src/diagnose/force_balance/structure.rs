//! The linear structure as accelerations: what the equations of the force balance multiply the
//! readings with.
//!
//! For the readings `x_i` of proof mass and cantilever, `x_i'' + sum_j (B_ij x_j' + K_ij x_j) =
//! D_i F_drive + M_i F_mass - a_base`. With as many readings as modes this is exact, whatever the
//! modes' shapes.

use nalgebra::DMatrix;

use crate::model::Model;
use crate::sim::{SimError, StretchSimulator};

/// Coefficients of the equations, one for each reading, the proof mass's first.
#[derive(Debug, Clone, PartialEq)]
pub struct AccelerationModel {
    /// `B` \[1/s\], readings x readings.
    pub damping: DMatrix<f64>,
    /// `K` \[1/s^2\], readings x readings.
    pub stiffness: DMatrix<f64>,
    /// `D` \[1/kg\].
    pub drive: Vec<f64>,
    /// `M` \[1/kg\].
    pub mass: Vec<f64>,
}

impl AccelerationModel {
    /// That of `model` for `readings` readings; `None` if it has another number of modes, so that
    /// the readings do not say where each mode is.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn of(model: &Model, readings: usize) -> Result<Option<Self>, SimError> {
        let structure = model.structure_with_effects();
        let modes = &structure.modes;
        if modes.len() != readings || readings == 0 {
            return Ok(None);
        }
        let shape = |i: usize, k: usize| {
            if i == 0 {
                modes[k].phi_p
            } else {
                modes[k].phi_c
            }
        };
        let phi = DMatrix::from_fn(readings, readings, shape);
        let Some(inverse) = phi.clone().try_inverse() else {
            return Ok(None);
        };
        let rates = |f: &dyn Fn(usize) -> f64| {
            let d = DMatrix::from_fn(readings, readings, |i, j| if i == j { f(i) } else { 0.0 });
            &phi * d * &inverse
        };
        let simulator = StretchSimulator::new(model, &crate::sim::Options::default())?;
        let (mass, drive) = (simulator.mass_response(), simulator.drive_response());
        Ok(Some(Self {
            damping: rates(&|k| modes[k].damping()),
            stiffness: rates(&|k| modes[k].omega().powi(2)),
            drive: [drive.0, drive.1][..readings].to_vec(),
            mass: [mass.0, mass.1][..readings].to_vec(),
        }))
    }

    /// Number of readings.
    pub fn readings(&self) -> usize {
        self.drive.len()
    }

    /// Whether a spring holds the mass: its readings have a zero then.
    pub fn is_sprung(&self) -> bool {
        self.stiffness.iter().any(|k| *k != 0.0)
    }

    /// Angular frequency of the fastest mode that swings \[1/s\], if one does.
    pub fn fastest(&self) -> Option<f64> {
        let values = self.stiffness.complex_eigenvalues();
        let most = values.iter().fold(0.0f64, |most, w2| most.max(w2.norm()));
        (most > 0.0).then(|| most.sqrt())
    }
}
