//! What a header says: names and units to columns.

use super::{ColumnChoice, ImportSettings, unit_shift};
use crate::recording::{ImportError, ImportWarning, WarningKind};

/// A quantity that a column can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Time,
    Voltage,
    ProofMass,
    Cantilever,
}

impl Role {
    const ALL: [Role; 4] = [Role::Time, Role::Voltage, Role::ProofMass, Role::Cantilever];

    /// Names, best first, in lower case without spaces and signs.
    fn names(self) -> &'static [&'static str] {
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

    fn base(self) -> &'static str {
        match self {
            Role::Time => "s",
            Role::Voltage => "V",
            Role::ProofMass | Role::Cantilever => "m",
        }
    }

    fn symbol(self) -> &'static str {
        match self {
            Role::Time => "t",
            Role::Voltage => "V",
            Role::ProofMass => "xp",
            Role::Cantilever => "xc",
        }
    }

    fn quantity(self) -> &'static str {
        match self {
            Role::Time => "time",
            Role::Voltage => "voltage",
            Role::ProofMass | Role::Cantilever => "displacement",
        }
    }

    fn units(self) -> &'static str {
        match self {
            Role::Time => "s, ms or us",
            Role::Voltage => "V or mV",
            Role::ProofMass | Role::Cantilever => "m, mm, um or nm",
        }
    }

    fn set(self, settings: &mut ImportSettings, choice: ColumnChoice) {
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
fn key(name: &str) -> String {
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

/// What was made of a header.
#[derive(Debug, Default)]
pub(super) struct Mapping {
    pub warnings: Vec<ImportWarning>,
    pub ambiguities: Vec<String>,
    pub problem: Option<ImportError>,
}

impl Mapping {
    fn warn(&mut self, kind: WarningKind, line: Option<usize>, message: String) {
        self.warnings.push(ImportWarning {
            kind,
            count: 1,
            first_line: line,
            message,
        });
    }
}

/// Finds the columns in the header `cells` of line `line` and writes them into
/// `settings`. `assumed` gives the displacement unit if the header names none.
pub(super) fn map_header(
    file: &str,
    line: usize,
    cells: &[String],
    assumed: &str,
    settings: &mut ImportSettings,
) -> Mapping {
    let mut mapping = Mapping::default();
    let columns: Vec<(String, Option<String>)> = cells
        .iter()
        .map(|cell| {
            let (name, unit) = split_unit(cell);
            (key(&name), unit)
        })
        .collect();
    let mut taken = vec![false; columns.len()];
    let mut misfits: [Option<usize>; 4] = [None; 4];
    let mut missing = Vec::new();

    for (r, role) in Role::ALL.into_iter().enumerate() {
        let rank = |i: &usize| role.names().iter().position(|n| *n == columns[*i].0);
        let mut named: Vec<usize> = (0..columns.len()).filter(|i| rank(i).is_some()).collect();
        named.sort_by_key(|i| rank(i));
        let fits = |i: &usize| {
            columns[*i]
                .1
                .as_deref()
                .is_none_or(|unit| unit_shift(unit, role.base()).is_some())
        };
        let Some(chosen) = named.iter().copied().find(fits) else {
            misfits[r] = named.first().copied();
            missing.push((r, role));
            continue;
        };
        taken[chosen] = true;
        for &other in named
            .iter()
            .filter(|i| **i != chosen && rank(i) == rank(&chosen))
        {
            taken[other] = true;
            mapping.warn(
                WarningKind::DuplicateColumn,
                Some(line),
                format!(
                    "columns {} and {} are both {}; column {} is used",
                    chosen + 1,
                    other + 1,
                    role.symbol(),
                    chosen + 1
                ),
            );
        }
        let unit = match columns[chosen].1.as_deref().filter(|u| !u.is_empty()) {
            Some(unit) => unit.to_owned(),
            None => {
                let unit = if role.base() == "m" {
                    assumed
                } else {
                    role.base()
                };
                let message = format!(
                    "column {} ({}) names no unit; it is read as {unit}",
                    chosen + 1,
                    role.symbol()
                );
                mapping.ambiguities.push(message.clone());
                mapping.warn(WarningKind::AssumedUnit, Some(line), message);
                unit.to_owned()
            }
        };
        role.set(
            settings,
            ColumnChoice {
                index: chosen,
                unit,
            },
        );
    }

    for (r, role) in missing {
        // A column that says by its unit what it is, if only one does.
        let fitting: Vec<usize> = (0..columns.len())
            .filter(|&i| !taken[i])
            .filter(|&i| {
                columns[i]
                    .1
                    .as_deref()
                    .is_some_and(|u| !u.is_empty() && unit_shift(u, role.base()).is_some())
            })
            .collect();
        if let ([only], true) = (fitting.as_slice(), role != Role::Cantilever) {
            taken[*only] = true;
            let message = format!(
                "column {} (\"{}\") is taken for {} because of its unit",
                only + 1,
                cells[*only].trim(),
                role.symbol()
            );
            mapping.ambiguities.push(message.clone());
            mapping.warn(WarningKind::GuessedColumn, Some(line), message);
            let unit = columns[*only].1.clone().unwrap_or_default();
            role.set(settings, ColumnChoice { index: *only, unit });
            continue;
        }
        let misfit = misfits[r].map(|i| (i, columns[i].1.clone().unwrap_or_default()));
        let required = matches!(role, Role::Time | Role::ProofMass);
        match misfit {
            Some((i, unit)) if required => {
                mapping.ambiguities.push(format!("\"{unit}\" is not a unit for {}", role.quantity()));
                mapping.problem.get_or_insert(ImportError::UnknownUnit {
                    file: file.to_owned(),
                    line,
                    column: i + 1,
                    unit,
                    quantity: role.quantity().to_owned(),
                    expected: role.units().to_owned(),
                });
            }
            Some((i, unit)) if !taken[i] => mapping.warn(
                WarningKind::IgnoredColumn,
                Some(line),
                format!(
                    "column {} ({}) is in \"{unit}\", which is not a unit for {}; it is left out (write {})",
                    i + 1,
                    role.symbol(),
                    role.quantity(),
                    role.units()
                ),
            ),
            _ => {}
        }
        if misfits[r].is_none() && required {
            let found = found_names(cells);
            let file = file.to_owned();
            mapping
                .ambiguities
                .push(format!("no {} column was recognised", role.symbol()));
            mapping.problem.get_or_insert(if role == Role::Time {
                ImportError::NoTimeColumn { file, line, found }
            } else {
                ImportError::NoPositionColumn { file, line, found }
            });
        }
    }
    mapping
}

/// The header as a sentence shows it, cut if it is long.
fn found_names(cells: &[String]) -> String {
    let mut names: Vec<String> = cells
        .iter()
        .take(12)
        .map(|cell| format!("\"{}\"", cell.trim().chars().take(40).collect::<String>()))
        .collect();
    if cells.len() > names.len() {
        names.push("...".to_owned());
    }
    names.join(", ")
}

/// Columns of a file without a header, by their number: t, x; t, V, xp; t, V, xp, xc.
pub(super) fn map_by_count(
    file: &str,
    line: usize,
    columns: usize,
    assumed: &str,
    settings: &mut ImportSettings,
) -> Mapping {
    let mut mapping = Mapping::default();
    let roles: &[Role] = match columns {
        0 | 1 => {
            mapping
                .ambiguities
                .push("there is one column only".to_owned());
            mapping.problem = Some(ImportError::NoPositionColumn {
                file: file.to_owned(),
                line,
                found: "a single column without a header".to_owned(),
            });
            &[Role::ProofMass]
        }
        2 => &[Role::Time, Role::ProofMass],
        3 => &[Role::Time, Role::Voltage, Role::ProofMass],
        _ => &Role::ALL,
    };
    let mut said = Vec::new();
    for (index, role) in roles.iter().enumerate() {
        let unit = if role.base() == "m" {
            assumed
        } else {
            role.base()
        };
        said.push(format!("{} [{unit}]", role.symbol()));
        role.set(
            settings,
            ColumnChoice {
                index,
                unit: unit.to_owned(),
            },
        );
    }
    let message = format!(
        "there is no header; the columns are read as {}",
        said.join(", ")
    );
    mapping.ambiguities.push(message.clone());
    mapping.warn(WarningKind::NoHeader, Some(line), message);
    mapping
}
