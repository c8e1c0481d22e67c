//! The same device in other units: all lengths, times and masses multiplied, voltages as they are.
//! A diagnosis must answer as before.

use serde::{Deserialize, Serialize};

use crate::model::parameter::{ParameterId, Scale};
use crate::model::preset::{Preset, PresetError};

/// By what lengths, times and masses are multiplied.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UnitFactors {
    /// Of lengths.
    pub length: f64,
    /// Of times.
    pub time: f64,
    /// Of masses.
    pub mass: f64,
}

impl UnitFactors {
    /// The factor of a quantity with this SI unit, such as `N m^2 s` or `m/s^2`; `None` if the unit
    /// is not known. Volts stay.
    #[must_use]
    pub fn of(&self, unit: &str) -> Option<f64> {
        // The only fraction among the powers, of the shapes of modes.
        let unit = unit.replace("^-1/2", "^-0.5");
        let mut factor = 1.0;
        for (part, sign) in unit.splitn(2, '/').zip([1.0, -1.0]) {
            let part = part.trim_matches(['(', ')', ' ']);
            for token in part
                .split([' ', '/'])
                .filter(|t| !t.is_empty() && *t != "1")
            {
                let (name, power) = token.split_once('^').unwrap_or((token, "1"));
                factor *= self
                    .of_symbol(name)?
                    .powf(sign * power.parse::<f64>().ok()?);
            }
        }
        Some(factor)
    }

    fn of_symbol(&self, name: &str) -> Option<f64> {
        Some(match name {
            "m" => self.length,
            "s" => self.time,
            "kg" => self.mass,
            "Hz" => 1.0 / self.time,
            "N" => self.mass * self.length / (self.time * self.time),
            "V" | "rad" => 1.0,
            _ => return None,
        })
    }

    /// The preset of the same device in the other units, as a person would write it: what acts on it
    /// is in the recordings, its drive is rest.
    ///
    /// # Errors
    /// [`PresetError`] if the device in these units is none that a preset can hold.
    pub fn preset(&self, preset: &Preset) -> Result<Preset, PresetError> {
        let mut other = preset.clone();
        let model = &mut other.model;
        for id in ParameterId::ALL {
            if let Some(factor) = self.of(id.spec().unit).filter(|f| *f != 1.0) {
                model.parameters.set(id, factor * model.parameters.get(id));
                let (low, high) = preset.range(id);
                let range = (factor * low, factor * high);
                if model.uses(id) && may_be_range(id, range) {
                    other.ranges.insert(id, range);
                }
            }
        }
        for known in &mut other.known {
            let factor = model.unit_of(&known.id).and_then(|unit| self.of(unit));
            let factor = factor.unwrap_or(1.0);
            known.value *= factor;
            known.std_error *= factor;
        }
        let shape = self.mass.sqrt().recip();
        for mode in &mut model.modes {
            mode.frequency /= self.time;
            mode.phi_c *= shape;
            mode.phi_p *= shape;
            mode.phi_drive *= shape;
        }
        model.proof_mass *= self.mass;
        for effect in &mut model.effects {
            for (spec, value) in effect.spec.parameters.iter().zip(&mut effect.values) {
                *value *= self.of(spec.unit).unwrap_or(1.0);
            }
        }
        other.about = format!("{}, in other units", preset.about);
        other.drive = "rest".to_owned();
        other.duration = (preset.duration * self.time).min(1e6);
        Preset::parse("the rescaled preset", &other.to_toml())
    }
}

fn may_be_range(id: ParameterId, (low, high): (f64, f64)) -> bool {
    let spec = id.spec();
    let positive = spec.scale == Scale::Linear || low > 0.0;
    low < high && positive && spec.refusal(low).is_none() && spec.refusal(high).is_none()
}

#[cfg(test)]
mod tests {
    use super::super::rescale::*;
    use crate::model::drive::Waveform;
    use crate::model::effects::CATALOGUE;
    use crate::sim::{Options, simulate};

    const UNITS: UnitFactors = UnitFactors {
        length: 30.0,
        time: 0.2,
        mass: 500.0,
    };

    #[test]
    fn units_are_multiplied_by_their_dimension() {
        let newton = 500.0 * 30.0 / 0.04;
        for (unit, factor) in [
            ("", 1.0),
            ("m", 30.0),
            ("Hz", 5.0),
            ("m/s^2", 30.0 / 0.04),
            ("N m^2 s", newton * 900.0 * 0.2),
            ("N s^2/m^2", newton * 0.04 / 900.0),
            ("1/s", 5.0),
            ("N/m^1.5", newton / 30f64.powf(1.5)),
            ("kg^-1/2", 500f64.powf(-0.5)),
        ] {
            let found = UNITS.of(unit).unwrap();
            assert!((found / factor - 1.0).abs() < 1e-12, "{unit}: {found}");
        }
        assert_eq!(UNITS.of("candela"), None);
        // Those of all parameters are known, so that no preset is half rescaled.
        let own = ParameterId::ALL.map(|id| id.spec().unit);
        let of_effects = CATALOGUE
            .iter()
            .flat_map(|e| e.parameters.iter().map(|p| p.unit));
        for unit in own.into_iter().chain(of_effects) {
            assert!(UNITS.of(unit).is_some(), "{unit}");
        }
    }

    #[test]
    fn what_is_known_is_known_in_the_other_units() {
        let acceleration = UNITS.length / (UNITS.time * UNITS.time);
        for name in ["faller", "bouncing-ball"] {
            let own = Preset::embedded(name).unwrap();
            let other = UNITS.preset(&own).unwrap();
            let [before, after] = [&own, &other].map(|p| p.known[0].clone());
            assert_eq!(
                (before.id.as_str(), after.id.as_str()),
                ("gravity.g", "gravity.g")
            );
            let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
            assert!(near(after.value, acceleration * before.value));
            assert!(near(after.std_error, acceleration * before.std_error));
            assert!(near(after.value, other.model.get("gravity.g").unwrap()));
        }
    }

    #[test]
    fn a_rescaled_device_moves_as_before_in_its_own_units() {
        let paper = Preset::embedded("paper").unwrap();
        let other = UNITS.preset(&paper).unwrap();
        let run = |preset: &Preset, time: f64, length: f64| {
            let drive = Waveform::Square {
                frequency: 40.0 / time,
                amplitude: 8.0,
            };
            let plain = Options::default();
            let options = Options {
                rate: 20e3 / time,
                tolerance: plain.tolerance * length,
                ..plain
            };
            simulate(&preset.model, &drive, 0.02 * time, &options).unwrap()
        };
        let a = run(&paper, 1.0, 1.0);
        let b = run(&other, UNITS.time, UNITS.length);
        assert_eq!(a.proof_mass.len(), b.proof_mass.len());
        let largest = a.proof_mass.iter().fold(0.0f64, |w, x| w.max(x.abs()));
        for (x, y) in a.proof_mass.iter().zip(&b.proof_mass) {
            assert!((x - y / UNITS.length).abs() < 1e-4 * largest);
        }
    }
}
