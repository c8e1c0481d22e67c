//! The table of all effects of the catalogue: scores, probabilities, and a remark on each.

use super::named_effects::probability;
use crate::diagnose::comparison::trial::{CandidateFit, SelectionResult};
use crate::diagnose::contact::law_test::LawTest;
use crate::diagnose::diagnosis::{Candidate, Verdict};
use crate::diagnose::findings::CandidateRemark;
use crate::diagnose::thresholds::{
    CONFIRMING_HELD_GAIN, FALSE_ABSTENTION_RATE, HELD_GAIN, REFIT_MIN_SCORE, TRAIN_GAIN,
    UNNAMED_MAX_PROBABILITY,
};
use crate::diagnose::verdict::decide::Decision;
use crate::model::Model;
use crate::model::effects::{CATALOGUE, EffectSpec};

/// All effects of the catalogue, most probable first; `tests` are the last ones of each contact law.
pub fn candidates(decision: &Decision, tests: &[LawTest]) -> Vec<Candidate> {
    let of = |spec: &'static EffectSpec| {
        let test = tests.iter().find(|t| t.id == spec.id);
        candidate(spec, decision, test)
    };
    let mut out: Vec<Candidate> = CATALOGUE.iter().copied().map(of).collect();
    if decision.verdict == Verdict::Unexplained {
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

/// One effect; `test` is that of its contact law, if it has one that was tested.
fn candidate(spec: &'static EffectSpec, decision: &Decision, test: Option<&LawTest>) -> Candidate {
    let found = &decision.found;
    let scored = found.scores.iter().find(|w| w.spec == spec);
    let fit = scored.and_then(|w| w.fit.as_ref());
    let (gain, held_out_gain, held_out_chi2) = match (fit, test) {
        (Some(t), _) => (
            t.gain,
            t.held_gain,
            t.held_out
                .as_ref()
                .map_or(f64::NAN, |h| h.cost / h.point.rows.max(1) as f64),
        ),
        (None, Some(t)) => (t.gain, t.held_gain, t.held_chi2),
        _ => (f64::NAN, f64::NAN, f64::NAN),
    };
    let named = found.state.named.iter().find(|n| n.spec == spec);
    let law = decision.contact_laws.iter().any(|t| t.id == spec.id);
    let probability = match named {
        Some(n) => probability(n.gain.0 + n.gain.1, n.alike.len()),
        None if law => test.map_or(0.0, |t| probability(t.gain + t.held_gain, 0)),
        None => unnamed_probability(spec, found, fit, (gain, held_out_gain)),
    };
    Candidate {
        id: spec.id.to_owned(),
        name: spec.name.to_owned(),
        probability,
        score: scored.map_or(0.0, |w| w.predicted_gain),
        gain,
        held_out_gain,
        held_out_chi2,
        remarks: remarks(spec, decision, test),
    }
}

/// Probability of an effect that is not named, with falls of chi2 on fitted and held-out recordings;
/// these are no numbers if it was not fitted.
fn unnamed_probability(
    spec: &EffectSpec,
    found: &SelectionResult,
    fit: Option<&CandidateFit>,
    (gain, held_out_gain): (f64, f64),
) -> f64 {
    let mut named = found.state.named.iter();
    match (named.find(|n| n.alike.contains(&spec.id)), fit) {
        (Some(n), Some(t)) => probability(t.worth(), n.alike.len()),
        // An effect that others explain better has no odds of its own.
        _ if found.state.named.is_empty() && gain.is_finite() => {
            let worth = gain.min(gain + held_out_gain);
            probability(worth, 0).min(UNNAMED_MAX_PROBABILITY)
        }
        _ => 0.0,
    }
}

/// What speaks for or against an effect; for one that is named its evidence does.
fn remarks(
    spec: &'static EffectSpec,
    decision: &Decision,
    test: Option<&LawTest>,
) -> Vec<CandidateRemark> {
    let found = &decision.found;
    if found.state.named.iter().any(|n| n.spec == spec) {
        return Vec::new();
    }
    if decision.refused.contains(&spec.id) {
        return vec![CandidateRemark::Refused];
    }
    if decision.contact_laws.iter().any(|t| t.id == spec.id) {
        // Its evidence says it.
        return Vec::new();
    }
    let scored = found.scores.iter().find(|w| w.spec == spec);
    let fit = scored.and_then(|w| w.fit.as_ref());
    let law = test.filter(|_| fit.is_none());
    let held_out = found.state.held_out.is_some();
    let mut remarks: Vec<CandidateRemark> =
        law.map(|t| unnamed_law(t, held_out)).into_iter().collect();
    if let Some(f) = scored.and_then(|w| w.self_ringing_frequency) {
        remarks.push(CandidateRemark::SelfRings(f));
    } else if let Some(t) = fit {
        remarks.push(if t.is_insignificant() {
            CandidateRemark::Insignificant
        } else if held_out && t.held_gain < HELD_GAIN {
            CandidateRemark::FailsHeldOut
        } else {
            CandidateRemark::Outweighed
        });
    } else if has(&found.baseline.train.model, spec) {
        remarks.push(CandidateRemark::InModel);
    } else if scored.is_some_and(|w| w.predicted_gain > REFIT_MIN_SCORE) {
        remarks.push(CandidateRemark::NotFitted);
    } else if scored.is_some() {
        remarks.push(CandidateRemark::AbsorbedByRetuning);
    } else if !found.baseline.train.model.allows(spec) {
        remarks.push(CandidateRemark::NothingToActOn);
    } else if test.is_none() {
        remarks.push(CandidateRemark::NotTested);
    }
    remarks
}

/// Whether a model has an effect.
fn has(model: &Model, spec: &EffectSpec) -> bool {
    model.effects.iter().any(|active| active.spec == spec)
}

/// Why a contact law is not named, as far as its test says; `held_out` is whether there are held-out
/// recordings.
fn unnamed_law(test: &LawTest, held_out: bool) -> CandidateRemark {
    let law = test.evidence.clone();
    let (fall, needed) = match test.min_predictive_gain {
        Some(least) => (test.gain + test.held_gain, least),
        None => (test.gain, TRAIN_GAIN),
    };
    let fitted = test.gain;
    if fitted <= TRAIN_GAIN && fall <= needed {
        CandidateRemark::LawFallsShort { law, fall, needed }
    } else if held_out && test.held_gain <= CONFIRMING_HELD_GAIN {
        CandidateRemark::LawFailsProof { law, fall: fitted }
    } else {
        CandidateRemark::LawNotNamed { law, fall }
    }
}
