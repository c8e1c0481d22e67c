//! What a header says: names and units to columns.

pub(super) mod header_clock;
pub(super) mod header_line;
mod mapping;
pub(super) mod meant;
mod motion;
pub(super) mod names;
mod role;
pub(super) mod sample;
mod search;
pub(super) mod trials;
pub(super) mod units;

pub use self::mapping::several;
pub(super) use self::mapping::{Mapping, Question, TableFacts, Topic, found_names};
use self::names::{Column, Role};
use self::search::ColumnSearch;
use self::trials::TrialColumns;
use super::settings::ImportSettings;
use crate::recording::error::{ImportError, WarningKind};

/// Finds the columns in the header `cells` and writes them into `settings`.
pub(super) fn map_header(
    facts: &TableFacts,
    cells: &[String],
    labels: &[String],
    settings: &mut ImportSettings,
) -> Mapping {
    let columns: Vec<Column> = cells.iter().map(|cell| Column::of(cell)).collect();
    let mut mapping = Mapping::default();
    for (column, unit) in facts.unknown_units {
        let message = format!(
            "the unit \"{unit}\" of column {} is not known; the units of the other columns are used",
            column + 1
        );
        mapping.warn(WarningKind::IgnoredColumn, Some(facts.line), message);
    }
    let groups = trials::groups(&columns, labels);
    let Some((first, _)) = groups.split_first() else {
        let every: Vec<usize> = (0..columns.len()).collect();
        ColumnSearch::new(facts, cells, &columns, &every, &mut mapping).run(settings);
        return mapping;
    };
    // Each recording has its own columns; what is said of the first holds for all.
    let unset = settings.clone();
    for (i, group) in groups.iter().enumerate() {
        let mut own = unset.clone();
        let mut found = Mapping::default();
        ColumnSearch::new(facts, cells, &columns, &group.columns, &mut found).run(&mut own);
        if i == 0 {
            mapping.warnings.append(&mut found.warnings);
            mapping.ambiguities.append(&mut found.ambiguities);
            mapping.questions.append(&mut found.questions);
            *settings = own.clone();
        }
        mapping.trials.push(TrialColumns {
            name: group.name.clone(),
            choices: Role::ALL.map(|role| role.of(&own).cloned()),
        });
    }
    let names: Vec<&str> = groups.iter().map(|g| g.name.as_str()).collect();
    let error = several(facts.file, &names);
    let short = format!(
        "there are {} recordings side by side; the first (\"{}\") is chosen",
        groups.len(),
        first.name
    );
    mapping.ask(Topic::Trial, error, short);
    mapping
}

/// Columns of a file without a header, by their number: t, x; t, V, xp; t, V, xp, xc. A file does not
/// say which they are, so that a person is asked.
pub(super) fn map_by_count(
    facts: &TableFacts,
    columns: usize,
    settings: &mut ImportSettings,
) -> Mapping {
    let mut mapping = Mapping::default();
    let (file, line) = (facts.file, facts.line);
    if columns <= 1 {
        let error = ImportError::NoPositionColumn {
            file: file.into(),
            line,
            found: "a single column without a header".into(),
        };
        let topic = Topic::Column(Role::ProofMass);
        mapping.ask(topic, error, "there is one column only".to_owned());
        return mapping;
    }
    let roles: &[Role] = match columns {
        2 => &[Role::Time, Role::ProofMass],
        3 => &[Role::Time, Role::Voltage, Role::ProofMass],
        _ => &Role::ALL,
    };
    let interval = facts.samples.first().map_or(f64::NAN, |s| s.step.abs());
    let mut readings = Vec::new();
    for (index, role) in roles.iter().enumerate() {
        let sample = facts.samples.get(index);
        let unit = match (role, sample) {
            (Role::Time, Some(sample)) => sample.time_unit().unit(),
            (Role::ProofMass | Role::Cantilever, Some(s)) => s.length_unit(interval).unit(),
            _ => role.base(),
        };
        readings.push(format!("{} [{unit}]", role.symbol()));
        let choice = super::settings::ColumnChoice::new(index, unit);
        role.set(settings, Some(choice));
    }
    let short = format!(
        "there is no header; the columns are taken as {}",
        readings.join(", ")
    );
    let error = ImportError::Undecided {
        file: file.into(),
        line,
        question: format!("there is no header that names the {columns} columns").into(),
        options:
            "--column t=1 --column xp=3 --unit xp=um (and --column V=2), with the right numbers"
                .into(),
    };
    let topic = Topic::Column(Role::Time);
    mapping.ask(topic, error.clone(), short.clone());
    mapping.questions.push(Question {
        topic: Topic::Column(Role::ProofMass),
        error,
        short: None,
    });
    mapping.warn(WarningKind::NoHeader, Some(line), short);
    mapping
}
