//! Dormand and Prince's pair of orders 5 and 4 with its continuous extension
//! (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
//! II.5 and II.6).

/// Most states that a trial device has.
pub const MAX_STATE: usize = 24;

/// One state, the entries beyond the dimension unused.
pub type State = [f64; MAX_STATE];

const C: [f64; 6] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const A: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
/// Fifth minus fourth order.
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// The last step that was tried: slopes and, once accepted, its polynomial.
#[derive(Debug, Clone)]
pub struct Stepper {
    dim: usize,
    slopes: [State; 7],
    dense: [State; 5],
    /// State at the end of the step.
    pub end: State,
}

impl Stepper {
    /// For states of `dim` entries.
    #[must_use]
    pub fn new(dim: usize) -> Self {
        Self {
            dim: dim.min(MAX_STATE),
            slopes: [[0.0; MAX_STATE]; 7],
            dense: [[0.0; MAX_STATE]; 5],
            end: [0.0; MAX_STATE],
        }
    }

    /// Evaluates the slope at a start that is not the end of the last step.
    pub fn restart(&mut self, t: f64, y: &State, rhs: &mut impl FnMut(f64, &State, &mut State)) {
        rhs(t, y, &mut self.slopes[0]);
    }

    /// Takes over the slope at the end of the accepted step.
    pub fn go_on(&mut self) {
        self.slopes[0] = self.slopes[6];
    }

    /// Tries a step; returns the largest error in units of `tolerance`.
    pub fn attempt(
        &mut self,
        t: f64,
        y: &State,
        h: f64,
        tolerance: &State,
        rhs: &mut impl FnMut(f64, &State, &mut State),
    ) -> f64 {
        for stage in 0..6 {
            let mut at = *y;
            for j in 0..=stage {
                let a = h * A[stage][j];
                if a != 0.0 {
                    for i in 0..self.dim {
                        at[i] += a * self.slopes[j][i];
                    }
                }
            }
            rhs(t + C[stage] * h, &at, &mut self.slopes[stage + 1]);
            self.end = at;
        }
        let mut worst: f64 = 0.0;
        for i in 0..self.dim {
            let mut error = 0.0;
            for (e, slope) in E.iter().zip(&self.slopes) {
                error += e * slope[i];
            }
            let error = (h * error / tolerance[i]).abs();
            // Not `max`, which would lose a NaN.
            if !(error <= worst) {
                worst = error;
            }
        }
        worst
    }

    /// Prepares [`Stepper::at`] for the step that was tried last from `y`.
    pub fn prepare(&mut self, y: &State, h: f64) {
        for i in 0..self.dim {
            let difference = self.end[i] - y[i];
            let bulge = h * self.slopes[0][i] - difference;
            let mut last = 0.0;
            for (d, slope) in D.iter().zip(&self.slopes) {
                last += d * slope[i];
            }
            self.dense[0][i] = y[i];
            self.dense[1][i] = difference;
            self.dense[2][i] = bulge;
            self.dense[3][i] = difference - h * self.slopes[6][i] - bulge;
            self.dense[4][i] = h * last;
        }
    }

    /// State at the share `s` (0 to 1) of the prepared step.
    #[must_use]
    pub fn at(&self, s: f64) -> State {
        let mut y = [0.0; MAX_STATE];
        let r = 1.0 - s;
        for (i, y) in y.iter_mut().enumerate().take(self.dim) {
            let d = &self.dense;
            *y = d[0][i] + s * (d[1][i] + r * (d[2][i] + s * (d[3][i] + r * d[4][i])));
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::super::integrator::*;

    /// Largest error over a decade of ring-down against the closed form.
    fn ring_down(h: f64) -> f64 {
        let (w, zeta) = (std::f64::consts::TAU * 623.0, 0.02);
        let wd = w * (1.0f64 - zeta * zeta).sqrt();
        let mut rhs = |_: f64, y: &State, d: &mut State| {
            d[0] = y[1];
            d[1] = -w * w * y[0] - 2.0 * zeta * w * y[1];
        };
        let mut y = [0.0; MAX_STATE];
        y[0] = 1.0;
        let mut stepper = Stepper::new(2);
        let (mut t, mut worst) = (0.0f64, 0.0f64);
        stepper.restart(t, &y, &mut rhs);
        while t < 0.01 {
            stepper.attempt(t, &y, h, &[1.0; MAX_STATE], &mut rhs);
            stepper.prepare(&y, h);
            for s in [0.3, 0.7, 1.0] {
                let at = t + s * h;
                let exact =
                    (-zeta * w * at).exp() * ((wd * at).cos() + zeta * w / wd * (wd * at).sin());
                worst = worst.max((stepper.at(s)[0] - exact).abs());
            }
            y = stepper.end;
            stepper.go_on();
            t += h;
        }
        worst
    }

    #[test]
    fn fifth_order_on_a_ring_down() {
        let (coarse, fine) = (ring_down(2e-5), ring_down(1e-5));
        println!("{coarse:e} {fine:e}");
        assert!(coarse < 1e-6);
        assert!((coarse / fine).log2() > 4.5);
    }
}
