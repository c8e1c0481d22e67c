//! Saving and exporting, on a thread of their own: a trace has millions of lines, and a
//! disk may be slow.

use std::path::{Path, PathBuf};

use super::explore;
use crate::app::export;
use crate::app::export::film::FilmRequest;
use crate::app::files::atomic_write::write_atomically;
use crate::app::files::event::{FileEvent, Purpose};
use crate::app::files::session_text::RecordingEntry;
use crate::app::files::{recent, session};
use crate::app::flows::sealed_trial::own_setup;
use crate::app::kept::{Kept, Memo};
use crate::app::services::Services;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::state::State;
use crate::diagnose::report;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::events::events_csv;

/// Why nothing can be exported.
const MISSING_RUN_REASON: &str = "there is no simulated run yet";

/// Saves the present state to a path, in the form that `purpose` names.
pub fn save(services: &mut Services, purpose: Purpose, path: PathBuf) {
    if purpose == Purpose::Film
        && let Some(request) = services.film.take()
    {
        return film(services, request, path);
    }
    let (state, absent) = (services.state.clone(), services.missing_recordings.clone());
    services.files.work("saving", path.clone(), move |_| {
        Some(match write(&state, &absent, purpose, &path) {
            Ok(()) => FileEvent::Saved {
                purpose,
                path,
                remark: remark(&state, purpose),
            },
            Err(reason) => FileEvent::Failed {
                message: format!("Saving failed: {reason}"),
            },
        })
    });
}

/// Writes a film; it can be cancelled.
fn film(services: &Services, request: FilmRequest, path: PathBuf) {
    services
        .files
        .work("filming", path.clone(), move |context| {
            let progress = |share: f32| context.progress(share);
            Some(match export::film::write(&request, &path, &progress) {
                Ok(true) => FileEvent::Saved {
                    purpose: Purpose::Film,
                    path,
                    remark: None,
                },
                Ok(false) => return None,
                Err(reason) => FileEvent::Failed {
                    message: format!("No film was made: {reason}"),
                },
            })
        });
}

fn write(
    state: &State,
    absent: &[RecordingEntry],
    purpose: Purpose,
    path: &Path,
) -> Result<(), String> {
    let text = |error: &dyn std::error::Error| error.to_string();
    let trace = || match &state.snapshot {
        Some(snapshot) => Ok(&*snapshot.trace),
        None => Err(MISSING_RUN_REASON.to_owned()),
    };
    let answer = || match state.diagnosing.shown() {
        Some(answer) => Ok(&answer.diagnosis),
        None => Err("there is no diagnosis yet".to_owned()),
    };
    match purpose {
        Purpose::Session => {
            let results = Kept::of(state).text(&Memo::default());
            session::save_with_results(path, own_setup(state), &state.view, absent, &results)
                .map_err(|e| text(&e))?;
            recent::remember(path, None);
            Ok(())
        }
        Purpose::Preset => {
            write_atomically(path, preset(state).to_toml().as_bytes()).map_err(|e| text(&e))
        }
        Purpose::Diagnosed => {
            let mut preset = preset(state);
            preset.model = answer()?.model.clone();
            write_atomically(path, preset.to_toml().as_bytes()).map_err(|e| text(&e))
        }
        Purpose::Report => {
            write_atomically(path, report::html(answer()?).as_bytes()).map_err(|e| text(&e))
        }
        Purpose::Diagnosis => {
            let json = serde_json::to_string_pretty(&report::json(answer()?));
            let json = json.map_err(|e| text(&e))? + "\n";
            write_atomically(path, json.as_bytes()).map_err(|e| text(&e))
        }
        Purpose::Svg => trace().and_then(|_| export::svg(path, state).map_err(|e| text(&e))),
        Purpose::Png => trace().and_then(|_| export::png(path, state).map_err(|e| text(&e))),
        Purpose::Trace => {
            let snapshot = state.snapshot.as_ref().ok_or(MISSING_RUN_REASON)?;
            write_atomically(path, &export::trace_csv::text(snapshot)?).map_err(|e| text(&e))
        }
        Purpose::Answers => {
            let learning = &state.learning;
            let lessons: Vec<_> = learning.lessons().map(|lesson| &**lesson).collect();
            let table = learning.pupil.csv(&lessons).map_err(|e| text(&e))?;
            write_atomically(path, &table).map_err(|e| text(&e))
        }
        Purpose::Film => Err("there is no film to write; export it again".to_owned()),
        Purpose::Waveform | Purpose::Generator(_) | Purpose::GaitContacts | Purpose::Map => {
            explore::write(state, purpose, path)
        }
        Purpose::Events => events_csv::write(path, &trace()?.events)
            .map_err(|error| format!("{}: {error}", path.display())),
    }
}

/// What is to be known about a saved file.
fn remark(state: &State, purpose: Purpose) -> Option<&'static str> {
    let is_preset = matches!(purpose, Purpose::Preset | Purpose::Diagnosed);
    (is_preset && drive_text(&state.setup.drive).is_none())
        .then_some("Saved with the preset's drive; a preset cannot hold this one.")
}

/// A drive as a preset holds it: in one line, which a table and a recording do not fit.
fn drive_text(drive: &DriveChoice) -> Option<String> {
    match drive {
        DriveChoice::Waveform(Waveform::Table(_)) | DriveChoice::Recorded(_) => None,
        DriveChoice::Waveform(waveform) => Some(waveform.to_string()),
    }
}

/// The present device as a preset, with its drive and span.
fn preset(state: &State) -> Preset {
    let mut preset = state.setup.preset.clone();
    // If the drive does not fit, the preset's own drive stays.
    if let Some(drive) = drive_text(&state.setup.drive) {
        preset.drive = drive;
    }
    preset.duration = state.setup.duration;
    preset
}
