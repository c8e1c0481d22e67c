//! One recording from several, of one file or of several files: repeated trials averaged, and the points
//! of two runs merged.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::single::{import_point, import_single, import_trials, preview, trials};
use crate::model::unit::counted;
use crate::recording::combine::{AverageOptions, Combination, CombineError, average, merge_points};
use crate::recording::csv::{
    self, ColumnChoice, ImportSettings, Preview, Progress, ReadingChoices,
};
use crate::recording::error::{ImportError, ImportWarning, WarningKind};
use crate::recording::{Channel, Recording};

/// The average of the recordings of `files`, in each file those of `which` (from 1), all where it is
/// `None`; read as headers and `choices` say.
///
/// # Errors
/// [`ImportError`]: a file that cannot be read; recordings that are no trials of one motion.
pub fn average_files(
    files: &[PathBuf],
    which: Option<&[usize]>,
    choices: &ReadingChoices,
    options: AverageOptions,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let mut all = Vec::new();
    for file in files {
        all.extend(import_trials(file, choices, which, progress)?);
    }
    averaged(&all, options)
}

/// The recording of two runs under one drive, one of the proof mass and one of the cantilever; `lag`
/// \[s\] is added to the times of the latter, by default what their voltages say.
///
/// # Errors
/// [`ImportError`]: a file that cannot be read, or that names the other point; runs that do not belong
/// together.
pub fn merge_files(
    proof_mass: &Path,
    cantilever: &Path,
    choices: &ReadingChoices,
    lag: Option<f64>,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let (first, named) = import_point(proof_mass, choices, progress)?;
    if named == Channel::Cantilever {
        return Err(combine_error(&format!(
            "{}: the file names its displacement as the cantilever's, but it is given as the run of the proof mass; turn the order of the two files",
            proof_mass.display()
        )));
    }
    let (second, _) = import_point(cantilever, choices, progress)?;
    merged(&first, &second, lag)
}

/// Reads `path` as `settings` say, together with what `combination` names.
pub(super) fn import_combined(
    path: &Path,
    settings: &ImportSettings,
    combination: &Combination,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let own = ImportSettings {
        combine: None,
        ..settings.clone()
    };
    match combination {
        Combination::Average {
            trials,
            files,
            leave_out_misfits,
            match_zeros,
        } => {
            let mut all = trials_of(path, &own, trials, progress)?;
            for file in files {
                all.extend(further_trials(path, &own, file, progress)?);
            }
            let options = AverageOptions {
                leave_out_misfits: *leave_out_misfits,
                match_zeros: *match_zeros,
            };
            averaged(&all, options)
        }
        Combination::Points {
            other,
            other_is_proof_mass,
            lag,
        } => {
            let first = import_single(path, &as_one_point(&own), progress)?;
            let second = second_run(path, &own, other, progress)?;
            if *other_is_proof_mass {
                merged(&second, &first, *lag)
            } else {
                merged(&first, &second, *lag)
            }
        }
    }
}

/// The recordings of a file with the numbers `which`, all where none is given, with columns as those that
/// `settings` choose.
fn trials_of(
    path: &Path,
    settings: &ImportSettings,
    which: &[usize],
    progress: Option<&Progress>,
) -> Result<Vec<Recording>, ImportError> {
    let count = trials(path)?.len();
    if count < 2 {
        return Ok(vec![import_single(path, settings, progress)?]);
    }
    let found = preview(path)?;
    let numbers = match which {
        [] => (1..=count).collect(),
        which => which.to_vec(),
    };
    let one = |number: usize| {
        let own = found.settings_of_trial(settings, number);
        let mut recording = import_single(path, &own, progress)?;
        recording.name = format!("{}, recording {number}", csv::short_name(path));
        Ok(recording)
    };
    numbers.into_iter().map(one).collect()
}

/// The recordings of a further file: read as the first one where their headers agree, else by their own.
fn further_trials(
    first: &Path,
    settings: &ImportSettings,
    file: &Path,
    progress: Option<&Progress>,
) -> Result<Vec<Recording>, ImportError> {
    let (model, own) = (preview(first)?, preview(file)?);
    if alike(&model, &own, settings, true) {
        return trials_of(file, settings, &[], progress);
    }
    let mut all = import_trials(file, &choices_of(settings), None, progress)?;
    for recording in &mut all {
        recording.warnings.push(own_header(first, file));
    }
    Ok(all)
}

/// The run of the other point, read likewise.
fn second_run(
    first: &Path,
    settings: &ImportSettings,
    other: &Path,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let (model, own) = (preview(first)?, preview(other)?);
    if alike(&model, &own, settings, false) {
        return import_single(other, &as_one_point(settings), progress);
    }
    let (mut recording, _) = import_point(other, &choices_of(settings), progress)?;
    recording.warnings.push(own_header(first, other));
    Ok(recording)
}

/// Settings with the only displacement as the proof mass.
fn as_one_point(settings: &ImportSettings) -> ImportSettings {
    let mut own = settings.clone();
    if own.proof_mass.is_none() {
        own.proof_mass = own.cantilever.take();
        (own.xp_scale, own.xp_offset) = (own.xc_scale, own.xc_offset);
    }
    own
}

/// Whether the columns that `settings` choose have the same names in both files; with `by_name` those of
/// the displacements, too, else their units alone: another point has another name.
fn alike(a: &Preview, b: &Preview, settings: &ImportSettings, by_name: bool) -> bool {
    let layout = |p: &Preview| {
        let own = &p.settings;
        (own.delimiter, own.skip_lines, own.decimal, own.encoding)
    };
    let cell = |p: &Preview, choice: &ColumnChoice| p.header.get(choice.index).cloned();
    let is_same = |choice: &Option<ColumnChoice>| {
        choice
            .as_ref()
            .is_none_or(|choice| cell(a, choice) == cell(b, choice))
    };
    let unit = |p: &Preview, choice: &ColumnChoice| {
        let all = [&p.settings.proof_mass, &p.settings.cantilever];
        let mut own = all.into_iter().flatten();
        own.find(|c| c.index == choice.index)
            .map(|c| c.unit.clone())
    };
    let motions = [&settings.proof_mass, &settings.cantilever];
    let motions_agree = motions.into_iter().all(|choice| {
        let same_unit = |c: &ColumnChoice| unit(a, c) == unit(b, c) && unit(a, c).is_some();
        is_same(choice) || (!by_name && choice.as_ref().is_some_and(same_unit))
    });
    a.columns == b.columns
        && layout(a) == layout(b)
        && is_same(&settings.time)
        && is_same(&settings.voltage)
        && motions_agree
}

/// What settings say beyond columns and text.
fn choices_of(settings: &ImportSettings) -> ReadingChoices {
    ReadingChoices {
        accept_losses: settings.accept_losses,
        drift: settings.drift,
        ..ReadingChoices::default()
    }
}

fn own_header(first: &Path, file: &Path) -> ImportWarning {
    let message = format!(
        "the header of {} differs from that of {}; it is read as it says itself, without scales and offsets of the latter",
        csv::short_name(file),
        csv::short_name(first)
    );
    ImportWarning::new(WarningKind::FormatNote, 1, None, &message)
}

fn averaged(all: &[Recording], options: AverageOptions) -> Result<Recording, ImportError> {
    let trials: Vec<&Recording> = all.iter().collect();
    let found = average(&trials, options).map_err(|error| explained(&error))?;
    let used = found.trials.iter().filter(|trial| trial.is_used).count();
    let mut mean = found.recording;
    let first = all.first();
    let name = first.and_then(|r| r.path.as_deref()).map(csv::short_name);
    let name = name.unwrap_or_else(|| mean.name.clone());
    mean.name = format!("{name}, mean of {}", counted(used, "trial"));
    mean.path = first.and_then(|r| r.path.clone());
    mean.sha256 = joined_hash(&trials);
    Ok(mean)
}

fn merged(
    proof_mass: &Recording,
    cantilever: &Recording,
    lag: Option<f64>,
) -> Result<Recording, ImportError> {
    let mut both = merge_points(proof_mass, cantilever, lag).map_err(|error| explained(&error))?;
    both.path = proof_mass.path.clone();
    both.sha256 = joined_hash(&[proof_mass, cantilever]);
    Ok(both)
}

/// The hash of the hashes of all files, each once; that of the file where it is one.
fn joined_hash(all: &[&Recording]) -> Option<String> {
    let mut own: Vec<&str> = all.iter().filter_map(|r| r.sha256.as_deref()).collect();
    own.dedup();
    match own[..] {
        [] => None,
        [only] => Some(only.to_owned()),
        _ => Some(csv::hex(&Sha256::digest(own.concat()))),
    }
}

fn explained(error: &CombineError) -> ImportError {
    combine_error(&error.to_string())
}

fn combine_error(message: &str) -> ImportError {
    ImportError::Combine(message.into())
}
