//! The device as windows of flight see it: its slowest mode moves, all faster ones follow at once.
//!
//! For the reading of the proof mass, `x'' + b x' + k x = d F_drive + m F_mass - a_base`, where what the
//! faster modes yield is proportional to the forces and moves the reading without delay (residual
//! flexibility). The windows are so wide that the faster modes' own ringing vanishes in them.

use crate::model::Model;

/// Coefficients of the equation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowMode {
    /// `b` \[1/s\].
    pub damping: f64,
    /// `k` \[1/s^2\]; 0 for a free mass.
    pub stiffness: f64,
    /// `d` \[1/kg\].
    pub drive: f64,
    /// `m` \[1/kg\].
    pub mass: f64,
    /// Whether a spring holds the mass: its reading has a zero then.
    pub is_sprung: bool,
}

impl SlowMode {
    /// That of `model`; `None` without a mode.
    pub fn of(model: &Model) -> Option<Self> {
        let structure = model.structure_with_effects();
        let slower = |a: f64, b: f64| a.total_cmp(&b);
        let modes = structure.modes.iter();
        let mode = modes.min_by(|a, b| slower(a.frequency, b.frequency))?;
        Some(Self {
            damping: mode.damping(),
            stiffness: mode.omega().powi(2),
            drive: mode.phi_p * mode.phi_drive,
            mass: mode.phi_p * mode.phi_p,
            is_sprung: mode.frequency > 0.0,
        })
    }

    /// `model`, whose slowest mode was `from`, with this one in its place.
    pub fn tuned(&self, model: &Model, from: &Self) -> Model {
        use crate::model::parameter::ParameterId as P;
        let mut tuned = model.clone();
        if let (Some(new), Some(old)) = (self.frequency(), from.frequency())
            && new > 0.0
            && old > 0.0
        {
            tuned
                .parameters
                .set(P::F1, model.parameters[P::F1] * new / old);
            tuned.parameters.set(P::Zeta1, 0.5 * self.damping / new);
        }
        if model.piezo.is_some() && from.drive != 0.0 {
            let eta = model.parameters[P::Eta] * self.drive / from.drive;
            tuned.parameters.set(P::Eta, eta);
        }
        tuned
    }

    /// Angular frequency \[1/s\], if it swings.
    pub fn frequency(&self) -> Option<f64> {
        self.is_sprung.then(|| self.stiffness.max(0.0).sqrt())
    }
}
