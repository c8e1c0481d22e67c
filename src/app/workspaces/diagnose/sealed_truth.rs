//! What was in the envelope.

use eframe::egui::{RichText, Ui};

use crate::app::analysis::sealed_trial::{Opened, is_right};
use crate::app::plots::frame::style;
use crate::app::widgets::text::{error_color, small};
use crate::model::effects::find;
use crate::trial::score::Mark;
use crate::trial::{Class, ConcealedEffect};

/// Draws the truth and the marks.
pub fn show(ui: &mut Ui, opened: &Opened) {
    let truth = &opened.truth;
    let text = match truth.class {
        Class::Nothing => "Nothing was left out.",
        Class::One => "One effect was left out:",
        Class::Two => "Two effects were left out:",
        Class::Outside => "Something that the catalogue does not have:",
    };
    ui.label(RichText::new(text).strong());
    for effect in &truth.effects {
        ui.label(RichText::new(name(effect)).strong());
        ui.label(small(size(effect)));
    }
    for decoy in &truth.decoys {
        let text = format!("Also there, and not to be named: {}.", name(decoy));
        ui.label(small(text)).on_hover_text(
            "A decoy: re-tuning the model takes it up wholly, so that it cannot be seen",
        );
    }
    verdict(ui, "You", opened.person);
    verdict(ui, "The tool", opened.tool);
    if opened.seal_holds {
        ui.label(small("The seal holds: its SHA-256 is the one shown at first.").weak());
    } else {
        ui.colored_label(error_color(ui), "The seal does not hold.");
    }
}

fn verdict(ui: &mut Ui, who: &str, mark: Option<Mark>) {
    let Some(mark) = mark else {
        ui.label(format!("{who}: no answer"));
        return;
    };
    let text = match mark {
        Mark::Right => "right",
        Mark::Group => "right, as one that looks alike",
        Mark::Part => "half right: one of two",
        Mark::Abstained => "abstained: named nothing",
        Mark::Wrong => "wrong: named what is not there",
        Mark::FalseAlarm => "false alarm: nothing was left out",
    };
    let color = if is_right(mark) {
        style::palette(ui).release
    } else {
        ui.visuals().warn_fg_color
    };
    ui.label(RichText::new(format!("{who}: {text}")).color(color));
}

/// The catalogue's name, or the words of a law that it does not have.
fn name(effect: &ConcealedEffect) -> String {
    match find(&effect.id) {
        Some(spec) => format!("{} ({})", spec.name, effect.formulation),
        None => format!(
            "{} ({})",
            effect.id.trim_start_matches("outside_").replace('_', " "),
            effect.formulation
        ),
    }
}

fn size(effect: &ConcealedEffect) -> String {
    let times = effect.times_smallest_visible;
    let visible = if times < 3.0 {
        format!("{times:.1} times the smallest visible size: too small to expect a name")
    } else {
        format!("{times:.1} times the smallest visible size")
    };
    match effect.size_nn {
        Some(force) => format!("at most {force:.2} nN, {visible}"),
        None => visible,
    }
}
