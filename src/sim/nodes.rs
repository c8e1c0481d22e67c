//! The five Gauss-Lobatto points of a step, and constants that follow from them.
//!
//! Within a step `[0, h]` every force is the polynomial of degree 4 through its values
//! at these points. The response of the linear structure to such a force is exact.

use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector};

/// Points per step.
pub const S: usize = 5;

/// Gauss-Lobatto points on [0, 1].
pub const NODES: [f64; S] = [
    0.0,
    0.172_673_164_646_011_43,
    0.5,
    0.827_326_835_353_988_6,
    1.0,
];

/// Coefficients of the polynomial through values and slopes at the points.
pub const DENSE: usize = 2 * S;

/// Lagrange polynomials of the points at `c` in [0, 1].
pub fn lagrange(c: f64) -> [f64; S] {
    std::array::from_fn(|j| {
        (0..S)
            .filter(|&l| l != j)
            .map(|l| (c - NODES[l]) / (NODES[j] - NODES[l]))
            .product()
    })
}

/// Weights that give the coefficient of a force's fourth Legendre polynomial from its values at
/// the points. The error estimate uses this highest coefficient.
pub fn top_coefficient() -> &'static [f64; S] {
    static WEIGHTS: OnceLock<[f64; S]> = OnceLock::new();
    // 70 is the leading coefficient of the shifted Legendre polynomial of degree 4.
    WEIGHTS.get_or_init(|| {
        std::array::from_fn(|j| {
            let product: f64 = (0..S)
                .filter(|&l| l != j)
                .map(|l| NODES[j] - NODES[l])
                .product();
            1.0 / (70.0 * product)
        })
    })
}

/// Points and weights of Gauss-Legendre quadrature on [0, 1], exact to degree 39.
pub fn gauss() -> &'static [(f64, f64); 20] {
    static POINTS: OnceLock<[(f64, f64); 20]> = OnceLock::new();
    POINTS.get_or_init(|| {
        const N: usize = 20;
        std::array::from_fn(|i| {
            // Newton's method on P_20 from the usual cosine estimate.
            let mut x = ((i as f64 + 0.75) / (N as f64 + 0.5) * std::f64::consts::PI).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=N {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = N as f64 * (x * p1 - p0) / (x * x - 1.0);
                let dx = p1 / slope;
                x -= dx;
                if dx.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
    })
}

/// A quantity over one step as a polynomial in `u` of [-1, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dense([f64; DENSE]);

impl Default for Dense {
    fn default() -> Self {
        Self([0.0; DENSE])
    }
}

impl Dense {
    /// Adds `weight` times a polynomial of degree 4 in `u`.
    #[inline]
    pub fn add(&mut self, weight: f64, polynomial: &[f64; S]) {
        for (c, p) in self.0.iter_mut().zip(polynomial) {
            *c += weight * p;
        }
    }

    /// From values and time derivatives at the points of a step of length `h` \[s\].
    #[inline]
    pub fn new(values: &[f64; S], slopes: &[f64; S], h: f64) -> Self {
        let matrix = hermite();
        let mut coefficients = [0.0; DENSE];
        for k in 0..S {
            let (value, slope) = (values[k], slopes[k] * (0.5 * h));
            let (row_v, row_s) = (&matrix[2 * k], &matrix[2 * k + 1]);
            for (c, (v, s)) in coefficients.iter_mut().zip(row_v.iter().zip(row_s)) {
                *c += v * value + s * slope;
            }
        }
        Self(coefficients)
    }

    /// Value at fraction `s` in [0, 1] of the step.
    #[inline]
    pub fn value(&self, s: f64) -> f64 {
        let c = &self.0;
        let u = 2.0 * s - 1.0;
        let u2 = u * u;
        // Even and odd powers separately: two short chains of operations are faster than a long
        // one.
        let even = c[0] + u2 * (c[2] + u2 * (c[4] + u2 * (c[6] + u2 * c[8])));
        let odd = c[1] + u2 * (c[3] + u2 * (c[5] + u2 * (c[7] + u2 * c[9])));
        even + u * odd
    }

    /// Value and time derivative at fraction `s` of a step of length `h` \[s\].
    #[inline]
    pub fn value_and_slope(&self, s: f64, h: f64) -> (f64, f64) {
        let c = &self.0;
        let u = 2.0 * s - 1.0;
        let u2 = u * u;
        let even =
            c[1] + u2 * (3.0 * c[3] + u2 * (5.0 * c[5] + u2 * (7.0 * c[7] + u2 * 9.0 * c[9])));
        let odd = 2.0 * c[2] + u2 * (4.0 * c[4] + u2 * (6.0 * c[6] + u2 * 8.0 * c[8]));
        (self.value(s), (even + u * odd) * 2.0 / h)
    }

    /// Bounds of the first and of the second derivative of the time derivative with respect to the
    /// fraction of a step of length `h` \[s\].
    pub fn most_bend(&self, h: f64) -> (f64, f64) {
        let sum = |f: fn(f64) -> f64| -> f64 {
            let own = self.0.iter().enumerate();
            own.map(|(power, c)| f(power as f64) * c.abs()).sum()
        };
        (
            4.0 / h * sum(|n| n * (n - 1.0)),
            8.0 / h * sum(|n| n * (n - 1.0) * (n - 2.0)),
        )
    }

    /// Lower bound of `sign` times the time derivative over a step of length `h` \[s\].
    pub fn least_slope(&self, sign: f64, h: f64) -> f64 {
        let rest = self.0.iter().enumerate().skip(2);
        let rest: f64 = rest.map(|(power, c)| power as f64 * c.abs()).sum();
        (sign * self.0[1] - rest) * 2.0 / h
    }
}

/// Coefficients in `u` of the polynomial of degree 4 through values at the points.
pub fn interpolant(values: &[f64; S]) -> [f64; S] {
    static MATRIX: OnceLock<[[f64; S]; S]> = OnceLock::new();
    let matrix = MATRIX.get_or_init(|| {
        let system = DMatrix::from_fn(S, S, |k, power| (2.0 * NODES[k] - 1.0).powi(power as i32));
        // The points are distinct: the matrix has an inverse.
        let inverse = system.try_inverse().unwrap_or_else(|| DMatrix::zeros(S, S));
        std::array::from_fn(|power| std::array::from_fn(|k| inverse[(power, k)]))
    });
    matrix.map(|row| row.iter().zip(values).map(|(m, v)| m * v).sum())
}

/// Row `2k` has the coefficients per unit value at point k, row `2k + 1` those per unit slope.
fn hermite() -> &'static [[f64; DENSE]; DENSE] {
    static MATRIX: OnceLock<[[f64; DENSE]; DENSE]> = OnceLock::new();
    MATRIX.get_or_init(|| {
        let mut system = DMatrix::zeros(DENSE, DENSE);
        for k in 0..S {
            let u: f64 = 2.0 * NODES[k] - 1.0;
            for power in 0..DENSE {
                let p = power as i32;
                system[(2 * k, power)] = u.powi(p);
                system[(2 * k + 1, power)] = if power == 0 {
                    0.0
                } else {
                    f64::from(p) * u.powi(p - 1)
                };
            }
        }
        let lu = system.lu();
        std::array::from_fn(|row| {
            let mut unit = DVector::zeros(DENSE);
            unit[row] = 1.0;
            // The points are distinct: the system has a solution.
            let solved = lu.solve(&unit).unwrap_or_else(|| DVector::zeros(DENSE));
            std::array::from_fn(|power| solved[power])
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::nodes::*;

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        let total: f64 = gauss().iter().map(|(_, w)| w).sum();
        assert!((total - 1.0).abs() < 1e-14);
        let tenth: f64 = gauss().iter().map(|(x, w)| w * x.powi(30)).sum();
        assert!((tenth - 1.0 / 31.0).abs() < 1e-15);
    }

    #[test]
    fn dense_output_is_exact_for_degree_nine_and_close_for_a_sine() {
        let h = 0.3;
        let f = |t: f64| t.powi(9) - 3.0 * t.powi(4) + 0.5;
        let df = |t: f64| 9.0 * t.powi(8) - 12.0 * t.powi(3);
        let dense = Dense::new(&NODES.map(|c| f(c * h)), &NODES.map(|c| df(c * h)), h);
        for i in 0..=20 {
            let s = f64::from(i) / 20.0;
            let (value, slope) = dense.value_and_slope(s, h);
            assert!((value - f(s * h)).abs() < 1e-14);
            assert!((dense.value(s) - value).abs() < 1e-15);
            assert!((slope - df(s * h)).abs() < 1e-12);
            assert!(dense.least_slope(1.0, h) <= slope);
            assert!(dense.least_slope(-1.0, h) <= -slope);
            let d2f = |t: f64| 72.0 * t.powi(7) - 36.0 * t * t;
            let d3f = |t: f64| 504.0 * t.powi(6) - 72.0 * t;
            let bend = dense.most_bend(h);
            assert!(bend.0 >= h * d2f(s * h).abs());
            assert!(bend.1 >= h * h * d3f(s * h).abs());
        }
        // A mode over the longest step, w h = 3.
        let sine = Dense::new(
            &NODES.map(|c| (3.0 * c).sin()),
            &NODES.map(|c| 3.0 * (3.0 * c).cos()),
            1.0,
        );
        let worst = (0..=100)
            .map(|i| f64::from(i) / 100.0)
            .map(|s| (sine.value(s) - (3.0 * s).sin()).abs())
            .fold(0.0, f64::max);
        // Hermite's bound: 3^10 / 10! times the largest squared node polynomial.
        assert!(worst < 1.4e-7, "{worst}");
    }

    #[test]
    fn top_coefficient_sees_only_the_fourth_degree() {
        let apply = |f: fn(f64) -> f64| -> f64 {
            NODES
                .iter()
                .zip(top_coefficient())
                .map(|(c, w)| w * f(*c))
                .sum()
        };
        assert!(apply(|c| c * c * c - c).abs() < 1e-15);
        assert!((apply(|c| 70.0 * c.powi(4)) - 1.0).abs() < 1e-12);
    }
}
