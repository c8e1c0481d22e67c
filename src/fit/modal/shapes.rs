//! Mode shapes from residues, and the device with the modes found.
//!
//! The drive enters through the cantilever, `F = [eta u, 0]`, so that the static displacements of mode
//! `r` per unit of input are `A_c = phi_c^2 eta / w^2` and `A_p = phi_p phi_c eta / w^2`. The shapes
//! are known up to one factor, which `eta` or a known mass or stiffness tells: a drive twice as strong
//! on a device twice as heavy moves the same.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::time_domain::least_squares::{Covariance, Solution};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::structure::Mode;

/// Frequencies within this factor are those of the same mode of device and sweep.
const SAME_MODE_FACTOR: f64 = 1.5;
/// Relative difference of `phi_drive / phi_c` between modes from which the drive is not a force on the
/// cantilever's point.
const FORCE_ON_POINT_TOLERANCE: f64 = 1e-3;

/// A value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard error.
    pub std_error: f64,
}

/// What fixes the scale of the mode shapes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Normalisation {
    /// `eta` of the device.
    Eta,
    /// Modal mass of the first mode at the proof mass \[kg\], `1 / phi_p1^2`.
    FirstModalMass(f64),
    /// Static stiffness against a force on the proof mass \[N/m\].
    Stiffness(f64),
}

/// Shapes of one mode [kg^-1/2].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// At the cantilever's centre; `None` if it was not recorded.
    pub phi_c: Option<Estimate>,
    /// At the proof mass.
    pub phi_p: Estimate,
    /// Coupling to the drive.
    pub phi_drive: f64,
}

/// Residues of one mode with their joint errors.
pub(super) struct Residues {
    /// Static displacement per input at the proof mass and the cantilever, with relative errors.
    pub(super) static_gain: [Option<Estimate>; 2],
    /// Covariance of `ln A_p`, `ln A_c`, `ln w`.
    log_covariance: [[f64; 3]; 3],
    omega: f64,
}

impl Residues {
    pub(super) fn of(
        solution: &Solution,
        covariance: &Covariance,
        r: usize,
        inflation: f64,
    ) -> Self {
        let matrix: &DMatrix<f64> = &covariance.matrix;
        let index = [0, 1].map(|c: usize| covariance.shared_at[c].map(|at| at + r));
        let value = [0, 1].map(|c: usize| solution.linear.shared[c].as_ref().map(|s| s[r]));
        let places = [index[0], index[1], Some(2 * r)];
        let scale = [value[0].unwrap_or(1.0), value[1].unwrap_or(1.0), 1.0];
        let mut log_covariance = [[0.0; 3]; 3];
        for (i, row) in log_covariance.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                if let (Some(a), Some(b)) = (places[i], places[j]) {
                    *entry = inflation * matrix[(a, b)] / (scale[i] * scale[j]);
                }
            }
        }
        let static_gain = [0, 1].map(|c: usize| {
            let (value, at) = (value[c]?, index[c]?);
            Some(Estimate {
                value,
                std_error: (inflation * matrix[(at, at)]).max(0.0).sqrt(),
            })
        });
        Self {
            static_gain,
            log_covariance,
            omega: solution.poles[r].omega,
        }
    }

    /// Relative standard error of `A_p^a A_c^b w^c`.
    fn relative_error(&self, powers: [f64; 3]) -> f64 {
        let mut variance = 0.0;
        for (row, a) in self.log_covariance.iter().zip(powers) {
            for (entry, b) in row.iter().zip(powers) {
                variance += a * b * entry;
            }
        }
        variance.max(0.0).sqrt()
    }

    /// `phi_p / phi_c`, if both were recorded.
    pub(super) fn ratio(&self) -> Option<Estimate> {
        let (p, c) = (self.static_gain[0]?, self.static_gain[1]?);
        let value = p.value / c.value;
        Some(Estimate {
            value,
            std_error: value.abs() * self.relative_error([1.0, -1.0, 0.0]),
        })
    }

    /// Shapes for a drive of `eta`; `known` is the mode of the device at hand that it is.
    pub(super) fn shape(&self, eta: f64, known: Option<&Mode>) -> Option<Shape> {
        let w2 = self.omega * self.omega;
        let [p, c] = self.static_gain;
        let estimate = |value: f64, powers| Estimate {
            value,
            std_error: f64::abs(value) * self.relative_error(powers),
        };
        match (p, c, known) {
            // The drive's coupling is known, as that of a bending layer is from its geometry.
            (Some(p), Some(c), Some(known)) => {
                let per = w2 / (eta * known.phi_drive);
                Some(Shape {
                    phi_c: Some(estimate(c.value * per, [0.0, 1.0, 2.0])),
                    phi_p: estimate(p.value * per, [1.0, 0.0, 2.0]),
                    phi_drive: known.phi_drive,
                })
            }
            (Some(p), Some(c), None) => {
                let phi_c = (c.value.abs() * w2 / eta).sqrt();
                let phi_drive = phi_c * c.value.signum();
                Some(Shape {
                    phi_c: Some(estimate(phi_c, [0.0, 0.5, 1.0])),
                    phi_p: estimate(p.value * w2 / (eta * phi_drive), [1.0, -0.5, 1.0]),
                    phi_drive,
                })
            }
            (Some(p), None, Some(known)) => Some(Shape {
                phi_c: None,
                phi_p: estimate(known.phi_p, [0.0; 3]),
                phi_drive: p.value * w2 / (eta * known.phi_p),
            }),
            (Some(p), None, None) => {
                let phi_p = (p.value.abs() * w2 / eta).sqrt();
                Some(Shape {
                    phi_c: None,
                    phi_p: estimate(phi_p, [0.5, 0.0, 1.0]),
                    phi_drive: phi_p * p.value.signum(),
                })
            }
            (None, ..) => None,
        }
    }
}

/// `eta` from a known mass or stiffness; `None` if the readings do not tell it.
pub(super) fn eta_of(
    normalisation: Normalisation,
    all: &[&Residues],
    of_device: f64,
) -> Option<f64> {
    let pair = |r: &&Residues| Some((r.static_gain[0]?.value, r.static_gain[1]?.value));
    match normalisation {
        Normalisation::Eta => Some(of_device),
        Normalisation::FirstModalMass(mass) => {
            let first = all.first()?;
            let (p, c) = pair(first)?;
            Some(mass * p * p * first.omega * first.omega / c.abs())
        }
        Normalisation::Stiffness(stiffness) => {
            let compliance: Option<f64> = all
                .iter()
                .map(|r| pair(r).map(|(p, c)| p * p / c.abs()))
                .sum();
            Some(stiffness * compliance?)
        }
    }
}

/// The device's mode nearest to a frequency \[Hz\], if it is near.
pub(super) fn same_mode(model: &Model, frequency: f64) -> Option<(usize, Mode)> {
    let modes = model.structure().modes;
    let distance = |m: &Mode| (m.frequency / frequency).ln().abs();
    let all = modes
        .into_iter()
        .enumerate()
        .filter(|(_, m)| m.frequency > 0.0);
    all.min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)))
        .filter(|(_, m)| distance(m) < SAME_MODE_FACTOR.ln())
}

/// Whether the drive of the device is a force on the cantilever's point: `phi_drive` and `phi_c` have the
/// same ratio in every mode.
pub(super) fn drives_the_point(model: &Model) -> bool {
    let modes = model.structure().modes;
    let ratios: Vec<f64> = modes.iter().map(|m| m.phi_drive / m.phi_c).collect();
    let first = ratios.first().copied().unwrap_or(1.0);
    !first.is_finite()
        || ratios
            .iter()
            .all(|r| !r.is_finite() || (r / first - 1.0).abs() < FORCE_ON_POINT_TOLERANCE)
}

/// Sets modes, with frequency and damping of the first two as parameters; factors on shapes go back
/// to 1.
pub(super) fn set_modes(model: &mut Model, modes: Vec<Mode>) {
    use ParameterId as P;
    for (mode, (f, zeta)) in modes.iter().zip([(P::F1, P::Zeta1), (P::F2, P::Zeta2)]) {
        model.parameters.set(f, mode.frequency);
        model.parameters.set(zeta, mode.zeta);
    }
    for id in [P::ShapeC1, P::ShapeC2, P::ShapeP2] {
        model.parameters.set(id, 1.0);
    }
    model.parameters.set(P::DriveP, 0.0);
    if modes.len() < 2 {
        for id in [P::F2, P::Zeta2] {
            model.parameters.set(id, id.spec().default);
        }
    }
    model.modes = modes;
}
