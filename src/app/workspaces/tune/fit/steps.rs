//! The guided identification: the paper's five steps, which of them the recordings allow,
//! and what each has found.

use eframe::egui::{Button, RichText, ScrollArea, Ui, Window};

use super::figures;
use crate::app::state::State;
use crate::app::widgets::text::{error_color, heading, small};
use crate::fit::paper_steps::guide::Step;
use crate::fit::paper_steps::outcome::StepResult;

/// Most recordings that are named in the list.
const FEW: usize = 3;

/// Draws the window while it is open.
pub fn show(ui: &mut Ui, state: &mut State) {
    if !state.identification.open {
        return;
    }
    let context = ui.ctx().clone();
    state
        .identification
        .poll(&state.setup, &state.fitting, &context);
    let mut open = true;
    Window::new("Identification, step by step")
        .open(&mut open)
        .default_size([560.0, 640.0])
        .default_pos([365.0, 60.0])
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("identification")
                .auto_shrink([false, true])
                .show(ui, |ui| {
                    list(ui, state);
                    ui.separator();
                    finding(ui, state);
                });
        });
    state.identification.open = open && state.identification.open;
}

fn list(ui: &mut Ui, state: &mut State) {
    ui.label(
        small(
            "The steps of the paper's section 4, with the recordings that the fit panel fits to.",
        )
        .weak(),
    );
    if let Some(first) = state.identification.first.clone() {
        ui.label(small(first).color(error_color(ui)));
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
            let button = ui.add_enabled(allowed && !busy, Button::new("Take"));
            if button
                .on_hover_text(format!("Take the step: {}", step.title()))
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
                let mut text = format!("      Not possible yet: {}.", missing.reason);
                if let Some(record) = missing.record {
                    text += &format!(" Record {record}.");
                }
                ui.label(small(text).color(ui.visuals().warn_fg_color));
            }
            Some(Ok(names)) if names.len() > FEW => {
                let text = format!("      with {} recordings", names.len());
                ui.label(small(text).weak()).on_hover_text(names.join("\n"));
            }
            Some(Ok(names)) => {
                ui.label(small(format!("      with {}", names.join(", "))).weak());
            }
            None => {}
        }
    }
    if let Some((step, job)) = &state.identification.job {
        let what = step.map_or("Looking at the recordings", Step::title);
        ui.label(small(what));
        ui.horizontal(|ui| {
            let cancel = ui.add_enabled(!job.is_cancelled(), Button::new("Cancel"));
            if cancel.on_hover_text("Stop soon").clicked() {
                job.cancel();
            }
            match job.progress() {
                Some(progress) => super::advance(ui, &progress),
                None => {
                    ui.spinner();
                }
            }
        });
    } else if !state.identification.is_current(&state.setup) {
        ui.horizontal(|ui| {
            if ui.button("Look again").clicked() {
                let context = ui.ctx().clone();
                let (setup, fitting) = (&state.setup, &state.fitting);
                state.identification.look(setup, fitting, &context);
            }
            let text = "Which steps the recordings allow with the device as it is now.";
            ui.label(small(text).weak());
        });
    }
    if let Some(step) = start {
        let context = ui.ctx().clone();
        let (setup, fitting) = (&state.setup, &state.fitting);
        state.identification.start(step, setup, fitting, &context);
    }
}

fn finding(ui: &mut Ui, state: &mut State) {
    let Some(step) = state.identification.chosen else {
        ui.weak("Take a step to see its figure.");
        return;
    };
    heading(ui, step.title());
    match state.identification.findings.get(step.id()).cloned() {
        None => {
            let taken = state.identification.job.as_ref();
            let busy = taken.is_some_and(|(taken, _)| *taken == Some(step));
            ui.weak(if busy {
                "Being taken."
            } else {
                "Not taken yet."
            });
        }
        Some(Err(error)) => {
            ui.colored_label(error_color(ui), error);
        }
        Some(Ok(found)) => {
            if step.finds_values() {
                let apply = ui.button("Apply");
                if apply
                    .on_hover_text("Give the device what was found; undo takes it back")
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
