//! The guided identification: the steps of the paper, which of them the recordings
//! allow, the fit of the device where it comes first, and the result of each step.

use eframe::egui::{Button, RichText, Ui};

use super::choose::symbol;
use super::{figures, modal_figures, summary};
use crate::app::analysis::identification::Course;
use crate::app::setup::command::Command;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::State;
use crate::app::widgets::job_progress::cancel_button;
use crate::app::widgets::text::{error_color, heading, small};
use crate::diagnose::report::words::capitalised;
use crate::fit::paper_steps::guide::Step;
use crate::fit::paper_steps::outcome::StepResult;

/// Up to this many recordings are named in the list; more are counted.
const MAX_NAMED_RECORDINGS: usize = 3;

/// Draws the guide.
pub(crate) fn show(ui: &mut Ui, state: &mut State) {
    let context = ui.ctx().clone();
    state.fitting.poll(&state.setup);
    state.identification.poll(&state.setup, &context);
    state
        .identification
        .proceed(&mut state.fitting, &mut state.setup, &context);
    list(ui, state);
    summary::show(ui, &state.identification);
    ui.separator();
    finding(ui, state);
}

fn list(ui: &mut Ui, state: &mut State) {
    ui.label(
        small("The steps of section 4 of the paper, using the recordings chosen for fitting.")
            .weak(),
    );
    whole_device(ui, state);
    if let Some(sampled) = state.identification.sampled {
        ui.label(small(sampled.to_string()).weak());
    }
    all_steps_button(ui, state);
    let mut start = None;
    let busy = is_busy(state);
    for step in Step::ALL {
        let allowance = state
            .identification
            .allowances
            .iter()
            .find(|allowance| allowance.step == step);
        let allowed = allowance.is_some_and(|a| a.by.is_ok());
        ui.horizontal(|ui| {
            let button = ui.add_enabled(allowed && !busy, Button::new("Run"));
            if button
                .on_hover_text(format!("Run the step: {}", step.title()))
                .clicked()
            {
                start = Some(step);
            }
            let chosen = state.identification.chosen == Some(step);
            let title = Button::selectable(chosen, RichText::new(step.title()).strong());
            if ui.add(title).on_hover_text("Show its figure").clicked() {
                state.identification.chosen = Some(step);
            }
            match state.identification.findings.get(step.id()) {
                Some(Ok(_)) => ui.label(small("done")),
                Some(Err(_)) => ui.label(small("failed").color(error_color(ui))),
                None => ui.label(""),
            };
        });
        match allowance.map(|a| &a.by) {
            Some(Err(missing)) => {
                let mut text = format!("      {}.", capitalised(&missing.reason));
                if let Some(record) = missing.record {
                    text += &format!(" Record {record}.");
                }
                ui.label(small(text).color(ui.visuals().warn_fg_color));
            }
            Some(Ok(names)) if names.len() > MAX_NAMED_RECORDINGS => {
                let text = format!("      uses {} recordings", names.len());
                ui.label(small(text).weak()).on_hover_text(names.join("\n"));
            }
            Some(Ok(names)) => {
                ui.label(small(format!("      uses {}", names.join(", "))).weak());
            }
            None => {}
        }
    }
    if let Some((step, job)) = &state.identification.job {
        let what = step.map_or("Reading the recordings", Step::title);
        ui.label(small(what));
        ui.horizontal(|ui| {
            cancel_button(ui, job, "Stop this step");
            match job.progress() {
                Some(progress) => super::fit_progress(ui, &progress),
                None => {
                    ui.spinner();
                }
            }
        });
    } else if state.identification.course == Course::ByHand
        && !state.identification.is_current(&state.setup)
    {
        ui.horizontal(|ui| {
            if ui.button("Check again").clicked() {
                let context = ui.ctx().clone();
                state.identification.look(&state.setup, &context);
            }
            let text = "Find which steps the recordings allow for the current device.";
            ui.label(small(text).weak());
        });
    }
    if let Some(step) = start {
        let context = ui.ctx().clone();
        state.identification.start(step, &state.setup, &context);
    }
}

/// Whether something runs that a step must wait for.
fn is_busy(state: &State) -> bool {
    let guide = &state.identification;
    guide.job.is_some() || guide.course != Course::ByHand || state.fitting.job.is_some()
}

/// Where the device, as it is, keeps steps from being taken: a fit of all of it at a press, or,
/// where all of it is fitted already, the way to what it lacks.
fn whole_device(ui: &mut Ui, state: &mut State) {
    if let Some(first) = state.identification.first.clone() {
        ui.label(small(first).color(error_color(ui)));
    }
    if state.identification.course == Course::Fitting {
        ui.label(small("Fitting the whole device"));
        if let Some(job) = state.fitting.job.clone() {
            ui.horizontal(|ui| {
                cancel_button(ui, &job, "Stop the fit; the device stays as it is");
                match job.progress() {
                    Some(progress) => super::fit_progress(ui, &progress),
                    None => {
                        ui.spinner();
                    }
                }
            });
        }
        return;
    }
    if let Some(error) = state.fitting.error.clone() {
        ui.label(small(error).color(error_color(ui)));
    }
    let guide = &state.identification;
    if let Some(ids) = guide.to_free(&state.fitting, &state.setup) {
        let symbols: Vec<String> = ids.iter().map(|id| symbol(id)).collect();
        let button = ui.add_enabled(!is_busy(state), Button::new("Fit the whole device"));
        if button
            .on_hover_text("Its values are set in the device (can be undone), and the recordings are examined again")
            .clicked()
        {
            let context = ui.ctx().clone();
            state
                .identification
                .fit_whole_device(ids, &mut state.fitting, &state.setup, &context);
        }
        let text = format!(
            "Bounces and releases are read with the device, so it has to follow the recordings first. Freed: {}.",
            symbols.join(", ")
        );
        ui.label(small(text).weak());
    } else if guide.first.is_some() {
        ui.label(small(
            "All of the device has been fitted, so it lacks something that these recordings show.",
        ));
        if ui.button("Find what it lacks").clicked() {
            state.ask(Command::Workspace(WorkspaceId::Diagnose));
        }
    }
}

/// The button that takes all steps.
fn all_steps_button(ui: &mut Ui, state: &mut State) {
    let mut allowances = state.identification.allowances.iter();
    let any = allowances.any(|a| a.by.is_ok());
    let button = ui.add_enabled(any && !is_busy(state), Button::new("Take all steps"));
    if button
        .on_hover_text("Run one after the other what the recordings allow, and set what is found in the device (can be undone)")
        .clicked()
    {
        state.identification.take_all_steps();
    }
}

fn finding(ui: &mut Ui, state: &mut State) {
    let Some(step) = state.identification.chosen else {
        ui.weak("Run a step to see its figure.");
        return;
    };
    heading(ui, step.title());
    match state.identification.findings.get(step.id()).cloned() {
        None => {
            let job = state.identification.job.as_ref();
            let busy = job.is_some_and(|(running, _)| *running == Some(step));
            ui.weak(if busy { "Running..." } else { "Not run yet." });
        }
        Some(Err(error)) => {
            ui.colored_label(error_color(ui), error);
        }
        Some(Ok(found)) => {
            if let Some(differences) = state.identification.differences(step, &state.setup) {
                ui.label(small(differences).color(ui.visuals().warn_fg_color));
            }
            if step.finds_values() {
                let apply = ui.button("Apply");
                if apply
                    .on_hover_text("Set the device to these values (can be undone)")
                    .clicked()
                {
                    state.identification.apply(step, &mut state.setup);
                }
            }
            match &found {
                StepResult::Modal(found) => modal_figures::show(ui, found),
                StepResult::Drive(found) => figures::drive(ui, found),
                StepResult::Restitution(found) => figures::restitution(ui, found),
                StepResult::Adhesion(found) => figures::adhesion(ui, found),
                StepResult::Film(found) => figures::film(ui, found),
                StepResult::Sensitivity(found) => figures::sensitivity(ui, found),
            }
        }
    }
}
