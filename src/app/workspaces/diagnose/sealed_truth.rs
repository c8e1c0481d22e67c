//! The contents of the envelope: the concealed effects, and how the guess and the diagnosis
//! score.

use eframe::egui::{RichText, Ui};

use crate::app::analysis::sealed_trial::{Opened, is_right};
use crate::app::plots::frame::style;
use crate::app::widgets::text::{error_color, small};
use crate::diagnose::Verdict;
use crate::model::effects::find;
use crate::trial::score::Mark;
use crate::trial::{Class, ConcealedEffect};

/// Draws the truth and the marks of the guess and of the diagnosis, which said these things.
pub fn show(ui: &mut Ui, opened: &Opened, [guessed, found]: [Option<Verdict>; 2]) {
    let truth = &opened.truth;
    let text = match truth.class {
        Class::Nothing => "Nothing was concealed.",
        Class::One => "One effect was concealed:",
        Class::Two => "Two effects were concealed:",
        Class::Outside => "An effect outside the catalogue was concealed:",
    };
    ui.label(RichText::new(text).strong());
    for effect in &truth.effects {
        ui.label(RichText::new(name(effect)).strong());
        ui.label(small(size(effect)));
    }
    for decoy in &truth.decoys {
        let text = format!("Also present as a decoy: {}.", name(decoy));
        ui.label(small(text)).on_hover_text(
            "Re-tuning the model absorbs it completely, so it cannot and need not be found",
        );
    }
    score(ui, "You", opened.person, guessed);
    score(ui, "The diagnosis", opened.tool, found);
    if opened.seal_holds {
        ui.label(small("The seal holds: the SHA-256 is the one shown at the start.").weak());
    } else {
        ui.colored_label(
            error_color(ui),
            "The seal does not hold: the SHA-256 differs.",
        );
    }
}

fn score(ui: &mut Ui, who: &str, mark: Option<Mark>, said: Option<Verdict>) {
    let Some(mark) = mark else {
        ui.label(format!("{who}: no answer"));
        return;
    };
    let text = match mark {
        Mark::Right => "right",
        Mark::Group => "right: a look-alike of it",
        Mark::Part => "partly right: one of two",
        Mark::Abstained => "abstained: no effect named",
        Mark::Wrong => "wrong: this effect is not present",
        Mark::FalseAlarm => "false alarm: nothing was concealed",
    };
    let color = if is_right(mark) {
        style::palette(ui).release
    } else {
        ui.visuals().warn_fg_color
    };
    // A mark is that of the names, whatever is said of the rest.
    let rest = match said {
        Some(Verdict::PartlyExplained) => "; something else was said to remain",
        _ => "",
    };
    ui.label(RichText::new(format!("{who}: {text}{rest}")).color(color));
}

/// The name in the catalogue, or a description if it is not there.
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
        format!("{times:.1} times the smallest visible size: too small to be identified")
    } else {
        format!("{times:.1} times the smallest visible size")
    };
    match effect.size_nn {
        Some(force) => format!("at most {force:.2} nN, {visible}"),
        None => visible,
    }
}
