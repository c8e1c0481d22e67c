//! A fit with one more effect, judged against the one without on both sides.

use crate::diagnose::comparison::hypothesis::Hypothesis;
use crate::diagnose::comparison::trial::{CandidateFit, ModelState};
use crate::diagnose::data::side::Split;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, simulated};
use crate::diagnose::shooting::coarse_fit::SubsetFit;
use crate::diagnose::shooting::fitted::{Bound, Fitted};
use crate::diagnose::shooting::local_fit::mode_count;
use crate::diagnose::shooting::workspace::Workspace;
use crate::model::{Model, with_effect};

/// Steps of a fit at most.
pub(crate) const MAX_FIT_STEPS: usize = 12;

/// A fit with one more effect against that of `stand`.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn evaluate_held_out(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: &Hypothesis,
    train: Fitted,
    control: &DiagnoseControl<'_>,
) -> Result<CandidateFit, DiagnoseError> {
    let held_out =
        workspace.fit_held_out(&train.model, (&train, stand.held_out.as_ref()), control)?;
    let mut gain = stand.train.cost - train.cost;
    let mut held_gain = match (&stand.held_out, &held_out) {
        (Some(before), Some(after)) => before.cost - after.cost,
        _ => 0.0,
    };
    // What begins after the fitted recordings is told by one that was kept out, which proves
    // nothing then.
    if let (Some(k), Some(before), Some(after)) =
        (hypothesis.estimated_on_held_out, &stand.held_out, &held_out)
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

/// A fit with one more effect against that of `stand`, from which it did not begin.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn evaluate_from_scratch(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: Hypothesis,
    train: Fitted,
    control: &DiagnoseControl<'_>,
) -> Result<CandidateFit, DiagnoseError> {
    let held_out = workspace.fit_held_out(&train.model, (&train, None), control)?;
    let (gain, held_gain) = gains_on_all_segments(workspace, stand, &train, held_out.as_ref())?;
    Ok(CandidateFit {
        gain,
        held_gain,
        train,
        held_out,
        hypothesis,
    })
}

/// Falls of chi2 against the fit of `stand` on either side, all stretches counted, whatever
/// either sets aside.
fn gains_on_all_segments(
    workspace: &Workspace,
    stand: &ModelState,
    train: &Fitted,
    held_out: Option<&Fitted>,
) -> Result<(f64, f64), DiagnoseError> {
    let gain = |side: &Split, before: &Fitted, after: &Fitted| {
        let first = side.segments();
        Ok::<f64, DiagnoseError>(
            before.cost_with_set_aside(first)? - after.cost_with_set_aside(first)?,
        )
    };
    let held_gain = match (&workspace.held_out, &stand.held_out, held_out) {
        (Some(side), Some(before), Some(after)) => gain(side, before, after)?,
        _ => 0.0,
    };
    Ok((gain(&workspace.train, &stand.train, train)?, held_gain))
}

/// The fit with what the re-tuning has found without which the baseline is lost; `None` for other
/// hypotheses and elsewhere.
pub(crate) fn fit_of_required_effect(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let known = workspace
        .required_effect
        .as_ref()
        .filter(|_| stand.named.is_empty());
    let Some(known) = known.filter(|k| k.start.spec == hypothesis.start.spec) else {
        return Ok(None);
    };
    let own = Hypothesis {
        start: known.start.clone(),
        free: known.free.clone(),
        bounds: known.bounds.clone(),
        cold_start: None,
        shape: known.shape.clone(),
        ..hypothesis.clone()
    };
    evaluate_from_scratch(workspace, stand, own, known.fitted.clone(), control).map(Some)
}

/// `model` with the effect of a hypothesis that it has already, but for what is not fitted.
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

/// The hypotheses that look like `hypothesis`.
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

/// A fit with that of a hypothesis and those which look like it that suits a part of the fitted
/// recordings best, begun from the fit `near`, in so many `steps` at most: of a further mode, whose
/// fits take long. `None` if it cannot be simulated.
pub fn best_start_on_subset(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: &Hypothesis,
    (near, steps): (&Fitted, usize),
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let mut best: Option<(SubsetFit, Hypothesis)> = None;
    for own in std::iter::once(hypothesis.clone()).chain(alternative_hypotheses(hypothesis)) {
        let (free, bounds) = parameters_with(stand, &own);
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
    let judged = train.map(|train| evaluate_held_out(workspace, stand, &own, train, control));
    judged.transpose()
}

/// What is fitted with one more effect, and its bounds.
pub fn parameters_with(stand: &ModelState, hypothesis: &Hypothesis) -> (Vec<String>, Vec<Bound>) {
    let (mut free, mut bounds) = selected_parameters(stand);
    free.extend_from_slice(&hypothesis.free);
    bounds.extend_from_slice(&hypothesis.bounds);
    (free, bounds)
}

/// A fit with one more effect from the fit of `stand`; `None` if it cannot be simulated.
pub(crate) fn fit_warm_start(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let start = with_effect(&stand.train.model, hypothesis.start.clone());
    fit_from(
        workspace,
        stand,
        hypothesis,
        (&start, &stand.train),
        control,
    )
}

/// A fit with one more effect that begins with a model and the states of another fit; `None`
/// if it cannot be simulated.
pub fn fit_from(
    workspace: &Workspace,
    stand: &ModelState,
    hypothesis: &Hypothesis,
    (start, near): (&Model, &Fitted),
    control: &DiagnoseControl<'_>,
) -> Result<Option<CandidateFit>, DiagnoseError> {
    let (free, bounds) = parameters_with(stand, hypothesis);
    let train = simulated(workspace.fit(start, &free, &bounds, near, MAX_FIT_STEPS, control))?;
    let judged = train.map(|train| evaluate_held_out(workspace, stand, hypothesis, train, control));
    judged.transpose()
}

/// `start` with what the effects named in `stand` leave free, fitted from the fit of `near` and
/// judged; `None` if it cannot be simulated, or a part of the stretches shows that it is lost
/// without a mode that `near` has.
///
/// # Errors
/// [`DiagnoseError`] if the recordings cannot be used.
pub fn refit(
    workspace: &Workspace,
    start: &Model,
    stand: &ModelState,
    near: &ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<Option<(Fitted, Option<Fitted>)>, DiagnoseError> {
    let (free, bounds) = selected_parameters(stand);
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

/// A fit with the first effect from where the re-tuning began, for `stand` has been drawn
/// along by what it lacks; `None` if it cannot be simulated.
pub(crate) fn fit_cold_start(
    workspace: &Workspace,
    stand: &ModelState,
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
    evaluate_from_scratch(workspace, stand, hypothesis, train, control).map(Some)
}

/// Freedoms and bounds of the effects named so far.
pub(crate) fn selected_parameters(stand: &ModelState) -> (Vec<String>, Vec<Bound>) {
    let all = stand.named.iter().map(|n| &n.hypothesis);
    (
        all.clone().flat_map(|h| h.free.clone()).collect(),
        all.flat_map(|h| h.bounds.clone()).collect(),
    )
}
