//! The fit panel: choose parameters and recordings, run a fit on another thread, and see the
//! result. Nothing is applied without being asked for.

pub(crate) mod choose;
mod figures;
mod modal_figures;
mod picture;
mod profile;
mod result;
pub(super) mod steps;
mod summary;

use eframe::egui::{Button, Ui};

use crate::app::analysis::recording_roles::with_role;
use crate::app::setup::command::Command;
use crate::app::setup::overlay::Role;
use crate::app::state::State;
use crate::app::widgets::job_progress::{STOP_HELP, cancel_button, progress_bar};
use crate::app::widgets::text::small;
use crate::fit::Progress;
use crate::model::unit::time_left;

/// Draws the panel.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    state.fitting.poll(&state.setup);
    choose::parameters(ui, state);
    ui.add_space(6.0);
    choose::recordings(ui, state);
    ui.add_space(6.0);
    ui.separator();
    run(ui, state);
    let guided = ui.button("Step by step...");
    if guided
        .on_hover_text(
            "The paper's identification: drive, restitution, adhesion, film, sensitivity",
        )
        .clicked()
    {
        state.ask(Command::Identification);
    }
    if let Some(error) = &state.fitting.error {
        ui.colored_label(crate::app::widgets::text::error_color(ui), error);
    }
    if state.fitting.result.is_some() {
        ui.separator();
        result::show(ui, state);
    }
}

/// The fit button, or the progress with a way to cancel.
fn run(ui: &mut Ui, state: &mut State) {
    if let Some(job) = state.fitting.job.clone() {
        ui.horizontal(|ui| {
            cancel_button(ui, &job, STOP_HELP);
            match job.progress() {
                Some(progress) => fit_progress(ui, &progress),
                None => {
                    ui.spinner();
                    ui.label("reading the recordings...");
                }
            }
        });
        ui.checkbox(&mut state.fitting.shown, "Show the curves while fitting");
        for doubt in job.progress().iter().flat_map(|p| p.doubts.iter()) {
            ui.label(small(doubt).color(ui.visuals().warn_fg_color));
        }
        return;
    }
    let why_not = obstacle(state);
    ui.horizontal(|ui| {
        let button = ui.add_enabled(why_not.is_none(), Button::new("Fit"));
        if button
            .on_hover_text("Fit the ticked parameters to the chosen recordings")
            .clicked()
        {
            state.fitting.start(&state.setup, ui.ctx());
        }
        match &why_not {
            Some(reason) => ui.weak(reason),
            None => ui.weak("Starts from the slider values."),
        };
    });
}

/// Stage, remaining time and misfit of a fit, on a progress bar.
fn fit_progress(ui: &mut Ui, progress: &Progress) {
    let share = progress.iteration as f32 / progress.expected.max(1) as f32;
    let left = time_left(progress.remaining);
    let text = format!(
        "{}{left}; misfit {:.2} x noise",
        progress.stage, progress.misfit
    );
    progress_bar(ui, share, text);
}

/// Why no fit can be started, if so.
fn obstacle(state: &State) -> Option<String> {
    let fitting = &state.fitting;
    if state.setup.overlays.is_empty() {
        return Some("Open a recording to fit to.".to_owned());
    }
    if with_role(&state.setup, Role::Train).next().is_none() {
        return Some("Choose at least one recording to fit to.".to_owned());
    }
    if fitting.free(&state.setup).is_empty() {
        return Some("Tick at least one parameter that is not locked.".to_owned());
    }
    let problem = state.setup.preset.model.check().err()?;
    Some(problem.to_string())
}
