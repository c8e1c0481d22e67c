//! Reads an opened file according to its kind.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::event::{FileEvent, failed};
use super::jobs::Context;
use super::session;
use super::session_text::RecordingEntry;
use crate::app::files::recent;
use crate::explore::waveform::{is_waveform_file, load};
use crate::learn::lesson::{Lesson, is_lesson_text};
use crate::model::drive::DriveReading;
use crate::model::preset::Preset;
use crate::recording::csv::{ColumnChoice, ImportSettings, Preview, ReadingChoices};
use crate::recording::import::{import, import_voltage, preview, preview_chosen};
use crate::recording::measured_drive::drive_of_samples;
use crate::recording::{Channel, ImportError, ImportWarning, WarningKind};

pub(super) fn open(path: PathBuf, context: &Context) -> Option<FileEvent> {
    let name = path.to_string_lossy().to_lowercase();
    if name.ends_with(".toml") {
        return Some(open_toml(path, context));
    }
    let mut preview = match preview(&path) {
        Ok(preview) => preview,
        Err(error) => return Some(failed(&error)),
    };
    take_known_sensitivities(&path, &mut preview);
    match recent::import_settings_for(&path) {
        // A file that has changed may need other settings than last time.
        Some(settings) => {
            // Guesses that nobody has confirmed are reported again.
            let as_guessed = settings == preview.settings && !preview.needs_dialog();
            let warnings = if as_guessed {
                preview.warnings.clone()
            } else {
                Vec::new()
            };
            match import_with(path.clone(), settings, warnings, None, context) {
                Some(FileEvent::Failed { message }) => {
                    preview.ambiguities.push(format!(
                        "The settings used last time no longer work: {message}"
                    ));
                    Some(FileEvent::Ask {
                        path,
                        preview: Box::new(preview),
                    })
                }
                event => event,
            }
        }
        None if preview.needs_dialog() => Some(FileEvent::Ask {
            path,
            preview: Box::new(preview),
        }),
        // What the header leaves open was guessed without asking, so it is reported.
        None => import_with(path, preview.settings, preview.warnings, None, context),
    }
}

/// Answers what an instrument's volts stand for as it was answered before for recordings of this folder, and
/// says so.
pub(super) fn take_known_sensitivities(path: &Path, preview: &mut Preview) {
    for known in recent::sensitivities_for(path) {
        let channels = [Channel::ProofMass, Channel::Cantilever];
        let channel = channels.into_iter().find(|c| c.symbol() == known.channel);
        let choice = channel.and_then(|channel| preview.settings.choice(channel));
        let is_open = |choice: &ColumnChoice| choice.scale.is_none() && choice.unit == known.unit;
        if !choice.is_some_and(is_open) {
            continue;
        }
        let choices = ReadingChoices {
            scales: vec![(known.channel.clone(), known.scale.clone())],
            ..ReadingChoices::default()
        };
        if choices.apply(preview).is_ok() {
            let message = format!(
                "{}: {} is taken, as given before for recordings of this folder",
                known.channel, known.scale
            );
            let kind = WarningKind::KnownSensitivity;
            let warning = ImportWarning::new(kind, 1, None, &message);
            preview.warnings.push(warning);
        }
    }
}

fn open_toml(path: PathBuf, context: &Context) -> FileEvent {
    if session::is_session(&path) {
        return match session::load(&path) {
            Ok(mut loaded) => {
                for message in std::mem::take(&mut loaded.missing) {
                    let message = format!("{}: {message}", path.display());
                    let _ = context.send.send(FileEvent::Failed { message });
                }
                recent::remember(&path, None);
                FileEvent::Session {
                    path,
                    loaded: Box::new(loaded),
                }
            }
            Err(error) => FileEvent::Failed {
                message: format!("{error}; the file was not changed"),
            },
        };
    }
    if let Ok(text) = std::fs::read_to_string(&path)
        && is_lesson_text(&text)
    {
        return match Lesson::parse(&path.to_string_lossy(), &text) {
            Ok(lesson) => {
                recent::remember(&path, None);
                FileEvent::Lesson {
                    lesson: Box::new(lesson),
                }
            }
            Err(error) => failed(&error),
        };
    }
    if std::fs::read_to_string(&path).is_ok_and(|text| is_waveform_file(&text)) {
        recent::remember(&path, None);
        return drawn_from(&path);
    }
    match Preset::load(&path.to_string_lossy()) {
        Ok(preset) => {
            recent::remember(&path, None);
            FileEvent::Preset {
                preset: Box::new(preset),
            }
        }
        Err(error) => failed(&error),
    }
}

/// Imports a recording; `None` if it was cancelled. `warnings` about its header are put
/// before those about its rows.
pub(super) fn import_with(
    path: PathBuf,
    settings: ImportSettings,
    mut warnings: Vec<ImportWarning>,
    entry: Option<RecordingEntry>,
    context: &Context,
) -> Option<FileEvent> {
    let progress = |share: f32| context.progress(share);
    Some(match import(&path, &settings, Some(&progress)) {
        Ok(mut recording) => {
            warnings.append(&mut recording.warnings);
            recording.warnings = warnings;
            let expected = entry.as_ref().and_then(|entry| entry.sha256.as_ref());
            if expected.is_some() && expected != recording.sha256.as_ref() {
                changed(&path)
            } else {
                // Ten million samples take a second or two, and the window asks for it.
                let _ = recording.drive(DriveReading::Recognised);
                if entry.is_none() {
                    recent::remember(&path, Some(&settings));
                }
                FileEvent::Recording {
                    path,
                    settings: Box::new(settings),
                    recording: Arc::new(recording),
                    entry: entry.map(Box::new),
                }
            }
        }
        Err(ImportError::Cancelled { .. }) => return None,
        Err(error) => match entry {
            Some(entry) if !path.exists() => FileEvent::Lost {
                id: entry.id,
                message: format!("{error}. The recording stays in the session"),
            },
            _ => failed(&error),
        },
    })
}

/// Asks for the settings of one of several recordings of a file.
pub(super) fn ask_trial(path: PathBuf, trial: usize) -> FileEvent {
    let choices = ReadingChoices {
        trial: Some(trial),
        ..ReadingChoices::default()
    };
    match preview_chosen(&path, &choices) {
        Ok(mut preview) => {
            take_known_sensitivities(&path, &mut preview);
            FileEvent::Ask {
                path,
                preview: Box::new(preview),
            }
        }
        Err(error) => failed(&error),
    }
}

/// Reads a drawn waveform from its file.
pub(super) fn drawn_from(path: &Path) -> FileEvent {
    match load(path) {
        Ok(drawn) => FileEvent::Drawn {
            drawn: Box::new(drawn),
        },
        Err(error) => failed(&error),
    }
}

/// Reads the voltage of a file as a drive.
pub(super) fn drive_from(path: &Path) -> FileEvent {
    let (time, voltage) = match import_voltage(path) {
        Ok(table) => table,
        Err(error) => return failed(&error),
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match drive_of_samples(&name, time, voltage, DriveReading::Recognised) {
        Ok(waveform) => FileEvent::Drive { waveform },
        Err(error) => failed(&error),
    }
}

fn changed(path: &Path) -> FileEvent {
    FileEvent::Failed {
        message: format!(
            "{}: the file has changed since the session was saved, so it was not loaded. Open it again if the change is intended",
            path.display()
        ),
    }
}
