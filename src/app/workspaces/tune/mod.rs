//! The Tune workspace: sliders on the left, plots in the middle, recordings, readouts and tools
//! on the right, time controls at the top.

pub(crate) mod differences;
pub mod drive;
pub(crate) mod fit;
mod kept_curves;
mod misfit_line;
mod parameters;
mod readouts;
pub(crate) mod recordings;
mod sensitivity;
mod start;
pub mod table_a1;
#[cfg(test)]
mod tests;
mod tools;
pub(crate) mod transport;

pub use self::recordings::remove as remove_recording;
pub use self::start::start_from_recording;
pub use self::transport::{speed_text, usual_speed};
pub use crate::app::setup::current_setup::choose_preset;

use eframe::egui::{CentralPanel, Id, Panel, Ui};

use crate::app::plots;
use crate::app::state::State;

/// Width of a window below which the panel of recordings and readouts starts closed \[points\]:
/// less than the sliders, the panel and readable plots need.
const NARROW_WINDOW: f32 = 1000.0;
/// Width of the sliders before a person changes it, and its limits \[points\].
const SLIDER_WIDTH: f32 = 350.0;
const SLIDER_WIDTHS: (f32, f32) = (250.0, 480.0);
/// Largest share of the window that the sliders take.
const SLIDER_SHARE: f32 = 0.34;

/// Draws the workspace.
pub fn show(ui: &mut Ui, state: &mut State) {
    let width = ui.available_width();
    close_readouts_in_narrow_window(ui, state, width);
    transport::show(ui, state);
    let (least, most) = SLIDER_WIDTHS;
    let most = (SLIDER_SHARE * width).clamp(least, most);
    Panel::left("tune parameters")
        .default_size(SLIDER_WIDTH.min(most))
        .size_range(least..=most)
        .show(ui, |ui| parameters::show(ui, state));
    state.fitting.poll(&state.setup);
    state.sensing.hovered = None;
    let busy = ui.input(|input| input.pointer.any_down());
    let snapshot = state.snapshot.as_ref();
    (state.sensing).update(&state.setup, snapshot, busy, ui.ctx());
    tools::show(ui, state);
    CentralPanel::default().show(ui, |ui| {
        misfit_line::show(ui, state);
        plots::show(ui, state);
    });
}

/// Closes the panel of recordings and readouts when the window becomes narrow, and opens it again
/// when there is room. A person can open it in a narrow window too.
fn close_readouts_in_narrow_window(ui: &Ui, state: &mut State, width: f32) {
    let key = Id::unique("readouts closed for lack of room");
    let is_narrow = width < NARROW_WINDOW;
    let was: Option<(bool, bool)> = ui.data(|data| data.get_temp(key));
    let (was_narrow, closed_here) = was.unwrap_or_default();
    let mut closed = closed_here;
    if is_narrow && !was_narrow {
        closed = std::mem::take(&mut state.view.side_panel);
    } else if !is_narrow && was_narrow {
        state.view.side_panel |= std::mem::take(&mut closed);
    }
    ui.data_mut(|data| data.insert_temp(key, (is_narrow, closed)));
}
