//! The relative error of a figure of Table A.1, coloured by its size.

use eframe::egui::{Color32, RichText, Ui};

use crate::app::widgets::text::small;
use crate::fit::table_a1::compare::{Column, Row};

/// Error of a row in figure number `figure`, in the order of
/// [`FEATURE_ROWS`](super::features::FEATURE_ROWS).
pub(crate) fn error(row: &Row, against: Column, figure: usize) -> Option<f64> {
    let errors = row.errors(against);
    [errors.bounces, errors.peak, errors.contact][figure]
}

/// An error with its colour.
pub(crate) fn error_cell(ui: &mut Ui, figure: usize, error: Option<f64>) {
    let Some(error) = error else {
        ui.label(small("-"))
            .on_hover_text("No relative error: a value is missing, or the published one is zero");
        return;
    };
    // Bounces are counted: one bounce too many is coloured like 30 %.
    let (text, badness) = if figure == 0 {
        (format!("{error:+.1}"), 0.3 * error.abs())
    } else {
        (format!("{:+.0} %", 100.0 * error), error.abs())
    };
    ui.label(RichText::new(text).monospace().color(color(ui, badness)));
}

/// Green to red by the size of an error; the number says the same without colour.
pub(crate) fn color(ui: &Ui, badness: f64) -> Color32 {
    let dark = ui.visuals().dark_mode;
    if badness <= 0.1 {
        crate::app::theme::good(dark)
    } else if badness <= 0.3 {
        ui.visuals().warn_fg_color
    } else {
        crate::app::widgets::text::error_color(ui)
    }
}
