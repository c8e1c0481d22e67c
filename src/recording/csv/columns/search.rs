//! The search for the columns of a recording among those of a header.

use super::mapping::{Mapping, TableFacts, Topic, found_names};
use super::meant::option_for;
use super::names::{Column, Role};
use super::sample::Suggestion;
use super::units::UnitKind;
use crate::recording::csv::settings::{ColumnChoice, ImportSettings};
use crate::recording::error::{ImportError, WarningKind};

/// The search.
pub(super) struct ColumnSearch<'a> {
    pub(super) facts: &'a TableFacts<'a>,
    pub(super) cells: &'a [String],
    columns: &'a [Column],
    /// The columns to search.
    among: &'a [usize],
    /// Columns that have a role.
    pub(super) taken: Vec<usize>,
    pub(super) mapping: &'a mut Mapping,
}

impl<'a> ColumnSearch<'a> {
    pub(super) fn new(
        facts: &'a TableFacts<'a>,
        cells: &'a [String],
        columns: &'a [Column],
        among: &'a [usize],
        mapping: &'a mut Mapping,
    ) -> Self {
        Self {
            facts,
            cells,
            columns,
            among,
            taken: Vec::new(),
            mapping,
        }
    }

    /// Chooses the columns of all roles.
    pub(super) fn run(mut self, settings: &mut ImportSettings) {
        self.time(settings);
        self.by_name(Role::Cantilever, settings);
        self.by_name(Role::ProofMass, settings);
        // A camera sees no voltage; its v is a speed.
        if !self.facts.is_si {
            self.by_name(Role::Voltage, settings);
        }
        if settings.proof_mass.is_none() {
            self.motion(settings);
        }
        if settings.voltage.is_none() && !self.facts.is_si {
            self.voltage(settings);
        }
    }

    pub(super) fn column(&self, i: usize) -> Option<&'a Column> {
        self.columns.get(i)
    }

    fn free(&self) -> Vec<usize> {
        let mut free = self.among.to_vec();
        free.retain(|i| !self.taken.contains(i));
        free
    }

    /// Free columns that fulfil a condition.
    pub(super) fn free_with(&self, condition: impl Fn(&Column) -> bool) -> Vec<usize> {
        let mut found = self.free();
        found.retain(|i| self.column(*i).is_some_and(&condition));
        found
    }

    pub(super) fn name(&self, i: usize) -> String {
        let name = self.cells.get(i).map_or("", |cell| cell.trim());
        format!(
            "{} (\"{}\")",
            i + 1,
            name.chars().take(40).collect::<String>()
        )
    }

    pub(super) fn names(&self, columns: &[usize]) -> String {
        let shown: Vec<String> = columns.iter().take(8).map(|i| self.name(*i)).collect();
        shown.join(" and ")
    }

    pub(super) fn undecided(&self, question: String, options: String) -> ImportError {
        ImportError::Undecided {
            file: self.facts.file.into(),
            line: self.facts.line,
            question: question.into(),
            options: options.into(),
        }
    }

    /// Columns whose names fit best, in order.
    pub(super) fn candidates(&self, role: Role, fits: impl Fn(&Column) -> bool) -> Vec<usize> {
        let ranked = |i: &usize| self.column(*i).and_then(|c| c.rank(role));
        let fitting = self.free_with(|c| c.rank(role).is_some() && fits(c));
        let best = fitting.iter().filter_map(ranked).min();
        fitting.into_iter().filter(|i| ranked(i) == best).collect()
    }

    fn time(&mut self, settings: &mut ImportSettings) {
        let candidates = self.candidates(Role::Time, |c| c.fits(Role::Time));
        let dates = self.free_with(Column::is_date);
        if let [first, rest @ ..] = candidates.as_slice() {
            self.choose_among(Role::Time, *first, rest);
            self.set_time(*first, settings);
            if let (Some(date), true) = (dates.first(), self.is_clock(*first)) {
                let own = self.facts.samples.get(*first).is_some_and(|s| s.has_date);
                settings.date_column = (!own).then_some(*date);
                self.taken.push(*date);
            }
            return;
        }
        if let Some(i) = self.candidates(Role::Time, |_| true).first().copied() {
            self.unknown_unit(Role::Time, i);
            return;
        }
        if let Some(date) = dates.iter().find(|i| self.is_clock(**i)) {
            self.taken.push(*date);
            self.set_time(*date, settings);
            return;
        }
        let by_unit = self.free_with(|c| c.kind == Some(UnitKind::Time));
        if let [only] = by_unit.as_slice() {
            self.taken.push(*only);
            self.guessed_by_unit(Role::Time, *only);
            self.set_time(*only, settings);
            return;
        }
        if let [_, _, ..] = by_unit.as_slice() {
            self.ask_which(Role::Time, &by_unit);
            return;
        }
        self.without_time(settings);
    }

    fn is_clock(&self, i: usize) -> bool {
        self.facts.samples.get(i).is_some_and(|s| s.is_clock)
    }

    /// No column is a time: the header's sampling rate, if it has one.
    fn without_time(&mut self, settings: &mut ImportSettings) {
        let index = self.free_with(Column::is_index);
        let counting = index
            .iter()
            .find(|i| self.facts.samples.get(**i).is_some_and(|s| s.counts));
        self.taken.extend(counting);
        if let Some(clock) = self.facts.clock {
            settings.clock = Some(clock);
            settings.time = counting.map(|i| ColumnChoice::new(*i, "sample"));
            self.say_clock(clock.interval);
            return;
        }
        let found = found_names(self.cells);
        let (short, error) = match counting {
            Some(i) => {
                settings.time = Some(ColumnChoice::new(*i, "sample"));
                let question = format!(
                    "column {} counts samples, and the file does not say how far they are apart",
                    self.name(*i)
                );
                let options = "--rate 50kHz or --dt 20us".to_owned();
                (question.clone(), self.undecided(question, options))
            }
            None if self.is_spectrum() => (
                "a spectrum, not a recording in time".to_owned(),
                ImportError::Spectrum {
                    file: self.facts.file.into(),
                    line: self.facts.line,
                    found: found.into(),
                },
            ),
            None => (
                "no t column was recognised".to_owned(),
                ImportError::NoTimeColumn {
                    file: self.facts.file.into(),
                    line: self.facts.line,
                    found: found.into(),
                },
            ),
        };
        self.mapping.ask(Topic::Clock, error, short);
    }

    /// Whether the first column is a frequency.
    fn is_spectrum(&self) -> bool {
        let first = self.cells.iter().find(|cell| !cell.trim().is_empty());
        first.is_some_and(|cell| {
            let cell = cell.trim().trim_matches('"').to_lowercase();
            ["freq", "f [", "f ("]
                .iter()
                .any(|start| cell.starts_with(start))
        })
    }

    fn say_clock(&mut self, interval: f64) {
        let interval = crate::model::unit::format_quantity(interval, "s", 6);
        let message =
            format!("the times are those of one sample every {interval}, as the lines above say");
        self.mapping
            .warn(WarningKind::SampleClock, Some(self.facts.line), message);
    }

    /// Takes column `i` for the time, in the unit that it names or that its numbers suggest.
    fn set_time(&mut self, i: usize, settings: &mut ImportSettings) {
        let sample = self.facts.samples.get(i).copied();
        let named = self.column(i).and_then(|c| c.unit.clone());
        let is_clock = sample.is_some_and(|s| s.is_clock);
        if let Some(unit) = named.filter(|_| !is_clock) {
            settings.time = Some(ColumnChoice::new(i, unit));
            return;
        }
        let suggestion = sample.map_or(Suggestion::Clear("s"), |s| s.time_unit());
        let counts = sample.is_some_and(|s| s.counts) && !self.facts.is_si;
        if let (true, Suggestion::Guess(_)) = (counts, suggestion) {
            self.counted_time(i, settings);
            return;
        }
        let unit = suggestion.unit();
        settings.time = Some(ColumnChoice::new(i, unit));
        match suggestion {
            Suggestion::Clear("clock") => {
                let message = format!("column {} holds clock times", self.name(i));
                let line = Some(self.facts.line);
                self.mapping.warn(WarningKind::ConvertedTime, line, message);
            }
            Suggestion::Clear("days") => {
                let message = format!(
                    "column {} names no unit and holds day numbers of a spreadsheet; a day is 86400 s",
                    self.name(i)
                );
                self.mapping
                    .guess(WarningKind::ConvertedTime, self.facts.line, message);
            }
            Suggestion::Guess(_) if !self.facts.is_si => {
                let question = format!(
                    "column {} names no unit of time, and its steps of {} are long for seconds",
                    self.name(i),
                    sample.map_or(0.0, |s| s.step)
                );
                let short = Some(question.clone());
                let error = self.undecided(question, "--unit t=ms (or s, us)".to_owned());
                self.assumed(Role::Time, i, unit);
                self.mapping.questions.push(super::Question {
                    topic: Topic::Unit(Role::Time),
                    error,
                    short,
                });
            }
            _ => self.assumed(Role::Time, i, unit),
        }
    }

    /// A time without a unit that counts 0, 1, 2: sample numbers, or seconds.
    fn counted_time(&mut self, i: usize, settings: &mut ImportSettings) {
        settings.time = Some(ColumnChoice::new(i, "sample"));
        if let Some(clock) = self.facts.clock {
            settings.clock = Some(clock);
            self.say_clock(clock.interval);
            return;
        }
        let question = format!(
            "column {} counts rows and names no unit: sample numbers or seconds",
            self.name(i)
        );
        let options = "--rate 50kHz or --dt 20us, or --unit t=s".to_owned();
        let error = self.undecided(question.clone(), options);
        self.mapping.ask(Topic::Clock, error, question);
    }

    /// Says that a unit was assumed.
    fn assumed(&mut self, role: Role, i: usize, unit: &str) {
        let message = format!(
            "column {} ({}) names no unit; it is read as {unit}",
            i + 1,
            role.symbol()
        );
        self.mapping
            .guess(WarningKind::AssumedUnit, self.facts.line, message);
    }

    pub(super) fn guessed_by_unit(&mut self, role: Role, i: usize) {
        let message = format!(
            "column {} is taken for {} because of its unit",
            self.name(i),
            role.symbol()
        );
        self.mapping
            .guess(WarningKind::GuessedColumn, self.facts.line, message);
    }

    /// Takes the first of several columns with fitting names, and asks where there are more.
    pub(super) fn choose_among(&mut self, role: Role, first: usize, rest: &[usize]) {
        self.taken.push(first);
        if rest.is_empty() {
            return;
        }
        let all = [&[first][..], rest].concat();
        self.ask_which(role, &all);
        self.taken.extend_from_slice(rest);
    }

    pub(super) fn ask_which(&mut self, role: Role, columns: &[usize]) {
        let question = format!(
            "columns {} could each be {} ({})",
            self.names(columns),
            role.symbol(),
            role.quantity()
        );
        let first = columns.first().copied().unwrap_or(0);
        let first = option_for(first, self.cells);
        let options = format!("--column {}={first} (name or number)", role.symbol());
        let error = self.undecided(question.clone(), options);
        self.mapping.ask(Topic::Column(role), error, question);
    }

    pub(super) fn unknown_unit(&mut self, role: Role, i: usize) {
        let unit = self
            .column(i)
            .and_then(|c| c.unit.clone())
            .unwrap_or_default();
        let short = format!("\"{unit}\" is not a unit for {}", role.quantity());
        let error = ImportError::UnknownUnit {
            file: self.facts.file.into(),
            line: self.facts.line,
            column: i + 1,
            unit: unit.into(),
            quantity: role.quantity().to_owned(),
            expected: role.units().to_owned(),
        };
        self.mapping.ask(Topic::Unit(role), error, short);
    }

    /// A voltage or a displacement by its name.
    fn by_name(&mut self, role: Role, settings: &mut ImportSettings) {
        let mut candidates = self.candidates(role, |c| c.fits(role));
        if role == Role::ProofMass {
            self.height_of_plane(&mut candidates);
        }
        let [first, rest @ ..] = candidates.as_slice() else {
            return;
        };
        self.choose_among(role, *first, rest);
        self.others_with_a_name(role, *first);
        let unit = self.unit_of(role, *first, settings);
        role.set(settings, Some(ColumnChoice::new(*first, unit)));
    }

    /// Says which columns with a less fitting name are not used.
    fn others_with_a_name(&mut self, role: Role, chosen: usize) {
        let others = self.free_with(|c| c.rank(role).is_some() && c.fits(role) && c.unit.is_some());
        for other in others {
            let message = format!(
                "column {} is used for {}; column {} could be meant too and is left out",
                self.name(chosen),
                role.symbol(),
                self.name(other)
            );
            let line = Some(self.facts.line);
            self.mapping
                .warn(WarningKind::DuplicateColumn, line, message);
            self.taken.push(other);
        }
    }

    /// The unit that the header gives for a column, or an assumed one with a word.
    pub(super) fn unit_of(&mut self, role: Role, i: usize, settings: &ImportSettings) -> String {
        if let Some(unit) = self.column(i).and_then(|c| c.unit.clone()) {
            return unit;
        }
        let suggestion = match (role, self.facts.samples.get(i)) {
            (Role::Voltage, _) | (_, None) => Suggestion::Clear(role.base()),
            (_, Some(_)) if self.facts.is_si => Suggestion::Clear("m"),
            (_, Some(sample)) => sample.length_unit(self.interval(settings)),
        };
        let unit = suggestion.unit();
        self.assumed(role, i, unit);
        if let Suggestion::Guess(_) = suggestion {
            let question = format!("column {} names no unit of length", self.name(i));
            let short = Some(question.clone());
            let options = format!("--unit {}=um (or m, mm, nm)", role.symbol());
            let error = self.undecided(question, options);
            let topic = Topic::Unit(role);
            self.mapping.questions.push(super::Question {
                topic,
                error,
                short,
            });
        }
        unit.to_owned()
    }

    /// Interval between samples \[s\], as far as it is known.
    fn interval(&self, settings: &ImportSettings) -> f64 {
        if let Some(clock) = settings.clock {
            return clock.interval;
        }
        let time = settings.time.as_ref();
        let unit = time.and_then(|t| super::units::time_unit(&t.unit, None));
        let step = time.and_then(|t| self.facts.samples.get(t.index));
        match (unit, step) {
            (Some(unit), Some(sample)) => sample.step.abs() * unit.factor * 10f64.powi(unit.shift),
            _ => f64::NAN,
        }
    }
}
