//! The moving structure of a trial device: mass, damping and stiffness matrices, the points at
//! which forces act, and the points of the readings.
//!
//! The lumped device uses its physical coordinates `[xc, xp]`, the beam the coordinates of its
//! lowest modes. The solver does not distinguish them.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix2};
use serde::Serialize;

/// Largest number of degrees of freedom of a trial device.
pub const MAX_DOF: usize = 6;

/// A vector with one number for each degree of freedom.
pub type Dofs = [f64; MAX_DOF];

/// Frequency \[Hz\], damping ratio and mass-normalised shape \[kg^-1/2\] at the
/// cantilever's centre and at the proof mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mode {
    /// Natural frequency \[Hz\].
    pub frequency: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Shape at the cantilever's centre \[kg^-1/2\].
    pub phi_c: f64,
    /// Shape at the proof mass's centre \[kg^-1/2\].
    pub phi_p: f64,
    /// Modal force per newton of drive \[kg^-1/2\].
    pub drive: f64,
    /// Modal load per unit of base acceleration \[kg^1/2\].
    pub base: f64,
}

/// `M x'' + B x' + K x = f`, solved for the accelerations.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Number of degrees of freedom in use.
    pub n: usize,
    /// `M^-1 K`.
    pub stiffness: [Dofs; MAX_DOF],
    /// `M^-1 B`.
    pub damping: [Dofs; MAX_DOF],
    /// Row that gives the displacement of the proof mass from the coordinates.
    pub read_p: Dofs,
    /// The same for the cantilever's centre.
    pub read_c: Dofs,
    /// Accelerations per newton on the proof mass.
    pub push_p: Dofs,
    /// Accelerations per newton on the cantilever's centre.
    pub push_c: Dofs,
    /// Accelerations per newton of drive.
    pub push_drive: Dofs,
    /// Accelerations per m/s^2 of the base (before the sign).
    pub push_base: Dofs,
    /// `read_p . push_p` \[1/kg\].
    pub mobility: f64,
}

fn dofs(v: &DVector<f64>) -> Dofs {
    let mut out = [0.0; MAX_DOF];
    for (o, x) in out.iter_mut().zip(v.iter()) {
        *o = *x;
    }
    out
}

fn matrix(m: &DMatrix<f64>) -> [Dofs; MAX_DOF] {
    let mut out = [[0.0; MAX_DOF]; MAX_DOF];
    for i in 0..m.nrows() {
        for j in 0..m.ncols() {
            out[i][j] = m[(i, j)];
        }
    }
    out
}

/// Scalar product of the first `n` entries.
#[inline]
#[must_use]
pub fn dot(n: usize, a: &Dofs, b: &[f64]) -> f64 {
    let mut sum = 0.0;
    for i in 0..n {
        sum += a[i] * b[i];
    }
    sum
}

impl Structure {
    /// The lumped device in `[xc, xp]`, from two measured modes. The drive acts on the cantilever,
    /// and with the share `on_p` on the proof mass.
    ///
    /// `None` if the two shapes are not independent.
    #[must_use]
    pub fn lumped(modes: &[Mode; 2], on_p: f64) -> Option<Self> {
        let phi = Matrix2::new(
            modes[0].phi_c,
            modes[1].phi_c,
            modes[0].phi_p,
            modes[1].phi_p,
        );
        let inverse = phi.try_inverse()?;
        let w = [TAU * modes[0].frequency, TAU * modes[1].frequency];
        let congruent =
            |a: f64, b: f64| inverse.transpose() * Matrix2::new(a, 0.0, 0.0, b) * inverse;
        let m = congruent(1.0, 1.0);
        let b = congruent(2.0 * modes[0].zeta * w[0], 2.0 * modes[1].zeta * w[1]);
        let k = congruent(w[0] * w[0], w[1] * w[1]);
        let full = |m: Matrix2<f64>| DMatrix::from_fn(2, 2, |i, j| m[(i, j)]);
        let (m, b, k) = (full(m), full(b), full(k));
        let inverse = m.clone().try_inverse()?;
        let c_row = DVector::from_vec(vec![1.0, 0.0]);
        let p_row = DVector::from_vec(vec![0.0, 1.0]);
        let drive = DVector::from_vec(vec![1.0, on_p]);
        let ones = DVector::from_vec(vec![1.0, 1.0]);
        let mut s = Self {
            n: 2,
            stiffness: matrix(&(&inverse * k)),
            damping: matrix(&(&inverse * b)),
            push_p: dofs(&(&inverse * &p_row)),
            push_c: dofs(&(&inverse * &c_row)),
            push_drive: dofs(&(&inverse * drive)),
            push_base: dofs(&ones),
            read_p: dofs(&p_row),
            read_c: dofs(&c_row),
            mobility: 0.0,
        };
        s.mobility = dot(s.n, &s.read_p, &s.push_p);
        Some(s)
    }

    /// A structure in the coordinates of its modes (at most five are used).
    #[must_use]
    pub fn modal(modes: &[Mode]) -> Self {
        let mut s = Self {
            n: 0,
            stiffness: [[0.0; MAX_DOF]; MAX_DOF],
            damping: [[0.0; MAX_DOF]; MAX_DOF],
            read_p: [0.0; MAX_DOF],
            read_c: [0.0; MAX_DOF],
            push_p: [0.0; MAX_DOF],
            push_c: [0.0; MAX_DOF],
            push_drive: [0.0; MAX_DOF],
            push_base: [0.0; MAX_DOF],
            mobility: 0.0,
        };
        for mode in modes.iter().take(MAX_DOF - 1) {
            s.append(mode);
        }
        s
    }

    /// Adds an oscillator. All forces excite it, and both readings show it.
    pub fn append(&mut self, mode: &Mode) {
        if self.n == MAX_DOF {
            return;
        }
        let (i, w) = (self.n, TAU * mode.frequency);
        self.n += 1;
        self.stiffness[i][i] = w * w;
        self.damping[i][i] = 2.0 * mode.zeta * w;
        self.read_p[i] = mode.phi_p;
        self.read_c[i] = mode.phi_c;
        self.push_p[i] = mode.phi_p;
        self.push_c[i] = mode.phi_c;
        self.push_drive[i] = mode.drive;
        self.push_base[i] = mode.base;
        self.mobility = dot(self.n, &self.read_p, &self.push_p);
    }

    /// Static displacements of proof mass and cantilever per newton of drive \[m/N\]. `None` if the
    /// stiffness is singular.
    #[must_use]
    pub fn static_gain(&self) -> Option<(f64, f64)> {
        let k = DMatrix::from_fn(self.n, self.n, |i, j| self.stiffness[i][j]);
        let f = DVector::from_fn(self.n, |i, _| self.push_drive[i]);
        let x = k.lu().solve(&f)?;
        Some((
            dot(self.n, &self.read_p, x.as_slice()),
            dot(self.n, &self.read_c, x.as_slice()),
        ))
    }

    /// Multiplies the drive by `factor`.
    pub fn scale_drive(&mut self, factor: f64) {
        self.push_drive.iter_mut().for_each(|d| *d *= factor);
    }
}
