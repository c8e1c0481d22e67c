//! `amplifier_lag`: the film sees the voltage late, through the amplifier's resistance or
//! because the amplifier's current, and with it the pace of the voltage, is bounded. With
//! both it slews first and settles exponentially in the end.
//!
//! Equation: `gc(V_l, V_l'), tau V_l' = V - V_l, |V_l'| <= 1/r`.
//! Source: first-order charging of the film's capacitance through the source resistance; slew
//! rate and settling as in the data sheets of amplifiers: bounded current into that
//! capacitance, an exponential once the current needed is below the bound.

use super::{
    Action, EdgeLag, EffectSpec, EvidenceFigure, Facts, FormError, FormTolerance, FoundBy,
    Kinematics, LagKind, Motion, Need, Quantity, RefinedBounds, Refinement, Search, Start,
    followed_time_constant,
};
use crate::model::bisection::bisect;
use crate::model::drive::{Segment, Shape};
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::piezo::Branch;
use crate::model::slew_rate_limiter::{MEMORY, SlewRateLimiter};

/// Step of the search for instants of the lagged voltage [time constants].
const SEARCH_STEP: f64 = 0.25;
/// Steps of that search: after so long nothing of the past is left.
const SEARCH_STEPS: usize = 400;
/// Difference of the voltages that counts as none, as a share of them.
const EQUAL: f64 = 1e-12;

/// Shortest time constant that is looked for \[s\].
const SHORTEST_LAG: f64 = 1e-6;
/// Share of its delay that an amplifier with both lags owes to the bounded rate in a first guess.
const DELAY_SHARE_OF_RATE: f64 = 0.75;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "amplifier_lag",
    name: "amplifier lag",
    sentence: "The amplifier charges the film with a delay, so that voltage edges excite the modes less.",
    law: "gc(V_l, V_l'),  tau V_l' = V - V_l,  |V_l'| <= 1/r",
    source: "first-order charging of the film's capacitance through the source resistance; slew rate and settling as in the data sheets of amplifiers: bounded current into that capacitance, an exponential once the current needed is below the bound",
    needs: Need::Drive,
    parameters: &[
        ParameterSpec {
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
        },
        ParameterSpec {
            id: "r",
            symbol: "r",
            name: "inverse slew rate",
            unit: "s/V",
            default: 0.0,
            range: (0.0, 1e-4),
            limits: (0.0, 1e3),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "reciprocal of the slew rate: capacitance over largest current; 1 mA into 10 nF is 10 us/V; 0: the amplifier follows any edge",
            equation: "|V_l'| <= 1/r",
        },
    ],
    build: |values, _| {
        let (mut tau, pace) = (values[0], values[1]);
        let mut rates = Vec::new();
        if tau > 0.0 {
            tau = followed_time_constant(tau);
            rates.push(1.0 / tau);
        }
        if pace > 0.0 {
            rates.extend([0.0; MEMORY]);
        }
        Box::new(AmplifierLag {
            tau,
            slew: (pace > 0.0).then(|| SlewRateLimiter {
                pace,
                slack: tau / pace,
            }),
            rates,
        })
    },
    facts: Facts {
        strengths: &["tau", "r"],
        edge_lags: &[
            EdgeLag {
                parameter: 0,
                kind: LagKind::DriveSettles,
            },
            EdgeLag {
                parameter: 1,
                kind: LagKind::DriveSlews,
            },
        ],
        twin_in_flight: Some("sensor_lag"),
        feature_strength: Some("tau"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        refinement: Some(Refinement {
            start: with_both_lags,
            bounds: RefinedBounds::ShortestLag(0, SHORTEST_LAG),
            simplified: |_| None,
        }),
        form_errors,
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Residual(Quantity::Voltage),
};

/// A time constant or a bounded rate, of different sizes.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.is_driven {
        return Vec::new();
    }
    let settles = |tau| Start::positive(&[tau, 0.0], 0, &[0]).shaped_by(&[1]);
    let slews = |pace| Start::positive(&[0.0, pace], 1, &[1]).shaped_by(&[0]);
    let settling = [SHORTEST_LAG, 3e-6, 1e-5, 5e-5, 2e-4].map(settles);
    let slewing = [1e-6, 5e-6, 2e-5].map(slews);
    settling.into_iter().chain(slewing).collect()
}

/// Values with both a time constant and a bounded rate, as late as before for an edge of `edge()`
/// \[V\]. Where one of the two is zero, or too small for the other to matter, no slope leads away
/// from there; `None` where both are above zero.
fn with_both_lags(values: &[f64], edge: &dyn Fn() -> f64) -> Option<Vec<f64>> {
    let [tau, pace] = values[..] else {
        return None;
    };
    if tau > 0.0 && pace > 0.0 {
        return None;
    }
    let edge = Some(edge()).filter(|e| *e > 0.0)?;
    let late = tau + 0.5 * pace * edge;
    // Bound by its pace for so long, it is late by r V/2 + tau^2 / (2 r V).
    let pace = 2.0 * DELAY_SHARE_OF_RATE * late / edge;
    let tau = (2.0 * (1.0 - DELAY_SHARE_OF_RATE) * late * pace * edge).sqrt();
    Some(vec![tau, pace])
}

/// A first-order lag or a bounded rate of another size, or the one that is as late in place of
/// the other.
fn form_errors(values: &[f64], tolerance: &FormTolerance) -> Vec<FormError> {
    let [tau, pace] = values[..] else {
        return Vec::new();
    };
    let volts = tolerance.volts;
    let swing = (0.5 * (volts.1 - volts.0)).max(1e-9);
    let of_tau = tolerance.scaled(values, 0);
    let of_pace = tolerance.scaled(values, 1);
    let all = match (tau > 0.0, pace > 0.0) {
        (true, true) => [of_tau, of_pace],
        (true, false) => [of_tau, vec![0.0, tau / swing]],
        _ => [of_pace, vec![pace * swing, 0.0]],
    };
    all.into_iter().map(FormError::Everywhere).collect()
}

/// States: the lagged voltage \[V\] if there is a time constant, then what a bounded pace
/// remembers if there is one.
#[derive(Debug)]
struct AmplifierLag {
    tau: f64,
    slew: Option<SlewRateLimiter>,
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
    /// Where the memory of the pace begins among the effect's states.
    fn first(&self) -> usize {
        usize::from(self.tau > 0.0)
    }

    /// The lagged voltage, if there is a time constant, and the memory of the pace.
    fn parts<'a>(&self, z: &'a [f64]) -> (Option<f64>, &'a [f64]) {
        let (lagged, memory) = z.split_at(self.first());
        (lagged.first().copied(), memory)
    }

    /// The lagged voltage `h` later than it was `lagged` at `t`, while it settles.
    fn later(&self, shape: &Shape, lagged: f64, t: f64, h: f64) -> f64 {
        let input: f64 = GAUSS
            .iter()
            .map(|(place, weight)| {
                weight * shape.voltage(t + place * h) * (-(1.0 - place) * h / self.tau).exp()
            })
            .sum();
        lagged * (-h / self.tau).exp() + h / self.tau * input
    }

    /// The first instant at which `holds` is true of how far the voltage is ahead of the lagged
    /// one \[V\], while that settles, if it does before `end`.
    fn instant(
        &self,
        shape: &Shape,
        lagged: f64,
        (start, end): (f64, f64),
        holds: &dyn Fn(f64) -> bool,
    ) -> Option<f64> {
        let (mut t, mut lagged) = (start, lagged);
        for _ in 0..SEARCH_STEPS {
            let h = (SEARCH_STEP * self.tau).min(end - t);
            let next = self.later(shape, lagged, t, h);
            if holds(shape.voltage(t + h) - next) {
                let after = bisect(0.0, h, |h| {
                    holds(shape.voltage(t + h) - self.later(shape, lagged, t, h))
                });
                return Some(t + after);
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
    fn acts_on_drive(&self) -> bool {
        true
    }

    fn does_nothing(&self) -> bool {
        self.rates.is_empty()
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn states_feel_motion(&self) -> bool {
        false
    }

    fn state_inputs(&self, at: &Kinematics, z: &[f64], inputs: &mut [f64]) {
        inputs.fill(0.0);
        if self.tau > 0.0 {
            let (_, memory) = self.parts(z);
            let bound = self.slew.and_then(|s| s.bound(at.voltage, at.t, memory));
            inputs[0] = match bound {
                // What the relaxation takes is given back: the line is exact.
                Some((own, rate)) => self.rates[0] * own + rate,
                None => self.rates[0] * at.voltage,
            };
        }
    }

    fn settle(&self, at: &Kinematics, z: &mut [f64]) {
        if self.slew.is_some() {
            z[self.first()..].copy_from_slice(&[at.voltage, at.t]);
        }
    }

    fn end_piece(&self, at: &Kinematics, _film: f64, z: &mut [f64]) {
        if let Some(slew) = self.slew {
            let (lagged, memory) = self.parts(z);
            let bound = || slew.bound(at.voltage, at.t, memory);
            let level = match lagged {
                Some(lagged) => bound().map_or(lagged, |(own, _)| own),
                None => slew.follow(at.voltage, at.t, memory),
            };
            slew.remember(level, at.t, &mut z[self.first()..]);
        }
    }

    /// The branch follows the sign of the film's voltage's change. Over a segment the voltage
    /// moves one way; where it has just turned, what lags behind it turns when they meet.
    fn piece(&self, segment: Segment, t: f64, z: &[f64]) -> Segment {
        let (lagged, memory) = self.parts(z);
        let mut piece = segment;
        let toward = |ahead: f64| match segment.branch {
            Branch::Poled => Branch::Poled,
            _ if ahead > 0.0 => Branch::Rising,
            _ => Branch::Falling,
        };
        if let Some(slew) = self.slew {
            let course = slew.course(&segment, t, memory);
            piece.end = course.end;
            if course.direction != 0.0 {
                piece.branch = toward(course.direction);
                return piece;
            }
        }
        let Some(lagged) = lagged else {
            return piece;
        };
        let shape = &segment.shape;
        if let Some(slew) = self.slew
            && shape.slope(t).abs() > 1.0 / slew.pace
        {
            // Looked through as far as the search goes.
            let far = t + SEARCH_STEP * SEARCH_STEPS as f64 * self.tau;
            piece.end = piece.end.min(far);
            let outrun = |ahead: f64| ahead.abs() > slew.slack;
            if let Some(end) = self.instant(shape, lagged, (t, piece.end), &outrun) {
                piece.end = end;
            }
        }
        if segment.branch == Branch::Poled {
            return piece;
        }
        let now = shape.voltage(t);
        let ahead = now - lagged;
        let branch = toward(ahead);
        if ahead.abs() <= EQUAL * now.abs().max(lagged.abs()) || branch == piece.branch {
            return piece;
        }
        if !matches!(shape, Shape::Constant { .. }) {
            let met = |then: f64| then * ahead <= 0.0;
            let end = self.instant(shape, lagged, (t, piece.end), &met);
            piece.end = end.unwrap_or(piece.end);
        }
        Segment { branch, ..piece }
    }

    fn drive_voltage(&self, voltage: f64, at: &Kinematics, z: &[f64]) -> f64 {
        let (lagged, memory) = self.parts(z);
        lagged.unwrap_or_else(|| {
            self.slew
                .map_or(voltage, |slew| slew.follow(voltage, at.t, memory))
        })
    }
}
