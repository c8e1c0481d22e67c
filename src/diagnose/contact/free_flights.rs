//! Bounces of a free mass from the parabolas of its flights, without a level of the ground and without
//! a model of its contacts.

use nalgebra::{DMatrix, DVector};

use crate::fit::Part;
use crate::fit::contact_readings::Bounce;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::recording::events::turning_points::turning_points;

/// Samples at either end of a flight that a contact may have touched.
const END_SAMPLES: usize = 1;
/// Samples of a flight from which its parabola is known with an error.
const MIN_SAMPLES: usize = 6;

/// Whether nothing but gravity and the gas acts on the device between its contacts.
pub fn is_free(model: &Model) -> bool {
    model.has_ground && model.parameters[ParameterId::F1] <= 0.0 && model.piezo.is_none()
}

/// Bounces in each of `parts`, whose noise is `noise` \[m\].
pub fn bounces(parts: &[Part], noise: f64) -> Vec<Bounce> {
    let all = parts.iter().enumerate();
    all.flat_map(|(k, part)| of_recording(k, part, noise))
        .collect()
}

fn of_recording(k: usize, part: &Part, noise: f64) -> Vec<Bounce> {
    let r = &part.recording;
    let (time, xp) = (
        &r.time[part.samples.clone()],
        &r.proof_mass[part.samples.clone()],
    );
    let axis = crate::recording::TimeAxis::Samples(time);
    let turns: Vec<f64> = turning_points(axis, xp, noise)
        .iter()
        .map(|t| t.time)
        .collect();
    let begins = std::iter::once(f64::NEG_INFINITY).chain(turns.iter().copied());
    let ends = turns.iter().copied().chain([f64::INFINITY]);
    let flights: Vec<Option<Parabola>> = begins
        .zip(ends)
        .map(|(begin, end)| Parabola::between(time, xp, (begin, end), noise))
        .collect();
    let both = flights.windows(2).zip(&turns);
    both.filter_map(|(pair, turn)| {
        let [Some(before), Some(after)] = pair else {
            return None;
        };
        let (down, up) = (before.slope(*turn), after.slope(*turn));
        let ratio = -up.0 / down.0;
        let error = (up.1 / up.0).hypot(down.1 / down.0) * ratio.abs();
        (down.0 < 0.0 && up.0 > 0.0).then_some(Bounce {
            recording: k,
            time: *turn,
            approach: -down.0,
            departure: up.0,
            ratio,
            error,
            miss: 0.0,
            // The height of the ground is not asked.
            miss_error: f64::INFINITY,
            shared: 0.0,
            flight: after.samples as f64,
        })
    })
    .collect()
}

/// The parabola of a flight.
struct Parabola {
    origin: f64,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
    samples: usize,
}

impl Parabola {
    /// That of the samples between two instants; `None` if they are few.
    fn between(time: &[f64], xp: &[f64], (begin, end): (f64, f64), noise: f64) -> Option<Self> {
        let first = time.partition_point(|t| *t <= begin);
        let last = time.partition_point(|t| *t < end);
        let inner = if begin.is_finite() { END_SAMPLES } else { 0 };
        let outer = if end.is_finite() { END_SAMPLES } else { 0 };
        let range = (first + inner)..last.saturating_sub(outer).max(first + inner);
        let points: Vec<(f64, f64)> = range
            .map(|i| (time[i], xp[i]))
            .filter(|p| p.1.is_finite())
            .collect();
        if points.len() < MIN_SAMPLES {
            return None;
        }
        let origin = points[points.len() / 2].0;
        let matrix = DMatrix::from_fn(points.len(), 3, |i, j| {
            (points[i].0 - origin).powi(i32::try_from(j).unwrap_or(0))
        });
        let right = DVector::from_iterator(points.len(), points.iter().map(|p| p.1));
        let inverse = matrix.tr_mul(&matrix).try_inverse()?;
        let coefficients = &inverse * matrix.tr_mul(&right);
        let left = (right - matrix * &coefficients).norm_squared() / (points.len() - 3) as f64;
        Some(Self {
            origin,
            coefficients,
            // What no parabola describes counts as noise.
            covariance: inverse * left.max(noise * noise),
            samples: points.len(),
        })
    }

    /// Slope at `t` \[s\] and its standard error \[m/s\].
    fn slope(&self, t: f64) -> (f64, f64) {
        let row = DVector::from_vec(vec![0.0, 1.0, 2.0 * (t - self.origin)]);
        let variance = (row.transpose() * &self.covariance * &row)[0];
        (row.dot(&self.coefficients), variance.max(0.0).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::recording::Recording;

    #[test]
    fn restitution_of_a_falling_ball_is_read_without_a_level() {
        // Falls from rest, leaves the ground with 0.7, then with 0.8 of its speed.
        let (g, dt) = (9.81, 2e-3);
        let mut xp = Vec::new();
        let (mut height, mut speed) = (0.2, 0.0);
        let mut ratios = [0.7, 0.8, 0.85].into_iter();
        for _ in 0..450 {
            xp.push(height - 0.05);
            let fall = |t: f64| (height + speed * t - 0.5 * g * t * t, speed - g * t);
            let (next, down) = fall(dt);
            if next > 0.0 {
                (height, speed) = (next, down);
                continue;
            }
            let Some(ratio) = ratios.next() else { break };
            let hit = (speed + f64::sqrt(speed * speed + 2.0 * g * height)) / g;
            let up = ratio * (g * hit - speed);
            let left = dt - hit;
            (height, speed) = (up * left - 0.5 * g * left * left, up - g * left);
        }
        let time = (0..xp.len()).map(|i| dt * i as f64).collect();
        let ball = Recording::new("ball", time, None, xp, None).unwrap();
        let found = bounces(&[Part::whole(Arc::new(ball))], 1e-6);
        assert!(found.len() >= 2, "{}", found.len());
        for (bounce, ratio) in found.iter().zip([0.7, 0.8]) {
            assert!((bounce.ratio - ratio).abs() < 1e-3, "{}", bounce.ratio);
        }
    }
}
