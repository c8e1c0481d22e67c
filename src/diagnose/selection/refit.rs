//! Fits with one more effect, compared with the fit without it on both splits.

use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::data::side::Split;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, simulated};
use crate::diagnose::shooting::coarse_fit::SubsetFit;
use crate::diagnose::shooting::fitted::{Bound, Fitted, RequiredEffect};
use crate::diagnose::shooting::local_fit::mode_count;
use crate::diagnose::shooting::workspace::Workspace;
use crate::model::{Model, with_effect};

/// Most iterations of a fit.
pub(crate) const MAX_FIT_STEPS: usize = 12;

/// The score of a fit with one more effect, `train`, relative to `state`, from which it was
/// started.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn evaluate_held_out(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: &Hypothesis,
    train: Fitted,
    control: &DiagnoseControl<'_>,
) -> Result<CandidateFit, DiagnoseError> {
    let held_out =
        workspace.fit_held_out(&train.model, (&train, state.held_out.as_ref()), control)?;
    let mut gain = state.train.cost - train.cost;
    let mut held_gain = match (&state.held_out, &held_out) {
        (Some(before), Some(after)) => before.cost - after.cost,
        _ => 0.0,
    };
    // An effect that begins after the fitted recordings is determined by one held-out
    // recording, which then does not confirm it.
    if let (Some(k), Some(before), Some(after)) =
        (hypothesis.estimated_on_held_out, &state.held_out, &held_out)
    {
        let falls = before
            .recording_costs()?
            .into_iter()
            .zip(after.recording_costs()?);
        let falls: Vec<f64> = falls.map(|(before, after)| before - after).collect();
        gain = falls[k];
        held_gain = falls.iter().sum::<f64>() - gain;
    }
    Ok(CandidateFit {
        gain,
        held_gain,
        train,
        held_out,
        hypothesis: hypothesis.clone(),
    })
}

/// The score of a fit with one more effect relative to `state`, from which it was not started.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn evaluate_from_scratch(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: Hypothesis,
    train: Fitted,
    control: &DiagnoseControl<'_>,
) -> Result<CandidateFit, DiagnoseError> {
    let held_out = workspace.fit_held_out(&train.model, (&train, None), control)?;
    let (gain, held_gain) = gains_on_all_segments(workspace, state, &train, held_out.as_ref())?;
    Ok(CandidateFit {
        gain,
        held_gain,
        train,
        held_out,
        hypothesis,
    })
}

/// Falls of chi2 relative to `state` on either split, all segments counted, whatever either sets
/// aside.
fn gains_on_all_segments(
    workspace: &Workspace,
    state: &ModelState,
    train: &Fitted,
    held_out: Option<&Fitted>,
) -> Result<(f64, f64), DiagnoseError> {
    let gain = |side: &Split, before: &Fitted, after: &Fitted| {
        let first = side.segments();
        Ok::<f64, DiagnoseError>(
            before.cost_with_set_aside(first)? - after.cost_with_set_aside(first)?,
        )
    };
    let held_gain = match (&workspace.held_out, &state.held_out, held_out) {
        (Some(side), Some(before), Some(after)) => gain(side, before, after)?,
        _ => 0.0,
    };
    Ok((gain(&workspace.train, &state.train, train)?, held_gain))
}

/// The hypothesis of an effect that was fitted from a cold start.
pub(crate) fn cold_hypothesis(known: &RequiredEffect) -> Hypothesis {
    Hypothesis {
        start: known.start.clone(),
        alternative_starts: Vec::new(),
        free: known.free.clone(),
        cold_start: None,
        shape: known.shape.clone(),
        bounds: known.bounds.clone(),
        predicted_gain: known.predicted_gain,
        look_elsewhere: false,
        sequential_time: false,
        estimated_on_held_out: None,
    }
}

/// `model`, which has the effect of a hypothesis already, with the values of the hypothesis for
/// all that is not fitted.
pub(crate) fn with_fixed_constants(model: &Model, hypothesis: &Hypothesis) -> Model {
    let mut with = model.clone();
    let own = &hypothesis.start;
    for effect in with.effects.iter_mut().filter(|e| e.spec == own.spec) {
        let all = own.spec.parameters.iter().zip(&own.values).enumerate();
        for (i, (parameter, value)) in all {
            let id = format!("{}.{}", own.spec.id, parameter.id);
            if !hypothesis.free.contains(&id) {
                effect.values[i] = *value;
            }
        }
    }
    with
}

/// The alternative starts of `hypothesis` as hypotheses.
pub(crate) fn alternative_hypotheses(
    hypothesis: &Hypothesis,
) -> impl Iterator<Item = Hypothesis> + '_ {
    hypothesis
        .alternative_starts
        .iter()
        .map(|(start, bounds)| Hypothesis {
            start: start.clone(),
            bounds: bounds.clone(),
            ..hypothesis.clone()
        })
}

/// The fit of a hypothesis or one of its alternatives, whichever fits a subset of the segments
/// best, started from the fit `near` with at most so many `steps`. Used for further modes, whose
/// fits are slow. `None` if it cannot be simulated.
pub fn best_start_on_subset(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: &Hypothesis,
    (near, steps): (&Fitted, usize),
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let mut best: Option<(SubsetFit, Hypothesis)> = None;
    for own in std::iter::once(hypothesis.clone()).chain(alternative_hypotheses(hypothesis)) {
        if best.is_some() && control.cancelled() {
            break;
        }
        let (free, bounds) = parameters_with(state, &own);
        let start = with_effect(&near.model, own.start.clone());
        let sketch = workspace.fit_subset(&start, &free, &bounds, near, control);
        let Some(sketch) = simulated(sketch)? else {
            continue;
        };
        log::debug!("{:.1} at {:?}", sketch.cost(), own.start.values);
        if best.as_ref().is_none_or(|b| sketch.cost() < b.0.cost()) {
            best = Some((sketch, own));
        }
    }
    let Some((sketch, own)) = best else {
        return Ok(None);
    };
    let train = simulated(workspace.fit_all_from(sketch, steps, control))?;
    let scored = train.map(|train| evaluate_held_out(workspace, state, &own, train, control));
    scored.transpose()
}

/// Free parameters and bounds with one more effect.
pub fn parameters_with(state: &ModelState, hypothesis: &Hypothesis) -> (Vec<String>, Vec<Bound>) {
    let (mut free, mut bounds) = selected_parameters(state);
    free.extend_from_slice(&hypothesis.free);
    bounds.extend_from_slice(&hypothesis.bounds);
    (free, bounds)
}

/// A fit with one more effect started from the fit of `state`; `None` if it cannot be simulated.
pub(crate) fn fit_warm_start(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let start = with_effect(&state.train.model, hypothesis.start.clone());
    fit_from(
        workspace,
        state,
        hypothesis,
        (&start, &state.train),
        control,
    )
}

/// A fit with one more effect started from a model and the initial states of another fit; `None`
/// if it cannot be simulated.
pub fn fit_from(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: &Hypothesis,
    (start, near): (&Model, &Fitted),
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let (free, bounds) = parameters_with(state, hypothesis);
    let train = simulated(workspace.fit(start, &free, &bounds, near, MAX_FIT_STEPS, control))?;
    let scored = train.map(|train| evaluate_held_out(workspace, state, hypothesis, train, control));
    scored.transpose()
}

/// `start` with the parameters of the effects named in `state` free, fitted from `near` on both
/// splits; `None` if it cannot be simulated, or if a subset of the segments shows that it is lost
/// without a mode that `near` has.
///
/// # Errors
/// [`DiagnoseError`] if the recordings cannot be used.
pub fn refit(
    workspace: &Workspace,
    start: &Model,
    state: &ModelState,
    near: &ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<Option<(Fitted, Option<Fitted>)>, DiagnoseError> {
    let (free, bounds) = selected_parameters(state);
    let train = if mode_count(start) == mode_count(&near.train.model) {
        workspace.fit(start, &free, &bounds, &near.train, MAX_FIT_STEPS, control)
    } else {
        let sketch = workspace.fit_subset(start, &free, &bounds, &near.train, control);
        if let Ok(sketch) = &sketch
            && sketch.is_lost_compared_to(&near.train)
        {
            return Ok(None);
        }
        sketch.and_then(|sketch| workspace.fit_all_from(sketch, MAX_FIT_STEPS, control))
    };
    let Some(train) = simulated(train)? else {
        return Ok(None);
    };
    let held_out =
        workspace.fit_held_out(&train.model, (&train, near.held_out.as_ref()), control)?;
    Ok(Some((train, held_out)))
}

/// A fit with the first effect from the model that the re-tuning started with, because the fit of
/// `state` has been drawn along by what it lacks; `None` if it cannot be simulated.
pub(crate) fn fit_cold_start(
    workspace: &Workspace,
    state: &ModelState,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let mut hypothesis = hypothesis.clone();
    if let Some((start, free)) = hypothesis.cold_start.take() {
        hypothesis.start = start;
        hypothesis.free = free;
        hypothesis.bounds.clear();
    }
    let start = with_effect(&workspace.initial_model, hypothesis.start.clone());
    let train = workspace.fit_cold_start(&start, &hypothesis.free, &hypothesis.bounds, control);
    let Some(train) = simulated(train)? else {
        return Ok(None);
    };
    evaluate_from_scratch(workspace, state, hypothesis, train, control).map(Some)
}

/// Free parameters and bounds of the effects named so far.
pub(crate) fn selected_parameters(state: &ModelState) -> (Vec<String>, Vec<Bound>) {
    let all = state.named.iter().map(|n| &n.hypothesis);
    (
        all.clone().flat_map(|h| h.free.clone()).collect(),
        all.flat_map(|h| h.bounds.clone()).collect(),
    )
}
