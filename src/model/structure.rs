//! The structure as vibration modes: `q_i'' + 2 zeta_i w_i q_i' + w_i^2 q_i = phi_i . F`.
//!
//! The number of modes is data. Readings follow from `x = Phi q`; a mode of 0 Hz is
//! a free mass. While the proof mass is held on the ground the structure has one
//! freedom less; [`Held`] is that structure, again as independent oscillators.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// One vibration mode with mass-normalised shape.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Undamped natural frequency \[Hz\]; 0 is a free mass.
    pub frequency: f64,
    /// Share of critical damping.
    pub zeta: f64,
    /// Shape at the cantilever's centre [kg^-1/2].
    pub phi_c: f64,
    /// Shape at the proof mass's centre [kg^-1/2].
    pub phi_p: f64,
    /// Coupling to the piezo drive [kg^-1/2]; `phi_c` for a force on the cantilever.
    pub phi_drive: f64,
}

impl Mode {
    /// Angular frequency [rad/s].
    pub fn omega(&self) -> f64 {
        TAU * self.frequency
    }

    /// Damping per unit mass, `2 zeta w` [1/s].
    pub fn damping(&self) -> f64 {
        2.0 * self.zeta * self.omega()
    }
}

/// The vibrating structure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Structure {
    /// Modes, at least one.
    pub modes: Vec<Mode>,
    /// Rigid mass at the tip \[kg\], on which weight acts.
    pub proof_mass: f64,
}

impl Structure {
    /// `phi_p . phi_p` [1/kg]: the velocity step of the proof mass per unit impulse on it.
    pub fn mobility(&self) -> f64 {
        self.modes.iter().map(|m| m.phi_p * m.phi_p).sum()
    }

    /// How each mode takes part in a rigid motion of the base: `Gamma` with `Phi Gamma = 1`
    /// at both points [kg^1/2]. A base acceleration `a` acts on mode `i` like the force
    /// `-Gamma_i a`. With more modes than points it is the shortest such vector; where the
    /// points are not independent it is that of the proof mass alone.
    pub fn participation(&self) -> Vec<f64> {
        let sum = |f: &dyn Fn(&Mode) -> f64| -> f64 { self.modes.iter().map(f).sum() };
        let cc = sum(&|m| m.phi_c * m.phi_c);
        let cp = sum(&|m| m.phi_c * m.phi_p);
        let pp = self.mobility();
        let determinant = cc * pp - cp * cp;
        let (c, p) = if determinant > 1e-9 * cc * pp {
            ((pp - cp) / determinant, (cc - cp) / determinant)
        } else {
            (0.0, 1.0 / pp)
        };
        self.modes
            .iter()
            .map(|m| c * m.phi_c + p * m.phi_p)
            .collect()
    }

    /// Static displacement of the proof mass per force on the cantilever [m/N], or
    /// `None` with a free mode.
    pub fn static_gain(&self) -> Option<f64> {
        self.modes
            .iter()
            .map(|m| (m.frequency > 0.0).then(|| m.phi_drive * m.phi_p / (m.omega() * m.omega())))
            .sum()
    }

    /// Physical matrices `(M, B, K)` for the two points `[xc, xp]`, defined for two modes.
    ///
    /// `M = Phi^-T Phi^-1`, `K = Phi^-T diag(w^2) Phi^-1`, `B = Phi^-T diag(2 zeta w) Phi^-1`.
    pub fn matrices(
        &self,
    ) -> Option<(
        nalgebra::Matrix2<f64>,
        nalgebra::Matrix2<f64>,
        nalgebra::Matrix2<f64>,
    )> {
        let [a, b] = self.modes.as_slice() else {
            return None;
        };
        let phi = nalgebra::Matrix2::new(a.phi_c, b.phi_c, a.phi_p, b.phi_p);
        let inverse = phi.try_inverse()?;
        let congruence = |d: [f64; 2]| {
            inverse.transpose() * nalgebra::Matrix2::new(d[0], 0.0, 0.0, d[1]) * inverse
        };
        Some((
            congruence([1.0, 1.0]),
            congruence([a.damping(), b.damping()]),
            congruence([a.omega().powi(2), b.omega().powi(2)]),
        ))
    }

    /// The structure with the proof mass held.
    pub fn held(&self) -> Held {
        Held::new(self)
    }
}

/// The structure with the proof mass held at a level: `q = level * anchor + basis r`.
///
/// `r` are independent oscillators but for the damping that couples them, which is
/// kept in `cross_damping`. Shapes: `basis` n x (n-1) row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Modal coordinates per metre of proof-mass level, `phi_p / (phi_p . phi_p)`.
    pub anchor: Vec<f64>,
    /// Columns span the motions that leave the proof mass where it is.
    pub basis: Vec<f64>,
    /// Squared angular frequencies of the held modes [1/s^2].
    pub omega2: Vec<f64>,
    /// Damping of each held mode [1/s].
    pub damping: Vec<f64>,
    /// Damping between held modes [1/s], zero on the diagonal, (n-1) x (n-1).
    pub cross_damping: Vec<f64>,
    /// Force on each held mode per metre of level, from the bent structure [kg^1/2/s^2].
    pub level_force: Vec<f64>,
    /// Coupling of each held mode to the drive.
    pub drive: Vec<f64>,
    /// Shape of each held mode at the cantilever's centre.
    pub cantilever: Vec<f64>,
}

impl Held {
    /// Forces on the held modes from forces on the modes in flight.
    pub fn project(&self, forces: &[f64]) -> Vec<f64> {
        let m = self.omega2.len();
        (0..m)
            .map(|k| {
                let row = |(i, force): (usize, &f64)| self.basis[i * m + k] * force;
                forces.iter().enumerate().map(row).sum()
            })
            .collect()
    }

    fn new(structure: &Structure) -> Self {
        let modes = &structure.modes;
        let n = modes.len();
        let mobility = structure.mobility();
        let anchor: Vec<f64> = modes.iter().map(|m| m.phi_p / mobility).collect();
        if n < 2 {
            return Self {
                anchor,
                basis: Vec::new(),
                omega2: Vec::new(),
                damping: Vec::new(),
                cross_damping: Vec::new(),
                level_force: Vec::new(),
                drive: Vec::new(),
                cantilever: Vec::new(),
            };
        }
        let normal = DVector::from_iterator(n, modes.iter().map(|m| m.phi_p / mobility.sqrt()));
        // The Householder reflection that maps e1 onto the normal has an orthonormal
        // basis of the plane normal to it in its other columns.
        let mut v = normal.clone();
        let sign = if v[0] >= 0.0 { 1.0 } else { -1.0 };
        v[0] += sign;
        let reflection = DMatrix::identity(n, n) - (&v * v.transpose()) * (2.0 / v.norm_squared());
        let plane = reflection.columns(1, n - 1).into_owned();
        let diagonal = |f: fn(&Mode) -> f64| {
            DMatrix::from_diagonal(&DVector::from_iterator(n, modes.iter().map(f)))
        };
        let stiffness = diagonal(|m| m.omega() * m.omega());
        let damping = diagonal(|m| m.damping());
        let eigen = SymmetricEigen::new(plane.transpose() * &stiffness * &plane);
        let basis = plane * eigen.eigenvectors;
        let coupled = basis.transpose() * damping * &basis;
        let anchor_vector = DVector::from_column_slice(&anchor);
        let level_force = -(basis.transpose() * stiffness * anchor_vector);
        let project = |f: fn(&Mode) -> f64| -> Vec<f64> {
            (basis.transpose() * DVector::from_iterator(n, modes.iter().map(f)))
                .iter()
                .copied()
                .collect()
        };
        let mut cross = coupled.clone();
        cross.fill_diagonal(0.0);
        Self {
            anchor,
            basis: basis.transpose().iter().copied().collect(),
            omega2: eigen.eigenvalues.iter().map(|&w2| w2.max(0.0)).collect(),
            damping: coupled.diagonal().iter().copied().collect(),
            cross_damping: cross.iter().copied().collect(),
            level_force: level_force.iter().copied().collect(),
            drive: project(|m| m.phi_drive),
            cantilever: project(|m| m.phi_c),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::structure::*;

    fn paper() -> Structure {
        let mode = |frequency, zeta, phi_c, phi_p| Mode {
            frequency,
            zeta,
            phi_c,
            phi_p,
            phi_drive: phi_c,
        };
        Structure {
            modes: vec![
                mode(623.0, 0.0262, 13381.005, 50145.332),
                mode(6424.0, 0.0257, 74486.762, -12923.177),
            ],
            proof_mass: 3.495e-10,
        }
    }

    #[test]
    fn matrices_are_those_of_the_model() {
        let (m, _, k) = paper().matrices().unwrap();
        for (value, expected) in [
            (m[(0, 0)], 1.7557e-10),
            (m[(0, 1)], 0.1909e-10),
            (m[(1, 1)], 3.7499e-10),
            (k[(0, 0)], 0.26839),
            (k[(0, 1)], -0.07061),
            (k[(1, 1)], 0.02467),
        ] {
            assert!(
                (value / expected - 1.0).abs() < 2e-3,
                "{value} should be {expected}"
            );
        }
        assert!((paper().static_gain().unwrap() * 3.819e-7 - 16.5e-6).abs() < 0.02e-6);
    }

    #[test]
    fn participation_is_the_inverse_of_the_shapes() {
        // M [1, 1] = Phi^-T Gamma.
        let mut structure = paper();
        let gamma = structure.participation();
        let (m, _, _) = structure.matrices().unwrap();
        for (row, phi) in [(0, [13381.005, 74486.762]), (1, [50145.332, -12923.177])] {
            assert!((phi[0] * gamma[0] + phi[1] * gamma[1] - 1.0).abs() < 1e-12);
            let force: f64 = m[(row, 0)] + m[(row, 1)];
            let inverse = nalgebra::Matrix2::new(13381.005, 74486.762, 50145.332, -12923.177)
                .try_inverse()
                .unwrap();
            let modal = inverse[(0, row)] * gamma[0] + inverse[(1, row)] * gamma[1];
            assert!((modal / force - 1.0).abs() < 1e-12);
        }
        structure.modes.truncate(1);
        assert!((structure.participation()[0] * 50145.332 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn held_structure_is_the_cantilever_alone() {
        // With xp held only the row of xc is left: M11 xc'' + B11 xc' + K11 xc = F.
        let structure = paper();
        let (m, b, k) = structure.matrices().unwrap();
        let held = structure.held();
        assert!((held.omega2[0] / (k[(0, 0)] / m[(0, 0)]) - 1.0).abs() < 1e-9);
        assert!((held.damping[0] / (b[(0, 0)] / m[(0, 0)]) - 1.0).abs() < 1e-9);
        // A motion along the basis leaves the proof mass where it is.
        let moved: f64 = structure
            .modes
            .iter()
            .zip(&held.basis)
            .map(|(mode, z)| mode.phi_p * z)
            .sum();
        assert!(moved.abs() < 1e-9 * structure.mobility().sqrt());
    }
}
