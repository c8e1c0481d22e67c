//! Whether neighbouring responses part.

use super::coordinates::Scale;
use super::error::SteadyError;
use super::stroboscope::Stroboscope;
use crate::sim::{MotionPhase, MotionState};

/// Distance to which a neighbour is brought back after each period, as a share of the response.
const NEIGHBOUR_DISTANCE: f64 = 1e-6;
/// An exponent above this is chaos \[1/period\]: neighbours part by a factor of e in 20 periods.
pub(super) const CHAOTIC_EXPONENT: f64 = 0.05;

/// Largest Lyapunov exponent \[1/period\] over `periods` from `start` (G. Benettin et al., Meccanica
/// 15 (1980) 9): the mean growth of a neighbour's distance, which is brought back after each period.
/// A neighbour that moves in another way has parted as far as responses can.
pub(super) fn lyapunov_exponent(
    stroboscope: &mut Stroboscope,
    scale: &Scale,
    start: &MotionState,
    periods: usize,
) -> Result<Option<f64>, SteadyError> {
    let mut reference = start.clone();
    let mut neighbour = beside(&reference);
    let mut growth = 0.0;
    for _ in 0..periods {
        let before = scale.distance(&reference, &neighbour);
        if !(before > 0.0 && before.is_finite()) {
            return Ok(None);
        }
        let (_, next) = stroboscope.map(&reference, 1)?;
        let (_, other) = stroboscope.map(&neighbour, 1)?;
        let after = scale.distance(&next, &other);
        // Nothing can be told below rounding.
        growth += (after.clamp(f64::EPSILON, 1.0) / before).ln();
        neighbour = if after.is_finite() && after > f64::EPSILON {
            closer(&next, &other, NEIGHBOUR_DISTANCE / after)
        } else {
            beside(&next)
        };
        reference = next;
    }
    Ok((periods > 0).then(|| growth / periods as f64))
}

/// A neighbour of a state.
fn beside(state: &MotionState) -> MotionState {
    let mut other = state.clone();
    let (q, v) = (&mut other.coordinates.q, &mut other.coordinates.v);
    for x in q.iter_mut().chain(v) {
        *x *= 1.0 + NEIGHBOUR_DISTANCE;
    }
    other
}

/// The state at `share` of the way from `state` to `other`, which moves in the same way.
fn closer(state: &MotionState, other: &MotionState, share: f64) -> MotionState {
    let mut between = state.clone();
    let mix = |a: &mut [f64], b: &[f64]| {
        a.iter_mut()
            .zip(b)
            .for_each(|(a, b)| *a += share * (b - *a));
    };
    let (a, b) = (&mut between.coordinates, &other.coordinates);
    mix(&mut a.q, &b.q);
    mix(&mut a.v, &b.v);
    if let (MotionPhase::Held { since, .. }, MotionPhase::Held { since: later, .. }) =
        (&mut between.phase, other.phase)
    {
        *since += share * (later - *since);
    }
    between
}
