//! Evaluation of hypotheses: those with the largest predicted gains are refitted, from the current
//! fit or, where that has lost track, from a cold start, and tested on the held-out recordings.

use super::refit::{
    MAX_FIT_STEPS, alternative_hypotheses, best_start_on_subset, cold_hypothesis,
    evaluate_from_scratch, fit_cold_start, fit_from, fit_warm_start, selected_parameters,
    with_fixed_constants,
};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::{CandidateFit, CandidateScore, ModelState};
use crate::diagnose::hypotheses::level_step_time;
use crate::diagnose::hypotheses::propose::propose;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{MIN_SHARE_OF_BEST, REFIT_MIN_SCORE, SEARCHED_REFIT_MIN_SCORE};
use crate::model::Model;
use crate::model::effects::EffectSpec;

/// Most hypotheses refitted in a round.
const MAX_REFITS: usize = 4;

/// Evaluates all hypotheses on what `state` lacks, or `only` one effect whatever its predicted
/// gain.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn evaluate_hypotheses(
    workspace: &Workspace,
    state: &ModelState,
    options: &DiagnoseOptions,
    only: Option<&str>,
    control: &DiagnoseControl<'_>,
    about: &dyn Fn(&str, f64),
) -> Result<Vec<CandidateScore>, DiagnoseError> {
    about("scan of the catalogue", 0.0);
    let asked = |spec: &EffectSpec| is_candidate(state, options, only, spec);
    let hypotheses = hypotheses(workspace, state, &asked, control)?;
    let mut out: Vec<CandidateScore> = Vec::new();
    let mut best = 0.0f64;
    let mut cold_start_tried = false;
    let count = hypotheses.len().clamp(1, MAX_REFITS);
    for (hypothesis, cold_fit) in hypotheses {
        let same = |w: &CandidateScore| w.spec == hypothesis.start.spec;
        let known = out.iter().position(same);
        let k = known.unwrap_or(out.len());
        // A predicted gain far below what a refit has reached makes a refit pointless:
        // predictions are accurate where the baseline is near the data.
        let least = if hypothesis.look_elsewhere {
            SEARCHED_REFIT_MIN_SCORE
        } else {
            REFIT_MIN_SCORE
        };
        let worth = hypothesis.predicted_gain > least
            && hypothesis.predicted_gain > MIN_SHARE_OF_BEST * best;
        let worth = worth || only.is_some() || cold_fit.is_some();
        let mut trial = None;
        if k < MAX_REFITS && worth && !control.cancelled() {
            about(
                hypothesis.start.spec.name,
                (k + 1) as f64 / (count + 1) as f64,
            );
            // A cold start takes as long as the re-tuning did. It is tried only for
            // the effect in flight with the largest predicted gain, where the fit has
            // gone astray.
            let is_in_flight = !hypothesis.start.spec.is_level_step();
            let cold_start = !cold_start_tried && state.named.is_empty() && is_in_flight;
            cold_start_tried |= cold_start;
            trial = match cold_fit {
                Some(fit) => {
                    let own = hypothesis.clone();
                    Some(evaluate_from_scratch(workspace, state, own, fit, control)?)
                }
                None => refit_hypothesis(workspace, state, &hypothesis, cold_start, control)?,
            };
            best = trial.as_ref().map_or(best, |t| best.max(t.gain));
        }
        let own = CandidateScore {
            spec: hypothesis.start.spec,
            predicted_gain: hypothesis.predicted_gain,
            fit: trial,
            self_ringing_frequency: None,
        };
        let worth = |w: &CandidateScore| {
            w.fit
                .as_ref()
                .map_or(f64::NEG_INFINITY, CandidateFit::worth)
        };
        match known {
            Some(known) if worth(&out[known]) >= worth(&own) => {}
            Some(known) => out[known] = own,
            None => out.push(own),
        }
    }
    Ok(out)
}

/// The hypotheses on what `state` lacks, the most promising first: those that were fitted from a cold
/// start, with their fits, and the scan of the catalogue unless the fit has gone astray for lack of
/// those.
fn hypotheses(
    workspace: &Workspace,
    state: &ModelState,
    asked: &dyn Fn(&EffectSpec) -> bool,
    control: &DiagnoseControl<'_>,
) -> Result<Vec<(Hypothesis, Option<Fitted>)>, DiagnoseError> {
    let astray = state.train.is_lost() && !state.misread;
    let cold = if state.named.is_empty() {
        let all = workspace.cold_fits().filter(|k| asked(k.start.spec));
        all.cloned().collect()
    } else if astray {
        let (free, bounds) = selected_parameters(state);
        workspace.guided_fits(&state.train.model, (&free, &bounds), asked, control)?
    } else {
        Vec::new()
    };
    // What is linearised far from the recordings says nothing.
    let mut scanned = if astray && !cold.is_empty() {
        Vec::new()
    } else {
        propose(workspace, state, asked)?
    };
    scanned.sort_by(|a, b| b.predicted_gain.total_cmp(&a.predicted_gain));
    for h in &scanned {
        let start = &h.start;
        log::debug!(
            "{} predicts {:.1} at {:?}",
            start.spec.id,
            h.predicted_gain,
            start.values
        );
    }
    let mut out = Vec::new();
    for known in cold {
        let own = scanned.iter().filter(|h| h.start.spec == known.start.spec);
        let mut hypothesis = cold_hypothesis(&known);
        hypothesis.predicted_gain = own.fold(hypothesis.predicted_gain, |most, h| {
            most.max(h.predicted_gain)
        });
        out.push((hypothesis, Some(known.fitted)));
        scanned.retain(|h| h.start.spec != known.start.spec);
    }
    out.extend(scanned.into_iter().map(|h| (h, None)));
    Ok(out)
}

/// Whether an effect is a candidate that the model does not have yet, or the `only` one, and not named
/// yet.
pub fn is_candidate(
    state: &ModelState,
    options: &DiagnoseOptions,
    only: Option<&str>,
    spec: &EffectSpec,
) -> bool {
    let wanted = match only {
        Some(only) => only == spec.id,
        None => options.has_candidate(spec.id) && !has(&state.train.model, spec),
    };
    wanted && state.named.iter().all(|n| n.spec != spec)
}

/// Whether a model has an effect.
fn has(model: &Model, spec: &EffectSpec) -> bool {
    model.effects.iter().any(|active| active.spec == spec)
}

/// A fit with one more effect, or `None` if it cannot be simulated; with `cold_start` also from a
/// cold start if the current fit has lost track.
fn refit_hypothesis(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: &Hypothesis,
    cold_start: bool,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    // A further mode starts from the residuals of a fit.
    let further = hypothesis.start.spec.adds_modes();
    let astray = cold_start && !state.misread && !further && state.train.is_lost();
    if astray
        && hypothesis.cold_start.is_some()
        && let Some(trial) = fit_cold_start(workspace, state, hypothesis, control)?
        && trial.worth() > 0.0
    {
        return Ok(Some(trial));
    }
    let series = hypothesis.sequential_time.then(|| workspace.as_sequence());
    let nearby = series.as_ref().unwrap_or(workspace);
    let near = if further {
        best_start_on_subset(
            nearby,
            state,
            hypothesis,
            (&state.train, MAX_FIT_STEPS),
            control,
        )?
    } else {
        fit_warm_start(nearby, state, hypothesis, control)?
    };
    let Some(mut near) = near else {
        return Ok(None);
    };
    let better = |near: CandidateFit, other: &Hypothesis| {
        // The fitted recordings hardly distinguish them: the fit of one is nearly that of
        // the other.
        let start = with_fixed_constants(&near.train.model, other);
        let tried = fit_from(nearby, state, other, (&start, &near.train), control)?;
        let tried = tried.filter(|tried| tried.worth() > near.worth());
        Ok::<CandidateFit, DiagnoseError>(tried.unwrap_or(near))
    };
    for other in alternative_hypotheses(hypothesis).filter(|_| !further) {
        if control.cancelled() {
            break;
        }
        near = better(near, &other)?;
    }
    if hypothesis.start.spec.is_level_step()
        && hypothesis.estimated_on_held_out.is_none()
        && let Some(finer) = level_step_time::refine_step_time(&near)?
    {
        near = better(near, &finer)?;
    }
    if astray
        && !control.cancelled()
        && hypothesis.cold_start.is_none()
        && near.train.is_lost()
        && let Some(other) = fit_cold_start(workspace, state, hypothesis, control)?
    {
        log::debug!(
            "from a cold start {:.0} in place of {:.0}",
            other.worth(),
            near.worth()
        );
        if other.worth() > near.worth() {
            return Ok(Some(other));
        }
    }
    Ok(Some(near))
}
