//! The sheet of the open step: heading, idea, question, and the buttons to go on.

use eframe::egui::{
    Button, CentralPanel, Frame, Key, Label, Margin, Panel, Popup, RichText, ScrollArea, Ui, vec2,
};

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
    Panel::bottom("step buttons")
        .frame(Frame::new().inner_margin(Margin::symmetric(0, 8)))
        .show(ui, |ui| buttons(ui, state));
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
        ScrollArea::vertical()
            .id_salt(("sheet", index))
            .auto_shrink([false, false])
            .show(ui, |ui| {
                ui.set_max_width(ui.available_width() - 8.0);
                content(ui, state);
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

/// How a button looks.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Look {
    /// It would do nothing.
    Off,
    /// It can be pressed.
    Usual,
    /// It goes on with the lesson.
    GoesOn,
}

impl Look {
    fn on_if(is_possible: bool) -> Self {
        if is_possible { Self::Usual } else { Self::Off }
    }
}

/// A button for a command; whether it was clicked.
fn button(ui: &mut Ui, name: &str, command: Command, look: Look, width: f32) -> bool {
    let mut text = RichText::new(name).size(14.0);
    let selection = ui.visuals().selection;
    if look == Look::GoesOn {
        text = text.color(selection.stroke.color);
    }
    let mut shown = Button::new(text).min_size(vec2(width, BUTTON_HEIGHT));
    if look == Look::GoesOn {
        shown = shown.fill(selection.bg_fill);
    }
    let response = ui.add_enabled(look != Look::Off, shown);
    response
        .on_hover_text(command.with_keys(command.text().1))
        .clicked()
}

/// Back, Predict or Play, Next; beneath them what is needed less often. What goes on with the
/// lesson stands out.
fn buttons(ui: &mut Ui, state: &mut State) {
    let Some(open) = &state.learning.open else {
        return;
    };
    let is_last = open.index + 1 == open.lesson.steps.len();
    let watches = open
        .step()
        .is_some_and(|step| step.task.controls().is_empty());
    let is_predicting = open.phase == Phase::Predicting;
    let is_ready = is_ready(open);
    let (middle, name) = match open.phase {
        Phase::Predicting => (Command::Learn(LearnCommand::Predict), "Predict"),
        _ if open.playback.is_playing => (Command::TogglePause, "Pause"),
        _ => (Command::TogglePause, "Play"),
    };
    let middle_look = match open.phase {
        Phase::Predicting if !is_ready => Look::Off,
        Phase::Predicting => Look::GoesOn,
        Phase::Watching if watches && !open.playback.is_playing => Look::GoesOn,
        _ => Look::Usual,
    };
    let next_look = match open.phase {
        Phase::Seen => Look::GoesOn,
        Phase::Watching if !watches => Look::GoesOn,
        _ => Look::Usual,
    };
    let next = match (is_last, is_predicting) {
        (true, _) => "Finish",
        (false, true) => "Skip",
        (false, false) => "Next",
    };
    let learn = Command::Learn;
    let spacing = ui.spacing().item_spacing.x;
    let third = (ui.available_width() - 2.0 * spacing) / 3.0;
    let rows = [
        vec![
            (
                "Back",
                learn(LearnCommand::Back),
                Look::on_if(open.index > 0),
            ),
            (name, middle, middle_look),
            (next, learn(LearnCommand::Next), next_look),
        ],
        vec![
            ("Start again", learn(LearnCommand::Reset), Look::Usual),
            ("Present", Command::Present, Look::Usual),
            ("Film...", Command::ExportFilm, Look::on_if(!is_predicting)),
        ],
    ];
    let mut asked = None;
    for row in rows {
        ui.horizontal(|ui| {
            for (name, command, look) in row {
                if button(ui, name, command, look, third) {
                    asked = Some(command);
                }
            }
        });
    }
    if let Some(command) = asked {
        state.ask(command);
    }
}

/// Whether a prediction was made that can be committed.
fn is_ready(open: &OpenStep) -> bool {
    open.step()
        .is_some_and(|step| open.draft.prediction(&step.task).is_some())
}
