//! Form errors: what a named effect would leave behind if its law had another form than the
//! catalogue's. That is the same force, somewhat larger or smaller in windows of height, velocity
//! or voltage, or in addition one of another time constant. A strong effect whose law is slightly
//! wrong leaves more than a weak effect brings, and its residual must not be named as another
//! effect.

use crate::diagnose::score_test::basis_forces;
use crate::diagnose::score_test::basis_forces::{Against, hat, window, window_grid};
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::state_ranges;
use crate::diagnose::shooting::fitted::Fitted;
use crate::model::drive::Segment;
use crate::model::effects::{
    Action, ActiveEffect, CATALOGUE, EffectSpec, FormError, FormTolerance, Kinematics, Need,
    Quantity,
};
use crate::model::parameter::ParameterSpec;
use crate::model::piezo::Branch;
use crate::model::sensor::Point;
use crate::sim::SimError;

/// Relative error of a law in a window.
const MAX_FORM_ERROR: f64 = 0.3;
/// Windows of height, velocity or voltage.
const WINDOW_COUNT: usize = 5;
/// Time constants of form errors, relative to that of the effect.
const TIME_CONSTANT_FACTORS: [f64; 3] = [0.2, 0.5, 3.0];
/// In place of a quantity where there is no window.
const NO_WINDOW: f64 = -1.0;
/// Number of values passed on to the wrapped effect.
const WRAPPED_VALUES: usize = 11;
/// Number of values before those.
const WRAPPER_VALUES: usize = 4;

static SPEC: EffectSpec = EffectSpec {
    id: "other_form",
    name: "other form of an effect",
    sentence: "An effect of the catalogue, in a window of one quantity.",
    law: "F = hat((u - middle) / width) F0",
    needs: Need::Nothing,
    source: "",
    parameters: &PARAMETERS,
    build: |values, around| {
        let index = (values[0].max(0.0) as usize).min(CATALOGUE.len() - 1);
        let spec = CATALOGUE[index];
        let own =
            &values[WRAPPER_VALUES..WRAPPER_VALUES + spec.parameters.len().min(WRAPPED_VALUES)];
        Box::new(WindowedEffect {
            inner: (spec.build)(own, around),
            against: Against::of(values[1]),
            middle: values[2],
            width: values[3],
        })
    },
    ..EffectSpec::DEFAULT
};

static PARAMETERS: [ParameterSpec; WRAPPER_VALUES + WRAPPED_VALUES] = [
    basis_forces::numeric_parameter("which"),
    basis_forces::numeric_parameter("against"),
    basis_forces::numeric_parameter("middle"),
    basis_forces::numeric_parameter("width"),
    basis_forces::numeric_parameter("a"),
    basis_forces::numeric_parameter("b"),
    basis_forces::numeric_parameter("c"),
    basis_forces::numeric_parameter("d"),
    basis_forces::numeric_parameter("e"),
    basis_forces::numeric_parameter("f"),
    basis_forces::numeric_parameter("g"),
    basis_forces::numeric_parameter("h"),
    basis_forces::numeric_parameter("i"),
    basis_forces::numeric_parameter("j"),
    basis_forces::numeric_parameter("k"),
];

/// `effect` with other values, wrapped so that a model can contain it in addition to the effect
/// itself; in a window of a quantity if one is given.
fn wrapped(
    effect: &ActiveEffect,
    values: &[f64],
    window: Option<(Against, f64, f64)>,
) -> Option<ActiveEffect> {
    let index = CATALOGUE.iter().position(|e| *e == effect.spec)?;
    let (against, middle, width) = window.map_or((NO_WINDOW, 0.0, 1.0), |(against, m, w)| {
        (against.number(), m, w)
    });
    let mut all = vec![index as f64, against, middle, width];
    all.extend_from_slice(values);
    all.resize(WRAPPER_VALUES + WRAPPED_VALUES, 0.0);
    Some(ActiveEffect {
        spec: &SPEC,
        values: all,
    })
}

/// Directions of the form errors of an effect, each of the size by which its law may be wrong.
fn form_errors(effect: &ActiveEffect, fitted: &Fitted) -> Vec<ActiveEffect> {
    let (height, speed, volts) = state_ranges(fitted);
    let windows = |over: Quantity| -> Vec<(Against, f64, f64)> {
        let (against, range) = match over {
            Quantity::Displacement => (Against::Height, height),
            Quantity::Velocity => (Against::Velocity, speed),
            Quantity::Voltage => (Against::Voltage, volts),
        };
        let (middles, width) = window_grid(range, WINDOW_COUNT).unwrap_or_default();
        middles.into_iter().map(|m| (against, m, width)).collect()
    };
    let forces = |against: Option<Against>, over: Quantity, size: f64| -> Vec<ActiveEffect> {
        let all = windows(over).into_iter();
        all.map(|(own, middle, width)| window(against.unwrap_or(own), middle, width, size))
            .collect()
    };
    let expand = |error: FormError| -> Vec<ActiveEffect> {
        match error {
            FormError::Everywhere(values) => wrapped(effect, &values, None).into_iter().collect(),
            FormError::InWindows(values, over) => windows(over)
                .into_iter()
                .filter_map(|w| wrapped(effect, &values, Some(w)))
                .collect(),
            FormError::ForceInWindows(size, over) => forces(None, over, size),
            FormError::DriveInWindows(size) => {
                forces(Some(Against::Drive), Quantity::Voltage, size)
            }
        }
    };
    let tolerance = FormTolerance {
        share: MAX_FORM_ERROR,
        times: TIME_CONSTANT_FACTORS,
        volts,
    };
    let all = (effect.spec.search.form_errors)(&effect.values, &tolerance);
    all.into_iter().flat_map(expand).collect()
}

/// Fall of chi2 that form errors of the effects `named` would bring at a fit, each under a prior
/// of the size by which a law may be wrong.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn form_error_gain(fitted: &Fitted, named: &[&'static EffectSpec]) -> Result<f64, SimError> {
    let own = |e: &&ActiveEffect| named.contains(&e.spec);
    let of = |e: &ActiveEffect| form_errors(e, fitted);
    let probes: Vec<ActiveEffect> = fitted
        .model
        .effects
        .iter()
        .filter(own)
        .flat_map(of)
        .collect();
    if probes.is_empty() {
        return Ok(0.0);
    }
    let linear = Linearized::new(fitted)?;
    // A model holds one effect of a kind, so that each is tested in turn.
    let scan = ScoreScan::of_effects(&linear, &fitted.model, &probes)?;
    Ok(scan.joint_with_prior(1.0).map_or(0.0, |joint| joint.gain))
}

/// An effect in a window, at those places where effects with windowed form errors act.
#[derive(Debug)]
struct WindowedEffect {
    inner: Box<dyn Action>,
    against: Option<Against>,
    middle: f64,
    width: f64,
}

impl WindowedEffect {
    /// Share of the effect that acts in the window.
    fn share(&self, at: &Kinematics) -> f64 {
        let within = |u: f64| hat(u, self.middle, self.width);
        match self.against {
            Some(Against::Height) => within(at.xp),
            Some(Against::Velocity) => within(at.vp),
            Some(_) => within(at.voltage),
            None => 1.0,
        }
    }
}

impl Action for WindowedEffect {
    fn does_nothing(&self) -> bool {
        self.inner.does_nothing()
    }

    fn state_rates(&self) -> &[f64] {
        self.inner.state_rates()
    }

    fn pace(&self, at: &Kinematics) -> f64 {
        self.inner.pace(at)
    }

    fn lasting(&self) -> f64 {
        self.inner.lasting()
    }

    fn acts_on_motion(&self) -> bool {
        // Its states are not readings.
        self.inner.acts_on_motion() || !self.inner.state_rates().is_empty()
    }

    fn states_are_forces(&self) -> bool {
        self.inner.states_are_forces()
    }

    fn state_inputs(&self, at: &Kinematics, z: &[f64], inputs: &mut [f64]) {
        self.inner.state_inputs(at, z, inputs);
    }

    fn settle(&self, at: &Kinematics, z: &mut [f64]) {
        self.inner.settle(at, z);
    }

    fn piece(&self, segment: Segment, t: f64, z: &[f64]) -> Segment {
        self.inner.piece(segment, t, z)
    }

    fn end_piece(&self, at: &Kinematics, film: f64, z: &mut [f64]) {
        self.inner.end_piece(at, film, z);
    }

    fn hysteresis(&self, gain: f64, voltage: f64, branch: Branch, z: &[f64]) -> f64 {
        let at = Kinematics {
            voltage,
            ..Kinematics::default()
        };
        gain + self.share(&at) * (self.inner.hysteresis(gain, voltage, branch, z) - gain)
    }

    fn drive_voltage(&self, voltage: f64, at: &Kinematics, z: &[f64]) -> f64 {
        self.inner.drive_voltage(voltage, at, z)
    }

    fn drive_gain(&self, gain: f64, at: &Kinematics, z: &[f64]) -> f64 {
        gain + self.share(at) * (self.inner.drive_gain(gain, at, z) - gain)
    }

    fn force_on_proof_mass(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.share(at) * self.inner.force_on_proof_mass(at, z)
    }

    fn friction(&self, xp: f64) -> f64 {
        let at = Kinematics {
            xp,
            ..Kinematics::default()
        };
        self.share(&at) * self.inner.friction(xp)
    }

    fn friction_varies(&self) -> bool {
        self.inner.friction_varies()
    }

    fn film_force(&self, film: f64, z: &[f64]) -> f64 {
        self.inner.film_force(film, z)
    }

    fn base_acceleration(&self, t: f64) -> f64 {
        self.inner.base_acceleration(t)
    }

    fn reading(&self, reading: f64, point: Point, t: f64, z: &[f64]) -> f64 {
        self.inner.reading(reading, point, t, z)
    }
}

#[cfg(test)]
mod tests {
    use super::super::law_form::*;
    use crate::diagnose::answer::effect_size::action;
    use crate::model::effects::find;
    use crate::model::preset::Preset;

    fn force(effect: &ActiveEffect, at: &Kinematics) -> f64 {
        let model = Preset::embedded("paper").unwrap().model;
        action(effect, &model).force_on_proof_mass(at, &[])
    }

    #[test]
    fn a_windowed_effect_equals_the_effect_in_its_window() {
        let cubic = ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![2e4, -2e12, 0.0],
        };
        let at = |xp: f64| Kinematics {
            xp,
            ..Kinematics::default()
        };
        let own = force(&cubic, &at(-4e-5));
        assert!(own > 0.0);
        let tenth: Vec<f64> = cubic.values.iter().map(|k| 0.1 * k).collect();
        let less = force(&wrapped(&cubic, &tenth, None).unwrap(), &at(-4e-5));
        assert!((less - 0.1 * own).abs() < 1e-12 * own, "{less} {own}");
        let whole = wrapped(&cubic, &cubic.values, None).unwrap();
        assert_eq!(force(&whole, &at(-4e-5)), own);
        let window = (Against::Height, -4e-5, 1e-5);
        let part = wrapped(&cubic, &cubic.values, Some(window)).unwrap();
        assert_eq!(force(&part, &at(-4e-5)), own);
        assert_eq!(force(&part, &at(-2e-5)), 0.0);
        let share = force(&part, &at(-4.5e-5)) / force(&cubic, &at(-4.5e-5));
        assert!((share - 0.5).abs() < 1e-9, "{share}");
    }

    #[test]
    fn windowed_hysteresis_loops_equal_those_of_the_effect_in_the_window() {
        let loops = ActiveEffect {
            spec: find("hysteresis_memory").unwrap(),
            values: vec![1.0, 1.0, 8.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let model = Preset::embedded("paper").unwrap().model;
        let gain = |effect: &ActiveEffect, voltage: f64| {
            let action = action(effect, &model);
            let mut z = vec![0.0; action.state_rates().len()];
            for extreme in [4.0, -4.0] {
                let at = Kinematics {
                    voltage: extreme,
                    ..Kinematics::default()
                };
                action.end_piece(&at, extreme, &mut z);
            }
            action.hysteresis(2.0, voltage, Branch::Rising, &z) - 2.0
        };
        let window = (Against::Voltage, 1.0, 2.0);
        let part = wrapped(&loops, &loops.values, Some(window)).unwrap();
        assert!(gain(&loops, 1.0).abs() > 0.1);
        assert_eq!(gain(&part, 1.0), gain(&loops, 1.0));
        assert_eq!(gain(&part, -1.5), 0.0);
        let share = gain(&part, 2.0) / gain(&loops, 2.0);
        assert!((share - 0.5).abs() < 1e-9, "{share}");
    }

    #[test]
    fn every_effect_fits_into_the_wrapper() {
        for effect in CATALOGUE {
            assert!(effect.parameters.len() <= WRAPPED_VALUES, "{}", effect.id);
        }
    }
}
