//! The list of lessons with the pupil's progress.

use std::sync::Arc;

use eframe::egui::{Align, Button, Layout, RichText, ScrollArea, Ui, vec2};

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
    ui.with_layout(Layout::bottom_up(Align::Min), |ui| {
        ui.add_space(6.0);
        for command in [LearnCommand::ExportAnswers, LearnCommand::OpenLesson] {
            let command = Command::Learn(command);
            let (name, help) = command.text();
            let button = Button::new(name).min_size(vec2(ui.available_width(), 24.0));
            if ui
                .add(button)
                .on_hover_text(command.with_keys(help))
                .clicked()
            {
                state.ask(command);
            }
        }
        ui.separator();
        ui.with_layout(Layout::top_down(Align::Min), |ui| {
            ScrollArea::vertical()
                .id_salt("lesson list")
                .show(ui, |ui| {
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
                });
        });
    });
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
    let button = ui.add_sized(vec2(ui.available_width(), 22.0), button);
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
