//! Step 3: what was left out. Every effect that was weighed, with "nothing" and
//! "unknown" as answers of their own; effects added or dropped by hand.

use eframe::egui::{Button, Frame, Label, Panel, RichText, Sense, Ui, vec2};

use super::words::{heading, promise, scrolled};
use super::{candidate, colors};
use crate::app::analysis::diagnosis::named;
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::widgets::text::small;
use crate::diagnose::diagnosis::Candidate;
use crate::diagnose::findings::FindingKind;
use crate::diagnose::report::words::{chi2, in_noise, listed};
use crate::diagnose::report::{probability, rest};
use crate::diagnose::thresholds::CALIBRATED_PRECISION;
use crate::diagnose::{Diagnosis, Verdict};
use crate::model::effects::find;

/// Probability from which an effect is listed by itself.
const WORTH: f64 = 1e-3;
/// Effects that are listed at least.
const LEAST: usize = 6;

/// Draws the step.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(answer) = state.diagnosing.shown().cloned() else {
        promise(
            ui,
            "Which effect was left out: each with its probability, what speaks for and against \
             it, and those that look alike. \"Nothing\" and \"unknown\" are real answers.",
        );
        return;
    };
    Panel::bottom("diagnose by hand")
        .resizable(false)
        .frame(Frame::NONE)
        .show(ui, |ui| by_hand(ui, state));
    scrolled(ui, "diagnose what", |ui| list(ui, state, &answer));
}

fn list(ui: &mut Ui, state: &mut State, answer: &Answer) {
    let d = &answer.diagnosis;
    let by_hand = answer.asked.by_hand.is_some();
    let diagnosing = &mut state.diagnosing;
    let is_named = |c: &&Candidate| d.named.iter().any(|n| n.id == c.id);
    for c in d.candidates.iter().filter(is_named) {
        candidate::show(ui, diagnosing, d, c, !by_hand);
    }
    if by_hand {
        ui.label(small("Chosen by hand: fitted and proved, whatever it brings.").weak());
    } else {
        answer_rows(ui, d);
    }
    // By hand nothing is weighed: the others are as the search weighed them.
    let searched = diagnosing.automatic.clone().filter(|_| by_hand);
    let candidates = searched.as_ref().map_or(d, |a| &a.diagnosis);
    let weighed = !by_hand || searched.is_some();
    let candidates = &candidates.candidates;
    let rest: Vec<&Candidate> = candidates.iter().filter(|c| !is_named(c)).collect();
    let worth = rest.iter().filter(|c| c.probability >= WORTH).count();
    let few = worth.max(LEAST).min(rest.len());
    let all = diagnosing.look.all_candidates;
    if !rest.is_empty() {
        ui.add_space(3.0);
        heading(
            ui,
            match (weighed, d.named.is_empty()) {
                (false, _) => "Not weighed",
                (true, true) => "Weighed",
                (true, false) => "Weighed beside it",
            },
        );
    }
    let shown = if all { rest.len() } else { few };
    for c in rest.iter().take(shown) {
        candidate::show(ui, diagnosing, d, c, weighed);
    }
    let more = rest.len() - few;
    if more > 0 {
        let text = if all {
            "Hide those that explain nothing".to_owned()
        } else {
            format!("Show {more} more that explain nothing")
        };
        if ui.button(small(text)).clicked() {
            diagnosing.look.all_candidates = !all;
        }
    }
}

/// "Nothing" and "unknown" beside the effects.
fn answer_rows(ui: &mut Ui, d: &Diagnosis) {
    let best = d
        .candidates
        .iter()
        .map(|c| c.probability)
        .fold(0.0, f64::max);
    let taken: f64 = d.named.iter().map(|n| n.probability).fold(best, f64::max)
        + d.named
            .first()
            .map_or(0.0, |n| n.probability * n.alike.len() as f64);
    let chance = (1.0 - taken / CALIBRATED_PRECISION).clamp(0.0, 1.0);
    // As often as names in sealed trials stood for something else.
    let other = (1.0 - taken - chance).clamp(0.0, 1.0);
    // How sure "nothing" is cannot be had from the odds of single effects: what is too
    // small to show is not among them.
    let (nothing, text, why_nothing) = match d.verdict {
        Verdict::Adequate => (
            1.0,
            "the answer".to_owned(),
            "The re-tuned model is at the noise on the recordings kept out, and no effect \
             improves it by more than chance. What is too small to show in them cannot be told."
                .to_owned(),
        ),
        Verdict::MissingPhysics => (
            chance,
            probability(chance),
            format!(
                "Without it the residual kept out is {}.",
                in_noise(d.held_out.before.rms, d.noise)
            ),
        ),
        Verdict::Unexplained => (
            0.0,
            probability(0.0),
            if d.inadequacy()
                .is_some_and(|f| matches!(f.kind, FindingKind::FailsHeldOut { .. }))
            {
                "Re-tuning alone comes to the noise, but an effect improves that by more than chance."
                    .to_owned()
            } else {
                "Re-tuning alone leaves more than the noise.".to_owned()
            },
        ),
    };
    row(
        ui,
        "Nothing left out",
        (nothing, &text),
        d.verdict == Verdict::Adequate,
        d,
        &why_nothing,
    );
    let left = rest::sentences(d);
    let more = d.inadequacy().is_some();
    let (share, text, why) = match d.verdict {
        Verdict::Unexplained => (
            1.0,
            "the answer".to_owned(),
            format!(
                "No effect of the catalogue carries what is missing. {}",
                left.join(" ")
            ),
        ),
        Verdict::MissingPhysics if more => (other, probability(other), left.join(" ")),
        Verdict::MissingPhysics => (
            other,
            probability(other),
            format!(
                "Nothing above the noise is left for it. But of the names that the program gave \
                 in sealed trials {} stood for another law.",
                probability(1.0 - CALIBRATED_PRECISION)
            ),
        ),
        Verdict::Adequate => (
            0.0,
            "no sign of it".to_owned(),
            "Nothing above the noise is left for something unknown.".to_owned(),
        ),
    };
    let is_answer = d.verdict == Verdict::Unexplained;
    row(
        ui,
        "Unknown: not in the catalogue",
        (share, &text),
        is_answer,
        d,
        &why,
    );
}

fn row(
    ui: &mut Ui,
    name: &str,
    (share, text): (f64, &str),
    is_answer: bool,
    d: &Diagnosis,
    why: &str,
) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        // Where the effects have their ticks.
        ui.add_space(ui.spacing().icon_width + 6.0);
        let (rect, _) = ui.allocate_exact_size(vec2(74.0, 17.0), Sense::hover());
        let color = if is_answer {
            colors::verdict(ui, d.verdict)
        } else {
            ui.visuals().widgets.active.bg_fill
        };
        candidate::bar(ui, rect, share, text, color);
        let text = RichText::new(name);
        let text = if is_answer { text.strong() } else { text };
        ui.add(Label::new(text).truncate()).on_hover_text(why);
    });
    if is_answer {
        ui.indent(name, |ui| ui.label(small(why)));
    }
}

/// Effects chosen by hand, and how they do beside the search's.
fn by_hand(ui: &mut Ui, state: &mut State) {
    ui.add_space(4.0);
    let diagnosing = &state.diagnosing;
    let picked = diagnosing.picked();
    let names: Vec<&str> = picked
        .iter()
        .map(|id| find(id).map_or(id.as_str(), |spec| spec.name))
        .collect();
    let text = match names.as_slice() {
        [] => "By hand: nothing ticked, the model alone".to_owned(),
        names => format!("By hand: {}", listed(names)),
    };
    ui.add(Label::new(small(text)).wrap());
    let same = diagnosing
        .automatic
        .as_ref()
        .is_some_and(|answer| named(&answer.diagnosis) == picked);
    let done = diagnosing
        .by_hand
        .as_ref()
        .is_some_and(|answer| answer.asked.by_hand.as_ref() == Some(&picked));
    let mut wanted = false;
    ui.horizontal(|ui| {
        let free = diagnosing.running.is_none();
        let button = ui.add_enabled(free && !same && !done, Button::new("Diagnose by hand"));
        let help = if same {
            "These are the effects that the search names: tick others to try them"
        } else if done {
            "It is done for these: see the proof"
        } else {
            "Fit and prove exactly the ticked effects, whatever they bring"
        };
        wanted = button
            .on_hover_text(help)
            .on_disabled_hover_text(help)
            .clicked();
    });
    for (title, answer) in [
        ("search", &diagnosing.automatic),
        ("by hand", &diagnosing.by_hand),
    ] {
        if let Some(answer) = answer.as_ref().filter(|_| diagnosing.by_hand.is_some()) {
            let d = &answer.diagnosis;
            let text = format!(
                "{title}: kept out {} to {}, chi2 {}",
                in_noise(d.held_out.before.rms, d.noise),
                in_noise(d.held_out.after.rms, d.noise),
                chi2(d.held_out.after.chi2)
            );
            ui.label(small(text));
        }
    }
    if wanted {
        state.ask(Command::DiagnoseByHand);
    }
    ui.add_space(4.0);
}
