//! The table of all effects of the catalogue: scores, probabilities, and a remark on each.

use super::named_effects::probability;
use crate::diagnose::comparison::trial::SelectionResult;
use crate::diagnose::contact::law_test::LawTest;
use crate::diagnose::diagnosis::{Candidate, Verdict};
use crate::diagnose::thresholds::{FALSE_ABSTENTION_RATE, HELD_GAIN, REFIT_MIN_SCORE};
use crate::model::effects::CATALOGUE;

/// All effects of the catalogue, most probable first.
pub fn candidates(
    found: &SelectionResult,
    tests: &[LawTest],
    named_laws: &[LawTest],
    verdict: Verdict,
) -> Vec<Candidate> {
    let mut out: Vec<Candidate> = CATALOGUE
        .iter()
        .map(|spec| {
            let named = found.state.named.iter().find(|n| n.spec == *spec);
            let scored = found.scores.iter().find(|w| w.spec == *spec);
            let fit = scored.and_then(|w| w.fit.as_ref());
            let test = tests.iter().find(|t| t.id == spec.id);
            let law = named_laws.iter().any(|t| t.id == spec.id);
            let mut remarks = Vec::new();
            let (gain, held_gain, held_chi2) = match (fit, test) {
                (Some(t), _) => (
                    t.gain,
                    t.held_gain,
                    t.held_out
                        .as_ref()
                        .map_or(f64::NAN, |h| h.cost / h.point.rows.max(1) as f64),
                ),
                (None, Some(t)) => {
                    remarks.push(t.evidence.clone());
                    (t.gain, t.held_gain, t.held_chi2)
                }
                _ => (f64::NAN, f64::NAN, f64::NAN),
            };
            if let Some(f) = scored.and_then(|w| w.self_ringing_frequency) {
                remarks.push(format!(
                    "something rings by itself at {:.2} kHz, and nothing that moves the device excites it",
                    1e-3 * f
                ));
            } else if let Some(t) = fit {
                remarks.push(if t.is_insignificant() {
                    "it improves the fit no more than chance would".to_owned()
                } else if found.state.held_out.is_some() && t.held_gain < HELD_GAIN {
                    "its improvement does not hold on held-out recordings".to_owned()
                } else if named.is_some() {
                    "it improves both fitted and held-out recordings more than any other effect".to_owned()
                } else {
                    "another effect improves the fit more, and nothing remains for this one".to_owned()
                });
            } else if scored.is_some_and(|w| w.predicted_gain > REFIT_MIN_SCORE) {
                remarks.push("its predicted gain is far below that of the best effect, so it was not fitted".to_owned());
            } else if scored.is_some() {
                remarks.push("re-tuning the device's own parameters explains everything that this effect could".to_owned());
            } else if !found.baseline.train.model.allows(spec) {
                remarks.push("this device has nothing that it could act on".to_owned());
            } else if test.is_none() {
                remarks.push("these recordings do not test it".to_owned());
            }
            let probability = match (named, verdict) {
                (Some(n), Verdict::MissingPhysics) => {
                    probability(n.gain.0 + n.gain.1, n.alike.len())
                }
                _ if law => test.map_or(0.0, |t| probability(t.gain + t.held_gain, 0)),
                _ => {
                    let alike = found
                        .state
                        .named
                        .iter()
                        .find(|n| n.alike.contains(&spec.id));
                    match (alike, fit) {
                        (Some(n), Some(t)) => probability(t.worth(), n.alike.len()),
                        // An effect that others explain better has no odds of its own.
                        _ if found.state.named.is_empty() && gain.is_finite() => {
                            probability(gain.min(gain + held_gain), 0).min(0.5)
                        }
                        _ => 0.0,
                    }
                }
            };
            Candidate {
                id: spec.id.to_owned(),
                name: spec.name.to_owned(),
                probability,
                score: scored.map_or(0.0, |w| w.predicted_gain),
                gain,
                held_out_gain: held_gain,
                held_out_chi2: held_chi2,
                remarks,
            }
        })
        .collect();
    if verdict == Verdict::Unexplained {
        // They share the probability that it was one of them after all.
        let all: f64 = out.iter().map(|c| c.probability).sum();
        let share = FALSE_ABSTENTION_RATE / all.max(FALSE_ABSTENTION_RATE);
        out.iter_mut().for_each(|c| c.probability *= share);
    }
    out.sort_by(|a, b| {
        b.probability
            .total_cmp(&a.probability)
            .then(b.score.total_cmp(&a.score))
    });
    out
}
