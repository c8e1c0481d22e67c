//! `piezo_creep`: the drive goes on growing slowly after a step of the voltage.
//!
//! Equation: `F = eta (gc + c z + c2 z2), tau z' = gc - z, tau2 z2' = gc - z2`.
//! Source: linear creep operator: Jung and Gweon, Rev. Sci. Instrum. 71, 1896 (2000).

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FormTolerance, FoundBy, Kinematics,
    Motion, Need, Quantity, RefinedBounds, Refinement, Search, Start,
};
use crate::model::parameter::{ParameterId, ParameterSpec, Parameters, Rank, Scale};
use crate::model::piezo::LARGEST_GAIN;

/// Factor between a time constant and the shorter and longer one that take its place in a first
/// guess of creep with two times.
const TIME_RATIO: f64 = 3.0;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "piezo_creep",
    name: "piezo creep",
    sentence: "After each step of the voltage the drive force keeps growing slowly; both readings show it, also while the mass is stuck.",
    law: "F = eta (gc + c z + c2 z2),  tau z' = gc - z,  tau2 z2' = gc - z2",
    source: "linear creep operator: Jung and Gweon, Rev. Sci. Instrum. 71, 1896 (2000)",
    needs: Need::Drive,
    parameters: &[
        ParameterSpec {
            id: "c",
            symbol: "c",
            name: "creep share",
            unit: "",
            default: 0.05,
            range: (-0.3, 0.3),
            limits: (-0.9, 10.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "what creep adds in the end, as a share of the drive",
            equation: "F = eta (gc + c z + c2 z2)",
        },
        ParameterSpec {
            id: "tau",
            symbol: "τ",
            name: "creep time",
            unit: "s",
            default: 20e-3,
            range: (1e-3, 1.0),
            limits: (1e-7, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "time over which the drive creeps on",
            equation: "tau z' = gc - z",
        },
        ParameterSpec {
            id: "c2",
            symbol: "c2",
            name: "second creep share",
            unit: "",
            default: 0.0,
            range: (-0.3, 0.3),
            limits: (-0.9, 10.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "what creep of a second time adds in the end, as a share of the drive; creep by the logarithm of time has many times",
            equation: "F = eta (gc + c z + c2 z2)",
        },
        ParameterSpec {
            id: "tau2",
            symbol: "τ2",
            name: "second creep time",
            unit: "s",
            default: 0.2,
            range: (1e-3, 1.0),
            limits: (1e-7, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "second time over which the drive creeps on",
            equation: "tau2 z2' = gc - z2",
        },
    ],
    build: |values, _| {
        let elements = values.chunks_exact(2).filter(|e| e[0] != 0.0);
        let (shares, rates) = elements.map(|e| (e[0], 1.0 / e[1])).unzip();
        Box::new(PiezoCreep { shares, rates })
    },
    facts: Facts {
        strengths: &["c", "c2"],
        largest_force: Some(largest_force),
        is_felt,
        feature_strength: Some("c"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        refinement: Some(Refinement {
            start: |values, _| with_two_times(values),
            bounds: RefinedBounds::Alike(&[(0, 2), (1, 3)]),
            simplified: with_one_time,
        }),
        form_errors,
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Residual(Quantity::Voltage),
};

/// Creep of one time, over three decades of it.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.is_driven {
        return Vec::new();
    }
    let one = |tau| Start::positive(&[0.02, tau, 0.0, tau], 0, &[0, 1]).shaped_by(&[2, 3]);
    [2e-3, 8e-3, 30e-3, 0.12, 0.5].map(one).to_vec()
}

/// Creep of one time as half of it each of a shorter and of a longer one.
fn with_two_times(values: &[f64]) -> Option<Vec<f64>> {
    let [share, tau, 0.0, _] = values[..] else {
        return None;
    };
    Some(vec![
        0.5 * share,
        tau / TIME_RATIO,
        0.5 * share,
        tau * TIME_RATIO,
    ])
}

/// Creep of two times as that of one between them.
fn with_one_time(values: &[f64]) -> Option<Vec<f64>> {
    let [share, tau, further, tau2] = values[..] else {
        return None;
    };
    let all = share + further;
    (share * further > 0.0).then(|| {
        vec![
            all,
            ((share * tau.ln() + further * tau2.ln()) / all).exp(),
            0.0,
            tau2,
        ]
    })
}

/// One more element in addition to those that there are.
fn form_errors(values: &[f64], tolerance: &FormTolerance) -> Vec<FormError> {
    let shares = values.iter().step_by(2);
    let own = values.chunks_exact(2).filter(|e| e[0] != 0.0);
    let times = own.flat_map(|e| tolerance.times.map(|factor| factor * e[1]));
    let share = tolerance.share * shares.sum::<f64>();
    times
        .map(|tau| FormError::Everywhere(vec![share, tau, 0.0, tau]))
        .collect()
}

/// Creep reaches this share of the drive's force.
fn largest_force(values: &[f64], parameters: &Parameters) -> f64 {
    let share = values[0] + values[2];
    share.abs() * parameters[ParameterId::Eta] * LARGEST_GAIN
}

/// Whether parameter number `i` bears on anything: see [`super::ActiveEffect::bears`].
fn is_felt(values: &[f64], i: usize) -> bool {
    i < 2 || values[2] != 0.0
}

#[derive(Debug)]
struct PiezoCreep {
    /// Share of each element, and the rate at which it settles \[1/s\].
    shares: Vec<f64>,
    rates: Vec<f64>,
}

impl PiezoCreep {
    fn creep(&self, z: &[f64]) -> f64 {
        self.shares.iter().zip(z).map(|(share, z)| share * z).sum()
    }
}

impl Action for PiezoCreep {
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
        let gain = at.gain - self.creep(z);
        for (input, rate) in inputs.iter_mut().zip(&self.rates) {
            *input = rate * gain;
        }
    }

    fn drive_gain(&self, gain: f64, _at: &Kinematics, z: &[f64]) -> f64 {
        gain + self.creep(z)
    }
}
