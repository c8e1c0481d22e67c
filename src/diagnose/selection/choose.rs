//! The best of the evaluated hypotheses, and those that cannot be distinguished from it.

use super::law_shape::{as_lag_twin, with_shape_parameters};
use crate::diagnose::comparison::trial::{CandidateFit, CandidateScore, ModelState};
use crate::diagnose::findings::Evidence;
use crate::diagnose::hypotheses::lag_twins;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    INDISTINGUISHABLE_GAIN, INDISTINGUISHABLE_SHARE, TWIN_INDISTINGUISHABLE_SHARE, TWIN_MIN_SHARE,
};
use crate::model::effects::{EffectSpec, find};

/// The best hypothesis of a round.
pub struct Choice {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// The fit with it.
    pub trial: CandidateFit,
    /// Ids of effects that fit equally well.
    pub alike: Vec<&'static str>,
    /// Why an effect that fits equally well in flight is not among those.
    pub rejected_twin: Option<Evidence>,
}

/// Adds to `scores` the lag twin of the best effect, started from its fit, if it is a candidate
/// and scored far less: the linearised problem predicts little of a lag that the clocks have
/// absorbed.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn add_twin(
    workspace: &Workspace,
    state: &ModelState,
    scores: &mut Vec<CandidateScore>,
    is_asked: &dyn Fn(&EffectSpec) -> bool,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    let worth = |w: &CandidateScore| {
        w.fit
            .as_ref()
            .map_or(f64::NEG_INFINITY, CandidateFit::worth)
    };
    let best = scores
        .iter()
        .max_by(|a, b| worth(a).total_cmp(&worth(b)))
        .and_then(|w| w.fit.as_ref().map(|t| (w.spec, t)));
    let Some((first, trial)) = best.filter(|(_, t)| !t.is_insignificant()) else {
        return Ok(());
    };
    let spec = lag_twins::twin(first.id)
        .and_then(find)
        .filter(|s| is_asked(s));
    let Some(spec) = spec.filter(|_| !control.cancelled()) else {
        return Ok(());
    };
    let known = scores.iter().position(|w| w.spec == spec);
    let least = known.map_or(f64::NEG_INFINITY, |k| worth(&scores[k]));
    if least > TWIN_MIN_SHARE * trial.worth() {
        return Ok(());
    }
    let Some(twin) = as_lag_twin(workspace, state, trial, spec, control)? else {
        return Ok(());
    };
    log::debug!("{} as {}: {:.0}", first.id, spec.id, twin.worth());
    if twin.worth() > least {
        let own = CandidateScore {
            spec,
            predicted_gain: known.map_or(0.0, |k| scores[k].predicted_gain),
            fit: Some(twin),
            self_ringing_frequency: None,
        };
        match known {
            Some(k) => scores[k] = own,
            None => scores.push(own),
        }
    }
    Ok(())
}

/// The best of `scores`. If one of the two lag twins is the best, both are given their shape
/// parameters and compared around impacts. `None` if nothing could be fitted.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn choose_best(
    workspace: &Workspace,
    state: &ModelState,
    scores: &mut [CandidateScore],
    control: &DiagnoseControl<'_>,
) -> Result<Option<Choice>, DiagnoseError> {
    let all = scores.iter_mut();
    let all = all.filter_map(|w| w.fit.as_mut().map(|t| (w.spec, t)));
    let mut trials: Vec<(&'static EffectSpec, &mut CandidateFit)> = all.collect();
    trials.sort_by(|a, b| b.1.worth().total_cmp(&a.1.worth()));
    let Some(first) = trials.first() else {
        return Ok(None);
    };
    // In flight the twin may even fit better where the law has a slightly different form.
    let twin = trials.iter().position(|(spec, t)| {
        lag_twins::are_lag_twins(first.0.id, spec.id)
            && t.worth() > TWIN_MIN_SHARE * first.1.worth()
            && !first.1.excels(t)
    });
    let mut rejected_twin = None;
    let mut best = 0;
    if let Some(twin) = twin {
        // A wrong form of the law would leave residuals around bounces that have nothing
        // to do with the two.
        for k in [0, twin] {
            *trials[k].1 = with_shape_parameters(workspace, state, trials[k].1.clone(), control)?;
        }
        let (a, b) = (trials[0].1.worth(), trials[twin].1.worth());
        log::debug!("{} {a:.0}, {} {b:.0}", trials[0].0.id, trials[twin].0.id);
        let mut lower = b - a;
        if a.min(b) > TWIN_MIN_SHARE * a.max(b) {
            let fits = |k: usize| (&trials[k].1.train, trials[k].1.held_out.as_ref());
            let around = lag_twins::compare_around_impacts(workspace, fits(0), fits(twin))?;
            if around.sure {
                let other = if around.fall > 0.0 { 0 } else { twin };
                rejected_twin = Some((trials[other].0, around.fall.abs()));
                lower = around.fall;
            } else {
                // Undecided twins are reported together, the likelier first.
                lower += around.fall;
            }
        }
        if lower > 0.0 {
            best = twin;
        }
    }
    let most = trials.iter().map(|(_, t)| t.worth());
    let most = most.fold(f64::NEG_INFINITY, f64::max);
    let first = &trials[best];
    let least = most - (INDISTINGUISHABLE_SHARE * most).max(INDISTINGUISHABLE_GAIN);
    let other =
        |spec: &EffectSpec| *spec != *first.0 && rejected_twin.is_none_or(|t| *spec != *t.0);
    let others = trials.iter().filter(|(spec, t)| {
        let twin = lag_twins::are_lag_twins(first.0.id, spec.id);
        let close =
            t.worth() > least || twin && t.worth() > (1.0 - TWIN_INDISTINGUISHABLE_SHARE) * most;
        other(spec) && close && !first.1.excels(t)
    });
    let alike = others.map(|(spec, _)| spec.id).collect();
    let rejected_twin = rejected_twin.map(|(other, fall)| Evidence::RejectedTwin {
        twin: other.name,
        chosen: first.0.name,
        fall,
    });
    Ok(Some(Choice {
        spec: first.0,
        trial: first.1.clone(),
        alike,
        rejected_twin,
    }))
}
