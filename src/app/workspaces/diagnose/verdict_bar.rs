//! The strip above the steps: the button that starts the diagnosis, its progress, and the
//! answer in one sentence.

use eframe::egui::{Align, Button, Layout, ProgressBar, RichText, Sense, Ui, UiBuilder, vec2};

use super::colors;
use crate::app::analysis::diagnosis::obstacle;
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::widgets::text::{error_color, small};
use crate::diagnose::DiagnoseProgress;
use crate::diagnose::report::headline::{change, headline};
use crate::diagnose::report::sentences;
use crate::diagnose::report::words::{listed, metres};
use crate::model::effects::find;
use crate::model::unit::time_left;

/// Height of the strip \[points\].
const STRIP_HEIGHT: f32 = 58.0;
/// Width of the button, and of the progress bar in its place \[points\].
const ACTION_WIDTH: f32 = 250.0;

/// Draws the strip above the steps.
pub fn show(ui: &mut Ui, state: &mut State) {
    let size = vec2(ui.available_width(), STRIP_HEIGHT);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_height(STRIP_HEIGHT);
        let (rect, _) = ui.allocate_exact_size(vec2(ACTION_WIDTH, STRIP_HEIGHT), Sense::hover());
        let inside = UiBuilder::new()
            .max_rect(rect.shrink2(vec2(0.0, 6.0)))
            .layout(Layout::top_down(Align::Min));
        ui.scope_builder(inside, |ui| action(ui, state));
        ui.add_space(8.0);
        ui.vertical(|ui| {
            ui.add_space(6.0);
            answer_or_hint(ui, state);
        });
    });
}

fn action(ui: &mut Ui, state: &mut State) {
    let Some(running) = state.diagnosing.running.clone() else {
        let why_not = obstacle(&state.setup);
        let text = RichText::new("Diagnose").size(19.0).strong();
        let button = Button::new(text.color(ui.visuals().strong_text_color()))
            .fill(ui.visuals().selection.bg_fill);
        let add = |ui: &mut Ui| ui.add_sized([ACTION_WIDTH, 44.0], button);
        let button = ui.add_enabled_ui(why_not.is_none(), add).inner;
        crate::app::plots::frame::layout_note::note(ui.ctx(), "diagnose", button.rect);
        let help = why_not.unwrap_or_else(|| {
            "Find what the model leaves out, and check it on held-out recordings".to_owned()
        });
        if button
            .on_hover_text(&help)
            .on_disabled_hover_text(&help)
            .clicked()
        {
            state.ask(Command::Diagnose);
        }
        return;
    };
    let progress = running.job.progress();
    ui.horizontal(|ui| {
        let cancel = ui.add_enabled(!running.job.is_cancelled(), Button::new("Cancel"));
        if cancel
            .on_hover_text(Command::CancelDiagnosis.text().1)
            .clicked()
        {
            state.ask(Command::CancelDiagnosis);
        }
        let done = progress.as_ref().map_or(0.0, |p| p.done as f32);
        let bar = ProgressBar::new(done.clamp(0.0, 1.0))
            .text(
                small(share(progress.as_ref(), running.job.is_cancelled()))
                    .color(ui.visuals().strong_text_color()),
            )
            .desired_width(ui.available_width());
        ui.add(bar);
    });
    ui.add(
        eframe::egui::Label::new(small(line(progress.as_ref(), running.job.is_cancelled())))
            .truncate(),
    );
}

/// The stage of the diagnosis in words.
fn line(progress: Option<&DiagnoseProgress>, cancelled: bool) -> String {
    if cancelled {
        return "Stopping; the results so far are kept".to_owned();
    }
    let Some(p) = progress else {
        return "Reading the recordings".to_owned();
    };
    let stage = p.stage_text();
    let detail = if p.detail.is_empty() || p.detail == "re-tuning" {
        String::new()
    } else {
        format!(": {}", p.detail.replace('_', " "))
    };
    format!("{stage}{detail}")
}

/// The progress in percent, with the time left.
fn share(progress: Option<&DiagnoseProgress>, cancelled: bool) -> String {
    let done = progress.map_or(0.0, |p| p.done);
    let left = progress.filter(|_| !cancelled);
    let left = left.map_or(String::new(), |p| time_left(p.remaining));
    format!("{:.0} %{left}", 100.0 * done)
}

fn answer_or_hint(ui: &mut Ui, state: &mut State) {
    if let Some(error) = &state.diagnosing.error {
        let text = format!("The diagnosis failed: {error}");
        ui.colored_label(error_color(ui), RichText::new(text).size(14.5));
        ui.label(small("Change the recordings or the device, then diagnose again.").weak());
        return;
    }
    let Some(answer) = state.diagnosing.shown().cloned() else {
        begin(ui, state);
        return;
    };
    let d = &answer.diagnosis;
    ui.horizontal_top(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(5.0, 40.0), Sense::hover());
        let color = colors::verdict(ui, d.verdict);
        ui.painter().rect_filled(rect, 2.0, color);
        ui.vertical(|ui| {
            ui.add(
                eframe::egui::Label::new(RichText::new(sentence(&answer)).size(15.5).strong())
                    .wrap(),
            );
            notes(ui, state, &answer);
        });
    });
}

/// The answer in a sentence. It starts with the effects if they were chosen by hand.
fn sentence(answer: &Answer) -> String {
    let d = &answer.diagnosis;
    let Some(ids) = &answer.asked.by_hand else {
        return headline(d);
    };
    let names: Vec<&str> = ids
        .iter()
        .map(|id| find(id).map_or(id.as_str(), |spec| spec.name))
        .collect();
    if names.is_empty() && !d.has_held_out() {
        return "By hand, the model alone. No recordings were held out to check it.".to_owned();
    }
    if names.is_empty() {
        return format!(
            "By hand, the model alone: on recordings not used for fitting the error is {} (noise {}).",
            metres(d.held_out.before.rms),
            metres(d.noise)
        );
    }
    format!("By hand, with {}. {}", listed(&names), change(d))
}

/// Small print below the answer.
fn notes(ui: &mut Ui, state: &mut State, answer: &Answer) {
    let d = &answer.diagnosis;
    ui.horizontal(|ui| {
        if state.diagnosing.automatic.is_some() && state.diagnosing.by_hand.is_some() {
            let shown = &mut state.diagnosing.hand_shown;
            ui.selectable_value(shown, false, small("found by the search"))
                .on_hover_text("Show the result of the search");
            ui.selectable_value(shown, true, small("by hand"))
                .on_hover_text("Show the result for the effects chosen by hand");
        }
        if d.cancelled {
            let text = small("Ended early: these are the results so far.");
            ui.label(text.color(ui.visuals().warn_fg_color));
        }
        if let Some(differences) = state.diagnosing.differences(&state.setup) {
            // What has changed may be a long list.
            let text = differences.split_inclusive(": ").next().unwrap_or_default();
            let text = text.trim_end_matches(": ").trim_end_matches('.');
            let text = small(format!("{text}: diagnose again."));
            ui.label(text.color(ui.visuals().warn_fg_color))
                .on_hover_text(&differences);
        }
        if !d.remarks.is_empty() {
            let title = small(format!("What limits this answer ({})", d.remarks.len()));
            ui.menu_button(title, |ui| {
                ui.set_max_width(460.0);
                for remark in sentences::remarks(&d.remarks) {
                    ui.label(small(super::candidate::sentence(&remark)));
                }
            });
        }
        if answer.asked.split {
            ui.label(small("The last third of each recording was held out.").weak());
        }
    });
}

/// Says what to do while there is no answer.
fn begin(ui: &mut Ui, state: &State) {
    let text = match (&state.diagnosing.running, obstacle(&state.setup)) {
        (Some(_), _) => "The diagnosis is running. You can keep working.".to_owned(),
        (None, Some(obstacle)) => obstacle,
        (None, None) => "What does the model leave out? Press Diagnose to find out.".to_owned(),
    };
    ui.label(RichText::new(text).size(15.5));
    ui.label(
        small(
            "An effect is named only if it also improves the fit to held-out recordings. \
             \"Nothing\" and \"unknown\" are possible answers.",
        )
        .weak(),
    );
}
