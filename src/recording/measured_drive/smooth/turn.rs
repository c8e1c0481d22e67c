//! The instant at which a smooth voltage turns, from a polynomial over as many samples as one
//! follows.

use nalgebra::{DMatrix, DVector};

use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CHECKED_TURN_DEGREES, FIRST_TURN_HALF_SAMPLES, MAX_TURN_HALF_BINS, MAX_TURN_HALF_SAMPLES,
    MAX_UNFOLLOWED_WINDOWS, MIN_TURN_CURVATURE_SIGMAS, SHORTER_TURN_WINDOWS,
    SIGNIFICANT_DEGREE_SIGMAS, TURN_DEGREE, TURN_WINDOW_GROWTH,
};

/// Polynomials up to the highest degree.
const POLYNOMIALS: usize = TURN_DEGREE + CHECKED_TURN_DEGREES + 1;

/// The turn near sample `near`, from samples `from..to` without a jump: time and its standard
/// deviation \[s\]. `half` samples on either side are known to be smooth. `None` if there is no
/// clear turn.
pub fn refine_turn(
    samples: &Samples<'_>,
    near: usize,
    half: usize,
    (from, to): (usize, usize),
) -> Option<(f64, f64)> {
    let mut followed = Vec::new();
    let mut failures = 0;
    let mut half = half.max(FIRST_TURN_HALF_SAMPLES);
    while near >= from + half && near + half < to && half <= MAX_TURN_HALF_SAMPLES {
        let (coefficients, inverse, _) =
            legendre_fit(samples, near, half, TURN_DEGREE + CHECKED_TURN_DEGREES)?;
        let significant = |k: usize| {
            coefficients[k].abs()
                > SIGNIFICANT_DEGREE_SIGMAS * samples.sigma * inverse[(k, k)].sqrt()
        };
        if (TURN_DEGREE + 1..=TURN_DEGREE + CHECKED_TURN_DEGREES).any(significant) {
            failures += 1;
            if failures == MAX_UNFOLLOWED_WINDOWS {
                break;
            }
        } else {
            failures = 0;
            followed.push(half);
        }
        half = ((half as f64 * TURN_WINDOW_GROWTH) as usize).max(half + 1);
    }
    // The longest knows it best, if it is a turn. What it does not follow but for noise moves it by no
    // more than it moves a far shorter one.
    let mut longest = followed.into_iter().rev();
    let (half, (time, sigma)) =
        longest.find_map(|half| Some((half, vertex(samples, near, half)?)))?;
    let short = (half as f64 / TURN_WINDOW_GROWTH.powi(SHORTER_TURN_WINDOWS)) as usize;
    let apart = vertex(samples, near, short.max(FIRST_TURN_HALF_SAMPLES))
        .map_or(0.0, |(shorter, _)| shorter - time);
    Some((time, sigma.hypot(apart)))
}

/// Legendre coefficients of the samples around `near`, their normal matrix's inverse, and half the
/// window \[s\].
fn legendre_fit(
    samples: &Samples<'_>,
    near: usize,
    half: usize,
    degree: usize,
) -> Option<(DVector<f64>, DMatrix<f64>, f64)> {
    let at = samples.time[near];
    let unit = (samples.time[near + half] - at).max(at - samples.time[near - half]);
    let n = degree + 1;
    let mut normal = DMatrix::<f64>::zeros(n, n);
    let mut right = DVector::<f64>::zeros(n);
    // Many samples are averaged in bins, over which a polynomial of low degree is straight.
    let bin = (half / MAX_TURN_HALF_BINS).max(1);
    let mut i = near - half;
    while i <= near + half {
        let end = (i + bin).min(near + half + 1);
        let count = (end - i) as f64;
        let mean = |values: &[f64]| values[i..end].iter().sum::<f64>() / count;
        let p = legendre((mean(samples.time) - at) / unit).0;
        let volts = mean(samples.volts);
        for a in 0..n {
            right[a] += count * p[a] * volts;
            for b in 0..=a {
                normal[(a, b)] += count * p[a] * p[b];
            }
        }
        i = end;
    }
    normal.fill_upper_triangle_with_lower_triangle();
    let inverse = normal.cholesky()?.inverse();
    let coefficients = &inverse * right;
    Some((coefficients, inverse, unit))
}

/// Legendre polynomials at `x` up to the highest degree used, and their derivatives.
fn legendre(x: f64) -> ([f64; POLYNOMIALS], [f64; POLYNOMIALS]) {
    let (mut p, mut d) = ([1.0; POLYNOMIALS], [0.0; POLYNOMIALS]);
    (p[1], d[1]) = (x, 1.0);
    for k in 1..POLYNOMIALS - 1 {
        let n = k as f64;
        p[k + 1] = ((2.0 * n + 1.0) * x * p[k] - n * p[k - 1]) / (n + 1.0);
        d[k + 1] = d[k - 1] + (2.0 * n + 1.0) * p[k];
    }
    (p, d)
}

/// Where the polynomial's slope vanishes, and its standard deviation \[s\].
fn vertex(samples: &Samples<'_>, near: usize, half: usize) -> Option<(f64, f64)> {
    let (c, inverse, unit) = legendre_fit(samples, near, half, TURN_DEGREE)?;
    let slope = |x: f64| -> f64 {
        let d = legendre(x).1;
        (0..=TURN_DEGREE).map(|k| d[k] * c[k]).sum()
    };
    let step = 1e-4;
    let bend_at = |x: f64| (slope(x + step) - slope(x - step)) / (2.0 * step);
    let mut x = 0.0;
    for _ in 0..20 {
        let change = slope(x) / bend_at(x);
        x -= change;
        if x.is_nan() || x.abs() >= 0.7 {
            return None;
        }
        if change.abs() < 1e-9 {
            break;
        }
    }
    let d = DVector::from_row_slice(&legendre(x).1[..=TURN_DEGREE]);
    let slope_sigma = samples.sigma * (d.transpose() * &inverse * &d)[(0, 0)].sqrt();
    let bend = bend_at(x).abs();
    // The curvature's own error is a few times the slope's, in the window's unit.
    (bend > MIN_TURN_CURVATURE_SIGMAS * slope_sigma)
        .then(|| (samples.time[near] + x * unit, unit * slope_sigma / bend))
}
