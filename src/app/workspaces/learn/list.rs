//! The list of lessons with the pupil's progress.

use std::sync::Arc;

use eframe::egui::{
    Align, Button, CentralPanel, Frame, Layout, Margin, Panel, RichText, ScrollArea, Ui, vec2,
};

use crate::app::analysis::learning::built_in;
use crate::app::setup::command::{Command, LearnCommand};
use crate::app::state::State;
use crate::app::theme;
use crate::app::widgets::text::small;
use crate::learn::lesson::Lesson;

/// Draws the list.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    ui.add_space(6.0);
    ui.label(RichText::new("Lessons").size(17.0).strong());
    ui.add_space(2.0);
    Panel::bottom("lesson files")
        .frame(Frame::new().inner_margin(Margin::symmetric(0, 8)))
        .show(ui, |ui| files(ui, state));
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
        ScrollArea::vertical()
            .id_salt("lesson list")
            .auto_shrink([false, false])
            .show(ui, |ui| all(ui, state));
    });
}

/// Lessons from files, and answers to a file.
fn files(ui: &mut Ui, state: &mut State) {
    let has_answers = !state.learning.pupil.is_new();
    for (command, is_possible) in [
        (LearnCommand::OpenLesson, true),
        (LearnCommand::ExportAnswers, has_answers),
    ] {
        let command = Command::Learn(command);
        let (name, help) = command.text();
        let button = Button::new(name).min_size(vec2(ui.available_width(), 24.0));
        let response = ui.add_enabled(is_possible, button);
        if response.on_hover_text(command.with_keys(help)).clicked() {
            state.ask(command);
        }
    }
}

fn all(ui: &mut Ui, state: &mut State) {
    let mut chosen = None;
    for (i, lesson) in built_in().iter().enumerate() {
        entry(ui, state, lesson, &format!("{}. ", i + 1), &mut chosen);
    }
    if !state.learning.own.is_empty() {
        ui.add_space(6.0);
        ui.weak("From files");
    }
    for lesson in state.learning.own.clone() {
        entry(ui, state, &lesson, "", &mut chosen);
    }
    if let Some(lesson) = chosen {
        state.learning.open_lesson(&lesson);
    }
}

fn entry(
    ui: &mut Ui,
    state: &State,
    lesson: &Arc<Lesson>,
    number: &str,
    chosen: &mut Option<Arc<Lesson>>,
) {
    let learning = &state.learning;
    let open = learning.open.as_ref();
    let is_open = open.is_some_and(|open| Arc::ptr_eq(&open.lesson, lesson));
    let progress = learning.pupil.progress(&lesson.id);
    let (earned, offered) = learning.pupil.stars(lesson);
    let title = RichText::new(format!("{number}{}", lesson.title)).size(13.5);
    let button = Button::selectable(is_open, title).wrap();
    let to_the_left = Layout::top_down_justified(Align::Min);
    let button = ui.with_layout(to_the_left, |ui| ui.add(button)).inner;
    if button.on_hover_text(&lesson.about).clicked() {
        *chosen = Some(Arc::clone(lesson));
    }
    let steps = lesson.steps.len();
    let (text, is_done) = if progress.is_done {
        (format!("done, {earned} of {offered} points"), true)
    } else if progress.answers.is_empty() && progress.reached == 0 {
        (format!("{} steps, {} min", steps, lesson.minutes), false)
    } else {
        let step = progress.step + 1;
        let text = format!("step {step} of {steps}, {earned} of {offered} points");
        (text, false)
    };
    let text = small(text);
    ui.horizontal(|ui| {
        ui.add_space(8.0);
        if is_done {
            ui.label(text.color(theme::good(ui.visuals().dark_mode)));
        } else {
            ui.label(text.weak());
        }
    });
}
