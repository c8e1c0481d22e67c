//! The named effects with their parameters, errors, probabilities and evidence.

use super::effect_size;
use super::proof::SplitSamples;
use super::systematic_error::systematic_error;
use crate::diagnose::comparison::trial::{ModelState, SelectionResult};
use crate::diagnose::contact::law_test::LawTest;
use crate::diagnose::diagnosis::{Estimate, NamedEffect};
use crate::diagnose::findings::Evidence;
use crate::diagnose::hypotheses::second_mode::second_mode_evidence;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::thresholds::{CALIBRATED_PRECISION, PRIOR_LOG_ODDS};
use crate::fit::problem::prepare::Prepared;
use crate::fit::uncertainty::fit_result::uncertainty;
use crate::model::Model;

/// The named effects and contact laws, largest gain first; `full` is the model with all of them.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn names(
    found: &SelectionResult,
    named_laws: &[LawTest],
    after: &SplitSamples,
    full: &Model,
) -> Result<Vec<NamedEffect>, DiagnoseError> {
    let mut out = selected_effects(&found.state, after)?;
    out.extend(
        named_laws
            .iter()
            .map(|law| (law.gain, contact_law(law, after, full))),
    );
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(out.into_iter().map(|(_, n)| n).collect())
}

/// The effects selected by flight, each with its gain on the fitted recordings.
fn selected_effects(
    state: &ModelState,
    after: &SplitSamples,
) -> Result<Vec<(f64, NamedEffect)>, DiagnoseError> {
    let mut out = Vec::new();
    if state.named.is_empty() {
        return Ok(out);
    }
    let prepared = Prepared {
        problem: state.train.problem.clone(),
        segments: state.train.point.segments.clone(),
        nuisances: Vec::new(),
    };
    let chi2 = state.train.cost / state.train.point.rows.max(1) as f64;
    let model = &state.train.model;
    let errors = uncertainty(model, &prepared, &state.train.point, chi2.max(1.0))?;
    for n in &state.named {
        let Some(effect) = model.effects.iter().find(|e| e.spec == n.spec) else {
            continue;
        };
        let all = n.spec.parameters.iter().zip(&effect.values);
        let bearing = all.enumerate().filter(|(i, _)| effect.bears(*i));
        let parameters = bearing.map(|(_, (p, value))| {
            let id = format!("{}.{}", n.spec.id, p.id);
            let fitted = errors.parameters.iter().find(|t| t.id == id);
            Estimate {
                id: p.id.to_owned(),
                value: *value,
                std_error: match n.hypothesis.estimated_on_held_out {
                    // Chi2 falls by the square of a height in units of its standard error.
                    Some(_) if n.hypothesis.free.contains(&id) => {
                        value.abs() / (n.gain.0 + n.gain.1).max(1.0).sqrt()
                    }
                    _ => fitted.map_or(f64::INFINITY, |f| {
                        f.std_error.hypot(systematic_error(n.spec, p, *value))
                    }),
                },
                unit: p.unit,
            }
        });
        let determined_by = n
            .hypothesis
            .estimated_on_held_out
            .zip(state.held_out.as_ref());
        let mut evidence = vec![match determined_by {
            Some((k, held)) => Evidence::AfterFitted {
                recording: held.problem.data[k].recording.name.clone(),
                gain: n.gain.0,
                held_out: n.gain.1,
            },
            None => Evidence::Gains {
                fitted: n.gain.0,
                held_out: state.held_out.as_ref().map(|_| n.gain.1),
            },
        }];
        evidence.extend(n.rejected_twin.clone());
        evidence.extend(second_mode_evidence(effect));
        if n.hypothesis.sequential_time {
            evidence.push(Evidence::SequentialTime);
        }
        out.push((
            n.gain.0,
            NamedEffect {
                id: n.spec.id.to_owned(),
                name: n.spec.name.to_owned(),
                probability: probability(n.gain.0 + n.gain.1, n.alike.len()),
                size: effect_size::of(effect, model, &after.train),
                parameters: parameters.collect(),
                alike: n.alike.iter().map(|a| (*a).to_owned()).collect(),
                evidence,
            },
        ));
    }
    Ok(out)
}

/// A named contact law.
fn contact_law(test: &LawTest, after: &SplitSamples, full: &Model) -> NamedEffect {
    let parameters = test.effect.spec.parameters.iter().zip(&test.effect.values);
    let parameters = parameters
        .zip(&test.errors)
        .map(|((p, value), error)| Estimate {
            id: p.id.to_owned(),
            value: *value,
            std_error: error.hypot(systematic_error(test.effect.spec, p, *value)),
            unit: p.unit,
        });
    NamedEffect {
        id: test.id.to_owned(),
        name: test.effect.spec.name.to_owned(),
        probability: probability(test.gain + test.held_gain, 0),
        size: effect_size::of(&test.effect, full, &after.train),
        parameters: parameters.collect(),
        alike: Vec::new(),
        evidence: vec![
            test.evidence.clone(),
            Evidence::EventGains {
                fitted: test.gain,
                held_out: test.held_gain,
                cross_validated: test.evidence.is_cross_validated(),
            },
        ],
    }
}

/// Probability of a name whose chi2 fell by `worth` on both sides, shared with `alike` effects that
/// cannot be distinguished from it: the odds against chance, times the precision of names in sealed
/// trials.
pub(crate) fn probability(worth: f64, alike: usize) -> f64 {
    let odds = (0.5 * worth - PRIOR_LOG_ODDS).clamp(-700.0, 700.0);
    CALIBRATED_PRECISION / (1.0 + (-odds).exp()) / (1 + alike) as f64
}
