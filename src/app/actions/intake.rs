//! Takes over what has become of files that were opened, read or saved.

use std::path::PathBuf;
use std::sync::Arc;

use super::save::save;
use crate::app::files::{FileEvent, Purpose};
use crate::app::session::{Loaded, RecordingEntry};
use crate::app::setup::{DriveChoice, Overlay, OverlayId};
use crate::app::shell::{Shell, import_entry};
use crate::app::state::Cursors;
use crate::app::workspaces::tune;
use crate::model::unit::format_quantity;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;

/// Takes over what has become of files.
pub fn take(shell: &mut Shell) {
    for event in shell.files.poll() {
        match event {
            FileEvent::Recording {
                path,
                settings,
                recording,
                entry,
            } => {
                let read = Arc::clone(&recording);
                let id = add_recording(shell, path, settings, recording, entry);
                for warning in &read.warnings {
                    let text = format!("{}: {}", read.name, warning.message);
                    shell.notice_of(Some(id), false, text);
                }
            }
            FileEvent::Ask { path, preview } => {
                let known = shell
                    .state
                    .setup
                    .overlays
                    .iter()
                    .find(|o| o.recording.path.as_ref() == Some(&path))
                    .map(|o| o.import.clone());
                shell.dialogs.ask_import(path, preview, known);
            }
            FileEvent::Preset { preset } => tune::choose_preset(&mut shell.state.setup, &preset),
            FileEvent::Session { path, loaded } => adopt_session(shell, path, *loaded),
            FileEvent::Saved { purpose, path } => {
                shell.notice(false, format!("Saved {}", path.display()));
                if purpose == Purpose::Session {
                    shell.session_path = Some(path);
                }
            }
            FileEvent::Aligned { id, found } => {
                let overlays = &mut shell.state.setup.overlays;
                if let Some(overlay) = overlays.iter_mut().find(|overlay| overlay.id == id) {
                    overlay.alignment.time_shift = found.time_shift;
                    let text = format!(
                        "{}: shifted by {}; correlation {:.3} over {:.0} % of it",
                        overlay.recording.name,
                        format_quantity(found.time_shift, "s", 4),
                        found.correlation.abs(),
                        100.0 * found.share
                    );
                    shell.notice(false, text);
                }
            }
            FileEvent::Failed { message } => shell.notice(true, message),
            FileEvent::SaveTo { purpose, path } => save(shell, purpose, path),
        }
    }
}

/// Shows a session in place of what is shown.
fn adopt_session(shell: &mut Shell, path: PathBuf, loaded: Loaded) {
    shell.next_overlay = shell.next_overlay.max(loaded.last_id());
    for text in &loaded.missing {
        shell.notice(true, text.clone());
    }
    shell.absent = loaded.recordings.clone();
    shell.session_path = Some(path);
    shell.hint = false;
    let state = &mut shell.state;
    // What belongs to the former session ends with it.
    state.ghost = None;
    state.scrub = None;
    state.paused = false;
    state.cursors = Cursors::default();
    state.selected = loaded.setup.overlays.first().map(|overlay| overlay.id);
    shell.speed_of.clone_from(&loaded.setup.preset.model.name);
    state.setup = loaded.setup;
    state.view = loaded.view;
    for entry in &loaded.recordings {
        import_entry(&shell.files, entry);
    }
}

/// Adds a recording; one read again from the same file replaces its former self. Returns
/// its number.
fn add_recording(
    shell: &mut Shell,
    path: PathBuf,
    settings: ImportSettings,
    recording: Arc<Recording>,
    entry: Option<RecordingEntry>,
) -> OverlayId {
    let overlays = &mut shell.state.setup.overlays;
    let former = overlays
        .iter()
        .position(|o| o.recording.path.as_deref() == Some(&path));
    let (alignment, color, visible) = match (&entry, former) {
        (Some(entry), _) => (entry.alignment, entry.color, entry.visible),
        (None, Some(i)) => (overlays[i].alignment, overlays[i].color, true),
        (None, None) => {
            let color = (0..)
                .find(|c| overlays.iter().all(|o| o.color != *c))
                .unwrap_or(0);
            (Alignment::default(), color, true)
        }
    };
    if let Some(entry) = &entry {
        shell.absent.retain(|absent| absent.id != entry.id);
    }
    // Data that changed take a new number: what was computed for the old one is void.
    let id = match &entry {
        Some(entry) => entry.id,
        None => {
            shell.next_overlay += 1;
            shell.next_overlay
        }
    };
    let overlay = Overlay {
        id,
        recording,
        import: settings,
        alignment,
        visible,
        color,
        made_up: false,
    };
    match former {
        Some(i) => {
            if shell.state.setup.drive == DriveChoice::Recorded(overlays[i].id) {
                shell.state.setup.drive = DriveChoice::Recorded(id);
            }
            overlays[i] = overlay;
        }
        None => overlays.push(overlay),
    }
    shell.state.selected = Some(id);
    id
}
