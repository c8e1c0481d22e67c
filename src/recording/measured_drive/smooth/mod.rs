//! A voltage that is no known waveform: the smoothest cubic spline that the samples allow.
//!
//! Least squares on cubic B-splines. Intervals between knots are halved where the samples deviate
//! from the spline by more than their error, until nowhere they do.

pub mod turn;

use nalgebra::{SMatrix, SVector};

use rayon::prelude::*;

use super::samples::Samples;
use super::thresholds::{
    BEND_GROUP_INTERVALS, FIRST_SPLINE_INTERVALS, FOLLOWED_PARTS, MAX_BEND_EXCESS_SIGMAS,
    MAX_SPLINE_EXCESS_SIGMAS, MIN_SAMPLES_PER_SPLINE_INTERVAL, TRIED_SPLINE_SAMPLES,
};
use crate::model::drive::Shape;

/// A cubic between two times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cubic {
    /// \[s\]
    pub start: f64,
    /// \[s\]
    pub end: f64,
    /// The voltage.
    pub shape: Shape,
    /// Standard deviation of the voltage \[V\].
    pub sigma: f64,
}

/// The spline through `samples`, at least two of which there must be.
pub fn smooth(samples: &Samples<'_>) -> Vec<Cubic> {
    let n = samples.len();
    // A long voltage begins with intervals as its first samples need.
    let mut count = FIRST_SPLINE_INTERVALS;
    if n > 4 * TRIED_SPLINE_SAMPLES {
        let tried = smooth(&samples.part(0, TRIED_SPLINE_SAMPLES)).len();
        count = count.max(n / (2 * TRIED_SPLINE_SAMPLES / tried.max(1)).max(1));
    }
    count = count.min(n / (2 * MIN_SAMPLES_PER_SPLINE_INTERVAL)).max(1);
    if n < 5 {
        return straight(samples);
    }
    // Knots as indices of samples.
    let mut knots: Vec<usize> = (0..=count).map(|k| k * (n - 1) / count).collect();
    let mut moments: Vec<Moments> = knots
        .par_windows(2)
        .map(|k| Moments::new(samples, k[0], k[1]))
        .collect();
    loop {
        let Some(cubics) = solve(samples, &knots, &moments) else {
            return straight(samples);
        };
        let split = split(samples, &knots, &cubics);
        if !split.contains(&true) {
            return cubics;
        }
        let mut refined = Vec::with_capacity(2 * knots.len());
        for (pair, split) in knots.windows(2).zip(&split) {
            refined.push(pair[0]);
            if *split {
                refined.push((pair[0] + pair[1]) / 2);
            }
        }
        refined.push(n - 1);
        let of_old: Vec<Option<usize>> = split
            .iter()
            .enumerate()
            .flat_map(|(k, split)| {
                let both = if *split {
                    vec![None, None]
                } else {
                    vec![Some(k)]
                };
                both.into_iter()
            })
            .collect();
        moments = refined
            .par_windows(2)
            .zip(&of_old)
            .map(|(k, old)| old.map_or_else(|| Moments::new(samples, k[0], k[1]), |k| moments[k]))
            .collect();
        knots = refined;
    }
}

/// Which intervals are to be halved.
fn split(samples: &Samples<'_>, knots: &[usize], cubics: &[Cubic]) -> Vec<bool> {
    let pairs = || knots.par_windows(2).zip(cubics);
    let bends: Vec<f64> = pairs()
        .map(|(pair, cubic)| bend(samples, cubic, pair[0], pair[1]))
        .collect();
    pairs()
        .enumerate()
        .map(|(k, (pair, cubic))| {
            let group = k.saturating_sub(BEND_GROUP_INTERVALS / 2)
                ..(k + BEND_GROUP_INTERVALS / 2).min(bends.len());
            let count = group.len() as f64;
            let mean = bends[group].iter().sum::<f64>() / count;
            let stiff = mean > 1.0 + MAX_BEND_EXCESS_SIGMAS * (2.0 / count).sqrt();
            pair[1] - pair[0] >= 2 * MIN_SAMPLES_PER_SPLINE_INTERVAL
                && (stiff || !follows(samples, cubic, pair[0], pair[1]))
        })
        .collect()
}

/// Sums over the samples of an interval: of products of the first powers of the share of the
/// interval passed, and of these times the voltage.
#[derive(Debug, Clone, Copy)]
struct Moments {
    powers: [f64; 7],
    volts: [f64; 4],
}

impl Moments {
    /// Of the samples `from..to`; the last sample of all belongs to the last interval.
    fn new(samples: &Samples<'_>, from: usize, to: usize) -> Self {
        let (start, width) = (samples.time[from], samples.time[to] - samples.time[from]);
        let last = if to + 1 == samples.len() { to + 1 } else { to };
        let mut moments = Self {
            powers: [0.0; 7],
            volts: [0.0; 4],
        };
        for i in from..last {
            let u = (samples.time[i] - start) / width;
            let mut power = 1.0;
            for k in 0..7 {
                moments.powers[k] += power;
                if k < 4 {
                    moments.volts[k] += power * samples.volts[i];
                }
                power *= u;
            }
        }
        moments
    }
}

/// Whether a cubic is all there is in the samples `from..to`.
fn follows(samples: &Samples<'_>, cubic: &Cubic, from: usize, to: usize) -> bool {
    let reach = samples.reach();
    let size = (to - from).div_ceil(FOLLOWED_PARTS).max(1);
    let mut start = from;
    while start < to {
        let end = (start + size).min(to);
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in start..end {
            let off = samples.volts[i] - cubic.shape.voltage(samples.time[i]);
            if off.is_nan() || off.abs() > reach {
                return false;
            }
            sum += off;
            squares += off * off;
        }
        let n = (end - start) as f64;
        let mean_limit =
            MAX_SPLINE_EXCESS_SIGMAS * samples.sigma / n.sqrt() + 0.5 * samples.quantum;
        let square_limit =
            samples.sigma * samples.sigma * (n + MAX_SPLINE_EXCESS_SIGMAS * (2.0 * n).sqrt());
        if sum.abs() / n > mean_limit || (samples.quantum == 0.0 && squares > square_limit) {
            return false;
        }
        start = end;
    }
    true
}

/// Square of the residuals' share of the first shape that a cubic has not, in units of its
/// variance: a spline too stiff by less than an interval alone shows leaves it in all of them.
fn bend(samples: &Samples<'_>, cubic: &Cubic, from: usize, to: usize) -> f64 {
    if samples.quantum > 0.0 || to < from + 8 {
        return 0.0;
    }
    let width = cubic.end - cubic.start;
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in from..to {
        let x = 2.0 * (samples.time[i] - cubic.start) / width - 1.0;
        // Legendre's polynomial of degree four.
        let shape = ((35.0 * x * x - 30.0) * x * x + 3.0) / 8.0;
        sum += shape * (samples.volts[i] - cubic.shape.voltage(samples.time[i]));
        squares += shape * shape;
    }
    sum * sum / (squares * samples.sigma * samples.sigma)
}

/// Straight lines from sample to sample.
fn straight(samples: &Samples<'_>) -> Vec<Cubic> {
    samples
        .time
        .windows(2)
        .zip(samples.volts.windows(2))
        .map(|(t, v)| Cubic {
            start: t[0],
            end: t[1],
            shape: Shape::Line {
                voltage: v[0],
                slope: (v[1] - v[0]) / (t[1] - t[0]),
                at: t[0],
            },
            sigma: samples.sigma,
        })
        .collect()
}

/// Least squares on the cubic B-splines of the knots. The normal matrix has three side diagonals;
/// its Cholesky factor too.
fn solve(samples: &Samples<'_>, knots: &[usize], moments: &[Moments]) -> Option<Vec<Cubic>> {
    let count = knots.len() - 1;
    let times: Vec<f64> = knots.iter().map(|&i| samples.time[i]).collect();
    // Knots beyond the ends, as far apart as the first and the last interval.
    let at = |k: isize| -> f64 {
        if k < 0 {
            times[0] + k as f64 * (times[1] - times[0])
        } else if k as usize > count {
            times[count] + (k as usize - count) as f64 * (times[count] - times[count - 1])
        } else {
            times[k as usize]
        }
    };
    let size = count + 3;
    let mut band = vec![[0.0f64; 4]; size];
    let mut right = vec![0.0f64; size];
    let mut bases = Vec::with_capacity(count);
    for k in 0..count {
        let basis = basis_of(&[
            at(k as isize - 2),
            at(k as isize - 1),
            at(k as isize),
            at(k as isize + 1),
            at(k as isize + 2),
            at(k as isize + 3),
        ]);
        let sums = &moments[k];
        let gram = SMatrix::<f64, 4, 4>::from_fn(|a, b| sums.powers[a + b]);
        let with_volts = SVector::<f64, 4>::from(sums.volts);
        let normal = basis.transpose() * gram * basis;
        let rhs = basis.transpose() * with_volts;
        for a in 0..4 {
            right[k + a] += rhs[a];
            for b in 0..=a {
                band[k + a][a - b] += normal[(a, b)];
            }
        }
        bases.push(basis);
    }
    // A trace of stiffness where knots are as close as samples.
    let scale = band.iter().map(|b| b[0]).fold(0.0, f64::max);
    band.iter_mut().for_each(|b| b[0] += 1e-13 * scale);
    let c = band_cholesky(&mut band, right)?;
    let cubics = (0..count)
        .map(|k| {
            let own = SVector::<f64, 4>::new(c[k], c[k + 1], c[k + 2], c[k + 3]);
            let p = bases[k] * own;
            let samples_here = (knots[k + 1] - knots[k]).max(1) as f64;
            Cubic {
                start: times[k],
                end: times[k + 1],
                shape: Shape::Cubic {
                    c: [p[0], p[1], p[2], p[3]],
                    at: times[k],
                    unit: times[k + 1] - times[k],
                },
                // A spline has one free number an interval.
                sigma: samples.sigma / samples_here.sqrt(),
            }
        })
        .collect();
    Some(cubics)
}

/// Solves `band x = right`; `band[i][j]` is the entry of row `i`, column `i - j`.
fn band_cholesky(band: &mut [[f64; 4]], mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    for i in 0..n {
        for j in (0..4.min(i + 1)).rev() {
            let column = i - j;
            let mut sum = band[i][j];
            for k in 1..4 - j {
                if column >= k {
                    sum -= band[i][j + k] * band[column][k];
                }
            }
            if j == 0 {
                if sum <= 0.0 || sum.is_nan() {
                    return None;
                }
                band[i][0] = sum.sqrt();
            } else {
                band[i][j] = sum / band[column][0];
            }
        }
        let mut value = right[i];
        for k in 1..4.min(i + 1) {
            value -= band[i][k] * right[i - k];
        }
        right[i] = value / band[i][0];
    }
    for i in (0..n).rev() {
        let mut value = right[i];
        for k in 1..4 {
            if i + k < n {
                value -= band[i + k][k] * right[i + k];
            }
        }
        right[i] = value / band[i][0];
    }
    Some(right)
}

/// The four B-splines that live between the middle two of six knots, as columns of coefficients
/// of powers of the interval's share (de Boor's recursion on polynomials).
fn basis_of(t: &[f64; 6]) -> SMatrix<f64, 4, 4> {
    let (start, width) = (t[2], t[3] - t[2]);
    // Order 1: only the spline of the interval itself.
    let mut splines: Vec<[f64; 4]> = vec![[1.0, 0.0, 0.0, 0.0]];
    for order in 2..=4usize {
        // Splines of this order that live here begin at knots 2 - (order - 1) ..= 2.
        let mut next = vec![[0.0; 4]; order];
        for (k, spline) in next.iter_mut().enumerate() {
            let first = 3 + k as isize - order as isize;
            let knot = |i: isize| -> f64 {
                // Outside the six only weights of splines that do not live here are asked.
                t[i.clamp(0, 5) as usize]
            };
            // Left parent begins at the same knot, right parent at the next.
            if k >= 1 {
                let (low, high) = (knot(first), knot(first + order as isize - 1));
                let parent = splines[k - 1];
                add_product(
                    spline,
                    parent,
                    (start - low) / (high - low),
                    width / (high - low),
                );
            }
            if k + 1 < order {
                let (low, high) = (knot(first + 1), knot(first + order as isize));
                let parent = splines[k];
                add_product(
                    spline,
                    parent,
                    (high - start) / (high - low),
                    -width / (high - low),
                );
            }
        }
        splines = next;
    }
    SMatrix::<f64, 4, 4>::from_fn(|power, k| splines[k][power])
}

/// Adds `(a + b u) parent(u)` to `spline`.
fn add_product(spline: &mut [f64; 4], parent: [f64; 4], a: f64, b: f64) {
    for power in 0..4 {
        spline[power] += a * parent[power];
        if power > 0 {
            spline[power] += b * parent[power - 1];
        }
    }
}
