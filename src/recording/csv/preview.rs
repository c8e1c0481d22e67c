//! What was understood of a file, for a dialog or at once for the import.

use super::columns::names::Role;
use super::columns::sample::ColumnSample;
use super::columns::{Question, Topic, several};
use super::settings::{ColumnChoice, ImportSettings};
use crate::recording::Channel;
use crate::recording::error::{ImportError, ImportWarning};

/// One of several recordings in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// What it is called in the file, or the lines where it stands.
    pub name: String,
    /// Its columns t, V, xp, xc, where recordings stand side by side.
    pub(super) columns: Option<[Option<ColumnChoice>; 4]>,
}

/// What was understood of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// File name or the name given for the bytes.
    pub name: String,
    /// Size of the file \[bytes\].
    pub size: u64,
    /// The instrument or program whose form the header has.
    pub written_by: Option<String>,
    /// Comments and free text before the header.
    pub comments: Vec<String>,
    /// Column names as written (with units); empty if there is no header.
    pub header: Vec<String>,
    /// Number of columns.
    pub columns: usize,
    /// The first rows of numbers, as text; at most 20.
    pub rows: Vec<Vec<String>>,
    /// The import that suggests itself. `time` and `proof_mass` are `None` where the
    /// user has to choose.
    pub settings: ImportSettings,
    /// What a user should confirm; empty if the file is clear.
    pub ambiguities: Vec<String>,
    /// What is worth saying if the import goes ahead as suggested.
    pub warnings: Vec<ImportWarning>,
    /// The recordings in the file, if it is known to hold several; empty if there is one.
    pub trials: Vec<Trial>,
    /// Whether the file itself is the text, so that delimiter and encoding can be chosen.
    pub is_text: bool,
    /// What must be decided before the import.
    pub(super) questions: Vec<Question>,
    /// What the columns look like.
    pub(super) samples: Vec<ColumnSample>,
}

impl Preview {
    /// Whether the file leaves a choice to the user.
    #[must_use]
    pub fn needs_dialog(&self) -> bool {
        !self.questions.is_empty() || !self.ambiguities.is_empty()
    }

    /// Why the file cannot be read as suggested, if so.
    #[must_use]
    pub fn problem(&self) -> Option<&ImportError> {
        self.questions.first().map(|question| &question.error)
    }

    /// Everything that must be decided before the file is read.
    pub fn problems(&self) -> impl Iterator<Item = &ImportError> {
        self.questions.iter().map(|question| &question.error)
    }

    /// What is still to be decided, in short: without the file and the options of the command line.
    pub fn open_points(&self) -> impl Iterator<Item = String> {
        let text = |question: &Question| match &question.short {
            Some(short) => short.clone(),
            None => question.error.to_string(),
        };
        self.questions.iter().map(text)
    }

    /// Takes recording `number` (from 1) of those in the file.
    ///
    /// # Errors
    /// [`ImportError::NoSuchTrial`].
    pub fn choose_trial(&mut self, number: usize) -> Result<(), ImportError> {
        let count = self.trials.len();
        let chosen = number.checked_sub(1).and_then(|i| self.trials.get(i));
        if count > 0 {
            let trial = chosen.ok_or_else(|| ImportError::NoSuchTrial {
                file: self.name.clone().into(),
                trial: number,
                count,
            })?;
            if let Some(columns) = trial.columns.clone() {
                for (role, choice) in Role::ALL.into_iter().zip(columns) {
                    role.set(&mut self.settings, choice);
                }
            }
        }
        self.settings.trial = Some(number);
        self.settle(Topic::Trial);
        Ok(())
    }

    /// `settings` for recording `number` (from 1) of those in the file: its columns, read as those of the
    /// recording that `settings` are for.
    #[must_use]
    pub fn settings_of_trial(&self, settings: &ImportSettings, number: usize) -> ImportSettings {
        let mut own = ImportSettings {
            trial: Some(number),
            ..settings.clone()
        };
        let trial = number.checked_sub(1).and_then(|i| self.trials.get(i));
        let Some(columns) = trial.and_then(|trial| trial.columns.clone()) else {
            return own;
        };
        for (role, column) in Role::ALL.into_iter().zip(columns) {
            let index = column.as_ref().map(|column| column.index);
            let as_chosen = role.of(settings).cloned().zip(index);
            let as_chosen = as_chosen.map(|(chosen, index)| ColumnChoice { index, ..chosen });
            role.set(&mut own, as_chosen.or(column));
        }
        own
    }

    /// Whether a displacement or another motion was recognised.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        self.settings.proof_mass.is_some() || !self.trials.is_empty()
    }

    /// Reads the only displacement of a file as the proof mass; which point the file says that it is.
    pub(super) fn take_single_point(&mut self) -> Channel {
        let settings = &mut self.settings;
        if settings.proof_mass.is_some() || settings.cantilever.is_none() {
            return Channel::ProofMass;
        }
        settings.proof_mass = settings.cantilever.take();
        (settings.xp_scale, settings.xp_offset) = (settings.xc_scale, settings.xc_offset);
        self.settle(Topic::Column(Role::ProofMass));
        // What is open of the one is open of the other.
        for question in &mut self.questions {
            match question.topic {
                Topic::Unit(Role::Cantilever) => question.topic = Topic::Unit(Role::ProofMass),
                Topic::Scale(Role::Cantilever) => question.topic = Topic::Scale(Role::ProofMass),
                _ => {}
            }
        }
        Channel::Cantilever
    }

    /// Asks which of the recordings of a file with several is meant.
    pub(in crate::recording) fn offer_trials(&mut self, file: &str, names: Vec<String>) {
        let shown: Vec<&str> = names.iter().map(String::as_str).collect();
        let error = several(file, &shown);
        self.ambiguities
            .push(format!("there are {} recordings in the file", names.len()));
        self.settle(Topic::Trial);
        let question = Question {
            topic: Topic::Trial,
            error,
            short: None,
        };
        self.questions.insert(0, question);
        let trial = |name| Trial {
            name,
            columns: None,
        };
        self.trials = names.into_iter().map(trial).collect();
    }

    /// Forgets the questions about a topic, and what was said of them.
    pub(super) fn settle(&mut self, topic: Topic) {
        let settled = self.questions.iter().filter(|q| q.topic == topic);
        let shorts: Vec<String> = settled.filter_map(|q| q.short.clone()).collect();
        self.ambiguities.retain(|line| !shorts.contains(line));
        self.questions.retain(|question| question.topic != topic);
    }
}
