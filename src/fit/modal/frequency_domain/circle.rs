//! Circle fit of one mode (C. Kennelly, C. Pancu, J. Aeronaut. Sci. 14 (1947) 603; D. J. Ewins, Modal
//! Testing, 2000, ch. 4): near its resonance the mobility of a viscously damped mode goes round a
//! circle, moved and turned by the modes beyond.
//!
//! `jw H = A/(2 zeta w_r) / (1 + j X) + rest`, `X = (w^2 - w_r^2) / (2 zeta w_r w)`, so that the angle
//! about the centre is `phi_0 - 2 atan(X)`.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::spectra::ResponsePoint;

/// Half-widths of the resonance on each side that are fitted: 250 degrees of the circle.
const FITTED_WIDTHS: f64 = 1.5;
/// Fewest points of a circle.
const MIN_POINTS: usize = 6;
/// Iterations of the angles' fit.
const ITERATIONS: usize = 30;

/// A circle in the plane of the mobility.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CircleFit {
    /// Frequency \[Hz\] and its standard error.
    pub frequency: (f64, f64),
    /// Damping ratio and its standard error.
    pub zeta: (f64, f64),
    /// Static displacement per input of this mode \[m\], from the diameter.
    pub residue: f64,
    /// Centre of the circle, real and imaginary part [m/s per input].
    pub center: (f64, f64),
    /// Radius [m/s per input].
    pub radius: f64,
    /// Root mean square distance of the points from the circle, as a share of the radius.
    pub scatter: f64,
    /// Band that was fitted \[Hz\].
    pub band: (f64, f64),
}

/// The mobility at a point of the response [m/s per input].
#[must_use]
pub fn mobility(point: &ResponsePoint) -> (f64, f64) {
    let w = TAU * point.frequency;
    (-w * point.h1[1], w * point.h1[0])
}

/// Fits a circle to the response near a resonance known roughly; `None` if there are too few lines
/// on it, or they are on no circle.
#[must_use]
pub fn circle_fit(points: &[ResponsePoint], frequency: f64, zeta: f64) -> Option<CircleFit> {
    let half = FITTED_WIDTHS * zeta * frequency;
    let band = (frequency - half, frequency + half);
    let near = points
        .iter()
        .filter(|p| p.frequency >= band.0 && p.frequency <= band.1);
    let own: Vec<(f64, f64, f64)> = near
        .map(|p| {
            let (re, im) = mobility(p);
            (p.frequency, re, im)
        })
        .collect();
    if own.len() < MIN_POINTS {
        return None;
    }
    let (center, radius) = circle(&own)?;
    let distance =
        |&(_, x, y): &(f64, f64, f64)| ((x - center.0).hypot(y - center.1) - radius).powi(2);
    let scatter = (own.iter().map(distance).sum::<f64>() / own.len() as f64).sqrt() / radius;
    let angles: Vec<(f64, f64)> = own
        .iter()
        .map(|&(f, x, y)| (TAU * f, (y - center.1).atan2(x - center.0)))
        .collect();
    let fit = fit_angles(&angles, TAU * frequency, zeta)?;
    let sign = if fit.turn.cos() >= 0.0 { 1.0 } else { -1.0 };
    Some(CircleFit {
        frequency: (fit.omega.0 / TAU, fit.omega.1 / TAU),
        zeta: fit.zeta,
        residue: sign * 2.0 * radius * 2.0 * fit.zeta.0 / fit.omega.0,
        center,
        radius,
        scatter,
        band,
    })
}

/// The circle of least algebraic distance (I. Kasa, 1976).
fn circle(points: &[(f64, f64, f64)]) -> Option<((f64, f64), f64)> {
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(&|p| p.1), mean(&|p| p.2));
    let scale = mean(&|p| (p.1 - mx).powi(2) + (p.2 - my).powi(2)).sqrt();
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (_, x, y) in points {
        let row = Vector3::new((x - mx) / scale, (y - my) / scale, 1.0);
        normal += row * row.transpose();
        right += row * (row.x * row.x + row.y * row.y);
    }
    let found = normal.try_inverse()? * right;
    let (cx, cy) = (0.5 * found.x, 0.5 * found.y);
    let radius = (found.z + cx * cx + cy * cy).max(0.0).sqrt();
    (radius > 0.0 && radius.is_finite())
        .then_some(((mx + scale * cx, my + scale * cy), scale * radius))
}

struct Angles {
    turn: f64,
    omega: (f64, f64),
    zeta: (f64, f64),
}

/// Fits `phi_0 - 2 atan((w^2 - w_r^2) / (2 zeta w_r w))` to angles by Gauss and Newton.
fn fit_angles(angles: &[(f64, f64)], omega: f64, zeta: f64) -> Option<Angles> {
    let nearest = angles
        .iter()
        .min_by(|a, b| (a.0 - omega).abs().total_cmp(&(b.0 - omega).abs()))?;
    // Unknowns: turn, ln w_r, ln zeta.
    let mut p = Vector3::new(nearest.1, omega.ln(), zeta.ln());
    let residual = |p: &Vector3<f64>, (w, angle): &(f64, f64)| {
        let (wr, z) = (p.y.exp(), p.z.exp());
        let x = (w * w - wr * wr) / (2.0 * z * wr * w);
        let left = angle - (p.x - 2.0 * x.atan());
        let left = (left + PI).rem_euclid(TAU) - PI;
        let slope = -2.0 / (1.0 + x * x);
        // dx/d ln w_r and dx/d ln zeta.
        let by_omega = -(w * w + wr * wr) / (2.0 * z * wr * w);
        (left, Vector3::new(1.0, slope * by_omega, -slope * x))
    };
    let mut covariance = Matrix3::zeros();
    for _ in 0..ITERATIONS {
        let mut normal = Matrix3::zeros();
        let mut right = Vector3::zeros();
        let mut squares = 0.0;
        for point in angles {
            let (left, row) = residual(&p, point);
            normal += row * row.transpose();
            right += row * left;
            squares += left * left;
        }
        let inverse = normal.try_inverse()?;
        covariance = inverse * (squares / (angles.len() as f64 - 3.0).max(1.0));
        let mut step = inverse * right;
        step.y = step.y.clamp(-0.1, 0.1);
        step.z = step.z.clamp(-0.5, 0.5);
        p += step;
        if step.norm() < 1e-12 {
            break;
        }
    }
    let (wr, z) = (p.y.exp(), p.z.exp());
    if !(p.iter().all(|v| v.is_finite()) && (wr / omega).ln().abs() < 1.0) {
        return None;
    }
    Some(Angles {
        turn: p.x,
        omega: (wr, wr * covariance[(1, 1)].max(0.0).sqrt()),
        zeta: (z, z * covariance[(2, 2)].max(0.0).sqrt()),
    })
}
