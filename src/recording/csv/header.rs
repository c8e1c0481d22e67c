//! What a header says: names and units to columns.

use super::names::{Role, key, split_unit, unit_shift};
use super::settings::{ColumnChoice, ImportSettings};
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
        self.warnings
            .push(ImportWarning::new(kind, 1, line, &message));
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
    let mut search = ColumnSearch {
        file,
        line,
        cells,
        columns: cells
            .iter()
            .map(|cell| {
                let (name, unit) = split_unit(cell);
                (key(&name), unit)
            })
            .collect(),
        taken: vec![false; cells.len()],
        mapping: Mapping::default(),
    };
    let mut missing = Vec::new();
    for role in Role::ALL {
        if let Err(misfit) = search.by_name(role, assumed, settings) {
            missing.push((role, misfit));
        }
    }
    for (role, misfit) in missing {
        if !search.by_unit(role, settings) {
            search.report_missing(role, misfit);
        }
    }
    search.mapping
}

/// The search for the columns of a header.
struct ColumnSearch<'a> {
    file: &'a str,
    line: usize,
    cells: &'a [String],
    /// Key of the name, and unit, of each column.
    columns: Vec<(String, Option<String>)>,
    /// Columns that already have a role, or compete for one.
    taken: Vec<bool>,
    mapping: Mapping,
}

impl ColumnSearch<'_> {
    /// Chooses the column whose name is the best for `role` and whose unit fits. Otherwise the
    /// error is a column with a fitting name in a unit of another quantity, if there is one.
    fn by_name(
        &mut self,
        role: Role,
        assumed: &str,
        settings: &mut ImportSettings,
    ) -> Result<(), Option<usize>> {
        let columns = &self.columns;
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
            return Err(named.first().copied());
        };
        self.taken[chosen] = true;
        // Two columns of one quantity, whatever their units or names: only a person knows
        // which is meant.
        for &other in named.iter().filter(|i| **i != chosen) {
            self.taken[other] = true;
            self.mapping.warn(
                WarningKind::DuplicateColumn,
                Some(self.line),
                format!(
                    "column {} (\"{}\") is used for {}, but column {} (\"{}\") could be meant too; choose it in the import settings, or rename it",
                    chosen + 1,
                    self.cells[chosen].trim(),
                    role.symbol(),
                    other + 1,
                    self.cells[other].trim()
                ),
            );
        }
        let unit = self.unit_of(chosen, role, assumed);
        role.set(
            settings,
            ColumnChoice {
                index: chosen,
                unit,
            },
        );
        Ok(())
    }

    /// The unit that the header gives for a column, or an assumed one with a warning.
    fn unit_of(&mut self, column: usize, role: Role, assumed: &str) -> String {
        if let Some(unit) = self.columns[column].1.as_deref().filter(|u| !u.is_empty()) {
            return unit.to_owned();
        }
        let unit = if role.base() == "m" {
            assumed
        } else {
            role.base()
        };
        let message = format!(
            "column {} ({}) names no unit; it is read as {unit}",
            column + 1,
            role.symbol()
        );
        self.mapping.ambiguities.push(message.clone());
        self.mapping
            .warn(WarningKind::AssumedUnit, Some(self.line), message);
        unit.to_owned()
    }

    /// Chooses the only free column whose unit is one of `role`; whether there is one.
    fn by_unit(&mut self, role: Role, settings: &mut ImportSettings) -> bool {
        let fitting: Vec<usize> = (0..self.columns.len())
            .filter(|&i| !self.taken[i])
            .filter(|&i| {
                self.columns[i]
                    .1
                    .as_deref()
                    .is_some_and(|u| !u.is_empty() && unit_shift(u, role.base()).is_some())
            })
            .collect();
        let ([only], true) = (fitting.as_slice(), role != Role::Cantilever) else {
            return false;
        };
        self.taken[*only] = true;
        let message = format!(
            "column {} (\"{}\") is taken for {} because of its unit",
            only + 1,
            self.cells[*only].trim(),
            role.symbol()
        );
        self.mapping.ambiguities.push(message.clone());
        self.mapping
            .warn(WarningKind::GuessedColumn, Some(self.line), message);
        let unit = self.columns[*only].1.clone().unwrap_or_default();
        role.set(settings, ColumnChoice { index: *only, unit });
        true
    }

    /// Says that no column was found for `role`; `misfit` is one with its name and a unit of
    /// another quantity.
    fn report_missing(&mut self, role: Role, misfit: Option<usize>) {
        let required = matches!(role, Role::Time | Role::ProofMass);
        match misfit.map(|i| (i, self.columns[i].1.clone().unwrap_or_default())) {
            Some((i, unit)) if required => {
                self.mapping
                    .ambiguities
                    .push(format!("\"{unit}\" is not a unit for {}", role.quantity()));
                self.mapping.problem.get_or_insert(ImportError::UnknownUnit {
                    file: self.file.into(),
                    line: self.line,
                    column: i + 1,
                    unit: unit.into(),
                    quantity: role.quantity().to_owned(),
                    expected: role.units().to_owned(),
                });
            }
            Some((i, unit)) if !self.taken[i] => self.mapping.warn(
                WarningKind::IgnoredColumn,
                Some(self.line),
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
        if misfit.is_none() && required {
            let found = found_names(self.cells).into();
            let (file, line) = (self.file.into(), self.line);
            self.mapping
                .ambiguities
                .push(format!("no {} column was recognised", role.symbol()));
            self.mapping.problem.get_or_insert(if role == Role::Time {
                ImportError::NoTimeColumn { file, line, found }
            } else {
                ImportError::NoPositionColumn { file, line, found }
            });
        }
    }
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
                file: file.into(),
                line,
                found: "a single column without a header".into(),
            });
            &[Role::ProofMass]
        }
        2 => &[Role::Time, Role::ProofMass],
        3 => &[Role::Time, Role::Voltage, Role::ProofMass],
        _ => &Role::ALL,
    };
    let mut readings = Vec::new();
    for (index, role) in roles.iter().enumerate() {
        let unit = if role.base() == "m" {
            assumed
        } else {
            role.base()
        };
        readings.push(format!("{} [{unit}]", role.symbol()));
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
        readings.join(", ")
    );
    mapping.ambiguities.push(message.clone());
    mapping.warn(WarningKind::NoHeader, Some(line), message);
    mapping
}
