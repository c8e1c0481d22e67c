//! The window of the sealed trial: conceal an effect, guess it, diagnose, open the envelope.

use eframe::egui::{Button, ComboBox, Grid, RichText, ScrollArea, TextEdit, Ui, Window};

use super::sealed_truth;
use crate::app::analysis::sealed_trial::{Guess, Level, Tally, answer_text};
use crate::app::flows::sealed_trial::{end, open};
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::widgets::text::{error_color, heading, small};
use crate::model::effects::CATALOGUE;
use crate::model::unit::format_quantity;

/// Noise levels that are offered \[m\].
const NOISE_LEVELS: [f64; 4] = [5e-9, 20e-9, 50e-9, 150e-9];

/// Draws the window while it is open.
pub fn show(ui: &mut Ui, state: &mut State) {
    if !state.diagnosing.trial.open {
        return;
    }
    let mut is_open = true;
    let room = ui.ctx().content_rect();
    Window::new("Sealed trial")
        .open(&mut is_open)
        .default_size([400.0, 640.0_f32.min(room.height() - 170.0)])
        // Next to the recordings, which are needed for a guess.
        .default_pos([room.right() - 440.0, 110.0])
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("trial")
                .auto_shrink([false, true])
                .show(ui, |ui| content(ui, state));
        });
    state.diagnosing.trial.open = is_open && state.diagnosing.trial.open;
}

fn content(ui: &mut Ui, state: &mut State) {
    match &state.diagnosing.trial.sealed {
        None => {
            ui.label(
                "The program simulates recordings with a concealed effect. It uses another model \
                 and another solver than the diagnosis does. You may guess the effect. Then the \
                 diagnosis looks for it from the recordings alone.",
            );
            settings(ui, state);
        }
        Some(_) => running(ui, state),
    }
    tally(ui, state.diagnosing.trial.tally);
}

fn settings(ui: &mut Ui, state: &mut State) {
    let busy = state.diagnosing.running.is_some();
    let trial = &mut state.diagnosing.trial;
    let making = trial.has_begun();
    ui.add_space(4.0);
    ui.add_enabled_ui(!making, |ui| {
        Grid::new("trial settings")
            .num_columns(2)
            .spacing([12.0, 5.0])
            .show(ui, |ui| {
                let label = ui.label("conceal");
                ComboBox::from_id_salt("trial level")
                    .selected_text(trial.level.text())
                    .show_ui(ui, |ui| {
                        for level in Level::ALL {
                            ui.selectable_value(&mut trial.level, level, level.text());
                        }
                    })
                    .response
                    .labelled_by(label.id);
                ui.end_row();
                let label = ui.label("device");
                let name = |beam: bool| {
                    if beam {
                        "beam with four modes"
                    } else {
                        "two coordinates, as in the model"
                    }
                };
                ComboBox::from_id_salt("trial device")
                    .selected_text(name(trial.beam))
                    .show_ui(ui, |ui| {
                        for beam in [false, true] {
                            ui.selectable_value(&mut trial.beam, beam, name(beam));
                        }
                    })
                    .response
                    .labelled_by(label.id);
                ui.end_row();
                let label = ui.label("measurement noise");
                let text = |noise: f64| format_quantity(noise, "m", 2);
                ComboBox::from_id_salt("trial noise")
                    .selected_text(text(trial.noise))
                    .show_ui(ui, |ui| {
                        for noise in NOISE_LEVELS {
                            ui.selectable_value(&mut trial.noise, noise, text(noise));
                        }
                    })
                    .response
                    .labelled_by(label.id);
                ui.end_row();
                let label = ui.label("seed");
                ui.add(
                    TextEdit::singleline(&mut trial.seed)
                        .hint_text("random")
                        .desired_width(110.0),
                )
                .labelled_by(label.id)
                .on_hover_text(
                    "The same seed gives the same trial; leave it empty for a random one",
                );
                ui.end_row();
            });
    });
    ui.label(
        small("Your own recordings and device are set aside and restored when the trial ends.")
            .weak(),
    );
    if let Some(error) = &trial.error {
        ui.colored_label(error_color(ui), error);
    }
    ui.horizontal(|ui| {
        let text = RichText::new("Start the trial").strong();
        let button = ui.add_enabled(!making && !busy, Button::new(text));
        if button
            .on_disabled_hover_text("Wait until the running job has finished")
            .clicked()
        {
            let context = ui.ctx().clone();
            trial.conceal(&context);
        }
        if making {
            ui.spinner();
            ui.label(match &trial.suspended {
                Some(_) => "simulating the recordings of the session's trial again",
                None => "simulating the recordings",
            });
        }
    });
}

fn running(ui: &mut Ui, state: &mut State) {
    let trial = &state.diagnosing.trial;
    let Some(sealed) = trial.sealed.clone() else {
        return;
    };
    heading(ui, "1  Sealed");
    ui.label(small(format!(
        "Seed {}; SHA-256 of what is concealed, fixed in advance:",
        sealed.draw.seed
    )));
    let (a, b) = sealed.seal.split_at(sealed.seal.len() / 2);
    ui.label(small(format!("{a}\n{b}")).monospace());
    ui.add_space(4.0);
    heading(ui, "2  Your guess (optional)");
    let opened = sealed.opened.is_some();
    let found = state.diagnosing.automatic.is_some();
    if opened || found {
        let text = match &sealed.guess {
            Some(guess) => guess.text(),
            None => "none".to_owned(),
        };
        ui.label(text);
        if found && !opened {
            let text = "The diagnosis has answered, so you can no longer guess.";
            ui.label(small(text).weak());
        }
    } else {
        guess(ui, state);
    }
    ui.add_space(4.0);
    heading(ui, "3  The diagnosis");
    match &state.diagnosing.automatic {
        Some(answer) => {
            ui.label(answer_text(&answer.diagnosis));
        }
        None if state.diagnosing.running.is_some() => {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label("diagnosing the recordings");
            });
        }
        None => {
            if ui.button("Diagnose").clicked() {
                state.ask(Command::Diagnose);
            }
        }
    }
    ui.add_space(4.0);
    heading(ui, "4  The envelope");
    match &sealed.opened {
        Some(opened) => {
            let found = state.diagnosing.automatic.as_ref();
            let said = [
                sealed.guess.as_ref().map(Guess::verdict),
                found.map(|answer| answer.diagnosis.verdict),
            ];
            sealed_truth::show(ui, opened, said);
        }
        None => {
            let button = ui.add_enabled(found, Button::new("Open the envelope"));
            if button
                .on_disabled_hover_text("Run the diagnosis first")
                .clicked()
            {
                open(state);
            }
        }
    }
    ui.add_space(6.0);
    ui.horizontal(|ui| {
        let text = if opened {
            "Close the trial"
        } else {
            "Give up the trial"
        };
        let close = ui.button(text);
        if close
            .on_hover_text("Restore your own recordings, device and answers")
            .clicked()
        {
            end(state);
        }
    });
}

fn guess(ui: &mut Ui, state: &mut State) {
    let Some(sealed) = &mut state.diagnosing.trial.sealed else {
        return;
    };
    ui.label(small("Look at the recordings in Tune or Where, then tick what you suspect.").weak());
    ui.horizontal_wrapped(|ui| {
        for (choice, text) in [(None, "no guess"), (Some(Guess::Nothing), "nothing")] {
            if ui
                .selectable_label(sealed.guess == choice, small(text))
                .clicked()
            {
                sealed.guess = choice;
            }
        }
        // Alone it is the whole guess, with effects what they do not explain.
        let mut on = sealed.guess.as_ref().is_some_and(Guess::is_unknown_in_part);
        let tick = ui.toggle_value(&mut on, small("not in the list"));
        let tick =
            tick.on_hover_text("An effect outside the catalogue, alone or with those ticked");
        if tick.clicked() {
            let effects = sealed
                .guess
                .take()
                .map_or_else(Default::default, |g| g.effects());
            sealed.guess = Guess::of(effects, on);
        }
    });
    Grid::new("guess")
        .num_columns(2)
        .spacing([10.0, 2.0])
        .show(ui, |ui| {
            for (i, spec) in CATALOGUE.iter().enumerate() {
                let mut ids = sealed
                    .guess
                    .as_ref()
                    .map_or_else(Default::default, Guess::effects);
                let mut on = ids.contains(spec.id);
                let tick = ui.checkbox(&mut on, small(spec.name));
                if tick.on_hover_text(spec.sentence).changed() {
                    if on {
                        ids.insert(spec.id.to_owned());
                    } else {
                        ids.remove(spec.id);
                    }
                    let and_more = sealed.guess.as_ref().is_some_and(Guess::is_unknown_in_part);
                    sealed.guess = Guess::of(ids, and_more);
                }
                if i % 2 == 1 {
                    ui.end_row();
                }
            }
        });
}

fn tally(ui: &mut Ui, tally: Tally) {
    if tally == Tally::default() {
        return;
    }
    ui.separator();
    let (you, tool) = (tally.person, tally.tool);
    ui.label(format!(
        "Right so far: you {} of {}, the diagnosis {} of {}.",
        you.0, you.1, tool.0, tool.1
    ))
    .on_hover_text("A look-alike of the concealed effect counts as right");
}
