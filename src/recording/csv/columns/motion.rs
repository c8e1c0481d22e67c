//! The search for a motion or a voltage where no column has its name: by units, rates, channels.

use super::mapping::{Topic, found_names};
use super::meant::option_for;
use super::names::{Column, Role};
use super::search::ColumnSearch;
use super::units::{UnitKind, example_scale};
use crate::recording::csv::settings::{ColumnChoice, ImportSettings, Quantity};
use crate::recording::error::{ImportError, WarningKind};

impl ColumnSearch<'_> {
    /// Of x and y, which a camera sees, y is the height.
    pub(super) fn height_of_plane(&mut self, candidates: &mut Vec<usize>) {
        let axis = |i: &usize| self.column(*i).and_then(Column::axis);
        let [a, b] = candidates.as_slice() else {
            return;
        };
        let (y, x) = match (axis(a), axis(b)) {
            (Some('x'), Some('y')) => (*b, *a),
            (Some('y'), Some('x')) => (*a, *b),
            _ => return,
        };
        let message = format!(
            "column {} is taken for the height; column {} is sideways and is left out",
            self.name(y),
            self.name(x)
        );
        if self.facts.is_si {
            let line = Some(self.facts.line);
            self.mapping.warn(WarningKind::GuessedColumn, line, message);
        } else {
            self.mapping
                .guess(WarningKind::GuessedColumn, self.facts.line, message);
        }
        self.taken.push(x);
        *candidates = vec![y];
    }

    /// No displacement has a known name: by its unit, else a velocity or an acceleration, else a
    /// channel in volts.
    pub(super) fn motion(&mut self, settings: &mut ImportSettings) {
        let role = Role::ProofMass;
        let scaled = self.candidates(role, |c| c.is_scalable(role));
        if let [first, rest @ ..] = scaled.as_slice() {
            let (first, rest) = (*first, rest.to_vec());
            self.choose_among(role, first, &rest);
            self.needs_scale(role, first, settings);
            return;
        }
        if let Some(i) = self
            .candidates(role, |c| {
                !matches!(c.kind, Some(UnitKind::Velocity | UnitKind::Acceleration))
            })
            .first()
            .copied()
        {
            self.unknown_unit(role, i);
            return;
        }
        let lengths = self
            .free_with(|c| c.kind == Some(UnitKind::Length) && c.rank(Role::Cantilever).is_none());
        match lengths.as_slice() {
            [] => {}
            [only] => {
                self.taken.push(*only);
                self.guessed_by_unit(role, *only);
                let unit = self.unit_of(role, *only, settings);
                role.set(settings, Some(ColumnChoice::new(*only, unit)));
                return;
            }
            several => {
                self.ask_which(role, several);
                return;
            }
        }
        if self.rate(settings) || self.channels(settings) {
            return;
        }
        let error = ImportError::NoPositionColumn {
            file: self.facts.file.into(),
            line: self.facts.line,
            found: found_names(self.cells).into(),
        };
        let short = "no xp column was recognised".to_owned();
        self.mapping.ask(Topic::Column(role), error, short);
    }

    /// A velocity, or an acceleration, in place of a displacement; whether there is one.
    fn rate(&mut self, settings: &mut ImportSettings) -> bool {
        let role = Role::ProofMass;
        for (kind, quantity) in [
            (UnitKind::Velocity, Quantity::Velocity),
            (UnitKind::Acceleration, Quantity::Acceleration),
        ] {
            let found = self.free_with(|c| c.is_rate(kind));
            let [first, rest @ ..] = found.as_slice() else {
                continue;
            };
            let unit = self.column(*first).and_then(|c| c.unit.clone());
            settings.proof_mass = Some(ColumnChoice {
                kind: quantity,
                ..ColumnChoice::new(
                    *first,
                    unit.unwrap_or_else(|| quantity.base_unit().to_owned()),
                )
            });
            self.taken.extend_from_slice(&found);
            let article = if quantity == Quantity::Acceleration {
                "an"
            } else {
                "a"
            };
            let said = format!(
                "there is no displacement; column {} is {article} {}",
                self.name(*first),
                quantity.label()
            );
            if !rest.is_empty() {
                let question = format!("{said}, and there are others: {}", self.names(rest));
                let options = {
                    let first = option_for(*first, self.cells);
                    format!("--column xp={first} (it is integrated)")
                };
                let error = self.undecided(question.clone(), options);
                self.mapping.ask(Topic::Column(role), error, question);
            } else if quantity == Quantity::Acceleration {
                let question =
                    format!("{said}: integrated twice, its errors grow with the square of time");
                let options = format!(
                    "--column xp={} to integrate it all the same, or record a displacement or a velocity",
                    option_for(*first, self.cells)
                );
                let error = self.undecided(question.clone(), options);
                self.mapping.ask(Topic::Column(role), error, question);
            } else {
                let message = format!("{said} and is integrated");
                self.mapping
                    .guess(WarningKind::Integrated, self.facts.line, message);
            }
            return true;
        }
        false
    }

    /// Channels that only an instrument named, in volts or without a unit; whether there are any.
    fn channels(&mut self, settings: &mut ImportSettings) -> bool {
        let role = Role::ProofMass;
        let channels = self.free_with(Column::is_channel);
        let has_voltage = settings.voltage.is_some();
        match channels.as_slice() {
            [] => return false,
            [only] => {
                let only = *only;
                self.taken.push(only);
                self.needs_scale(role, only, settings);
                let message = format!(
                    "column {} is the only channel and is taken for xp",
                    self.name(only)
                );
                self.mapping
                    .guess(WarningKind::GuessedColumn, self.facts.line, message);
            }
            [first, second, ..] => {
                let (volts, motion) = if has_voltage {
                    (None, *first)
                } else {
                    (Some(*first), *second)
                };
                if let Some(volts) = volts {
                    settings.voltage = Some(ColumnChoice::new(volts, self.unit_or(volts, "V")));
                }
                let question = format!(
                    "nothing says which of the channels {} is the drive voltage and which the displacement",
                    self.names(&channels)
                );
                let unit = self.unit_or(motion, "V");
                let options = format!(
                    "--column V={} --column xp={} --scale xp={}",
                    option_for(*first, self.cells),
                    option_for(motion, self.cells),
                    example_scale("m", &unit)
                );
                let error = self.undecided(question.clone(), options);
                self.taken.extend_from_slice(&channels);
                self.mapping.ask(Topic::Column(role), error, question);
                self.needs_scale(role, motion, settings);
            }
        }
        true
    }

    fn unit_or(&self, i: usize, unit: &str) -> String {
        let own = self.column(i).and_then(|c| c.unit.clone());
        own.unwrap_or_else(|| unit.to_owned())
    }

    /// Takes a column whose unit needs a scale, and asks for it.
    fn needs_scale(&mut self, role: Role, i: usize, settings: &mut ImportSettings) {
        let unit = self.unit_or(i, "V");
        let error = ImportError::NeedsScale {
            file: self.facts.file.into(),
            line: self.facts.line,
            column: i + 1,
            unit: unit.clone().into(),
            symbol: role.symbol().to_owned(),
            example: example_scale(role.base(), &unit).into(),
        };
        let short = format!(
            "column {} ({}) is in \"{unit}\"; say what one {unit} stands for",
            self.name(i),
            role.symbol()
        );
        role.set(settings, Some(ColumnChoice::new(i, unit)));
        self.mapping.ask(Topic::Scale(role), error, short);
    }

    /// No voltage has a known name: by its unit. It may be missing.
    pub(super) fn voltage(&mut self, settings: &mut ImportSettings) {
        let role = Role::Voltage;
        let scaled = self.candidates(role, |c| c.is_scalable(role));
        if let [only] = scaled.as_slice() {
            self.taken.push(*only);
            self.needs_scale(role, *only, settings);
            return;
        }
        if let Some(i) = self
            .candidates(role, |c| !c.is_rate(UnitKind::Velocity))
            .first()
        {
            let message = format!(
                "column {} (V) is in \"{}\", which is not a unit for voltage; it is left out (write V or mV)",
                self.name(*i),
                self.column(*i)
                    .and_then(|c| c.unit.clone())
                    .unwrap_or_default(),
            );
            let line = Some(self.facts.line);
            self.mapping.warn(WarningKind::IgnoredColumn, line, message);
            return;
        }
        let by_unit = self.free_with(|c| c.kind == Some(UnitKind::Voltage));
        match by_unit.as_slice() {
            [] => {}
            [only] => {
                self.taken.push(*only);
                self.guessed_by_unit(role, *only);
                let unit = self.unit_or(*only, "V");
                role.set(settings, Some(ColumnChoice::new(*only, unit)));
            }
            several => self.ask_which(role, several),
        }
    }
}
