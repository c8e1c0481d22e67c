//! Step 3: which effect is missing. Lists every effect that was compared, together with
//! the answers "nothing" and "unknown". Effects can be added and removed by hand.

use eframe::egui::{Button, Frame, Label, Panel, RichText, Sense, Ui, vec2};

use super::words::{placeholder, scrolled};
use super::{candidate, colors};
use crate::app::analysis::diagnosis::named;
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::widgets::text::{heading, small};
use crate::diagnose::diagnosis::Candidate;
use crate::diagnose::findings::FindingKind;
use crate::diagnose::report::words::{chi2, in_noise, listed};
use crate::diagnose::report::{probability, rest};
use crate::diagnose::thresholds::CALIBRATED_PRECISION;
use crate::diagnose::{Diagnosis, Verdict};
use crate::model::effects::find;

/// Effects at least this probable are listed without being asked for.
const MIN_LISTED_PROBABILITY: f64 = 1e-3;
/// Effects that are listed at least, however improbable.
const MIN_LISTED_CANDIDATES: usize = 6;

/// Draws the step.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(answer) = state.diagnosing.shown().cloned() else {
        placeholder(
            ui,
            "Which effect the model leaves out: each with its probability, the evidence for and \
             against it, and its look-alikes. \"Nothing\" and \"unknown\" are possible answers.",
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
        ui.label(small("Chosen by hand: fitted and checked even if it does not help.").weak());
    } else {
        answer_rows(ui, d);
    }
    // A run by hand compares nothing: the other effects keep the numbers of the search.
    let searched = diagnosing.automatic.clone().filter(|_| by_hand);
    let candidates = searched.as_ref().map_or(d, |a| &a.diagnosis);
    let compared = !by_hand || searched.is_some();
    let candidates = &candidates.candidates;
    let rest: Vec<&Candidate> = candidates.iter().filter(|c| !is_named(c)).collect();
    let probable = rest
        .iter()
        .filter(|c| c.probability >= MIN_LISTED_PROBABILITY)
        .count();
    let few = probable.max(MIN_LISTED_CANDIDATES).min(rest.len());
    let all = diagnosing.look.all_candidates;
    if !rest.is_empty() {
        ui.add_space(3.0);
        heading(
            ui,
            match (compared, d.named.is_empty()) {
                (false, _) => "Not compared",
                (true, true) => "Candidates",
                (true, false) => "Other candidates",
            },
        );
    }
    let shown = if all { rest.len() } else { few };
    for c in rest.iter().take(shown) {
        candidate::show(ui, diagnosing, d, c, compared);
    }
    let more = rest.len() - few;
    if more > 0 {
        let text = if all {
            "Hide improbable effects".to_owned()
        } else {
            format!("Show improbable effects ({more})")
        };
        if ui.button(small(text)).clicked() {
            diagnosing.look.all_candidates = !all;
        }
    }
}

/// The rows "nothing" and "unknown".
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
    let none_probability = (1.0 - taken / CALIBRATED_PRECISION).clamp(0.0, 1.0);
    // The share of sealed trials in which the effect named was in truth another law.
    let other_probability = (1.0 - taken - none_probability).clamp(0.0, 1.0);
    // The odds of single effects do not give a probability of "nothing": effects too small
    // to be seen are not among them.
    let (nothing, text, why_nothing) = match d.verdict {
        Verdict::Adequate => (
            1.0,
            "the answer".to_owned(),
            "The re-tuned model fits the held-out recordings to within the noise, and no effect \
             improves it significantly. Effects too small for these recordings cannot be \
             ruled out."
                .to_owned(),
        ),
        Verdict::MissingPhysics => (
            none_probability,
            probability(none_probability),
            format!(
                "Without a new effect the error on held-out recordings is {}.",
                in_noise(d.held_out.before.rms, d.noise)
            ),
        ),
        Verdict::Unexplained => (
            0.0,
            probability(0.0),
            if d.inadequacy()
                .is_some_and(|f| matches!(f.kind, FindingKind::FailsHeldOut { .. }))
            {
                "Re-tuning alone reaches the noise. One effect improves the fit significantly, \
                 but not on held-out recordings."
                    .to_owned()
            } else {
                "With re-tuning alone the error stays above the noise.".to_owned()
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
    let unexplained = rest::sentences(d);
    let is_inadequate = d.inadequacy().is_some();
    let (share, text, why) = match d.verdict {
        Verdict::Unexplained => (
            1.0,
            "the answer".to_owned(),
            format!(
                "No effect of the catalogue explains the difference. {}",
                unexplained.join(" ")
            ),
        ),
        Verdict::MissingPhysics if is_inadequate => (
            other_probability,
            probability(other_probability),
            unexplained.join(" "),
        ),
        Verdict::MissingPhysics => (
            other_probability,
            probability(other_probability),
            format!(
                "No difference above the noise remains. In sealed trials, however, {} of the \
                 named effects were wrong.",
                probability(1.0 - CALIBRATED_PRECISION)
            ),
        ),
        Verdict::Adequate => (
            0.0,
            "no sign of it".to_owned(),
            "No difference above the noise remains.".to_owned(),
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
        // The width of the tick box of an effect.
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

/// Effects chosen by hand, and their result next to that of the search.
fn by_hand(ui: &mut Ui, state: &mut State) {
    ui.add_space(4.0);
    let diagnosing = &state.diagnosing;
    let picked = diagnosing.picked();
    let names: Vec<&str> = picked
        .iter()
        .map(|id| find(id).map_or(id.as_str(), |spec| spec.name))
        .collect();
    let text = match names.as_slice() {
        [] => "No effect ticked: tests the model alone".to_owned(),
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
        let button = ui.add_enabled(free && !same && !done, Button::new("Test ticked effects"));
        let help = if same {
            "These are the effects that the search found: tick others to test them"
        } else if done {
            "Already done for these: see Proof"
        } else {
            "Fit exactly the ticked effects and check them on held-out recordings"
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
                "{title}: held out {} to {}, chi2 {}",
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
