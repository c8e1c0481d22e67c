//! Hypotheses weighed: each of those that promise most is fitted, from the fit there is or,
//! where that has lost its way, from where the re-tuning began, and judged on the recordings
//! kept out.

use super::refit::{
    MAX_FIT_STEPS, alternative_hypotheses, best_start_on_subset, fit_cold_start, fit_from,
    fit_of_required_effect, fit_warm_start, with_fixed_constants,
};
use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::{CandidateFit, CandidateScore, ModelState};
use crate::diagnose::hypotheses::level_step_time;
use crate::diagnose::hypotheses::propose::propose;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{MIN_SHARE_OF_BEST, REFIT_MIN_SCORE, SEARCHED_REFIT_MIN_SCORE};
use crate::model::effects::EffectSpec;

/// Most hypotheses refitted in a round.
const MAX_REFITS: usize = 4;
/// A ground that steps leaves the flight as it is.
const LEVEL_STEP_ID: &str = "gap_step";

/// Weighs all hypotheses that `stand` does not have yet, or `only` one effect whatever it
/// promises.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn evaluate_hypotheses(
    workspace: &Workspace,
    stand: &ModelState,
    options: &DiagnoseOptions,
    only: Option<&str>,
    control: &DiagnoseControl<'_>,
    about: &dyn Fn(&str, f64),
) -> Result<Vec<CandidateScore>, DiagnoseError> {
    about("scan of the catalogue", 0.0);
    let asked = |spec: &EffectSpec| is_candidate(stand, options, only, spec);
    let mut hypotheses = propose(workspace, stand, &asked)?;
    hypotheses.sort_by(|a, b| b.predicted_gain.total_cmp(&a.predicted_gain));
    for h in &hypotheses {
        let start = &h.start;
        log::debug!(
            "{} promises {:.1} at {:?}",
            start.spec.id,
            h.predicted_gain,
            start.values
        );
    }
    let mut out: Vec<CandidateScore> = Vec::new();
    let mut best = 0.0f64;
    let mut afar_asked = false;
    // What the re-tuning has found comes first, whatever it promises where clocks have taken it.
    if let Some(known) = workspace
        .required_effect
        .as_ref()
        .filter(|_| stand.named.is_empty())
    {
        let is_known = |h: &Hypothesis| h.start.spec == known.start.spec;
        hypotheses.sort_by_key(|h| !is_known(h));
        hypotheses.dedup_by(|later, earlier| is_known(later) && is_known(earlier));
    }
    let count = hypotheses.len().clamp(1, MAX_REFITS);
    for hypothesis in hypotheses {
        let same = |w: &CandidateScore| w.spec == hypothesis.start.spec;
        let known = out.iter().position(same);
        let k = known.unwrap_or(out.len());
        // Where the promise is far below what a refit has reached, a refit is in vain:
        // promises are right where the baseline is near the data.
        let least = if hypothesis.look_elsewhere {
            SEARCHED_REFIT_MIN_SCORE
        } else {
            REFIT_MIN_SCORE
        };
        let worth = hypothesis.predicted_gain > least
            && hypothesis.predicted_gain > MIN_SHARE_OF_BEST * best;
        let worth = worth || only.is_some();
        let mut trial = None;
        if k < MAX_REFITS && worth && !control.cancelled() {
            about(
                hypothesis.start.spec.name,
                (k + 1) as f64 / (count + 1) as f64,
            );
            // From afar takes as long as the re-tuning did: only for what promises most of all
            // that acts in flight, where that has gone astray.
            let afar =
                !afar_asked && stand.named.is_empty() && hypothesis.start.spec.id != LEVEL_STEP_ID;
            afar_asked |= afar;
            trial = refit_hypothesis(workspace, stand, &hypothesis, afar, control)?;
            best = trial.as_ref().map_or(best, |t| best.max(t.gain));
        }
        let own = CandidateScore {
            spec: hypothesis.start.spec,
            promise: hypothesis.predicted_gain,
            trial,
            by_itself: None,
        };
        let worth = |w: &CandidateScore| {
            w.trial
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

/// Whether an effect is a candidate, or the `only` one, and not named yet.
pub fn is_candidate(
    stand: &ModelState,
    options: &DiagnoseOptions,
    only: Option<&str>,
    spec: &EffectSpec,
) -> bool {
    let wanted = match only {
        Some(only) => only == spec.id,
        None => options.has_candidate(spec.id),
    };
    wanted && stand.named.iter().all(|n| n.spec != spec)
}

/// A fit with one more effect, or `None` if it cannot be simulated; also from `afar` if the
/// fit there is has lost its way.
fn refit_hypothesis(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: &Hypothesis,
    afar: bool,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    if let Some(trial) = fit_of_required_effect(workspace, stand, hypothesis, control)? {
        return Ok(Some(trial));
    }
    // A further mode begins with what a fit has left to it.
    let further = hypothesis.start.spec.id == "extra_mode";
    let astray = afar && !stand.misread && !further && stand.train.is_lost();
    if astray
        && hypothesis.cold_start.is_some()
        && let Some(trial) = fit_cold_start(workspace, stand, hypothesis, control)?
        && trial.worth() > 0.0
    {
        return Ok(Some(trial));
    }
    let series = hypothesis.sequential_time.then(|| workspace.as_sequence());
    let nearby = series.as_ref().unwrap_or(workspace);
    let near = if further {
        best_start_on_subset(
            nearby,
            stand,
            hypothesis,
            (&stand.train, MAX_FIT_STEPS),
            control,
        )?
    } else {
        fit_warm_start(nearby, stand, hypothesis, control)?
    };
    let Some(mut near) = near else {
        return Ok(None);
    };
    let better = |near: CandidateFit, other: &Hypothesis| {
        // They look alike to the fitted recordings: the fit of the one is all but the other's.
        let start = with_fixed_constants(&near.train.model, other);
        let tried = fit_from(nearby, stand, other, (&start, &near.train), control)?;
        let tried = tried.filter(|tried| tried.worth() > near.worth());
        Ok::<CandidateFit, DiagnoseError>(tried.unwrap_or(near))
    };
    for other in alternative_hypotheses(hypothesis).filter(|_| !further) {
        near = better(near, &other)?;
    }
    if hypothesis.start.spec.id == LEVEL_STEP_ID
        && hypothesis.estimated_on_held_out.is_none()
        && let Some(finer) = level_step_time::refine_step_time(&near)?
    {
        near = better(near, &finer)?;
    }
    if astray
        && hypothesis.cold_start.is_none()
        && near.train.is_lost()
        && let Some(other) = fit_cold_start(workspace, stand, hypothesis, control)?
    {
        log::debug!(
            "from afar {:.0} in place of {:.0}",
            other.worth(),
            near.worth()
        );
        if other.worth() > near.worth() {
            return Ok(Some(other));
        }
    }
    Ok(Some(near))
}
