//! What an effect that was named would leave behind if its law were of another form than
//! the catalogue's: the same force, somewhat larger or smaller in windows of height,
//! velocity or voltage, or beside it one of another time constant. A strong effect whose
//! law is a little off leaves more than a weak one brings, and must not be given a name
//! of its own for that.

use crate::diagnose::score_test::basis_forces;
use crate::diagnose::score_test::basis_forces::{Against, hat, side_by_side, window};
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::score_test::state_range::spans;
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

/// By what share a law may be off in a window.
const OFF: f64 = 0.3;
/// Windows of height, velocity or voltage.
const WINDOWS: usize = 5;
/// Time constants of kin, over that of the effect.
const TIMES: [f64; 3] = [0.2, 0.5, 3.0];
/// In place of a quantity where there is no window.
const NOWHERE: f64 = -1.0;
/// Values of the wrapped effect that are passed on.
const VALUES: usize = 11;
/// Values before those.
const OWN: usize = 4;

static SPEC: EffectSpec = EffectSpec {
    id: "kin",
    name: "kin of an effect",
    sentence: "An effect of the catalogue, in a window of one quantity.",
    law: "F = hat((u - middle) / width) F0",
    needs: Need::Nothing,
    source: "",
    parameters: &PARAMETERS,
    build: |values, around| {
        let index = (values[0].max(0.0) as usize).min(CATALOGUE.len() - 1);
        let spec = CATALOGUE[index];
        let own = &values[OWN..OWN + spec.parameters.len().min(VALUES)];
        Box::new(Kin {
            inner: (spec.build)(own, around),
            against: Against::of(values[1]),
            middle: values[2],
            width: values[3],
        })
    },
    ..EffectSpec::DEFAULT
};

static PARAMETERS: [ParameterSpec; OWN + VALUES] = [
    basis_forces::number("which"),
    basis_forces::number("against"),
    basis_forces::number("middle"),
    basis_forces::number("width"),
    basis_forces::number("a"),
    basis_forces::number("b"),
    basis_forces::number("c"),
    basis_forces::number("d"),
    basis_forces::number("e"),
    basis_forces::number("f"),
    basis_forces::number("g"),
    basis_forces::number("h"),
    basis_forces::number("i"),
    basis_forces::number("j"),
    basis_forces::number("k"),
];

/// `effect` with other values, wrapped so that it stands beside the effect itself; in a
/// window of a quantity if there is one.
fn wrapped(
    effect: &ActiveEffect,
    values: &[f64],
    window: Option<(Against, f64, f64)>,
) -> Option<ActiveEffect> {
    let index = CATALOGUE.iter().position(|e| *e == effect.spec)?;
    let (against, middle, width) = window.map_or((NOWHERE, 0.0, 1.0), |(against, m, w)| {
        (against.number(), m, w)
    });
    let mut all = vec![index as f64, against, middle, width];
    all.extend_from_slice(values);
    all.resize(OWN + VALUES, 0.0);
    Some(ActiveEffect {
        spec: &SPEC,
        values: all,
    })
}

/// Directions of kin of an effect, each of the size by which its law may be off.
fn directions(effect: &ActiveEffect, fitted: &Fitted) -> Vec<ActiveEffect> {
    let (height, speed, volts) = spans(fitted);
    let windows = |over: Quantity| -> Vec<(Against, f64, f64)> {
        let (against, range) = match over {
            Quantity::Displacement => (Against::Height, height),
            Quantity::Velocity => (Against::Velocity, speed),
            Quantity::Voltage => (Against::Voltage, volts),
        };
        let (middles, width) = side_by_side(range, WINDOWS).unwrap_or_default();
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
        share: OFF,
        times: TIMES,
        volts,
    };
    let all = (effect.spec.search.form_errors)(&effect.values, &tolerance);
    all.into_iter().flat_map(expand).collect()
}

/// Fall of chi2 that kin of `named` would bring at a fit, none of them larger than the
/// share by which a law may be off.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn form_error_gain(fitted: &Fitted, named: &[&'static EffectSpec]) -> Result<f64, SimError> {
    let own = |e: &&ActiveEffect| named.contains(&e.spec);
    let of = |e: &ActiveEffect| directions(e, fitted);
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
    // All stand side by side, of which a model has one each by kind: one after the other.
    let scan = ScoreScan::of(&linear, &fitted.model, &probes)?;
    Ok(scan.within(1.0).map_or(0.0, |joint| joint.gain))
}

/// An effect in a window: of those places where the effects that have kin by being wrapped
/// attach.
#[derive(Debug)]
struct Kin {
    inner: Box<dyn Action>,
    against: Option<Against>,
    middle: f64,
    width: f64,
}

impl Kin {
    /// How much of the effect there is, by the window that it is in.
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

impl Action for Kin {
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
        // Its states are no readings.
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
    fn kin_is_the_effect_itself_in_a_window() {
        let cubic = ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![2e4, -2e12],
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
    fn loops_in_a_window_of_voltage_are_those_of_the_effect_there() {
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
    fn every_effect_fits_into_its_kin() {
        for effect in CATALOGUE {
            assert!(effect.parameters.len() <= VALUES, "{}", effect.id);
        }
    }
}
