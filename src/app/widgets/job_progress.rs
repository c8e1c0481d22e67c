//! A running job: the button that cancels it, and its progress bar.

use eframe::egui::{Button, ProgressBar, Ui};

use super::text::small;
use crate::app::analysis::job::Job;

/// Greatest width of a progress bar \[points\]. In a narrow panel it takes the room there is.
const MAX_BAR_WIDTH: f32 = 330.0;

/// Help of a button that cancels work with a usable result so far.
pub const STOP_HELP: &str = "Stop and keep the best result so far";

/// A button that cancels `job`; disabled once it was pressed.
pub fn cancel_button<P, T>(ui: &mut Ui, job: &Job<P, T>, help: &str)
where
    P: Send + 'static,
    T: Send + 'static,
{
    let cancel = ui.add_enabled(!job.is_cancelled(), Button::new("Cancel"));
    if cancel.on_hover_text(help).clicked() {
        job.cancel();
    }
}

/// A bar that is filled to `share`, 0..1, with `text` on it.
pub fn progress_bar(ui: &mut Ui, share: f32, text: impl Into<String>) {
    let color = ui.visuals().strong_text_color();
    let bar = ProgressBar::new(share.clamp(0.0, 1.0))
        .text(small(text).color(color))
        .desired_width(ui.available_width().min(MAX_BAR_WIDTH));
    ui.add(bar);
}
