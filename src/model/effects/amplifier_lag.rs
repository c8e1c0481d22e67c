//! `amplifier_lag`: the film sees the voltage late, through the amplifier's resistance.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::drive::{Segment, Shape};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::piezo::Branch;

/// Step of the search for the turn of the lagged voltage [time constants].
const SEARCH_STEP: f64 = 0.25;
/// Steps of that search: after so long nothing of the past is left.
const SEARCH_STEPS: usize = 400;
/// Difference of the voltages that counts as none, as a share of them.
const EQUAL: f64 = 1e-12;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "amplifier_lag",
    name: "amplifier lag",
    sentence: "The amplifier charges the film with a delay, so that voltage edges excite the modes less.",
    law: "gc(V_l, V_l'),  tau V_l' = V - V_l",
    source: "first-order charging of the film's capacitance through the source resistance",
    needs: Need::Drive,
    parameters: &[ParameterSpec {
        id: "tau",
        symbol: "τ",
        name: "time constant",
        unit: "s",
        default: 50e-6,
        range: (0.0, 1e-3),
        limits: (0.0, 1e3),
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning: "resistance times capacitance; 100 kohm into 1.3 nF is 130 us",
        equation: "tau V_l' = V - V_l",
    }],
    build: |values, _| {
        Box::new(AmplifierLag {
            tau: values[0],
            rates: if values[0] > 0.0 {
                vec![1.0 / values[0]]
            } else {
                Vec::new()
            },
        })
    },
};

/// State: the lagged voltage [V].
#[derive(Debug)]
struct AmplifierLag {
    tau: f64,
    rates: Vec<f64>,
}

/// Points and weights of Gauss-Legendre quadrature on 0..1.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

impl AmplifierLag {
    /// The lagged voltage `h` later than it was `lagged` at `t`.
    fn later(&self, shape: &Shape, lagged: f64, t: f64, h: f64) -> f64 {
        let input: f64 = GAUSS
            .iter()
            .map(|(place, weight)| {
                weight * shape.voltage(t + place * h) * (-(1.0 - place) * h / self.tau).exp()
            })
            .sum();
        lagged * (-h / self.tau).exp() + h / self.tau * input
    }

    /// When voltage and lagged voltage meet, if they do before `end`.
    fn meeting(&self, shape: &Shape, lagged: f64, start: f64, end: f64) -> Option<f64> {
        let ahead = |t: f64, lagged: f64| shape.voltage(t) - lagged;
        let sign = ahead(start, lagged).signum();
        let (mut t, mut lagged) = (start, lagged);
        for _ in 0..SEARCH_STEPS {
            let h = (SEARCH_STEP * self.tau).min(end - t);
            let next = self.later(shape, lagged, t, h);
            if ahead(t + h, next) * sign <= 0.0 {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let there = self.later(shape, lagged, t, middle);
                    if ahead(t + middle, there) * sign <= 0.0 {
                        high = middle;
                    } else {
                        low = middle;
                    }
                }
                return Some(t + high);
            }
            t += h;
            lagged = next;
            if t >= end {
                return None;
            }
        }
        None
    }
}

impl Action for AmplifierLag {
    fn does_nothing(&self) -> bool {
        self.rates.is_empty()
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn state_inputs(&self, at: &Kinematics, _z: &[f64], inputs: &mut [f64]) {
        if let ([rate], [input]) = (self.rates.as_slice(), inputs) {
            *input = rate * at.voltage;
        }
    }

    /// The branch follows the sign of `V_l' = (V - V_l) / tau`. Over a segment the voltage
    /// moves one way; where it has just turned, the lagged one turns when they meet.
    fn piece(&self, segment: Segment, t: f64, z: &[f64]) -> Segment {
        let (&[lagged], false) = (z, segment.branch == Branch::Poled) else {
            return segment;
        };
        let voltage = segment.shape.voltage(t);
        let ahead = voltage - lagged;
        let branch = if ahead > 0.0 {
            Branch::Rising
        } else {
            Branch::Falling
        };
        if ahead.abs() <= EQUAL * voltage.abs().max(lagged.abs()) || branch == segment.branch {
            return segment;
        }
        let moves = !matches!(segment.shape, Shape::Constant { .. });
        let end = moves.then(|| self.meeting(&segment.shape, lagged, t, segment.end));
        Segment {
            end: end.flatten().unwrap_or(segment.end),
            branch,
            ..segment
        }
    }

    fn drive_voltage(&self, voltage: f64, _at: &Kinematics, z: &[f64]) -> f64 {
        z.first().copied().unwrap_or(voltage)
    }
}
