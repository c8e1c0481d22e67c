//! `--screenshot`: a picture of the settled window.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui;
use eframe::egui::{Ui, ViewportCommand};

use super::options::AppError;
use super::window::Shell;
use crate::app::setup::drive_choice::Mode;

/// Quiet frames before the picture is taken.
const SETTLED_FRAMES: u32 = 12;
/// Time after which it is taken as things are [s].
const PATIENCE: f64 = 120.0;

/// Outcome of `--screenshot`, handed out of the event loop.
pub type PictureOutcome = Arc<Mutex<Option<Result<(), AppError>>>>;

/// A picture to be taken: where to, and for how many frames the window is quiet.
pub(super) type Wanted = (PathBuf, u32);

impl Shell {
    /// Says that something failed; a picture of the window is then no success.
    pub(in crate::app) fn fail(&mut self, message: String) {
        if self.picture.is_some() {
            self.failed.get_or_insert_with(|| message.clone());
        }
        self.notice(true, message);
    }

    /// Whether there is more to come without anybody's doing.
    fn is_busy(&self) -> bool {
        let state = &self.state;
        if self.files.pending() > 0 {
            return true;
        }
        if state.refusal.is_some() || self.broken {
            return false;
        }
        let Some(snapshot) = &state.snapshot else {
            return true;
        };
        state.view.mode == Mode::Window
            && (snapshot.features.is_none()
                || snapshot.comparisons.iter().any(|c| c.features.is_none()))
    }

    /// Takes the picture of `--screenshot` once nothing moves any more.
    pub(super) fn picture(&mut self, ui: &Ui) {
        let busy = self.is_busy() && ui.input(|input| input.time) < PATIENCE;
        let Some((path, frames)) = &mut self.picture else {
            return;
        };
        ui.ctx().request_repaint();
        if busy {
            *frames = 0;
            return;
        }
        *frames += 1;
        if *frames != SETTLED_FRAMES {
            return;
        }
        let failed = self.failed.take();
        let (path, outcome, context) = (path.clone(), Arc::clone(&self.outcome), ui.ctx().clone());
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
            .and_then(|()| failed.map_or(Ok(()), |message| Err(AppError::File(message))));
            *outcome.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            context.send_viewport_cmd(ViewportCommand::Close);
        });
        ui.ctx()
            .send_viewport_cmd(ViewportCommand::Screenshot(callback));
    }
}
