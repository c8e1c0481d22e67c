//! `--screenshot`: saves a picture of the window once nothing moves any more, and closes it.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui;
use eframe::egui::{Ui, ViewportCommand};

use super::options::AppError;
use crate::app::services::Services;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::workspace_id::WorkspaceId;

/// Frames without work before the picture is taken: the layout has then settled.
const SETTLED_FRAMES: u32 = 12;
/// Time after which the picture is taken even if work goes on \[s\].
const MAX_WAIT: f64 = 120.0;

/// Outcome of `--screenshot`, handed out of the event loop.
pub type PictureOutcome = Arc<Mutex<Option<Result<(), AppError>>>>;

/// A picture to be taken.
pub(super) struct Screenshot {
    path: PathBuf,
    /// Frames without work so far.
    settled_frames: u32,
    outcome: PictureOutcome,
}

impl Screenshot {
    /// A picture to be saved to `path`.
    pub(super) fn new(path: PathBuf, outcome: PictureOutcome) -> Self {
        Self {
            path,
            settled_frames: 0,
            outcome,
        }
    }

    /// Called once a frame: takes the picture when the window has settled. `is_broken`: the
    /// simulator gives no more results.
    pub(super) fn update(&mut self, services: &mut Services, ui: &Ui, is_broken: bool) {
        let busy = is_busy(services, is_broken) && ui.input(|input| input.time) < MAX_WAIT;
        ui.ctx().request_repaint();
        if busy {
            self.settled_frames = 0;
            return;
        }
        self.settled_frames += 1;
        if self.settled_frames != SETTLED_FRAMES {
            return;
        }
        let failure = services.first_failure.take();
        let (path, outcome) = (self.path.clone(), Arc::clone(&self.outcome));
        let context = ui.ctx().clone();
        let callback = egui::ScreenshotCallback::new(move |image| {
            let [width, height] = image.size;
            let result = image::save_buffer(
                &path,
                image.as_raw(),
                width as u32,
                height as u32,
                image::ColorType::Rgba8,
            )
            .map_err(|error| AppError::Screenshot(format!("{}: {error}", path.display())))
            .and_then(|()| failure.map_or(Ok(()), |message| Err(AppError::File(message))));
            *outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            context.send_viewport_cmd(ViewportCommand::Close);
        });
        ui.ctx()
            .send_viewport_cmd(ViewportCommand::Screenshot(callback));
    }
}

/// Whether work in progress will still change the window.
fn is_busy(services: &Services, is_broken: bool) -> bool {
    let state = &services.state;
    if services.files.pending() > 0 {
        return true;
    }
    if state.view.workspace == WorkspaceId::Explore.name() && state.exploring.is_busy() {
        return true;
    }
    if state.view.workspace == WorkspaceId::Learn.name() && state.learning.is_busy() {
        return true;
    }
    if !state.kept_runs.are_complete(&state.setup.kept) {
        return true;
    }
    if state.refusal.is_some() || is_broken {
        return false;
    }
    let Some(snapshot) = &state.snapshot else {
        return true;
    };
    state.view.mode == Mode::WholeSpan
        && (snapshot.features.is_none()
            || snapshot.comparisons.iter().any(|c| c.features.is_none()))
}
