//! Step 4: the proof on held-out recordings, and what can be done with the answer.

use eframe::egui::{Button, Frame, Grid, Label, Panel, RichText, Ui, vec2};

use super::colors;
use super::figures::{before_after_bars, frame};
use super::words::{placeholder, role_text, scrolled};
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::flows::load_example;
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::State;
use crate::app::widgets::text::{heading, small};
use crate::diagnose::Diagnosis;
use crate::diagnose::diagnosis::{BeforeAfter, NextExperiment};
use crate::diagnose::report::rest;
use crate::diagnose::report::words::{
    chi2, gain, in_noise, metres, no_experiment, would_distinguish,
};
use crate::model::drive::Waveform;
use crate::trial::demo::put_in;

/// Draws the step.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(answer) = state.diagnosing.shown().cloned() else {
        placeholder(
            ui,
            "Simulation against recordings not used for fitting, before and after, relative to \
             their noise. Then apply the result to the device, save it, or export the report.",
        );
        return;
    };
    Panel::bottom("diagnose actions")
        .resizable(false)
        .frame(Frame::NONE)
        .show(ui, |ui| actions(ui, state));
    scrolled(ui, "diagnose proof", |ui| {
        summary(ui, &answer.diagnosis);
        ui.add_space(4.0);
        before_after_bars::show(ui, &mut state.diagnosing.look, &answer.diagnosis);
        ui.add_space(4.0);
        heading(ui, "What remains unexplained");
        for sentence in rest::sentences(&answer.diagnosis) {
            ui.label(small(sentence));
        }
        next(ui, state, &answer);
        example_truth(ui, state);
    });
}

fn summary(ui: &mut Ui, d: &Diagnosis) {
    let named = !d.named.is_empty();
    ui.label(small("Root mean square of simulation minus recording, xp").weak());
    Grid::new("proof summary")
        .num_columns(3)
        .min_col_width(72.0)
        .spacing([16.0, 4.0])
        .show(ui, |ui| {
            ui.label("");
            ui.label(small("before").color(colors::before(ui)));
            if named {
                ui.label(small("after").color(colors::after(ui)));
            }
            ui.end_row();
            for (held_out, both) in [(true, &d.held_out), (false, &d.train)] {
                row(ui, role_text(held_out), both, d.noise, named);
            }
        });
    let text = format!("noise {}", metres(d.noise));
    let mut entries = frame::model_entries(ui, d);
    entries.push((text.as_str(), colors::noise(ui)));
    frame::legend(ui, &entries);
}

fn row(ui: &mut Ui, title: &str, both: &BeforeAfter, noise: f64, named: bool) {
    ui.label(RichText::new(title).strong());
    let sides = [(&both.before, true), (&both.after, named)];
    for (side, _) in sides.iter().filter(|(_, shown)| *shown) {
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            let line = |text: RichText| Label::new(text).extend();
            ui.add(line(RichText::new(metres(side.rms)).size(17.0).strong()));
            ui.add(line(small(in_noise(side.rms, noise)).weak()));
            let text = small(format!("chi2 {}", chi2(side.chi2))).weak();
            ui.add(line(text)).on_hover_text(
                "Mean square of all residuals in units of their noise; 1 if nothing is missing",
            );
        });
    }
    ui.end_row();
}

fn next(ui: &mut Ui, state: &mut State, answer: &Answer) {
    ui.add_space(4.0);
    heading(ui, "Next experiment");
    let Some(next) = &answer.diagnosis.next_experiment else {
        ui.label(small(no_experiment(&answer.diagnosis)));
        return;
    };
    ui.label(small(format!(
        "Drive with {}: {} (expected difference in chi2: {}).",
        next.drive,
        would_distinguish(next),
        gain(next.expected)
    )));
    let drive = Waveform::parse(&next.drive, NextExperiment::DURATION).ok();
    let driven = state.setup.preset.model.piezo.is_some();
    let button = ui.add_enabled(
        drive.is_some() && driven,
        Button::new(small("Load this drive")),
    );
    if let Some(drive) = drive
        && button
            .on_hover_text("Use it as the drive in Tune (can be undone)")
            .clicked()
    {
        state.setup.drive = DriveChoice::Waveform(drive);
        state.ask(Command::Workspace(WorkspaceId::Tune));
    }
}

/// The effect that the example was simulated with.
fn example_truth(ui: &mut Ui, state: &State) {
    if !load_example::is_loaded(&state.setup) {
        return;
    }
    ui.add_space(4.0);
    ui.collapsing("What the example contains", |ui| {
        let text = put_in().unwrap_or_else(|error| format!("It cannot be read: {error}."));
        ui.label(small(text));
    });
}

fn actions(ui: &mut Ui, state: &mut State) {
    ui.add_space(4.0);
    let on_trial = state.diagnosing.trial.sealed.is_some();
    let why_not = state.diagnosing.why_not_applied(&state.setup);
    let width = ui.available_width() - 4.0;
    let text = RichText::new("Apply to the device").strong();
    let accept = Button::new(text.color(ui.visuals().strong_text_color()))
        .fill(ui.visuals().selection.bg_fill);
    let add = |ui: &mut Ui| ui.add_sized([width, 26.0], accept);
    let accept = ui.add_enabled_ui(why_not.is_none(), add).inner;
    if accept
        .on_hover_text("Apply the re-tuned values and the new effect to the device (can be undone)")
        .on_disabled_hover_text(why_not.unwrap_or_default())
        .clicked()
    {
        state.ask(Command::AcceptDiagnosis);
    }
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let half = vec2(0.5 * (width - 4.0), 22.0);
        for (text, command) in [
            ("Export report...", Command::ExportReport),
            ("Save as preset...", Command::SaveDiagnosed),
        ] {
            let button = ui.add_sized(half, Button::new(text));
            if button.on_hover_text(command.text().1).clicked() {
                state.ask(command);
            }
        }
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let half = vec2(0.5 * (width - 4.0), 22.0);
        let json = ui.add_sized(half, Button::new("Export JSON..."));
        if json
            .on_hover_text(Command::ExportDiagnosis.text().1)
            .clicked()
        {
            state.ask(Command::ExportDiagnosis);
        }
        let tune = ui.add_sized(half, Button::new("Show in Tune"));
        if tune.on_hover_text("Go to the Tune workspace").clicked() {
            state.ask(Command::Workspace(WorkspaceId::Tune));
        }
    });
    if on_trial {
        ui.add(Label::new(small("The device of a sealed trial cannot be applied.").weak()).wrap());
    }
    ui.add_space(4.0);
}
