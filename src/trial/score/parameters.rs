//! True values of the parameters that a diagnosis states, where the concealed law has
//! the same parameter.

use super::reported::Named;
use crate::trial::one_mode::apparatus::OneModeDevice;
use crate::trial::truth::{DeviceTruth, Truth};

/// The masses of a trial are up to this much off those of the model, and no recording tells a
/// mass and a force apart: shapes within 3 % at the mass, squared, and the readings'
/// scale.
const OF_FORCE: f64 = 0.08;
/// The mass of a one-mode device, as it was weighed.
const OF_MASS: f64 = 0.01;
/// Scale of the readings.
const OF_LENGTH: f64 = 0.01;
/// Share of the base's motion that the modes see, and the readings' scale.
const OF_ACCELERATION: f64 = 0.04;
/// Clock of the readings against that of the voltage \[s\].
const OF_DELAY: f64 = 8e-6;

/// The truth about a parameter, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueValue {
    /// The value.
    pub value: f64,
    /// By how much the instruments can bias it, in ways that no recording determines.
    pub instrument_bias: f64,
}

/// The strength of a law of a one-mode device as a force in the recordings' own scale: a reading
/// `scale` times too large makes the strength `scale^power` times as large. The mass is known to 1 %.
fn of_one_mode(
    truth: &Truth,
    device: &OneModeDevice,
    law: &serde_json::Value,
    (effect, parameter): (&str, &str),
) -> Option<TrueValue> {
    let (path, power) = match (effect, parameter) {
        ("quadratic_drag", "cd") => ("/quadratic_drag/c", -1),
        ("dry_friction", "fc") => ("/dry_friction/a", 1),
        ("load_friction", "ml") => ("/load_friction/m", 0),
        ("cubic_stiffness", "k3") => ("/cubic_stiffness/k", -2),
        ("even_stiffness", "k2") => ("/even_stiffness/k", -1),
        _ => return None,
    };
    let value = device.mass * law.pointer(path)?.as_f64()?;
    let scale = (truth.instruments.scale_p.powi(power) - 1.0).abs();
    Some(TrueValue {
        value,
        instrument_bias: (OF_MASS + scale) * value.abs(),
    })
}

/// The true value of `parameter` of an effect that was named and is there; `None` where
/// the concealed formulation has no such parameter.
#[must_use]
pub fn true_value(truth: &Truth, named: &Named, parameter: &str) -> Option<TrueValue> {
    // The truth is in the units before they were changed.
    if truth.units.is_some() {
        return None;
    }
    let law = &truth.effects.iter().find(|e| e.id == named.id)?.law;
    if let DeviceTruth::OneMode(device) = &truth.device {
        return of_one_mode(truth, device, law, (&named.id, parameter));
    }
    let number = |path: &str| law.pointer(path).and_then(serde_json::Value::as_f64);
    let exact = |value: f64| TrueValue {
        value,
        instrument_bias: 0.0,
    };
    let within = |value: f64, share: f64| TrueValue {
        value,
        instrument_bias: share * value.abs(),
    };
    let stated = |id: &str| named.parameters.iter().find(|p| p.id == id);
    match (named.id.as_str(), parameter) {
        ("amplifier_lag", "tau") => {
            if let Some(lag) = number("/amplifier/lag") {
                return Some(exact(lag));
            }
            let first = number("/amplifier/first")?;
            (number("/amplifier/second")? == 0.0).then(|| exact(first))
        }
        ("amplifier_lag", "r") => number("/amplifier/rate").map(|rate| exact(1.0 / rate)),
        ("piezo_creep", "c" | "tau") => {
            let others = ["1", "2"].map(|k| number(&format!("/term/creep/compliance/{k}")));
            let path = if parameter == "c" {
                "/term/creep/compliance/0"
            } else {
                "/term/creep/tau/0"
            };
            // Of two elements neither is the one that there is.
            let one = stated("c2").is_none_or(|c2| c2.value == 0.0);
            (others == [Some(0.0); 2] && one).then_some(exact(number(path)?))
        }
        ("quadratic_drag", "cd") => Some(within(number("/term/drag/cd")?, OF_FORCE)),
        ("dry_friction", "fc") => Some(within(number("/friction")?, OF_FORCE)),
        ("film_spring", "tau") => {
            let tau = number("/film/tau")?;
            (number("/film/power")? == 0.0).then(|| exact(tau))
        }
        ("long_range_attraction", "n") => Some(exact(number("/term/power_attraction/power")?)),
        ("long_range_attraction", "A" | "h0") => {
            // Strength and range are those of one exponent, unless it is fitted with them.
            let (exponent, error) =
                stated("n").map_or((2.0, f64::INFINITY), |n| (n.value, n.std_error));
            let power = number("/term/power_attraction/power")?;
            if error.is_infinite() && (exponent - power).abs() > 0.25 {
                return None;
            }
            if parameter == "A" {
                Some(within(number("/term/power_attraction/a")?, OF_FORCE))
            } else {
                Some(within(number("/term/power_attraction/h0")?, OF_LENGTH))
            }
        }
        ("gap_step", "h" | "t0") => {
            // A step once in a series is another course than the catalogue's.
            if !law.pointer("/gap_step/once_in")?.is_null() {
                return None;
            }
            if parameter == "h" {
                Some(within(number("/gap_step/rise")?, OF_LENGTH))
            } else {
                Some(exact(number("/gap_step/time")?))
            }
        }
        ("base_vibration", "f") => Some(exact(number("/term/base/frequency")?)),
        ("base_vibration", "a") => {
            // A negative strength is another phase.
            let sign = stated("a").map_or(1.0, |a| a.value.signum());
            Some(within(sign * number("/term/base/a")?, OF_ACCELERATION))
        }
        ("zero_drift", "a") => {
            number("/drift/course/exponential")?;
            Some(within(number("/drift/amplitude")?, OF_LENGTH))
        }
        ("zero_drift", "tau") => Some(exact(number("/drift/course/exponential")?)),
        ("zero_drift", "b") => {
            let rate = number("/drift/amplitude")? / number("/drift/course/line")?;
            Some(within(rate, OF_LENGTH))
        }
        ("sensor_lag", "tau") => Some(exact(number("/term/sensor_lag/tau")?)),
        ("sensor_lag", "delay") => Some(TrueValue {
            value: number("/delay")?,
            instrument_bias: OF_DELAY,
        }),
        ("extra_mode", "f") => Some(exact(number("/mode/frequency")?)),
        ("extra_mode", "zeta") => Some(exact(number("/mode/zeta")?)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::*;
    use super::super::reported::{Estimate, Named};
    use crate::trial::draw::{Case, Mix, Settings};

    fn named(id: &str, parameters: &[(&str, f64)]) -> Named {
        Named {
            id: id.into(),
            probability: 1.0,
            confusion_group: Vec::new(),
            parameters: parameters
                .iter()
                .map(|(id, value)| Estimate {
                    id: (*id).into(),
                    value: *value,
                    std_error: 0.0,
                })
                .collect(),
        }
    }

    /// The first trial of an effect in a formulation that begins with `formulation`.
    fn truth(id: &str, formulation: &str) -> Truth {
        let settings = Settings {
            mix: Mix::Effect(id.to_owned()),
            rate: 2e3,
            ..Settings::default()
        };
        (0..40)
            .filter_map(|seed| Case::draw(seed, &settings).ok())
            .map(|case| case.into_parts().1.open().0)
            .find(|truth| truth.effects[0].formulation.starts_with(formulation))
            .unwrap()
    }

    #[test]
    fn values_are_found_in_the_laws_as_written() {
        for (id, formulation, parameters) in [
            ("amplifier_lag", "one resistor", &["tau"][..]),
            ("amplifier_lag", "bounded", &["tau", "r"]),
            ("piezo_creep", "one Kelvin", &["c", "tau"]),
            ("quadratic_drag", "wake", &["cd"]),
            ("dry_friction", "Coulomb", &["fc"]),
            ("film_spring", "constant", &["tau"]),
            ("gap_step", "in every", &["h", "t0"]),
            ("base_vibration", "sinusoid", &["a", "f"]),
            ("zero_drift", "exponential", &["a", "tau"]),
            ("zero_drift", "line", &["b"]),
            ("sensor_lag", "first", &["tau"]),
            ("sensor_lag", "pure", &["delay"]),
            ("extra_mode", "", &["f", "zeta"]),
        ] {
            let truth = truth(id, formulation);
            for parameter in parameters {
                let found = true_value(&truth, &named(id, &[]), parameter);
                let found = found.unwrap_or_else(|| panic!("{id} {parameter}"));
                assert!(
                    found.value != 0.0 && found.instrument_bias >= 0.0,
                    "{id} {parameter}"
                );
            }
        }
    }

    #[test]
    fn strengths_of_one_mode_devices_are_forces_on_the_mass() {
        for (id, parameter, path) in [
            ("quadratic_drag", "cd", "/quadratic_drag/c"),
            ("dry_friction", "fc", "/dry_friction/a"),
            ("cubic_stiffness", "k3", "/cubic_stiffness/k"),
            ("even_stiffness", "k2", "/even_stiffness/k"),
            ("load_friction", "ml", "/load_friction/m"),
        ] {
            let settings = Settings {
                mix: Mix::Effect(id.to_owned()),
                ..Settings::of_rig("spring")
            };
            let mut truth = Case::draw(3, &settings).unwrap().into_parts().1.open().0;
            let per_mass = truth.effects[0]
                .law
                .pointer(path)
                .unwrap()
                .as_f64()
                .unwrap();
            let DeviceTruth::OneMode(device) = truth.device.clone() else {
                panic!("{:?}", truth.device)
            };
            let found = true_value(&truth, &named(id, &[]), parameter).unwrap();
            assert!((found.value / (per_mass * device.mass) - 1.0).abs() < 1e-12);
            // In other units it is another number.
            truth.units = Some(crate::trial::rescale::UnitFactors {
                length: 2.0,
                time: 3.0,
                mass: 4.0,
            });
            assert_eq!(true_value(&truth, &named(id, &[]), parameter), None);
        }
    }

    #[test]
    fn other_formulations_have_no_such_parameter() {
        for (id, formulation, parameter) in [
            ("amplifier_lag", "ladder of two", "tau"),
            ("piezo_creep", "chain", "c"),
            ("film_spring", "time grows", "tau"),
            // A spring that levels off is a fifth weaker than its cubic one where the swing
            // is half as long as its limit.
            ("cubic_stiffness", "hardening", "k3"),
            ("gap_step", "once", "h"),
            ("zero_drift", "line", "a"),
            ("sensor_lag", "pure", "tau"),
            ("long_range_attraction", "patch", "A"),
        ] {
            let truth = truth(id, formulation);
            assert_eq!(true_value(&truth, &named(id, &[]), parameter), None, "{id}");
        }
        let one = truth("piezo_creep", "one Kelvin");
        let two = named("piezo_creep", &[("c", 0.02), ("c2", 0.01)]);
        assert_eq!(true_value(&one, &two, "c"), None);
        let truth = truth("long_range_attraction", "power");
        let power = truth.effects[0].law["term"]["power_attraction"]["power"].as_f64();
        let same = named("long_range_attraction", &[("n", power.unwrap())]);
        assert!(true_value(&truth, &same, "h0").is_some());
        let mut other = named("long_range_attraction", &[("n", 9.0)]);
        assert!(true_value(&truth, &other, "h0").is_some());
        other.parameters[0].std_error = f64::INFINITY;
        assert!(true_value(&truth, &other, "h0").is_none());
    }
}
