//! Quantities as people write them: `58 um`, `2e-21`, `15Hz`, `27.43 nN`.
//!
//! Everything inside the program is SI `f64`; this file is the only place that
//! knows prefixes. Texts use `u` for micro where a file is written and `µ` on
//! screen; both, and the Greek letter U+03BC, are read.

mod coordinate;

use std::f64::consts::PI;
use std::time::Duration;

use thiserror::Error;

pub use self::coordinate::Coordinate;

/// Why a text could not be read as a quantity.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitError {
    /// The numeric part is missing or malformed.
    #[error("\"{0}\" is not a number; write for example \"58 um\", \"2e-21\" or \"15 Hz\"")]
    NotANumber(String),
    /// The unit is not the expected one, with or without a prefix.
    #[error(
        "\"{unit}\" is not a unit of this quantity; write it in {expected}, a prefix (n, u, m, k) is fine"
    )]
    WrongUnit { unit: String, expected: String },
    /// The number is NaN or infinite.
    #[error("\"{0}\" is not a finite number")]
    NotFinite(String),
}

/// SI prefixes that are read, with their powers of ten.
const PREFIXES: [(&str, i32); 11] = [
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("\u{b5}", -6),
    ("\u{3bc}", -6),
    ("m", -3),
    ("c", -2),
    ("", 0),
    ("k", 3),
    ("M", 6),
    ("G", 9),
];

/// Units of one quantity that are no SI unit with a prefix: text, the SI unit, factor.
const OTHER_UNITS: [(&str, &str, f64); 12] = [
    ("deg", "rad", PI / 180.0),
    ("\u{b0}", "rad", PI / 180.0),
    ("rev", "rad", 2.0 * PI),
    ("deg/s", "rad/s", PI / 180.0),
    ("rpm", "rad/s", 2.0 * PI / 60.0),
    ("km/h", "m/s", 1.0 / 3.6),
    ("m/min", "m/s", 1.0 / 60.0),
    ("dyn", "N", 1e-5),
    // Forces of balances and tensile testers, by standard gravity.
    ("gf", "N", 9.80665e-3),
    ("kgf", "N", 9.80665),
    ("t", "kg", 1e3),
    ("g/cm^3", "kg/m^3", 1e3),
];

/// Factor that turns a number in `unit` into the SI `base` unit, or `None` if
/// `unit` is not `base` with an optional prefix, or another unit of that quantity: degrees
/// for `rad`, grams for `kg`, `gf` for `N`. An empty `unit` counts as `base`.
///
/// `unit_factor("um", "m") == Some(1e-6)`; `unit_factor("ms", "m") == None`.
///
/// # Examples
/// ```
/// use impactscope::model::unit::unit_factor;
///
/// assert_eq!(unit_factor("mrad", "rad"), Some(1e-3));
/// assert!((unit_factor("deg", "rad").unwrap() - 0.0174532925).abs() < 1e-10);
/// assert_eq!(unit_factor("uN", "N"), Some(1e-6));
/// assert_eq!(unit_factor("mm/s", "m/s"), Some(1e-3));
/// assert_eq!(unit_factor("ug", "kg"), Some(1e-9));
/// assert_eq!(unit_factor("deg", "m"), None);
/// ```
pub fn unit_factor(unit: &str, base: &str) -> Option<f64> {
    let unit = unit.trim();
    if unit.is_empty() || unit == base {
        return Some(1.0);
    }
    let other = OTHER_UNITS
        .iter()
        .find(|(text, si, _)| *text == unit && *si == base);
    if let Some((_, _, factor)) = other {
        return Some(*factor);
    }
    // The unit of mass has its prefix already.
    let (stem, already) = match base.strip_prefix("kg") {
        Some(rest) => (base.strip_prefix('k').unwrap_or(rest), 3),
        None => (base, 0),
    };
    let prefix = unit.strip_suffix(stem)?;
    PREFIXES
        .iter()
        .find(|(text, _)| *text == prefix)
        .map(|(_, power)| power_of_ten(power - already))
}

/// `10^power`, rounded once: products such as `1e-6 * 1e-3` are not the number nearest to 1e-9.
fn power_of_ten(power: i32) -> f64 {
    // Powers up to 1e22 are exact, so that their reciprocals are rounded once.
    let exact = 10f64.powi(power.abs());
    if power < 0 { 1.0 / exact } else { exact }
}

/// Splits `"58 um"` into `(58.0, "um")`. The number takes as much of the text as
/// parses, so that `2e-21N m^2 s` and `1e3` both work.
fn split_number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let end = text
        .char_indices()
        .take_while(|(_, c)| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',' | 'e' | 'E'))
        .map(|(i, c)| i + c.len_utf8())
        .collect::<Vec<_>>();
    end.into_iter().rev().find_map(|i| {
        text[..i]
            .replace(',', ".")
            .parse::<f64>()
            .ok()
            .map(|number| (number, text[i..].trim()))
    })
}

/// Reads a quantity given in `base` units, with or without a prefix.
///
/// # Errors
/// [`UnitError`] naming the offending text and the expected unit.
pub fn parse_quantity(text: &str, base: &str) -> Result<f64, UnitError> {
    let trimmed = text.trim();
    let (number, unit) =
        split_number(trimmed).ok_or_else(|| UnitError::NotANumber(trimmed.to_owned()))?;
    // Compound units are taken in any spacing: "N m^2 s", "Nm^2s", "N*m^2*s".
    let squeeze = |s: &str| s.replace([' ', '*', '\u{b7}'], "");
    let factor =
        unit_factor(&squeeze(unit), &squeeze(base)).ok_or_else(|| UnitError::WrongUnit {
            unit: unit.to_owned(),
            expected: if base.is_empty() {
                "plain numbers".to_owned()
            } else {
                base.to_owned()
            },
        })?;
    let value = number * factor;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(UnitError::NotFinite(trimmed.to_owned()))
    }
}

/// True for units that read naturally with an engineering prefix (`um`, `nN`). What is a multiple
/// of something (`%`, `1/V`, `x noise`) does not.
fn takes_prefix(base: &str) -> bool {
    !base.is_empty() && !base.contains('^') && !base.starts_with(['%', '1', 'x'])
}

/// The engineering prefix that suits `magnitude`, as `(text, factor)`.
pub fn prefix_for(magnitude: f64, base: &str) -> (&'static str, f64) {
    const STEPS: [(&str, f64); 8] = [
        ("p", 1e-12),
        ("n", 1e-9),
        ("\u{b5}", 1e-6),
        ("m", 1e-3),
        ("", 1.0),
        ("k", 1e3),
        ("M", 1e6),
        ("G", 1e9),
    ];
    let magnitude = magnitude.abs();
    if !takes_prefix(base) || magnitude == 0.0 || !magnitude.is_finite() {
        return ("", 1.0);
    }
    STEPS
        .iter()
        .rev()
        .find(|(_, factor)| magnitude >= factor * 0.9995)
        .copied()
        .unwrap_or(STEPS[0])
}

/// Writes a quantity for the screen with about `digits` significant digits:
/// `format_quantity(5.8e-5, "m", 4) == "58 µm"`.
pub fn format_quantity(value: f64, base: &str, digits: usize) -> String {
    if !value.is_finite() {
        return format!("{value}");
    }
    let (prefix, factor) = prefix_for(value, base);
    let number = format_number(value / factor, digits);
    if base.is_empty() {
        number
    } else {
        format!("{number} {prefix}{base}")
    }
}

/// A count with what it counts, whose plural ends in s: `1 cell`, `3 cells`.
pub fn counted(count: usize, singular: &str) -> String {
    format!("{count} {singular}{}", if count == 1 { "" } else { "s" })
}

/// The remaining time, to follow a progress: `, about 7 s left`. Empty below one second, which is also
/// what a stage says that cannot foresee its end.
pub fn time_left(left: Duration) -> String {
    let seconds = left.as_secs_f64();
    if seconds < 1.0 {
        return String::new();
    }
    format!(", about {seconds:.0} s left")
}

/// Writes a number with `digits` significant digits, without trailing zeros, in
/// scientific form outside 1e-4..1e6.
pub fn format_number(value: f64, digits: usize) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.max(1);
    if !(1e-4..1e6).contains(&magnitude) {
        let text = format!("{value:.*e}", digits - 1);
        return match text.split_once('e') {
            Some((mantissa, exponent)) if mantissa.contains('.') => format!(
                "{}e{exponent}",
                mantissa.trim_end_matches('0').trim_end_matches('.')
            ),
            _ => text,
        };
    }
    let decimals = (digits as i32 - 1 - magnitude.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use crate::model::unit::*;

    #[test]
    fn reads_what_people_type() {
        let close = |text: &str, base: &str, value: f64| {
            let read = parse_quantity(text, base).unwrap();
            assert!(
                (read - value).abs() <= 1e-12 * value.abs(),
                "{text}: {read}"
            );
        };
        close("58 um", "m", 58e-6);
        close("58\u{b5}m", "m", 58e-6);
        close("0,058 mm", "m", 58e-6);
        close("2e-21", "N m^2 s", 2e-21);
        close("2e-21 Nm^2s", "N m^2 s", 2e-21);
        close("50kHz", "Hz", 50e3);
        close("1.7 uN/s", "N/s", 1.7e-6);
        close("0.4", "s", 0.4);
        close("-3mV", "V", -3e-3);
    }

    #[test]
    fn angles_forces_speeds_and_masses_have_their_own_units() {
        let close = |text: &str, base: &str, value: f64| {
            let read = parse_quantity(text, base).unwrap();
            assert!((read / value - 1.0).abs() <= 1e-12, "{text}: {read}");
        };
        close("5 deg", "rad", 5.0 * PI / 180.0);
        close("-90\u{b0}", "rad", -PI / 2.0);
        close("12 mrad", "rad", 0.012);
        close("1.5", "rad", 1.5);
        close("60 rpm", "rad/s", 2.0 * PI);
        close("27 nN", "N", 27e-9);
        close("2 gf", "N", 0.0196133);
        close("36 km/h", "m/s", 10.0);
        close("30 um/s", "m/s", 30e-6);
        close("349.5 ng", "kg", 3.495e-10);
        close("5 g", "kg", 5e-3);
        close("2.33 g/cm^3", "kg/m^3", 2330.0);
        close("2330 kg/m^3", "kg/m^3", 2330.0);
        close("3.5e-7 kg/m", "kg/m", 3.5e-7);
        close("0.35 mg/m", "kg/m", 3.5e-7);
        close("169 GPa", "Pa", 169e9);
        for (text, base) in [("5 m", "rad"), ("5 deg", "m"), ("3 N", "kg"), ("1 g", "N")] {
            assert!(parse_quantity(text, base).is_err(), "{text} as {base}");
        }
    }

    #[test]
    fn refuses_the_wrong_unit_and_nonsense() {
        assert!(matches!(
            parse_quantity("5 ms", "m"),
            Err(UnitError::WrongUnit { .. })
        ));
        assert!(matches!(
            parse_quantity("abc", "m"),
            Err(UnitError::NotANumber(_))
        ));
        assert!(matches!(
            parse_quantity("1e999", "m"),
            Err(UnitError::NotFinite(_))
        ));
        assert!(parse_quantity("", "m").is_err());
    }

    #[test]
    fn writes_what_it_reads() {
        assert_eq!(format_quantity(58e-6, "m", 4), "58 \u{b5}m");
        assert_eq!(format_quantity(2.743e-8, "N", 4), "27.43 nN");
        assert_eq!(
            format_quantity(1.747e-21, "N m^2 s", 4),
            "1.747e-21 N m^2 s"
        );
        assert_eq!(format_quantity(0.378, "", 4), "0.378");
        assert_eq!(format_quantity(0.0, "V", 4), "0 V");
        assert_eq!(format_quantity(1e-3, "s", 3), "1 ms");
        assert_eq!(format_quantity(0.064, "1/V", 3), "0.064 1/V");
        assert_eq!(format_quantity(3200.0, "x noise", 3), "3200 x noise");
        assert_eq!(parse_quantity("5 x noise", "x noise"), Ok(5.0));
    }
}
