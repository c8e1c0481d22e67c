//! Takes the results of file work: recordings, presets and sessions that were read, files
//! that were saved, and failures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::explore;
use super::save::save;
use crate::app::analysis::diagnosis::Diagnosing;
use crate::app::analysis::fit::Fitting;
use crate::app::analysis::identification::Identification;
use crate::app::files::event::{FileEvent, Purpose};
use crate::app::files::session;
use crate::app::files::session_text::{Loaded, RecordingEntry, own_drive};
use crate::app::kept;
use crate::app::services::Services;
use crate::app::setup::current_setup::choose_preset;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::notice::About;
use crate::app::setup::overlay::{Estimates, Overlay, OverlayId};
use crate::app::setup::own_drive::OwnDrive;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::Cursors;
use crate::model::unit::format_quantity;
use crate::recording::Recording;
use crate::recording::align::{Aligned, Alignment};
use crate::recording::csv::ImportSettings;

/// Takes the results of file work; returns whether there were any.
pub fn receive(services: &mut Services) -> bool {
    let events = services.files.poll();
    let any = !events.is_empty();
    for event in events {
        match event {
            FileEvent::Recording {
                path,
                settings,
                recording,
                entry,
            } => {
                let read = Arc::clone(&recording);
                let id = add_recording(services, path, *settings, recording, entry.map(|e| *e));
                for warning in &read.warnings {
                    let text = format!("{}: {}", read.name, warning.message);
                    services.notice_about(Some(About::Recording(id)), false, text);
                }
            }
            FileEvent::Ask { path, preview } => {
                let known = services
                    .state
                    .setup
                    .overlays
                    .iter()
                    .find(|o| o.recording.path.as_ref() == Some(&path))
                    .map(|o| o.import.clone());
                let open = services.state.setup.overlays.iter();
                let runs = open.filter_map(|o| o.recording.path.clone()).collect();
                services.dialogs.know_runs(runs);
                services.dialogs.ask_import(path, *preview, known);
            }
            FileEvent::Preset { preset } => {
                choose_preset(&mut services.state.setup, &preset);
            }
            FileEvent::Session { path, loaded } => adopt_session(services, path, *loaded),
            FileEvent::Saved {
                purpose,
                path,
                remark,
            } => {
                services.notice(false, format!("Saved {}", path.display()));
                if let Some(remark) = remark {
                    services.notice(false, remark);
                }
                if purpose == Purpose::Session {
                    services.session_path = Some(path);
                }
            }
            FileEvent::Aligned { id, found } => shift_recording(services, id, &found),
            FileEvent::Failed { message } => services.fail(message),
            FileEvent::Lost { id, message } => services.report_missing(id, message),
            FileEvent::Drive { waveform } => {
                services.state.setup.drive = DriveChoice::Waveform(waveform);
            }
            FileEvent::Lesson { lesson } => {
                let state = &mut services.state;
                state.learning.take(*lesson);
                WorkspaceId::Learn
                    .name()
                    .clone_into(&mut state.view.workspace);
            }
            FileEvent::Drawn { drawn } => explore::opened(services, *drawn),
            FileEvent::TypePath { purpose } => {
                if !services.dialogs.is_open() {
                    services.dialogs.ask_path(purpose);
                }
            }
            FileEvent::SaveTo { purpose, path } => save(services, purpose, path),
        }
    }
    any
}

fn shift_recording(services: &mut Services, id: OverlayId, found: &Aligned) {
    let overlays = &mut services.state.setup.overlays;
    if let Some(overlay) = overlays.iter_mut().find(|overlay| overlay.id == id) {
        overlay.alignment.time_shift = found.time_shift;
        let text = format!(
            "{}: shifted by {}; correlation {:.3} over {:.0} % of the recording",
            overlay.recording.name,
            format_quantity(found.time_shift, "s", 4),
            found.correlation.abs(),
            100.0 * found.share
        );
        services.notice(false, text);
    }
}

/// Replaces the present session by the one that was read.
fn adopt_session(services: &mut Services, path: PathBuf, loaded: Loaded) {
    services.last_overlay_id = services.last_overlay_id.max(loaded.last_id());
    for text in &loaded.missing {
        services.notice(true, text.clone());
    }
    services.requested_files = (loaded.recordings.iter())
        .filter_map(|entry| entry.path.clone())
        .collect();
    services.missing_recordings = loaded.recordings.clone();
    // An autosaved session belongs to its window, which may be open: what is saved on demand
    // goes to a file that the person names.
    services.session_path = Some(path).filter(|path| !session::is_autosaved(path));
    services.shows_hint = false;
    let state = &mut services.state;
    // The former session's results and cursors end with it; the tally of sealed trials belongs to
    // the person.
    let tally = state.diagnosing.trial.tally;
    state.stop_jobs();
    state.fitting = Fitting::default();
    state.identification = Identification::default();
    state.diagnosing = Diagnosing::default();
    state.diagnosing.trial.tally = tally;
    state.scrub = None;
    state.paused = false;
    state.cursors = Cursors::default();
    state.selected = loaded.setup.overlays.first().map(|overlay| overlay.id);
    services
        .speed_set_for
        .clone_from(&loaded.setup.preset.model.name);
    state.setup = loaded.setup;
    state.view = loaded.view;
    if let Some(lost) = kept::restore(state, &loaded.results) {
        services.notice(true, lost);
    }
    for entry in &loaded.recordings {
        services.files.import_session_recording(entry);
    }
}

/// Whether a file is a preset or a session.
fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "toml")
}

/// Adds a recording; one read again from the same file replaces the earlier one. Returns
/// its number.
fn add_recording(
    services: &mut Services,
    path: PathBuf,
    settings: ImportSettings,
    recording: Arc<Recording>,
    entry: Option<RecordingEntry>,
) -> OverlayId {
    // Opened again by hand, it takes the place of the one that the session misses.
    services.forget_missing(|absent| match &entry {
        Some(entry) => absent.id == entry.id,
        None => absent.path.as_deref() == Some(&*path),
    });
    let overlays = &mut services.state.setup.overlays;
    let former = overlays
        .iter()
        .position(|o| o.recording.path.as_deref() == Some(&path));
    // Its place among files that were requested together.
    let order = &services.requested_files;
    let rank = |path: &PathBuf| order.iter().position(|asked| asked == path);
    let own_rank = rank(&path);
    let (alignment, color, visible, role, drive, estimates) = match (&entry, former) {
        // A drive that cannot be read was refused when the session was opened.
        (Some(entry), _) => (
            entry.alignment,
            entry.color,
            entry.visible,
            entry.role,
            own_drive(entry.drive.as_ref(), services.state.setup.duration).unwrap_or_default(),
            entry.estimates,
        ),
        (None, Some(i)) => {
            let former = &overlays[i];
            (
                former.alignment,
                former.color,
                true,
                former.role,
                former.drive.clone(),
                former.estimates,
            )
        }
        (None, None) => {
            let recordings = order.iter().filter(|path| !is_toml(path));
            let before = own_rank.map(|_| recordings.take_while(|asked| **asked != path).count());
            let color = before
                .into_iter()
                .chain(0..)
                .find(|c| overlays.iter().all(|o| o.color != *c))
                .unwrap_or(0);
            (
                Alignment::default(),
                color,
                true,
                None,
                OwnDrive::default(),
                Estimates::default(),
            )
        }
    };
    // New data take a new number: results computed for the old number no longer hold.
    let id = match &entry {
        Some(entry) => entry.id,
        None => {
            services.last_overlay_id += 1;
            services.last_overlay_id
        }
    };
    let overlay = Overlay {
        id,
        recording,
        import: settings,
        alignment,
        drive,
        estimates,
        visible,
        color,
        made_up: false,
        role,
    };
    match former {
        Some(i) => {
            if services.state.setup.drive == DriveChoice::Recorded(overlays[i].id) {
                services.state.setup.drive = DriveChoice::Recorded(id);
            }
            overlays[i] = overlay;
        }
        None => {
            let later = |o: &Overlay| o.recording.path.as_ref().and_then(rank) > own_rank;
            let at = own_rank.and_then(|_| overlays.iter().position(later));
            overlays.insert(at.unwrap_or(overlays.len()), overlay);
        }
    }
    services.state.selected = Some(id);
    id
}
