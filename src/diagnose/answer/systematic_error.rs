//! Systematic errors of parameters, which no recording determines: the scale of the readings, the
//! clock of the recorder, and the mass of the device. They are added to the statistical errors.

use crate::model::effects::EffectSpec;
use crate::model::parameter::ParameterSpec;

/// Standard error of the readings' scale, as a share: uniform within 1 % (the calibration of an
/// interferometer or a vibrometer).
const SCALE_ERROR: f64 = 0.006;
/// Standard error of the mass behind the mode shapes, as a share. An assumption, for a proof mass
/// known from its drawn size and density only.
const MASS_ERROR: f64 = 0.03;

/// Standard error of a time shift between voltage and reading \[s\]: uniform within 10 us. It cannot
/// be distinguished from a delay of the reading.
const CLOCK_ERROR: f64 = 5.8e-6;

/// Systematic standard error of the `value` of a parameter of an effect.
pub fn systematic_error(effect: &EffectSpec, parameter: &ParameterSpec, value: f64) -> f64 {
    let delay = effect.facts.reading_delay.map(|i| effect.parameters[i].id);
    if delay == Some(parameter.id) && value != 0.0 {
        CLOCK_ERROR
    } else {
        by_units(value, parameter.unit)
    }
}

/// Systematic standard error of `value`, in its SI `unit`, by scale and mass.
fn by_units(value: f64, unit: &str) -> f64 {
    let (mut length, mut mass) = (0.0, 0.0);
    let sides = match unit {
        // The slash is part of an exponent.
        "kg^-1/2" => [(1.0, "kg^-0.5"), (1.0, "")],
        _ => {
            let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
            [(1.0, above), (-1.0, below)]
        }
    };
    for (sign, factors) in sides {
        for factor in factors.split_whitespace() {
            let (symbol, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let power = sign * power.parse::<f64>().unwrap_or(1.0);
            match symbol {
                "m" => length += power,
                "kg" => mass += power,
                // kg m/s^2
                "N" => {
                    length += power;
                    mass += power;
                }
                _ => {}
            }
        }
    }
    value.abs() * (SCALE_ERROR * length).hypot(MASS_ERROR * mass)
}

#[cfg(test)]
mod tests {
    use super::super::systematic_error::*;
    use crate::model::effects::CATALOGUE;

    #[test]
    fn errors_scale_with_the_powers_of_length_and_mass() {
        for (unit, length, mass) in [
            ("s", 0.0, 0.0),
            ("m", 1.0, 0.0),
            ("m/s^2", 1.0, 0.0),
            ("N", 1.0, 1.0),
            ("N/m^3", -2.0, 1.0),
            ("N s^2/m^2", -1.0, 1.0),
            ("N/m^1.5", -0.5, 1.0),
            ("kg^-1/2", 0.0, -0.5),
            ("s/m", -1.0, 0.0),
            ("1/V", 0.0, 0.0),
        ] {
            let expected = 2.0 * f64::hypot(SCALE_ERROR * length, MASS_ERROR * mass);
            assert!((by_units(-2.0, unit) - expected).abs() < 1e-12, "{unit}");
        }
        let units = CATALOGUE.iter().flat_map(|e| e.parameters);
        assert!(units.into_iter().all(|p| by_units(1.0, p.unit) < 0.1));
    }
}
