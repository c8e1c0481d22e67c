//! Ranges of the sliders from the device's own lengths, times and forces.

use std::collections::BTreeMap;

use crate::model::Model;
use crate::model::parameter::{ParameterId, Scale};
use crate::model::piezo::Branch;

/// Factor by which a frequency may be off either way: beyond, it is another device.
const FREQUENCY_FACTOR: f64 = 5.0;
/// The same for a damping ratio or a force, of which only the order of magnitude is known.
const LOG_FACTOR: f64 = 30.0;
/// The same for the film's coefficient, whose gap is often badly known.
const FILM_FACTOR: f64 = 100.0;
/// Factors of distances.
const DISTANCE_FACTORS: (f64, f64) = (0.3, 3.0);
/// Noise over the device's travel up to which a slider goes.
const NOISE_SHARE: f64 = 0.01;
/// Largest damping ratio of a slider: critical.
const MAX_ZETA: f64 = 1.0;

/// The length that the device moves over \[m\]: its static motion at `voltage`, its start, its ground;
/// 1 m where nothing tells.
fn travel(model: &Model, voltage: f64) -> f64 {
    use ParameterId as P;
    let p = &model.parameters;
    let mut scale = p[P::X0].abs();
    if model.has_ground {
        scale = scale.max(p[P::Dp]);
    }
    if let (Some(piezo), Some(gain)) = (&model.piezo, model.structure().static_gain()) {
        let largest = [voltage, -voltage]
            .map(|v| piezo.gain(v, Branch::Rising).abs())
            .into_iter()
            .fold(0.0, f64::max);
        scale = scale.max((p[P::Eta] * gain * largest).abs());
    }
    if scale > 0.0 && scale.is_finite() {
        scale
    } else {
        1.0
    }
}

/// Ranges of all parameters of the device that the table's range does not suit. `voltage` is the
/// amplitude of its usual drive \[V\].
pub fn slider_ranges(model: &Model, voltage: f64) -> BTreeMap<ParameterId, (f64, f64)> {
    use ParameterId as P;
    let p = &model.parameters;
    let length = travel(model, voltage);
    let slowest = model.modes.iter().map(|m| m.frequency).filter(|f| *f > 0.0);
    let slowest = slowest.fold(f64::INFINITY, f64::min);
    let omega = std::f64::consts::TAU
        * if slowest.is_finite() {
            slowest
        } else {
            1.0 / length.sqrt()
        };
    // A force that moves the device over its travel, by its spring or in one swing.
    let force = length * omega * omega / model.structure().mobility();
    let around = |value: f64, factor: f64, otherwise: f64| {
        let middle = if value > 0.0 { value } else { otherwise };
        (middle / factor, middle * factor)
    };
    let mut ranges = BTreeMap::new();
    for id in P::ALL.into_iter().filter(|id| model.uses(*id)) {
        let value = p[id];
        let range = match id {
            P::F1 | P::F2 if value > 0.0 => around(value, FREQUENCY_FACTOR, 1.0),
            P::F1 | P::F2 => continue,
            P::Zeta1 | P::Zeta2 => {
                let (low, high) = around(value, LOG_FACTOR, 0.01);
                (low.min(0.1), high.min(MAX_ZETA).max(1.5 * value))
            }
            P::Eta => around(value, LOG_FACTOR, force),
            P::Cs => around(value, FILM_FACTOR, film_scale(model, force, length, omega)),
            P::Ca0 => around(value, FILM_FACTOR, 0.1 * force),
            P::Ca => around(value, FILM_FACTOR, force * omega / std::f64::consts::TAU),
            P::Dp | P::Gp => (DISTANCE_FACTORS.0 * value, DISTANCE_FACTORS.1 * value),
            P::X0 | P::OffsetP | P::OffsetC => (-2.0 * length, 2.0 * length),
            P::V0 => (-2.0 * length * omega, 2.0 * length * omega),
            P::Noise => (0.0, NOISE_SHARE * length),
            P::Alpha | P::ShapeC1 | P::ShapeC2 | P::ShapeP2 | P::DriveP => continue,
        };
        let range = (round_number(range.0), round_number(range.1));
        let spec = id.spec();
        let allowed = spec.refusal(range.0).is_none() && spec.refusal(range.1).is_none();
        let increasing = range.0 < range.1 && (spec.scale == Scale::Linear || range.0 > 0.0);
        if allowed && increasing && range != spec.range {
            ranges.insert(id, range);
        }
    }
    ranges
}

/// A coefficient whose film is felt at contact: its force equals `force` at the speed of a swing.
fn film_scale(model: &Model, force: f64, length: f64, omega: f64) -> f64 {
    use ParameterId as P;
    let p = &model.parameters;
    force * (p[P::Gp] - p[P::Dp]).abs().powi(3) / (length * omega)
}

/// The number of two digits near a value.
pub(super) fn round_number(value: f64) -> f64 {
    let text = format!("{value:.1e}");
    text.parse().unwrap_or(value)
}
