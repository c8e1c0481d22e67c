//! Takes over what has become of files that were opened, read or saved.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::save::save;
use crate::app::analysis::diagnosis::Diagnosing;
use crate::app::files::event::{FileEvent, Purpose};
use crate::app::files::session_text::{Loaded, RecordingEntry};
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::notice::About;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::shell::reference_curve::Return;
use crate::app::shell::window::{Shell, import_entry};
use crate::app::state::Cursors;
use crate::model::unit::format_quantity;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;

/// Takes over what has become of files; returns whether anything has.
pub fn take(shell: &mut Shell) -> bool {
    let events = shell.files.poll();
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
                let id = add_recording(shell, path, settings, recording, entry);
                for warning in &read.warnings {
                    let text = format!("{}: {}", read.name, warning.message);
                    shell.notice_of(Some(About::Recording(id)), false, text);
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
            FileEvent::Preset { preset } => {
                crate::app::setup::setup::choose_preset(&mut shell.state.setup, &preset)
            }
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
            FileEvent::Failed { message } => shell.fail(message),
            FileEvent::Lost { id, message } => shell.lost(id, message),
            FileEvent::Drive { waveform } => {
                shell.state.setup.drive = DriveChoice::Waveform(waveform);
            }
            FileEvent::Kept { kept, run } => {
                // It may have been dropped meanwhile, or another one kept.
                if shell.state.view.kept.as_ref() == Some(&*kept) {
                    match run {
                        Ok(run) => shell.state.ghost = Some(run),
                        Err(reason) => {
                            shell.fail(format!("The kept curve (A/B) is not shown: {reason}"));
                        }
                    }
                }
            }
            FileEvent::TypePath { purpose } => {
                if !shell.dialogs.is_open() {
                    shell.dialogs.ask_path(purpose);
                }
            }
            FileEvent::SaveTo { purpose, path } => save(shell, purpose, path),
        }
    }
    any
}

/// Shows a session in place of what is shown.
fn adopt_session(shell: &mut Shell, path: PathBuf, loaded: Loaded) {
    shell.next_overlay = shell.next_overlay.max(loaded.last_id());
    for text in &loaded.missing {
        shell.notice(true, text.clone());
    }
    shell.order = (loaded.recordings.iter())
        .filter_map(|entry| entry.path.clone())
        .collect();
    shell.absent = loaded.recordings.clone();
    shell.session_path = Some(path);
    shell.hint = false;
    let state = &mut shell.state;
    // What belongs to the former session ends with it.
    state.ghost = None;
    shell.kept = Return::Open;
    let state = &mut shell.state;
    let tally = state.diagnosing.trial.tally;
    state.diagnosing = Diagnosing::default();
    state.diagnosing.trial.tally = tally;
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

/// Whether a file is a preset or a session.
fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "toml")
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
    // Where it stands among files that were asked for together.
    let order = &shell.order;
    let rank = |path: &PathBuf| order.iter().position(|asked| asked == path);
    let own_rank = rank(&path);
    let (alignment, color, visible, role) = match (&entry, former) {
        (Some(entry), _) => (entry.alignment, entry.color, entry.visible, entry.role),
        (None, Some(i)) => {
            let former = &overlays[i];
            (former.alignment, former.color, true, former.role)
        }
        (None, None) => {
            let recordings = order.iter().filter(|path| !is_toml(path));
            let before = own_rank.map(|_| recordings.take_while(|asked| **asked != path).count());
            let color = before
                .into_iter()
                .chain(0..)
                .find(|c| overlays.iter().all(|o| o.color != *c))
                .unwrap_or(0);
            (Alignment::default(), color, true, None)
        }
    };
    if let Some(entry) = &entry {
        shell.absent.retain(|absent| absent.id != entry.id);
        let lost = Some(About::Lost(entry.id));
        shell.state.notices.retain(|notice| notice.about != lost);
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
        role,
    };
    match former {
        Some(i) => {
            if shell.state.setup.drive == DriveChoice::Recorded(overlays[i].id) {
                shell.state.setup.drive = DriveChoice::Recorded(id);
            }
            overlays[i] = overlay;
        }
        None => {
            let later = |o: &Overlay| o.recording.path.as_ref().and_then(rank) > own_rank;
            let at = own_rank.and_then(|_| overlays.iter().position(later));
            overlays.insert(at.unwrap_or(overlays.len()), overlay);
        }
    }
    shell.state.selected = Some(id);
    id
}
