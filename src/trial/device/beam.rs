//! A distributed device: an Euler-Bernoulli beam of Hermite elements. It carries a rigid proof mass
//! at its end and is bent by the pair of moments of a piezo patch.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::structure::Mode;

/// Dimensions and material of the beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Free length from the clamp to the proof mass \[m\].
    pub length: f64,
    /// Bending stiffness \[N m^2\].
    pub stiffness: f64,
    /// Mass per length \[kg/m\].
    pub line_mass: f64,
    /// Proof mass \[kg\].
    pub mass: f64,
    /// Length of the proof mass along the beam \[m\].
    pub mass_length: f64,
    /// Height of the proof mass \[m\], for its rotary inertia.
    pub mass_height: f64,
    /// Position of the cantilever's reading \[m from the clamp\].
    pub reading: f64,
    /// Start of the piezo patch \[m from the clamp\].
    pub patch_from: f64,
    /// End of the piezo patch \[m from the clamp\].
    pub patch_to: f64,
    /// Number of elements along the beam.
    pub elements: usize,
}

impl Default for Beam {
    fn default() -> Self {
        Self {
            length: 750e-6,
            stiffness: 1.139e-12,
            line_mass: 3.519e-7,
            mass: 3.495e-10,
            mass_length: 150e-6,
            mass_height: 10e-6,
            reading: 375e-6,
            patch_from: 0.0,
            patch_to: 750e-6,
            elements: 24,
        }
    }
}

impl Beam {
    /// Hermite shape functions at the point `x`: the element, its four weights for the deflection,
    /// and those for the slope.
    fn shape(&self, x: f64) -> (usize, [f64; 4], [f64; 4]) {
        let l = self.length / self.elements as f64;
        let e = ((x / l).floor().max(0.0) as usize).min(self.elements - 1);
        let s = x / l - e as f64;
        let (s2, s3) = (s * s, s * s * s);
        (
            e,
            [
                1.0 - 3.0 * s2 + 2.0 * s3,
                l * (s - 2.0 * s2 + s3),
                3.0 * s2 - 2.0 * s3,
                l * (s3 - s2),
            ],
            [
                (-6.0 * s + 6.0 * s2) / l,
                1.0 - 4.0 * s + 3.0 * s2,
                (6.0 * s - 6.0 * s2) / l,
                3.0 * s2 - 2.0 * s,
            ],
        )
    }

    /// The lowest `count` modes with the damping ratios `zetas[i]`. The last ratio holds for all
    /// further modes. The drive is the modal work of the patch's pair of moments per newton metre.
    /// `None` if the matrices are not positive definite.
    #[must_use]
    pub fn modes(&self, count: usize, zetas: &[f64]) -> Option<Vec<Mode>> {
        let size = 2 * self.elements;
        let l = self.length / self.elements as f64;
        let (ei, ra) = (self.stiffness / (l * l * l), self.line_mass * l / 420.0);
        let ke = [
            [12.0, 6.0 * l, -12.0, 6.0 * l],
            [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
            [-12.0, -6.0 * l, 12.0, -6.0 * l],
            [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
        ];
        let me = [
            [156.0, 22.0 * l, 54.0, -13.0 * l],
            [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
            [54.0, 13.0 * l, 156.0, -22.0 * l],
            [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
        ];
        let mut k = DMatrix::zeros(size, size);
        let mut m = DMatrix::zeros(size, size);
        // Inertial load of a unit base acceleration: M times a rigid translation.
        let mut rigid = DVector::zeros(size);
        for e in 0..self.elements {
            for i in 0..4 {
                // Node 0 is clamped: global index of local i is 2 (e - 1) + i.
                let Some(gi) = (2 * e + i).checked_sub(2) else {
                    continue;
                };
                for j in 0..4 {
                    // A rigid translation also moves the clamp.
                    if j % 2 == 0 {
                        rigid[gi] += ra * me[i][j];
                    }
                    if let Some(gj) = (2 * e + j).checked_sub(2) {
                        k[(gi, gj)] += ei * ke[i][j];
                        m[(gi, gj)] += ra * me[i][j];
                    }
                }
            }
        }
        let arm = 0.5 * self.mass_length;
        let (w, r) = (size - 2, size - 1);
        let rotary = self.mass
            * (self.mass_length * self.mass_length + self.mass_height * self.mass_height)
            / 12.0;
        m[(w, w)] += self.mass;
        m[(w, r)] += self.mass * arm;
        m[(r, w)] += self.mass * arm;
        m[(r, r)] += rotary + self.mass * arm * arm;
        rigid[w] += self.mass;
        rigid[r] += self.mass * arm;

        let factor = m.cholesky()?;
        let lower = factor.l();
        // L^-1 K L^-T is symmetric with the squared frequencies as eigenvalues.
        let half = lower.solve_lower_triangular(&k)?;
        let reduced = lower.solve_lower_triangular(&half.transpose())?;
        let symmetric: DMatrix<f64> = 0.5 * (&reduced + reduced.transpose());
        let eigen = SymmetricEigen::new(symmetric);
        let mut order: Vec<usize> = (0..size).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));

        let mut modes = Vec::with_capacity(count);
        for (rank, &at) in order.iter().take(count).enumerate() {
            let y = lower
                .transpose()
                .solve_upper_triangular(&eigen.eigenvectors.column(at).into_owned())?;
            let at_point = |x: f64, slope: bool| {
                let (e, deflection, rotation) = self.shape(x);
                let weights = if slope { rotation } else { deflection };
                (0..4)
                    .filter_map(|i| (2 * e + i).checked_sub(2).map(|g| weights[i] * y[g]))
                    .sum::<f64>()
            };
            let phi_p = y[w] + arm * y[r];
            let phi_c = at_point(self.reading, false);
            // Sign convention: the cantilever's centre moves up in every mode of the table.
            let sign = if phi_c < 0.0 { -1.0 } else { 1.0 };
            modes.push(Mode {
                frequency: eigen.eigenvalues[at].max(0.0).sqrt() / TAU,
                zeta: *zetas.get(rank).or(zetas.last())?,
                phi_c: sign * phi_c,
                phi_p: sign * phi_p,
                drive: sign * (at_point(self.patch_to, true) - at_point(self.patch_from, true)),
                base: sign * y.dot(&rigid),
            });
        }
        Some(modes)
    }
}

#[cfg(test)]
mod tests {
    use super::super::beam::*;

    #[test]
    fn frequencies_and_shapes_of_the_device() {
        let modes = Beam::default().modes(4, &[0.02]).unwrap();
        let table = [
            (623.0, 13381.005, 50145.332),
            (6424.0, 74486.762, -12923.177),
            (19175.0, 63144.79, 2944.80),
        ];
        for (mode, (f, c, p)) in modes.iter().zip(table) {
            println!("{mode:?}");
            assert!((mode.frequency / f - 1.0).abs() < 2e-3);
            assert!((mode.phi_c / c - 1.0).abs() < 1e-2);
            assert!((mode.phi_p / p - 1.0).abs() < 2e-2);
        }
        assert!(modes[3].frequency > 30e3);
    }

    #[test]
    fn refinement_does_not_move_the_modes() {
        let coarse = Beam::default().modes(4, &[0.02]).unwrap();
        let fine = Beam {
            elements: 60,
            ..Beam::default()
        };
        for (a, b) in coarse.iter().zip(fine.modes(4, &[0.02]).unwrap()) {
            assert!((a.frequency / b.frequency - 1.0).abs() < 1e-5);
            assert!((a.phi_p / b.phi_p - 1.0).abs() < 1e-3);
        }
    }
}
