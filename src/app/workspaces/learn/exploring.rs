//! Steps with controls: free exploration, a fit by hand, and the game of the concealed effect.

use eframe::egui::{Button, Grid, Label, RichText, Ui, vec2};

use super::words::{TEXT_SIZE, paragraphs, verdict};
use crate::app::analysis::learning::OpenStep;
use crate::app::theme;
use crate::app::widgets::parameter_slider::{ParameterSlider, Size};
use crate::learn::controls::Control;
use crate::learn::lesson::{Concealed, Explore, HandFit, Written};
use crate::learn::prediction::Scored;
use crate::learn::target::fit_score;
use crate::model::unit::format_number;

/// The sliders of a step.
fn sliders(ui: &mut Ui, open: &mut OpenStep, controls: &[Control]) {
    let Some(original) = open.step().map(|step| step.scene.clone()) else {
        return;
    };
    for control in controls {
        let (Some(spec), Some(value)) = (
            control.spec(&open.scene),
            open.scene.control_value(&control.id),
        ) else {
            continue;
        };
        let refused = open.scene.preset.model.check().err();
        let problem = refused.filter(|error| error.parameter == control.id);
        let slider = ParameterSlider {
            scope: "lesson",
            id: &control.id,
            spec,
            value,
            original: original.control_value(&control.id).unwrap_or(value),
            locked: None,
            size: Size::Large,
            problem: problem.as_ref().map(|error| error.reason.as_str()),
            extrapolation: None,
        };
        if let Some(value) = slider.show(ui).value {
            open.scene.set_control(&control.id, value);
            // What is moved is seen whole at once; Play shows it in time.
            open.playback.is_playing = false;
            open.playback.time = open.scene.duration;
        }
        ui.add_space(4.0);
    }
    if open.scene != original && ui.button("Back to the values of the step").clicked() {
        open.restore();
    }
}

/// Free exploration, with a goal if there is one.
pub(super) fn explore(ui: &mut Ui, open: &mut OpenStep, explore: &Explore, written: &Written) {
    paragraphs(ui, &written.question);
    sliders(ui, open, &explore.controls);
    let Some(goal) = &explore.goal else {
        return;
    };
    let is_reached = open
        .result()
        .and_then(|result| goal.holds(&result.run).ok())
        .unwrap_or(false);
    ui.add_space(6.0);
    if is_reached {
        let color = theme::good(ui.visuals().dark_mode);
        ui.label(
            RichText::new("You have found it.")
                .size(TEXT_SIZE)
                .color(color),
        );
    } else {
        ui.weak("Not found yet.");
    }
}

/// A fit by hand. Returns the score when it is handed in.
pub(super) fn fit(
    ui: &mut Ui,
    open: &mut OpenStep,
    fit: &HandFit,
    written: &Written,
) -> Option<Scored> {
    paragraphs(ui, &written.question);
    sliders(ui, open, &fit.controls);
    ui.add_space(6.0);
    let misfit = open.misfit()?;
    let points = 100.0 * fit_score(misfit);
    let text = format!(
        "Misfit: {} x noise. Score: {points:.0} of 100.",
        format_number(misfit, 3)
    );
    ui.label(RichText::new(text).size(TEXT_SIZE).strong());
    ui.weak("A perfect fit has a misfit of about 1: only the noise is left.");
    let hand_in = Button::new(RichText::new("Hand in").size(14.0)).min_size(vec2(110.0, 28.0));
    let clicked = ui.add(hand_in).clicked();
    if clicked {
        open.scored = open.hand_in(fit);
    }
    if let Some(scored) = &open.scored {
        verdict(ui, scored);
    }
    open.scored.clone().filter(|_| clicked)
}

/// What was done in the game.
#[derive(Default)]
pub(super) struct GameOutput {
    /// The score of a guess.
    pub(super) scored: Option<Scored>,
    /// Whether the person wants the sealed trial of the Diagnose workspace.
    pub(super) asks_for_sealed_trial: bool,
}

/// The game of the concealed effect.
pub(super) fn concealed(
    ui: &mut Ui,
    open: &mut OpenStep,
    game: &Concealed,
    written: &Written,
) -> GameOutput {
    let mut output = GameOutput::default();
    paragraphs(ui, &written.question);
    let mut level_asked = None;
    ui.horizontal_wrapped(|ui| {
        for (i, level) in game.levels.iter().enumerate() {
            let is_on = open.round.as_ref().is_some_and(|round| round.level == i);
            let (right, all) = open.tally.get(i).copied().unwrap_or_default();
            let name = format!("Level {}: {} ({right} of {all})", i + 1, level.name);
            if ui.selectable_label(is_on, name).clicked() {
                level_asked = Some(i);
            }
        }
    });
    let Some(round) = open.round.clone() else {
        return output;
    };
    ui.weak(format!(
        "Sealed before you guess: SHA-256 {}...",
        round.seal
    ));
    ui.add_space(4.0);
    sliders(ui, open, &game.controls);
    if let Some(misfit) = open.misfit() {
        let text = format!("Misfit now: {} x noise.", format_number(misfit, 3));
        ui.label(RichText::new(text).size(TEXT_SIZE).strong());
    }
    ui.add_space(6.0);
    ui.label(RichText::new("What is concealed?").size(TEXT_SIZE).strong());
    let guess = open.guess;
    if let Some(level) = game.level(&round) {
        for (i, candidate) in level.candidates.iter().enumerate() {
            let text = RichText::new(&candidate.name).size(TEXT_SIZE);
            let button = Button::new(text).selected(guess == Some(i));
            let button = button.min_size(vec2(ui.available_width(), 26.0));
            let response = ui.add_enabled(guess.is_none(), button);
            if response.on_hover_text(&candidate.sign).clicked() {
                output.scored = open.guess(i);
                open.scored.clone_from(&output.scored);
            }
        }
    }
    if let (Some(_), Some(opened)) = (open.guess, game.opened(&round)) {
        let is_right = open
            .scored
            .as_ref()
            .is_some_and(|scored| scored.score > 0.0);
        let word = if is_right { "Right" } else { "No" };
        let text = format!("{word}: it was {}. {}", opened.name, opened.sign);
        ui.add(Label::new(RichText::new(text).size(TEXT_SIZE)).wrap());
        let holds = if game.seal_holds(&round) {
            "The seal holds."
        } else {
            "The seal does not hold: this is an error of the program."
        };
        ui.weak(holds);
        if ui.button("Another one").clicked() {
            level_asked = Some(round.level);
        }
    }
    ui.add_space(6.0);
    Grid::new("after the game").show(ui, |ui| {
        let trial = ui.button("A real sealed trial...");
        output.asks_for_sealed_trial = trial
            .on_hover_text(
                "In Diagnose: other devices, unknown parameters, and the diagnosis as your rival",
            )
            .clicked();
    });
    if let Some(level) = level_asked {
        open.scored = None;
        open.draw(game, level);
    }
    output
}
