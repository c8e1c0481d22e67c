//! What a header says: names and units to columns.

use super::names::{Role, key, split_unit};
use super::{ColumnChoice, ImportSettings, unit_shift};
use crate::recording::error::{ImportError, ImportWarning, WarningKind};

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
        // Two columns of one quantity, whatever their units or names: only a person knows
        // which is meant.
        for &other in named.iter().filter(|i| **i != chosen) {
            taken[other] = true;
            mapping.warn(
                WarningKind::DuplicateColumn,
                Some(line),
                format!(
                    "column {} (\"{}\") is used for {}, but column {} (\"{}\") could be meant too; choose it in the import settings, or rename it",
                    chosen + 1,
                    cells[chosen].trim(),
                    role.symbol(),
                    other + 1,
                    cells[other].trim()
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
