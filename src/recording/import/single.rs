//! One recording from one file of any kind.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::source::{Part, is_known, parts_of};
use crate::recording::csv::{self, ImportSettings, Preview, Progress, ReadingChoices};
use crate::recording::error::{ImportError, ImportWarning, WarningKind};
use crate::recording::formats::HEAD_BYTES;
use crate::recording::{Channel, Recording};

/// Rows of a table that are looked at to see what its columns are.
const LOOKED_AT_ROWS: usize = 2000;

/// What was understood of a file, for a dialog.
///
/// # Errors
/// [`ImportError`]; each names the file, the place and the remedy.
pub fn preview(path: &Path) -> Result<Preview, ImportError> {
    match Source::open(path, None)? {
        None => csv::preview(path),
        Some(source) => source.preview(&ReadingChoices::default()),
    }
}

/// What is understood of a file with answers to what it leaves open.
///
/// # Errors
/// As [`preview`]; an answer that does not fit the file.
pub fn preview_chosen(path: &Path, choices: &ReadingChoices) -> Result<Preview, ImportError> {
    let name = path.display().to_string();
    match Source::open(path, None)? {
        None => csv::preview_chosen(&name, &csv::read_file(path, None)?, choices),
        Some(source) => source.preview(choices),
    }
}

/// Reads the rows of a file as `settings` say, without what they say of further ones.
///
/// # Errors
/// As [`preview`].
pub fn import_single(
    path: &Path,
    settings: &ImportSettings,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let Some(source) = Source::open(path, progress)? else {
        return csv::import(path, settings, progress);
    };
    let (part, settings) = source.part_of(settings)?;
    let mut recording = csv::import_bytes(&source.file, &part.text(), &settings)?;
    recording.warnings.splice(0..0, part.notes());
    Ok(source.named(recording, part))
}

/// Reads a file as its header says, with answers to what it leaves open.
///
/// # Errors
/// As [`preview`]; what the answers do not decide.
pub fn import_chosen(
    path: &Path,
    choices: &ReadingChoices,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let Some(source) = Source::open(path, progress)? else {
        return csv::import_chosen(path, choices, progress);
    };
    let (part, warning) = source.chosen(choices)?;
    let choices = source.within_part(choices);
    let mut recording = csv::import_bytes_chosen(&source.file, &part.text(), &choices)?;
    recording
        .warnings
        .splice(0..0, warning.into_iter().chain(part.notes()));
    Ok(source.named(recording, part))
}

/// Reads several of the recordings of a file, those of `which` (from 1), all of them where it is `None`,
/// each named by its number where there are several.
///
/// # Errors
/// As [`import_chosen`]; a number that the file does not have.
pub fn import_trials(
    path: &Path,
    choices: &ReadingChoices,
    which: Option<&[usize]>,
    progress: Option<&Progress>,
) -> Result<Vec<Recording>, ImportError> {
    let numbers: Vec<usize> = match which {
        Some(which) => which.to_vec(),
        // A file that leaves something else open is explained by the import itself.
        None => (1..=trials(path).map_or(1, |names| names.len())).collect(),
    };
    let is_single = which.is_none() && numbers.len() == 1;
    let one = |number: usize| {
        let choices = ReadingChoices {
            trial: (!is_single).then_some(number),
            ..choices.clone()
        };
        let mut recording = import_chosen(path, &choices, progress)?;
        if !is_single {
            recording.name = format!("{}, recording {number}", csv::short_name(path));
        }
        Ok(recording)
    };
    numbers.into_iter().map(one).collect()
}

/// Reads a recording with one displacement, whichever point of the device it is of: it is in
/// [`Recording::proof_mass`], and the channel says what the file calls it. For
/// [`crate::recording::combine::merge_points`].
///
/// # Errors
/// As [`import_chosen`].
pub fn import_point(
    path: &Path,
    choices: &ReadingChoices,
    progress: Option<&Progress>,
) -> Result<(Recording, Channel), ImportError> {
    let Some(source) = Source::open(path, progress)? else {
        let file = path.display().to_string();
        let bytes = csv::read_file(path, progress)?;
        let (mut recording, channel) = csv::import_bytes_point(&file, &bytes, choices)?;
        recording.name = csv::short_name(path);
        recording.path = Some(path.to_owned());
        return Ok((recording, channel));
    };
    let (part, warning) = source.chosen(choices)?;
    let within = source.within_part(choices);
    let (mut recording, channel) = csv::import_bytes_point(&source.file, &part.text(), &within)?;
    let notes = warning.into_iter().chain(part.notes());
    recording.warnings.splice(0..0, notes);
    Ok((source.named(recording, part), channel))
}

/// The recordings that a file holds, each as [`import_chosen`] would take it, by name. Names are empty
/// where there is one.
///
/// # Errors
/// As [`preview`].
pub fn trials(path: &Path) -> Result<Vec<String>, ImportError> {
    match Source::open(path, None)? {
        None => {
            let bytes = csv::read_file(path, None)?;
            let found = csv::trials(&path.display().to_string(), &bytes)?;
            Ok(names_of(found))
        }
        Some(source) => Ok(match &source.usable()[..] {
            [only] => names_of(csv::trials(&source.file, &only.text())?),
            all => names(all).into_iter().map(str::to_owned).collect(),
        }),
    }
}

/// The voltage of a file; it needs no displacement. `(times [s], volts [V])`.
///
/// # Errors
/// As [`preview`], and if there is no voltage.
pub fn import_voltage(path: &Path) -> Result<(Vec<f64>, Vec<f64>), ImportError> {
    match Source::open(path, None)? {
        None => csv::import_voltage(path),
        Some(source) => {
            let (part, _) = source.chosen(&ReadingChoices::default())?;
            csv::import_voltage_bytes(&source.file, &part.text())
        }
    }
}

/// A file that is not text, or a text in a wrapper.
struct Source {
    file: String,
    path: std::path::PathBuf,
    sha256: String,
    parts: Vec<Part>,
    /// Indices of the parts in which a recording is seen; of all where none is.
    usable: Vec<usize>,
}

impl Source {
    /// `None` for a file of text.
    fn open(path: &Path, progress: Option<&Progress>) -> Result<Option<Self>, ImportError> {
        let name = csv::short_name(path);
        let mut head = Vec::new();
        // What cannot be opened is for the reader of text to explain.
        let Ok(input) = std::fs::File::open(path) else {
            return Ok(None);
        };
        let is_file = input.metadata().is_ok_and(|about| about.is_file());
        if !is_file
            || input
                .take(HEAD_BYTES as u64)
                .read_to_end(&mut head)
                .is_err()
            || !is_known(&head, &name)
        {
            return Ok(None);
        }
        let file = path.display().to_string();
        let bytes = csv::read_file(path, progress)?;
        let sha256 = csv::hex(&Sha256::digest(&bytes));
        let parts = parts_of(&file, &name, bytes)?;
        let usable = usable(&file, &parts);
        Ok(Some(Self {
            usable,
            file,
            path: path.to_owned(),
            sha256,
            parts,
        }))
    }

    /// The parts among which `trial` chooses.
    fn usable(&self) -> Vec<&Part> {
        let parts = self.usable.iter().filter_map(|i| self.parts.get(*i));
        parts.collect()
    }

    /// The part that is asked for, and what is worth saying of the choice.
    fn chosen(
        &self,
        choices: &ReadingChoices,
    ) -> Result<(&Part, Option<ImportWarning>), ImportError> {
        let usable = self.usable();
        match (&usable[..], choices.trial) {
            ([], _) => Err(no_table(&self.file)),
            ([only], _) => Ok((only, self.left_aside(only))),
            (all, None) => Err(csv::several(&self.file, &names(all))),
            (all, Some(trial)) => {
                let part = trial.checked_sub(1).and_then(|i| all.get(i));
                let part = part.ok_or_else(|| ImportError::NoSuchTrial {
                    file: self.file.clone().into(),
                    trial,
                    count: all.len(),
                })?;
                Ok((part, None))
            }
        }
    }

    /// Says which of several tables was read where only one can be a recording.
    fn left_aside(&self, part: &Part) -> Option<ImportWarning> {
        let others = self.parts.len() - 1;
        (others > 0).then(|| {
            let message = format!(
                "the file has {} tables; \"{}\" is read, the others have no time and displacement",
                others + 1,
                part.name
            );
            ImportWarning::new(WarningKind::FormatNote, others, None, &message)
        })
    }

    /// The choices for the text of a part: which recording of the file is decided.
    fn within_part<'c>(&self, choices: &'c ReadingChoices) -> Cow<'c, ReadingChoices> {
        if self.usable.len() < 2 {
            return Cow::Borrowed(choices);
        }
        Cow::Owned(ReadingChoices {
            trial: None,
            ..choices.clone()
        })
    }

    fn part_of(&self, settings: &ImportSettings) -> Result<(&Part, ImportSettings), ImportError> {
        let choices = ReadingChoices {
            trial: settings.trial,
            ..ReadingChoices::default()
        };
        let (part, _) = self.chosen(&choices)?;
        let trial = settings.trial.filter(|_| self.usable.len() < 2);
        Ok((
            part,
            ImportSettings {
                trial,
                ..settings.clone()
            },
        ))
    }

    /// What is understood of the part that is asked for, of the first one where none is.
    fn preview(&self, choices: &ReadingChoices) -> Result<Preview, ImportError> {
        let usable = self.usable();
        let asked = ReadingChoices {
            trial: choices.trial.or((usable.len() > 1).then_some(1)),
            ..choices.clone()
        };
        let (part, aside) = self.chosen(&asked)?;
        let head = part.head(LOOKED_AT_ROWS);
        let name = csv::short_name(&self.path);
        let within = self.within_part(&asked);
        // Where nothing is said, recordings below each other are looked for, too.
        let mut preview = if *within == ReadingChoices::default() {
            csv::preview_bytes(&name, &head)?
        } else {
            csv::preview_chosen(&name, &head, &within)?
        };
        preview.written_by = part.format.map(str::to_owned).or(preview.written_by);
        let notes = aside.into_iter().chain(part.notes());
        preview.warnings.splice(0..0, notes);
        preview.is_text = false;
        if usable.len() > 1 {
            let all = names(&usable).into_iter().map(str::to_owned);
            preview.offer_trials(&self.file, all.collect());
            if let Some(trial) = choices.trial {
                preview.choose_trial(trial)?;
            }
        }
        Ok(preview)
    }

    fn named(&self, mut recording: Recording, part: &Part) -> Recording {
        let name = csv::short_name(&self.path);
        recording.name = if self.usable.len() > 1 {
            format!("{name}: {}", part.name)
        } else {
            name
        };
        recording.path = Some(self.path.clone());
        recording.sha256 = Some(self.sha256.clone());
        recording
    }
}

fn no_table(file: &str) -> ImportError {
    let message =
        format!("{file}: there is no table of numbers in it; export the recording as CSV");
    ImportError::Format(message.into())
}

/// The parts of a file in which a recording is seen; all where none is.
fn usable(file: &str, parts: &[Part]) -> Vec<usize> {
    let all = || (0..parts.len()).collect();
    if parts.len() < 2 {
        return all();
    }
    let looks_right = |i: &usize| {
        let head = parts[*i].head(LOOKED_AT_ROWS);
        csv::preview_bytes(file, &head).is_ok_and(|preview| preview.has_motion())
    };
    let found: Vec<usize> = (0..parts.len()).filter(looks_right).collect();
    if found.is_empty() { all() } else { found }
}

/// Names for [`trials`].
fn names_of(found: Vec<csv::Trial>) -> Vec<String> {
    match &found[..] {
        [_] => vec![String::new()],
        _ => found.into_iter().map(|trial| trial.name).collect(),
    }
}

fn names<'p>(parts: &'p [&Part]) -> Vec<&'p str> {
    parts.iter().map(|part| part.name.as_str()).collect()
}
