//! The sheet of the open step: heading, idea, question, and the buttons to go on.

use eframe::egui::{Align, Button, Key, Label, Layout, Popup, RichText, ScrollArea, Ui, vec2};

use super::words::paragraphs;
use super::{exploring, question};
use crate::app::analysis::learning::{OpenStep, Phase};
use crate::app::setup::command::{Command, LearnCommand};
use crate::app::state::State;
use crate::learn::lesson::Task;

/// Size of a heading \[points\].
const HEADING_SIZE: f32 = 19.0;
/// Height of a button to go on \[points\].
const BUTTON_HEIGHT: f32 = 30.0;

/// Draws the sheet.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    let Some(open) = &state.learning.open else {
        ui.weak("Choose a lesson on the left.");
        return;
    };
    let (steps, index) = (open.lesson.steps.len(), open.index);
    let can_predict = open.phase == Phase::Predicting;
    ui.add_space(6.0);
    ui.weak(format!(
        "{}: step {} of {steps}",
        open.lesson.title,
        index + 1
    ));
    ui.with_layout(Layout::bottom_up(Align::Min), |ui| {
        ui.add_space(8.0);
        buttons(ui, state);
        ui.separator();
        ui.with_layout(Layout::top_down(Align::Min), |ui| {
            ScrollArea::vertical()
                .id_salt(("sheet", index))
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    ui.set_max_width(ui.available_width() - 8.0);
                    content(ui, state);
                });
        });
    });
    let is_free = ui.memory(|memory| memory.focused().is_none()) && !Popup::is_any_open(ui.ctx());
    if can_predict && is_free && ui.input(|input| input.key_pressed(Key::Enter)) {
        state.ask(Command::Learn(LearnCommand::Predict));
    }
}

fn content(ui: &mut Ui, state: &mut State) {
    let Some(open) = &mut state.learning.open else {
        return;
    };
    let Some(step) = open.step().cloned() else {
        return;
    };
    let heading = RichText::new(&step.title).size(HEADING_SIZE).strong();
    ui.add(Label::new(heading).wrap());
    ui.add_space(6.0);
    let Some(written) = open.result().map(|result| result.written.clone()) else {
        ui.weak("The numbers are being computed.");
        return;
    };
    paragraphs(ui, &written.text);
    if step.task == Task::Watch {
        return;
    }
    ui.add_space(6.0);
    ui.separator();
    match &step.task {
        Task::Watch => {}
        Task::Choice(choice) => question::choice(ui, open, choice, &written),
        Task::Mark(mark) => question::mark(ui, open, mark, &written),
        Task::Curve(curve) => question::curve(ui, open, curve, &written),
        Task::Explore(explore) => exploring::explore(ui, open, explore, &written),
        Task::Fit(fit) => {
            if let Some(scored) = exploring::fit(ui, open, fit, &written) {
                keep(state, scored);
            }
        }
        Task::Concealed(game) => {
            let output = exploring::concealed(ui, open, game, &written);
            if let Some(scored) = output.scored {
                keep(state, scored);
            }
            if output.asks_for_sealed_trial {
                use crate::app::setup::workspace_id::WorkspaceId;

                state.ask(Command::Workspace(WorkspaceId::Diagnose));
                if !state.diagnosing.trial.open {
                    state.ask(Command::SealedTrial);
                }
            }
        }
    }
}

/// Keeps what was handed in.
fn keep(state: &mut State, scored: crate::learn::prediction::Scored) {
    if let Some((lesson, index)) = state.learning.place() {
        state.learning.pupil.answer(&lesson, index, None, scored);
    }
}

/// Back, Next, Predict, Play and Reset, from the bottom upwards.
fn buttons(ui: &mut Ui, state: &mut State) {
    let Some(open) = &state.learning.open else {
        return;
    };
    let is_last = open.index + 1 == open.lesson.steps.len();
    let is_first = open.index == 0;
    let is_predicting = open.phase == Phase::Predicting;
    let mut asked = None;
    let mut button = |ui: &mut Ui, name: &str, command: Command, is_enabled: bool, width: f32| {
        let shown = Button::new(RichText::new(name).size(14.0));
        let shown = shown.min_size(vec2(width, BUTTON_HEIGHT));
        let response = ui.add_enabled(is_enabled, shown);
        if response
            .on_hover_text(command.with_keys(command.text().1))
            .clicked()
        {
            asked = Some(command);
        }
    };
    let learn = Command::Learn;
    let width = ui.available_width() - 2.0 * ui.spacing().item_spacing.x;
    ui.horizontal(|ui| {
        let reset = learn(LearnCommand::Reset);
        button(ui, "Start again", reset, true, 0.3 * width);
        button(ui, "Present", Command::Present, true, 0.3 * width);
    });
    ui.horizontal(|ui| {
        let third = width / 3.0;
        let next = if is_last { "Finish" } else { "Next" };
        button(ui, "Back", learn(LearnCommand::Back), !is_first, third);
        if is_predicting {
            let ready = is_ready(open);
            button(ui, "Predict", learn(LearnCommand::Predict), ready, third);
        } else {
            let name = if open.playback.is_playing {
                "Pause"
            } else {
                "Play"
            };
            button(ui, name, Command::TogglePause, true, third);
        }
        button(ui, next, learn(LearnCommand::Next), true, third);
    });
    if let Some(command) = asked {
        state.ask(command);
    }
}

/// Whether a prediction was made that can be committed.
fn is_ready(open: &OpenStep) -> bool {
    open.step()
        .is_some_and(|step| open.draft.prediction(&step.task).is_some())
}
