//! What the samples leave open of a cycle: directions in which its numbers may be off together.
//!
//! On a coarse digitiser a level is known to half a step and a ramp's slope far better: another
//! level means corners earlier or later along the ramp. Each direction is such a joint change, by one
//! standard deviation, independent of the others.

use nalgebra::{DMatrix, SymmetricEigen};

use super::estimate::{Estimate, estimate};
use super::open_numbers::{Numbers, STEP, Spread};
use super::tie::{classes, common};
use super::waveform::Cycle;
use crate::recording::measured_drive::knots::{Knot, Knots};
use crate::recording::measured_drive::round_number::is_two_digit_setting;
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    BOUNDED_SPREAD_REACH_SIGMAS, CLOCK_INTERVALS, JUMP_RESPONSE_TIME, MAX_OPEN_DIRECTIONS,
    NOISE_REACH_SIGMAS, PERIOD_STEPS, ROUNDING_ERROR_REACH_SIGMAS, UNNOTICED_DIRECTION_SHARE,
    UNSEEN_DIGITISER_STEPS,
};

/// The cycle under which `samples` are likeliest. Instants of jumps, and then the period, are held:
/// between two samples all are alike.
pub fn likeliest(samples: &Samples<'_>, cycle: &Cycle) -> Option<Estimate> {
    let jumps = cycle.knots.iter().any(|k| k.jumps());
    estimate(samples, cycle, quantum_of(samples, cycle), |numbers, k| {
        if k == STEP {
            return !jumps;
        }
        (0..cycle.knots.len()).all(|j| numbers.time(j) != k || !cycle.knots[j].jumps())
    })
}

/// Step of the digitiser \[V\] that counts, else 0.
fn quantum_of(samples: &Samples<'_>, cycle: &Cycle) -> f64 {
    // Levels alone do not show the step of a digitiser. Where they have no noise, it is larger than
    // the noise was.
    let levels = cycle.knots.iter().all(|k| k.jumps());
    let amplitude = cycle.amplitude();
    if levels && !samples.is_noisy() && !is_two_digit_setting(amplitude) {
        return samples
            .quantum
            .max(2.0 * amplitude / UNSEEN_DIGITISER_STEPS);
    }
    samples.quantum
}

/// Standard deviations within which the numbers of `cycle` lie: rounding has limits, noise has not.
pub fn reach_sigmas(samples: &Samples<'_>, cycle: &Cycle) -> f64 {
    if quantum_of(samples, cycle) > 0.0 {
        ROUNDING_ERROR_REACH_SIGMAS
    } else {
        NOISE_REACH_SIGMAS
    }
}

/// What is open of the estimated cycle that `knots`, found in `part` of the samples, repeat.
pub fn of(part: &Samples<'_>, knots: &Knots, estimate: &Estimate) -> Option<Spread> {
    let (cycle, numbers) = (&estimate.cycle, &estimate.numbers);
    let mut covariance = estimate.covariance().clone();
    add_jumps(&mut covariance, part, knots, cycle, numbers);
    let weights = weights(part, cycle, numbers);
    let n = numbers.len();
    let weighted = DMatrix::from_fn(n, n, |a, b| weights[a] * weights[b] * covariance[(a, b)]);
    if weighted.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::new(weighted);
    let least = UNNOTICED_DIRECTION_SHARE * part.span();
    let mut order: Vec<usize> = (0..n)
        .filter(|&k| eigen.eigenvalues[k] > least * least)
        .collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    order.truncate(MAX_OPEN_DIRECTIONS);
    let direction = |k: usize| -> Vec<f64> {
        let size = eigen.eigenvalues[k].sqrt();
        let own = eigen.eigenvectors.column(k);
        (0..n)
            .map(|a| {
                if weights[a] > 0.0 {
                    size * own[a] / weights[a]
                } else {
                    0.0
                }
            })
            .collect()
    };
    Some(Spread {
        numbers: numbers.clone(),
        directions: order.into_iter().map(direction).collect(),
        is_period_set: false,
        most: if quantum_of(part, cycle) > 0.0 || cycle.knots.iter().any(Knot::jumps) {
            BOUNDED_SPREAD_REACH_SIGMAS
        } else {
            NOISE_REACH_SIGMAS
        },
    })
}

/// By how much a change of each number changes the voltage \[V per unit\].
fn weights(samples: &Samples<'_>, cycle: &Cycle, numbers: &Numbers) -> Vec<f64> {
    let slope = |k: i64| {
        let (a, b) = (cycle.knot(k), cycle.knot(k + 1));
        ((b.before - a.after) / (b.time - a.time)).abs()
    };
    let mut weights = vec![1.0; numbers.len()];
    let mut largest = 0.0f64;
    for (j, knot) in cycle.knots.iter().enumerate() {
        let k = j as i64;
        let of_jump = (knot.after - knot.before).abs() / JUMP_RESPONSE_TIME;
        weights[numbers.time(j)] = slope(k).max(slope(k - 1)).max(of_jump);
        largest = largest.max(weights[numbers.time(j)]);
    }
    let span = samples.in_time();
    weights[STEP] = largest * (0.5 * (span.last - span.first) / cycle.step()).max(1.0);
    weights
}

/// Adds the second moments of the step and the jumps' instants about the estimate: all steps that
/// put every jump between the samples where it was seen are as likely as the room they leave.
fn add_jumps(
    covariance: &mut DMatrix<f64>,
    part: &Samples<'_>,
    knots: &Knots,
    cycle: &Cycle,
    numbers: &Numbers,
) {
    let count = cycle.knots.len();
    let jumps: Vec<usize> = (0..count).filter(|&j| cycle.knots[j].jumps()).collect();
    if jumps.is_empty() {
        return;
    }
    let inner = &knots.0[1..knots.0.len() - 1];
    let classes = classes(part, inner, count);
    let fuzz = CLOCK_INTERVALS * part.interval;
    let (low, high) = cycle.period_bounds;
    let (low, high) = (low / cycle.factor(), high / cycle.factor());
    let mut total = 0.0;
    let mut moments = DMatrix::<f64>::zeros(numbers.len(), numbers.len());
    for i in 0..PERIOD_STEPS {
        let step = low + (high - low) * (i as f64 + 0.5) / PERIOD_STEPS as f64;
        let rooms: Vec<(f64, f64)> = jumps.iter().map(|&j| common(&classes[j], step)).collect();
        let weight: f64 = rooms.iter().map(|r| (r.1 - r.0).max(fuzz) / fuzz).product();
        let mut off = vec![(STEP, step - cycle.step())];
        for (&j, room) in jumps.iter().zip(&rooms) {
            let middle = 0.5 * (room.0 + room.1) + numbers.turn() * step;
            let k = numbers.time(j);
            off.push((k, middle - numbers.value(cycle, k)));
            moments[(k, k)] += weight * (room.1 - room.0).powi(2) / 12.0;
        }
        for &(a, x) in &off {
            for &(b, y) in &off {
                moments[(a, b)] += weight * x * y;
            }
        }
        total += weight;
    }
    if total > 0.0 && total.is_finite() {
        *covariance += moments / total;
    }
}
