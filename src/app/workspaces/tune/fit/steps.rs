//! The guided identification: the five steps of the paper, which of them the recordings
//! allow, and the result of each.

use eframe::egui::{Button, RichText, Ui};

use super::choose::symbol;
use super::figures;
use crate::app::state::State;
use crate::app::widgets::job_progress::cancel_button;
use crate::app::widgets::text::{error_color, heading, small};
use crate::diagnose::report::words::capitalised;
use crate::fit::paper_steps::guide::Step;
use crate::fit::paper_steps::outcome::StepResult;
use crate::model::parameter::ParameterId;

/// Up to this many recordings are named in the list; more are counted.
const MAX_NAMED_RECORDINGS: usize = 3;

/// The parameters of drive, damping and film. They shape the motion before a contact, so they
/// must be right before bounces and releases can be read. The steps identify the contact itself.
const MOTION_PARAMETERS: [ParameterId; 6] = [
    ParameterId::Eta,
    ParameterId::Zeta1,
    ParameterId::Zeta2,
    ParameterId::Dp,
    ParameterId::Cs,
    ParameterId::Gp,
];

/// Draws the guide.
pub(crate) fn show(ui: &mut Ui, state: &mut State) {
    let context = ui.ctx().clone();
    state.identification.poll(&state.setup, &context);
    list(ui, state);
    ui.separator();
    finding(ui, state);
}

fn list(ui: &mut Ui, state: &mut State) {
    ui.label(
        small("The steps of section 4 of the paper, using the recordings chosen for fitting.")
            .weak(),
    );
    if let Some(first) = state.identification.first.clone() {
        ui.label(small(first).color(error_color(ui)));
        first_fit_button(ui, state);
    }
    if let Some(sampled) = state.identification.sampled {
        ui.label(small(sampled.to_string()).weak());
    }
    let mut start = None;
    let busy = state.identification.job.is_some();
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
    } else if !state.identification.is_current(&state.setup) {
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

/// A button that frees [`MOTION_PARAMETERS`] and opens the fit panel, for a device that is too
/// far from the recordings for any step.
fn first_fit_button(ui: &mut Ui, state: &mut State) {
    let setup = &state.setup;
    let free: Vec<&str> = MOTION_PARAMETERS
        .into_iter()
        .filter(|id| setup.preset.model.uses(*id))
        .map(|id| id.spec().id)
        .filter(|id| !setup.locked.contains(*id))
        .collect();
    if free.is_empty() {
        return;
    }
    let symbols: Vec<String> = free.iter().map(|id| symbol(id)).collect();
    let text = format!("Free {} and open the fit", symbols.join(", "));
    if ui.button(small(text)).clicked() {
        state.fitting.free = Some(free.into_iter().map(str::to_owned).collect());
        state.fitting.open = true;
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
                    found.apply(&mut state.setup.preset.model);
                }
            }
            match &found {
                StepResult::Drive(found) => figures::drive(ui, found),
                StepResult::Restitution(found) => figures::restitution(ui, found),
                StepResult::Adhesion(found) => figures::adhesion(ui, found),
                StepResult::Film(found) => figures::film(ui, found),
                StepResult::Sensitivity(found) => figures::sensitivity(ui, found),
            }
        }
    }
}
