//! Units of columns, as people write them.

use crate::model::unit::unit_factor;
use crate::recording::csv::settings::ColumnChoice;

/// What a unit is one of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) enum UnitKind {
    Time,
    Voltage,
    Length,
    Velocity,
    Acceleration,
    /// A known unit of another quantity.
    Other,
}

impl UnitKind {
    /// Whether numbers of this quantity may stand for a motion or a voltage by a scale.
    pub(in crate::recording::csv) fn takes_scale(self) -> bool {
        matches!(self, UnitKind::Voltage | UnitKind::Other)
    }
}

/// Units of other quantities, so that a row of units is known as one.
const OTHER_UNITS: [&str; 34] = [
    "hz", "khz", "mhz", "n", "mn", "un", "nn", "a", "ma", "ua", "degc", "\u{b0}c", "c", "k", "%",
    "px", "pixel", "pixels", "counts", "lsb", "deg", "\u{b0}", "rad", "mrad", "pa", "kpa", "w",
    "db", "g", "kg", "ohm", "\u{3a9}", "rpm", "a.u.",
];

/// A unit of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::recording::csv) struct TimeUnit {
    /// Power of ten over the second.
    pub shift: i32,
    /// A further factor, which is no power of ten.
    pub factor: f64,
    /// Whether the cells are clock times.
    pub is_clock: bool,
}

/// The unit of a time column. `interval` \[s\] is that of sample numbers.
pub(in crate::recording::csv) fn time_unit(unit: &str, interval: Option<f64>) -> Option<TimeUnit> {
    let plain = |shift| TimeUnit {
        shift,
        factor: 1.0,
        is_clock: false,
    };
    let times = |factor| TimeUnit { factor, ..plain(0) };
    match unit.trim().to_lowercase().as_str() {
        "min" | "mins" | "minute" | "minutes" => Some(times(60.0)),
        "h" | "hr" | "hrs" | "hour" | "hours" => Some(times(3600.0)),
        "d" | "day" | "days" => Some(times(86_400.0)),
        "sample" | "samples" => Some(times(interval?)),
        "clock" => Some(TimeUnit {
            is_clock: true,
            ..plain(0)
        }),
        _ => unit_shift(unit, "s").map(plain),
    }
}

/// A unit in the spelling of [`crate::model::unit`]: words and capitals are undone.
fn plain_unit(unit: &str, base: &str) -> String {
    let unit = unit.trim();
    let lower = unit.to_lowercase();
    let word = match lower.as_str() {
        "sec" | "second" | "seconds" | "secs" | "sekunden" => "s",
        "msec" | "millisecond" | "milliseconds" => "ms",
        "usec" | "\u{b5}sec" | "\u{3bc}sec" | "microsecond" | "microseconds" => "us",
        "nsec" | "nanosecond" | "nanoseconds" => "ns",
        "volt" | "volts" => "V",
        "millivolt" | "millivolts" => "mV",
        "kilovolt" | "kilovolts" => "kV",
        "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => "um",
        "meter" | "meters" | "metre" | "metres" => "m",
        "centimeter" | "centimeters" | "centimetre" | "centimetres" => "cm",
        "millimeter" | "millimeters" | "millimetre" | "millimetres" => "mm",
        "nanometer" | "nanometers" | "nanometre" | "nanometres" => "nm",
        // `S`, `MS`, `UM`, `mv`: capitals that change no prefix people mean here.
        "s" | "ms" | "us" | "\u{b5}s" | "\u{3bc}s" | "ns" | "um" | "\u{b5}m" | "\u{3bc}m"
        | "nm" | "cm"
            if base != "V" =>
        {
            lower.as_str()
        }
        "v" => "V",
        "mv" if unit != "MV" => "mV",
        "kv" => "kV",
        _ => unit,
    };
    word.to_owned()
}

/// The power of ten of `unit` over the SI unit `base`; `None` if it is not a unit
/// of that quantity.
pub(in crate::recording::csv) fn unit_shift(unit: &str, base: &str) -> Option<i32> {
    if unit.trim().is_empty() {
        return Some(0);
    }
    let lower = unit.trim().to_lowercase();
    let squeezed: String = lower.chars().filter(|c| !c.is_whitespace()).collect();
    match base {
        "m" if matches!(
            squeezed.as_str(),
            "\u{e5}" | "\u{212b}" | "angstrom" | "a\u{30a}"
        ) =>
        {
            Some(-10)
        }
        "m/s" | "m/s^2" => {
            let squared = squeezed
                .replace('\u{b2}', "^2")
                .replace("**2", "^2")
                .replace("sec", "s");
            let squared = match squared.strip_suffix("/s2") {
                Some(length) => format!("{length}/s^2"),
                None => squared.replace("/s/s", "/s^2"),
            };
            let length = squared.strip_suffix(base.strip_prefix('m').unwrap_or_default())?;
            if length.is_empty() {
                return None;
            }
            unit_shift(length, "m")
        }
        _ => {
            let unit = plain_unit(unit, base);
            unit_factor(&unit, base).map(|factor| factor.log10().round() as i32)
        }
    }
}

/// The quantity that `unit` belongs to; `None` for an unknown or an empty unit.
pub(in crate::recording::csv) fn kind_of(unit: &str) -> Option<UnitKind> {
    let unit = unit.trim();
    if unit.is_empty() {
        return None;
    }
    if time_unit(unit, None).is_some() {
        return Some(UnitKind::Time);
    }
    let bases = [
        ("V", UnitKind::Voltage),
        ("m", UnitKind::Length),
        ("m/s", UnitKind::Velocity),
        ("m/s^2", UnitKind::Acceleration),
    ];
    if let Some((_, kind)) = bases.iter().find(|(b, _)| unit_shift(unit, b).is_some()) {
        return Some(*kind);
    }
    let lower = unit.to_lowercase();
    OTHER_UNITS
        .contains(&lower.as_str())
        .then_some(UnitKind::Other)
}

/// What one unit of a column stands for: `0.5um/V`, `-20 nm/mV`, `12 um / px`, `5mm/s/V`. The factor
/// \[`base` per unit of the file\] and the power of ten of the file's unit; `None` if it does not fit.
pub(in crate::recording::csv) fn sensitivity(
    scale: &str,
    unit: &str,
    base: &str,
) -> Option<(f64, i32)> {
    let scale = scale.trim();
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
    let end = scale.find(|c: char| !is_number(c)).unwrap_or(scale.len());
    let number: f64 = scale.get(..end)?.parse().ok()?;
    let (now, read) = scale.get(end..)?.trim().rsplit_once('/')?;
    let (now, read, unit) = (now.trim(), read.trim(), unit.trim());
    if now.is_empty() || read.is_empty() || number == 0.0 || !number.is_finite() {
        return None;
    }
    let now = unit_shift(now, base)?;
    let (read, own) = match (unit_shift(read, "V"), unit_shift(unit, "V")) {
        (Some(read), Some(own)) => (read, own),
        _ if read.eq_ignore_ascii_case(unit) => (0, 0),
        _ => return None,
    };
    let factor = number * 10f64.powi(now - read);
    factor.is_finite().then_some((factor, own))
}

/// A scale as a message shows it.
pub(in crate::recording::csv) fn example_scale(base: &str, unit: &str) -> String {
    match base {
        "V" => format!("0.08V/{unit}"),
        "m" => format!("0.5um/{unit}"),
        "m/s" => format!("5mm/s/{unit}"),
        _ => format!("9.81m/s^2/{unit}"),
    }
}

/// The unit inside `[..]` or `(..)`, or the bare text.
pub(in crate::recording::csv) fn unbracket(text: &str) -> &str {
    let text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(inner) = text.strip_prefix(open).and_then(|t| t.strip_suffix(close)) {
            return inner.trim();
        }
    }
    text
}

/// Whether a row only names units, as oscilloscopes write below the names. Some units may be unknown
/// if more are known.
pub(in crate::recording::csv) fn is_units_row(cells: &[String]) -> bool {
    let named: Vec<&str> = cells
        .iter()
        .map(|cell| cell.trim())
        .filter(|cell| !unbracket(cell).is_empty())
        .collect();
    let known = named
        .iter()
        .filter(|cell| kind_of(unbracket(cell)).is_some())
        .count();
    let bracketed = named.iter().all(|cell| unbracket(cell).len() < cell.len());
    known > 0
        && (known == named.len()
            || (known >= 2 && 2 * known > named.len())
            || (bracketed && 2 * known >= named.len()))
}

/// `xp [um]`, `xp (um)`, `xp / um`, `xp_um`, `C1 in V` to name and unit.
pub(in crate::recording::csv) fn split_unit(cell: &str) -> (String, Option<String>) {
    let cell = cell.trim();
    let is_unit = |text: &str| kind_of(text).is_some();
    if let Some((name, unit)) = split_bracket(cell) {
        if is_unit(unit) {
            return (name.to_owned(), Some(unit.to_owned()));
        }
        // A remark such as "xp [um] (laser)": what stands before it decides.
        return match split_bracket(name).filter(|(_, inner)| is_unit(inner)) {
            Some((name, inner)) => (name.to_owned(), Some(inner.to_owned())),
            None => (name.to_owned(), Some(unit.to_owned())),
        };
    }
    let parts = [
        (cell.rsplit_once('/'), true),
        (cell.rsplit_once(" in "), true),
        (cell.rsplit_once(['_', ' ']), false),
        (cell.rsplit_once(','), false),
    ];
    for (part, is_clear) in parts {
        let Some((name, unit)) = part else { continue };
        let (name, unit) = (name.trim(), unit.trim());
        // "Channel A" is no current.
        let fits = is_clear || kind_of(unit) != Some(UnitKind::Other);
        if is_unit(unit) && fits && !name.is_empty() && !name.ends_with('/') {
            let velocity = name.rsplit_once([' ', '_', '/']);
            // "v / mm/s": the unit itself has a stroke.
            if let Some((short, first)) = velocity
                && is_unit(&format!("{}/{unit}", first.trim()))
                && cell.ends_with(&format!("{}/{unit}", first.trim()))
            {
                let short = short.trim().trim_end_matches('/').trim();
                return (short.to_owned(), Some(format!("{}/{unit}", first.trim())));
            }
            return (name.to_owned(), Some(unit.to_owned()));
        }
    }
    if let Some(unit) = cell.strip_prefix("in ").filter(|u| is_unit(u)) {
        return (String::new(), Some(unit.trim().to_owned()));
    }
    (cell.to_owned(), None)
}

/// `name [inner]` or `name (inner)` to its two parts.
fn split_bracket(cell: &str) -> Option<(&str, &str)> {
    [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let rest = cell.strip_suffix(close)?;
            let at = rest.rfind(open)?;
            Some((rest[..at].trim(), rest[at + 1..].trim()))
        })
}

impl ColumnChoice {
    /// Whether the column of a motion is in the unit of something else, such as the volts of a meter: it
    /// then needs a [`ColumnChoice::scale`].
    #[must_use]
    pub fn is_in_foreign_unit(&self) -> bool {
        unit_shift(&self.unit, self.kind.base_unit()).is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::super::units::*;

    #[test]
    fn units_of_all_quantities() {
        for (unit, base, shift) in [
            ("um", "m", Some(-6)),
            ("\u{c5}", "m", Some(-10)),
            ("mm/s", "m/s", Some(-3)),
            ("m/s\u{b2}", "m/s^2", Some(0)),
            ("mm/s2", "m/s^2", Some(-3)),
            ("m/s", "m/s^2", None),
            ("m/s^2", "m/s", None),
            ("kV", "V", Some(3)),
            ("px", "m", None),
        ] {
            assert_eq!(unit_shift(unit, base), shift, "{unit}");
        }
        assert_eq!(time_unit("min", None).map(|u| u.factor), Some(60.0));
        assert_eq!(time_unit("sample", None), None);
        assert_eq!(time_unit("sample", Some(0.5)).map(|u| u.factor), Some(0.5));
        assert_eq!(kind_of("%"), Some(UnitKind::Other));
        assert_eq!(kind_of("furlong"), None);
    }

    #[test]
    fn scales_name_both_units() {
        let (factor, shift) = sensitivity("0.5um/V", "mV", "m").unwrap();
        assert!((factor - 0.5e-6).abs() < 1e-18 && shift == -3);
        let (factor, _) = sensitivity("-20 nm / mV", "V", "m").unwrap();
        assert!((factor + 20e-6).abs() < 1e-15);
        assert!(sensitivity("5mm/s/V", "V", "m/s").is_some());
        assert_eq!(sensitivity("2.5um/px", "px", "m").map(|s| s.1), Some(0));
        for text in ["0.5", "um/V", "0.5um", "0.5s/V", "0um/V", "1um/px"] {
            assert_eq!(sensitivity(text, "V", "m"), None, "{text}");
        }
    }

    #[test]
    fn names_and_units_come_apart() {
        for (cell, name, unit) in [
            ("xp [um]", "xp", "um"),
            ("Auslenkung x / \u{b5}m", "Auslenkung x", "\u{b5}m"),
            ("xp_um", "xp", "um"),
            ("C1 in V", "C1", "V"),
            ("v / mm/s", "v", "mm/s"),
            ("v [mm/s]", "v", "mm/s"),
            ("Displacement (px)", "Displacement", "px"),
        ] {
            assert_eq!(split_unit(cell), (name.to_owned(), Some(unit.to_owned())));
        }
        assert_eq!(split_unit("trial 1"), ("trial 1".to_owned(), None));
        assert_eq!(split_unit("Channel A"), ("Channel A".to_owned(), None));
    }
}
