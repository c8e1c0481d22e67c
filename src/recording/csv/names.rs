//! Names and units of columns, as people write them.

use super::settings::{ColumnChoice, ImportSettings};
use crate::model::unit::unit_factor;

/// A quantity that a column can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Voltage,
    ProofMass,
    Cantilever,
}

impl Role {
    pub(super) const ALL: [Role; 4] =
        [Role::Time, Role::Voltage, Role::ProofMass, Role::Cantilever];

    /// Names, best first, in lower case without spaces and signs.
    pub(super) fn names(self) -> &'static [&'static str] {
        match self {
            Role::Time => &["t", "time", "zeit", "timestamp", "times", "temps"],
            Role::Voltage => &[
                "v",
                "u",
                "voltage",
                "volt",
                "volts",
                "drivevoltage",
                "inputvoltage",
                "drive",
                "input",
                "spannung",
                "vin",
                "uin",
            ],
            Role::ProofMass => &[
                "xp",
                "proofmass",
                "proofmassposition",
                "tip",
                "tipposition",
                "tipdisplacement",
                "x",
                "position",
                "pos",
                "displacement",
                "deflection",
                "height",
                "weg",
            ],
            Role::Cantilever => &[
                "xc",
                "cantilever",
                "cantilevercentre",
                "cantilevercenter",
                "beam",
                "centre",
                "center",
            ],
        }
    }

    pub(super) fn base(self) -> &'static str {
        match self {
            Role::Time => "s",
            Role::Voltage => "V",
            Role::ProofMass | Role::Cantilever => "m",
        }
    }

    pub(super) fn symbol(self) -> &'static str {
        match self {
            Role::Time => "t",
            Role::Voltage => "V",
            Role::ProofMass => "xp",
            Role::Cantilever => "xc",
        }
    }

    pub(super) fn quantity(self) -> &'static str {
        match self {
            Role::Time => "time",
            Role::Voltage => "voltage",
            Role::ProofMass | Role::Cantilever => "displacement",
        }
    }

    pub(super) fn units(self) -> &'static str {
        match self {
            Role::Time => "s, ms or us",
            Role::Voltage => "V or mV",
            Role::ProofMass | Role::Cantilever => "m, mm, um or nm",
        }
    }

    pub(super) fn set(self, settings: &mut ImportSettings, choice: ColumnChoice) {
        let slot = match self {
            Role::Time => &mut settings.time,
            Role::Voltage => &mut settings.voltage,
            Role::ProofMass => &mut settings.proof_mass,
            Role::Cantilever => &mut settings.cantilever,
        };
        *slot = Some(choice);
    }
}

/// A unit in the spelling of [`crate::model::unit`]: words and capitals are undone.
pub(super) fn plain_unit(unit: &str, base: &str) -> String {
    let unit = unit.trim();
    let lower = unit.to_lowercase();
    let word = match lower.as_str() {
        "sec" | "second" | "seconds" | "secs" => "s",
        "msec" | "millisecond" | "milliseconds" => "ms",
        "usec" | "\u{b5}sec" | "microsecond" | "microseconds" => "us",
        "volt" | "volts" => "V",
        "millivolt" | "millivolts" => "mV",
        "micron" | "microns" | "micrometer" | "micrometers" | "micrometre" | "micrometres" => "um",
        "meter" | "meters" | "metre" | "metres" => "m",
        "millimeter" | "millimeters" | "millimetre" | "millimetres" => "mm",
        "nanometer" | "nanometers" | "nanometre" | "nanometres" => "nm",
        // `S`, `MS`, `UM`, `mv`: capitals that change no prefix people mean here.
        "s" | "ms" | "us" | "ns" | "um" | "nm" | "cm" if base != "V" => lower.as_str(),
        "v" => "V",
        "mv" if unit != "MV" => "mV",
        _ => unit,
    };
    word.to_owned()
}

/// The power of ten of `unit` over the SI unit `base`; `None` if it is not a unit
/// of that quantity.
pub(super) fn unit_shift(unit: &str, base: &str) -> Option<i32> {
    let unit = plain_unit(unit, base);
    unit_factor(&unit, base).map(|factor| factor.log10().round() as i32)
}

/// Whether `unit` belongs to any quantity of a recording.
fn is_unit(unit: &str) -> bool {
    !unit.trim().is_empty()
        && Role::ALL
            .iter()
            .any(|role| unit_shift(unit, role.base()).is_some())
}

/// The unit inside `[..]` or `(..)`, or the bare text.
pub(super) fn unbracket(text: &str) -> &str {
    let text = text.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(inner) = text.strip_prefix(open).and_then(|t| t.strip_suffix(close)) {
            return inner.trim();
        }
    }
    text
}

/// Whether a row only names units, as oscilloscopes write below the names.
pub(super) fn is_units_row(cells: &[String]) -> bool {
    cells.iter().any(|cell| is_unit(unbracket(cell)))
        && cells.iter().all(|cell| {
            let unit = unbracket(cell);
            unit.is_empty() || is_unit(unit)
        })
}

/// `xp [um]`, `xp (um)`, `xp / um`, `xp_um` to name and unit.
pub(super) fn split_unit(cell: &str) -> (String, Option<String>) {
    let cell = cell.trim();
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
    if let Some((name, unit)) = cell.rsplit_once('/')
        && is_unit(unit)
    {
        return (name.trim().to_owned(), Some(unit.trim().to_owned()));
    }
    if let Some((name, unit)) = cell.rsplit_once(['_', ' '])
        && is_unit(unit)
        && !name.trim().is_empty()
    {
        return (name.trim().to_owned(), Some(unit.trim().to_owned()));
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

/// A name without case, spaces and signs.
pub(super) fn key(name: &str) -> String {
    name.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

/// Whether the cells can be a header: one of them is a time column by name, or two
/// are known names.
pub(super) fn is_header(cells: &[String]) -> bool {
    let keys: Vec<String> = cells.iter().map(|c| key(&split_unit(c).0)).collect();
    let known = |role: &Role| keys.iter().any(|k| role.names().contains(&k.as_str()));
    cells.len() >= 2 && (known(&Role::Time) || Role::ALL.iter().filter(|r| known(r)).count() >= 2)
}
