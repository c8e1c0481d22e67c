//! The fit of the device to the experiments of Table A.1. It runs on another thread and can be
//! cancelled. The result shows the fitted columns, the error at each frequency when it is left
//! out (cross-validation), and the cases that are not reproduced. The device changes only when
//! the result is applied.

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{Grid, Id, RichText, Ui};

use super::error_cell::{error, error_cell};
use super::features::FEATURE_ROWS;
use crate::app::analysis::job::Job;
use crate::app::state::State;
use crate::app::widgets::job_progress::{STOP_HELP, cancel_button, progress_bar};
use crate::app::widgets::result_buttons::{apply_button, discard_button};
use crate::app::widgets::text::small;
use crate::fit::table_a1::calibrate::{
    FREE_PARAMETERS, MAX_GENERATIONS, Misfit, TABLE_LIMITS, TableFit, fit_table,
};
use crate::fit::table_a1::compare::Column;
use crate::model::Model;
use crate::model::unit::{format_number, format_quantity};

/// Progress of a fit: the share done, and the time left.
pub(crate) type TableFitProgress = (f64, Duration);

/// The running fit and the last result, kept in egui's memory.
#[derive(Debug, Clone, Default)]
pub(crate) struct TableFitState {
    pub(crate) job: Option<Job<TableFitProgress, TableFit>>,
    /// The device that the fit started from.
    pub(crate) base: Option<Arc<Model>>,
    /// The result, or why there is none.
    pub(crate) result: Option<Result<Arc<TableFit>, String>>,
}

/// Key of the state in egui's memory.
pub(crate) fn key() -> Id {
    Id::unique("table fit")
}

/// The running fit, wherever it is shown; `None` if there is none.
pub(crate) fn running(ui: &Ui) -> Option<Job<TableFitProgress, TableFit>> {
    let fit: TableFitState = ui.data(|data| data.get_temp(key()))?;
    fit.job
}

/// Draws the button, or the progress of the fit that it has started.
pub fn controls(ui: &mut Ui, state: &mut State) {
    let mut fit: TableFitState = ui.data(|data| data.get_temp(key())).unwrap_or_default();
    if let Some(result) = fit.job.as_ref().and_then(Job::take) {
        fit.job = None;
        fit.result = Some(result.map(Arc::new));
    }
    ui.horizontal_wrapped(|ui| match fit.job.clone() {
        Some(job) => progress(ui, &job),
        None => {
            let help = "Fit the device to the 16 experiments, then repeat the fit without each frequency. The sliders change only when the result is applied.";
            if ui.button("Fit to the experiments").on_hover_text(help).clicked() {
                fit.start(&state.setup.preset.model, ui);
            }
            ui.label(small("takes a few minutes; starts from the current values").weak());
        }
    });
    ui.data_mut(|data| data.insert_temp(key(), fit));
}

impl TableFitState {
    fn start(&mut self, model: &Model, ui: &Ui) {
        let base = Arc::new(model.clone());
        self.base = Some(Arc::clone(&base));
        self.result = None;
        self.job = Some(Job::start("table fit", ui.ctx(), move |control| {
            let started = Instant::now();
            let fit = fit_table(&base, MAX_GENERATIONS, |share| {
                let left = started.elapsed().mul_f64((1.0 - share) / share);
                control.report((share, left));
                !control.cancel().load(std::sync::atomic::Ordering::Relaxed)
            });
            Ok(fit)
        }));
    }
}

fn progress(ui: &mut Ui, job: &Job<TableFitProgress, TableFit>) {
    cancel_button(ui, job, STOP_HELP);
    match job.progress() {
        Some((share, left)) => {
            let text = format!("about {:.0} s left", left.as_secs_f64());
            progress_bar(ui, share as f32, text);
        }
        None => {
            ui.spinner();
        }
    }
}

/// Draws the result of the last fit, if there was one.
pub fn result(ui: &mut Ui, state: &mut State) {
    let fit: TableFitState = ui.data(|data| data.get_temp(key())).unwrap_or_default();
    let found = match (&fit.result, &fit.base) {
        (Some(Ok(found)), Some(base)) => (Arc::clone(found), Arc::clone(base)),
        (Some(Err(reason)), _) => {
            ui.colored_label(crate::app::widgets::text::error_color(ui), reason);
            return;
        }
        _ => return,
    };
    let (found, base) = found;
    ui.label(RichText::new("Fitted to the experiments").strong());
    if found.cancelled {
        ui.label("Cancelled: this is the best so far.");
    }
    apply_or_discard(ui, state, &found, &base);
    values(ui, &found, &base);
    ui.add_space(6.0);
    errors(ui, &found);
    ui.add_space(6.0);
    columns(ui, &found);
    ui.add_space(6.0);
    let missed: Vec<String> = found.missed().iter().map(|case| case.name()).collect();
    ui.label(small(if missed.is_empty() {
        "All cases are within 30 % in peak and contact.".to_owned()
    } else {
        format!(
            "More than 30 % off in peak or contact: {}.",
            missed.join("; ")
        )
    }));
    if let Some(worse) = found.made_worse() {
        ui.label(small(worse));
    }
    ui.label(small(TABLE_LIMITS).weak());
    ui.separator();
}

fn apply_or_discard(ui: &mut Ui, state: &mut State, found: &TableFit, base: &Model) {
    let model = &mut state.setup.preset.model;
    ui.horizontal(|ui| {
        if apply_button(ui, model.name == base.name) {
            found.apply(model);
        }
        if discard_button(ui) {
            ui.data_mut(|data| data.insert_temp(key(), TableFitState::default()));
        }
    });
}

fn values(ui: &mut Ui, found: &TableFit, base: &Model) {
    let errors = found.errors();
    Grid::new("table fit values")
        .num_columns(4)
        .striped(true)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            titles(ui, ["", "before", "fitted", "std. error"]);
            for (k, id) in FREE_PARAMETERS.into_iter().enumerate() {
                let spec = id.spec();
                let write = |value: f64, digits| format_quantity(value, spec.unit, digits);
                ui.label(spec.symbol).on_hover_text(spec.name);
                ui.label(write(base.parameters[id], 4));
                ui.label(RichText::new(write(found.model.parameters[id], 4)).strong());
                let error = errors.as_ref().map(|errors| write(errors[k], 2));
                ui.label(error.map_or("-".to_owned(), |e| format!("\u{b1} {e}")))
                    .on_hover_text("How much it changes when one frequency is omitted");
                ui.end_row();
            }
        });
}

/// Errors before and after: over all cases, and at each frequency when it was omitted.
fn errors(ui: &mut Ui, found: &TableFit) {
    Grid::new("table fit errors")
        .num_columns(4)
        .striped(true)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            titles(
                ui,
                [
                    "mean absolute errors",
                    "in peak",
                    "in contact",
                    "both within 30 %",
                ],
            );
            let mut line = |name: String, misfit: &Misfit| {
                let percent = |v: f64| format!("{} %", format_number(100.0 * v, 2));
                ui.label(name);
                ui.label(percent(misfit.peak));
                ui.label(percent(misfit.contact));
                ui.label(format!(
                    "{} of {}",
                    misfit.both_within_30_percent, misfit.cases
                ));
                ui.end_row();
            };
            line("all cases, before".to_owned(), &found.before);
            line("all cases, fitted".to_owned(), &found.after);
            for omitted in &found.left_out {
                let name = |what| format!("{} Hz, {what}", omitted.frequency);
                line(name("before"), &omitted.before);
                line(name("fitted to the other frequencies"), &omitted.after);
            }
        });
}

/// The fitted columns next to the experiment.
fn columns(ui: &mut Ui, found: &TableFit) {
    Grid::new("table fit columns")
        .num_columns(10)
        .striped(true)
        .spacing([9.0, 3.0])
        .show(ui, |ui| {
            ui.label(small("case").strong());
            for row in &FEATURE_ROWS {
                for title in [row.title(), "exp.", "error"] {
                    ui.label(small(title).strong());
                }
            }
            ui.end_row();
            for row in &found.rows {
                ui.label(format!("{} fitted", row.case.name()));
                for (figure, kind) in FEATURE_ROWS.iter().enumerate() {
                    for cell in [&row.model, &row.case.experiment] {
                        let text = kind
                            .value(cell)
                            .map_or("-".to_owned(), |v| format_number(v, 3));
                        ui.label(RichText::new(text).monospace());
                    }
                    error_cell(ui, figure, error(row, Column::Experiment, figure));
                }
                ui.end_row();
            }
        });
}

fn titles<const N: usize>(ui: &mut Ui, titles: [&str; N]) {
    for title in titles {
        ui.label(small(title).strong());
    }
    ui.end_row();
}
