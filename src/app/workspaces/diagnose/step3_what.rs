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
use crate::diagnose::findings::{Finding, FindingKind};
use crate::diagnose::report::words::{chi2, in_noise, listed, share};
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
    for (name, row) in [
        ("Nothing left out", nothing_row(d)),
        ("Unknown: not in the catalogue", unknown_row(d)),
    ] {
        show_row(ui, name, d, &row);
    }
}

/// One of those two answers.
struct AnswerRow {
    /// Length of its bar, 0 to 1.
    share: f64,
    /// What is written on the bar.
    text: String,
    /// Whether it is the answer, or part of it.
    is_answer: bool,
    why: String,
}

impl AnswerRow {
    fn answer(why: String) -> Self {
        Self {
            share: 1.0,
            text: "the answer".to_owned(),
            is_answer: true,
            why,
        }
    }

    fn of_probability(p: f64, why: String) -> Self {
        Self {
            share: p,
            text: probability(p),
            is_answer: false,
            why,
        }
    }
}

/// Probabilities that nothing is missing, and that it is another law than those named. The odds of
/// single effects do not give a probability of "nothing": effects too small to be seen are not among
/// them.
fn other_probabilities(d: &Diagnosis) -> (f64, f64) {
    let best = d
        .candidates
        .iter()
        .map(|c| c.probability)
        .fold(0.0, f64::max);
    let taken: f64 = d.named.iter().map(|n| n.probability).fold(best, f64::max)
        + d.named
            .first()
            .map_or(0.0, |n| n.probability * n.alike.len() as f64);
    let nothing = (1.0 - taken / CALIBRATED_PRECISION).clamp(0.0, 1.0);
    // The share of sealed trials in which the effect named was in truth another law.
    (nothing, (1.0 - taken - nothing).clamp(0.0, 1.0))
}

fn nothing_row(d: &Diagnosis) -> AnswerRow {
    match d.verdict {
        Verdict::Adequate => AnswerRow::answer(
            "The re-tuned model fits the held-out recordings to within the noise, and no effect \
             improves it significantly. Effects too small for these recordings cannot be \
             ruled out."
                .to_owned(),
        ),
        Verdict::MissingPhysics | Verdict::PartlyExplained => AnswerRow::of_probability(
            other_probabilities(d).0,
            format!(
                "Without a new effect the error on held-out recordings is {}.",
                in_noise(d.held_out.before.rms, d.noise)
            ),
        ),
        Verdict::Unexplained => {
            let fails = |f: &Finding| matches!(f.kind, FindingKind::FailsHeldOut { .. });
            let why = if d.inadequacy().is_some_and(fails) {
                "Re-tuning alone reaches the noise. One effect improves the fit significantly, \
                 but not on held-out recordings."
            } else {
                "With re-tuning alone the error stays above the noise."
            };
            AnswerRow::of_probability(0.0, why.to_owned())
        }
    }
}

fn unknown_row(d: &Diagnosis) -> AnswerRow {
    let what_remains = rest::sentences(d).join(" ");
    match d.verdict {
        Verdict::Unexplained => AnswerRow::answer(format!(
            "No effect of the catalogue explains the difference. {what_remains}"
        )),
        Verdict::PartlyExplained => {
            let left = d.remaining.as_ref().map_or(f64::NAN, |r| r.share);
            AnswerRow {
                share: if left.is_finite() { left } else { 0.0 },
                text: format!("{} left", share(left)),
                is_answer: true,
                why: what_remains,
            }
        }
        Verdict::MissingPhysics => AnswerRow::of_probability(
            other_probabilities(d).1,
            format!(
                "No difference above the noise remains. In sealed trials, however, {} of the \
                 named effects were wrong.",
                probability(1.0 - CALIBRATED_PRECISION)
            ),
        ),
        Verdict::Adequate => AnswerRow {
            share: 0.0,
            text: "no sign of it".to_owned(),
            is_answer: false,
            why: "No difference above the noise remains.".to_owned(),
        },
    }
}

fn show_row(ui: &mut Ui, name: &str, d: &Diagnosis, row: &AnswerRow) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        // The width of the tick box of an effect.
        ui.add_space(ui.spacing().icon_width + 6.0);
        let (rect, _) = ui.allocate_exact_size(vec2(74.0, 17.0), Sense::hover());
        let color = if row.is_answer {
            colors::verdict(ui, d.verdict)
        } else {
            ui.visuals().widgets.active.bg_fill
        };
        candidate::bar(ui, rect, row.share, &row.text, color);
        let text = RichText::new(name);
        let text = if row.is_answer { text.strong() } else { text };
        ui.add(Label::new(text).truncate()).on_hover_text(&row.why);
    });
    if row.is_answer {
        ui.indent(name, |ui| ui.label(small(&row.why)));
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
