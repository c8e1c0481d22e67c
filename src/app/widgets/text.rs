//! Small pieces of text: sizes, headings, times, axis numbers and shortened names.

use std::ops::RangeInclusive;

use eframe::egui::{RichText, Ui};
use egui_plot::{GridInput, GridMark, uniform_grid_spacer};

use crate::app::plots::frame::axes::{round_step, tick};
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::OverlayId;

/// Text a little smaller than the rest, still readable.
pub(crate) fn small(text: impl Into<String>) -> RichText {
    RichText::new(text).size(11.5)
}

/// Colour of errors in the current theme.
pub(crate) fn error_color(ui: &Ui) -> eframe::egui::Color32 {
    crate::app::theme::error(ui.visuals().dark_mode)
}

/// Grid lines at round values, about six across the plot.
pub(crate) fn round_steps() -> impl Fn(GridInput) -> Vec<GridMark> {
    uniform_grid_spacer(|input| {
        let step = step_of(input.bounds.0, input.bounds.1);
        [step / 5.0, step, 10.0 * step]
    })
}

/// Distance of the grid lines on an axis from `low` to `high`.
pub(crate) fn step_of(low: f64, high: f64) -> f64 {
    round_step((high - low) / 6.0)
}

/// Number at a grid line, with the same digits along the axis.
pub(crate) fn round_text(mark: GridMark, range: &RangeInclusive<f64>) -> String {
    tick(GridMark {
        step_size: step_of(*range.start(), *range.end()),
        ..mark
    })
}

/// The title of a part of a panel.
pub(crate) fn heading(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).strong());
}

/// Name of a recording; its number if it was removed.
pub(crate) fn name_of(setup: &Setup, id: OverlayId) -> String {
    let overlay = setup.overlays.iter().find(|overlay| overlay.id == id);
    overlay.map_or_else(
        || format!("#{id}"),
        |overlay| overlay.recording.name.clone(),
    )
}

/// A name of at most `limit` characters. The middle is cut, because the names of a series
/// differ at the end.
pub(crate) fn short(name: &str, limit: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= limit {
        return name.to_owned();
    }
    let end = limit / 2;
    let start: String = letters[..limit - end - 1].iter().collect();
    let end: String = letters[letters.len() - end..].iter().collect();
    format!("{}\u{2026}{}", start.trim_end(), end.trim_start())
}
