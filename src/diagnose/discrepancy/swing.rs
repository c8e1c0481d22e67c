//! Whether what passes for a vibration of the base is one: a stiffness that comes and goes
//! swings as steadily, but pushes as much harder as the mass is farther out.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::diagnose::score_test::basis_forces::number;
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::spans;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::effects::{Action, ActiveEffect, EffectSpec, Kinematics, Need};
use crate::sim::SimError;

/// Share of the vibration's force that the size of the probe has at the greatest height.
const SMALL: f64 = 0.1;

static SPEC: EffectSpec = EffectSpec {
    id: "swinging_stiffness",
    name: "stiffness that comes and goes",
    sentence: "A stiffness that swings steadily.",
    law: "F = k sin(2 pi f t + phase) xp",
    needs: Need::Nothing,
    source: "",
    parameters: &[number("k"), number("f"), number("phase")],
    build: |values, _| {
        Box::new(Swing {
            stiffness: values[0],
            frequency: values[1],
            phase: values[2],
        })
    },
    ..EffectSpec::DEFAULT
};

#[derive(Debug)]
struct Swing {
    stiffness: f64,
    frequency: f64,
    phase: f64,
}

impl Action for Swing {
    fn does_nothing(&self) -> bool {
        self.stiffness == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        let turns = (self.frequency * at.t).fract();
        self.stiffness * (TAU * turns + self.phase).sin() * at.xp
    }
}

/// Fall of chi2 that a stiffness would bring that swings with the vibration of the base in
/// the fitted model; 0 without one.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn gain(fitted: &Fitted) -> Result<f64, SimError> {
    let model = &fitted.model;
    let named = model.effects.iter().find(|e| e.spec.is_base_sinusoid());
    let ((low, high), ..) = spans(fitted);
    let reach = low.abs().max(high.abs());
    let Some(vibration) = named.filter(|_| reach > 0.0) else {
        return Ok(0.0);
    };
    let force = vibration.values[0] / model.structure().mobility();
    let probe = |phase| ActiveEffect {
        spec: &SPEC,
        values: vec![SMALL * force / reach, vibration.values[1], phase],
    };
    let linear = Linearized::new(fitted)?;
    let scan = ScoreScan::of(&linear, model, &[probe(0.0), probe(FRAC_PI_2)])?;
    Ok(scan.joint(&[0, 1]).map_or(0.0, |joint| joint.gain))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::swing::*;
    use crate::diagnose::options::DiagnoseOptions;
    use crate::diagnose::shooting::workspace::Workspace;
    use crate::diagnose::test_support::QUIET;
    use crate::fit::Part;
    use crate::model::effects::find;
    use crate::model::preset::Preset;
    use crate::model::with_effect;
    use crate::recording::Recording;

    /// A mass on a spring that rings while `force(t, x)` acts on a unit of its mass, small
    /// steps of a symplectic rule.
    fn ring(force: &dyn Fn(f64, f64) -> f64, seed: u64) -> Part {
        let mut dice = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { (0..12).map(|_| dice.random_range(-0.5..0.5)).sum() };
        let (omega, zeta, h): (f64, f64, f64) = (8.6, 2e-3, 1e-4);
        let (mut x, mut v, mut t) = (0.1 + 0.01 * normal(), 0.0, 0.0);
        let (mut time, mut seen) = (Vec::new(), Vec::new());
        for step in 0..600_000 {
            if step % 100 == 0 {
                time.push(t);
                seen.push(x + 1e-4 * normal());
            }
            let a =
                |t: f64, x: f64, v: f64| force(t, x) - omega * omega * x - 2.0 * zeta * omega * v;
            let half = v + 0.5 * h * a(t, x, v);
            x += h * half;
            t += h;
            v = half + 0.5 * h * a(t, x, half);
        }
        let name = format!("ring {seed}");
        Part::whole(Arc::new(
            Recording::new(name, time, None, seen, None).unwrap(),
        ))
    }

    /// What a stiffness would bring beside a vibration of 3.1 Hz that was fitted.
    fn beside_a_vibration(force: &dyn Fn(f64, f64) -> f64) -> f64 {
        let model = Preset::embedded("oscillator").unwrap().model;
        let train = [ring(force, 1), ring(force, 2)];
        let workspace = Workspace::new(&model, &train, &[], &DiagnoseOptions::default()).unwrap();
        let base = workspace.baseline(&model, &QUIET).unwrap();
        assert_eq!(gain(&base).unwrap(), 0.0);
        let vibration = ActiveEffect {
            spec: find("base_vibration").unwrap(),
            values: vec![0.05, 3.1, 0.4],
        };
        let start = with_effect(&base.model, vibration);
        let free = ["base_vibration.a", "base_vibration.phase"].map(str::to_owned);
        let fitted = workspace.fit(&start, &free, &[], &base, 12, &QUIET);
        gain(&fitted.unwrap()).unwrap()
    }

    #[test]
    fn a_stiffness_that_comes_and_goes_shows_beside_a_vibration_and_not_where_there_is_none() {
        let swing = |t: f64| (TAU * 3.1 * t + 0.4).sin();
        let vibration = beside_a_vibration(&|t, _| -0.05 * swing(t));
        assert!(vibration < 15.0, "{vibration}");
        let stiffness = beside_a_vibration(&|t, x| -0.8 * swing(t) * (x + 0.06));
        assert!(stiffness > 100.0, "{stiffness}");
    }
}
