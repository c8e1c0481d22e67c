//! Forward selection of effects: hypotheses proposed by the score test are refitted, tested on the
//! held-out recordings, and added one by one while both splits improve significantly.

use super::evaluate::{evaluate_hypotheses, is_candidate};
use super::law_shape::{drop_second_time_constant, with_shape_parameters};
use super::stopping::is_form_error;
use super::{choose, prune, self_ringing};
use crate::diagnose::comparison::significance;
use crate::diagnose::comparison::trial::{
    CandidateFit, ModelState, SelectedEffect, SelectionResult,
};
use crate::diagnose::data::side::Split;
use crate::diagnose::hypotheses::propose::propose;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::score_test::reading_scales::{self, gain_by_own_scales};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    FURTHER_MIN_SHARE, HELD_GAIN, HELD_OUT_ODD_RATIO, MISLED_MIN_CHI2_RATIO, OWN_SCALES_MIN_GAIN,
    RECOVERED_MIN_SHARE, REVIEW_MIN_CHI2_RATIO, SET_ASIDE_REVIEW_SHARE,
};
use crate::model::effects::EffectSpec;

/// Searches for what `baseline` lacks, first with the segments set aside as misread if they are
/// many: an effect that spoils only some segments hides in them.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn select_effects(
    workspace: &Workspace,
    baseline: ModelState,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<SelectionResult, DiagnoseError> {
    let aside = baseline.train.set_aside_share();
    log::debug!("{:.1} % of the rows are set aside", 100.0 * aside);
    // What spoils held-out recordings may have been set aside in the fitted ones.
    let odd = baseline.held_out.as_ref().is_some_and(|held| {
        held.per_value() > HELD_OUT_ODD_RATIO
            && held.per_value() > HELD_OUT_ODD_RATIO * baseline.train.per_value()
    });
    let look = aside > SET_ASIDE_REVIEW_SHARE || (aside > 0.0 && odd);
    // Where the baseline is lost in the other segments too, these show what it lacks.
    if look
        && !control.cancelled()
        && !baseline.train.is_lost()
        && options.by_hand.is_none()
        && let Some(found) = select_with_set_aside(workspace, &baseline, options, control, report)?
    {
        return Ok(found);
    }
    let from = SelectionResult {
        state: baseline.clone(),
        baseline,
        scores: Vec::new(),
        scales_differ: false,
    };
    search_forward(workspace, from, options, control, report)
}

/// Searches for an effect that describes most of the segments set aside as misread, and for others
/// together with it; `None` if there is none.
fn select_with_set_aside(
    workspace: &Workspace,
    baseline: &ModelState,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<Option<SelectionResult>, DiagnoseError> {
    let all = |side: &Split, fitted: &Fitted| workspace.with_all_segments(side, fitted);
    let held_out = workspace.held_out.as_ref().zip(baseline.held_out.as_ref());
    let whole = ModelState {
        train: all(&workspace.train, &baseline.train)?,
        held_out: held_out
            .map(|(side, fitted)| all(side, fitted))
            .transpose()?,
        named: Vec::new(),
        misread: true,
    };
    let once = DiagnoseOptions {
        most: options.most.min(1),
        ..options.clone()
    };
    let from = SelectionResult {
        baseline: baseline.clone(),
        state: whole,
        scores: Vec::new(),
        scales_differ: false,
    };
    let mut found = search_forward(workspace, from, &once, control, report)?;
    if found.state.named.is_empty() {
        return Ok(None);
    }
    let state = &mut found.state;
    let in_sequence = state.named.iter().any(|n| n.hypothesis.sequential_time);
    let workspace = if in_sequence {
        workspace.as_sequence()
    } else {
        workspace.clone()
    };
    recheck_misread(&workspace, state, control)?;
    state.misread = false;
    let left = state.train.set_aside_share();
    log::debug!("{:.1} % of the rows are set aside after that", 100.0 * left);
    // An effect that also acts in the other segments may have been misled by them.
    let before = baseline.train.per_value().max(1.0);
    let astray = state.train.per_value() > MISLED_MIN_CHI2_RATIO * before;
    if astray || left > (1.0 - RECOVERED_MIN_SHARE) * baseline.train.set_aside_share() {
        return Ok(None);
    }
    search_forward(&workspace, found, options, control, report).map(Some)
}

/// Sets aside what is misread for the model of `state`.
fn recheck_misread(
    workspace: &Workspace,
    state: &mut ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    state.train =
        workspace.without_misread(&workspace.train, state.train.clone(), false, control)?;
    if let (Some(side), Some(held_out)) = (&workspace.held_out, state.held_out.take()) {
        let near = (&state.train, Some(&held_out));
        let fitted = workspace.fit_held_out(&state.train.model, near, control)?;
        state.held_out = fitted
            .map(|fitted| workspace.without_misread(side, fitted, true, control))
            .transpose()?;
    }
    Ok(())
}

/// Searches for what the state of `from` still lacks.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
fn search_forward(
    workspace: &Workspace,
    from: SelectionResult,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<SelectionResult, DiagnoseError> {
    let SelectionResult {
        mut baseline,
        mut state,
        mut scores,
        mut scales_differ,
    } = from;
    let plain = workspace;
    let mut workspace = plain.clone();
    let rounds = options.by_hand.as_ref().map_or(options.most, Vec::len);
    for round in state.named.len()..rounds {
        if control.cancelled() {
            break;
        }
        let about = |detail: &str, share: f64| {
            report(detail, (round as f64 + share) / rounds as f64);
        };
        let only = options.by_hand.as_ref().map(|ids| ids[round].as_str());
        // No effect could bring enough to be named.
        let little = state.most_left() < FURTHER_MIN_SHARE * state.explained();
        if only.is_none() {
            scales_differ = !little && do_scales_differ(&workspace, &state, options)?;
            if little || scales_differ {
                break;
            }
        }
        let mut round_scores =
            evaluate_hypotheses(&workspace, &state, options, only, control, &about)?;
        let is_asked = |spec: &EffectSpec| is_candidate(&state, options, only, spec);
        choose::add_twin(&workspace, &state, &mut round_scores, &is_asked, control)?;
        let best = choose::choose_best(&workspace, &state, &mut round_scores, control)?;
        let vibration = self_ringing::significant_vibration(&round_scores);
        if scores.is_empty() {
            scores = round_scores;
        }
        let Some(mut best) = best else {
            // With effects chosen by hand, the next one may still help.
            if only.is_some() {
                continue;
            }
            break;
        };
        let mut trial = with_shape_parameters(&workspace, &state, best.trial, control)?;
        if only.is_none() && is_rejected(&workspace, &state, &trial)? {
            break;
        }
        if only.is_none()
            && let Some(f) = self_ringing::is_self_excited(&workspace, &state, &trial, control)?
        {
            if let Some(vibration) = vibration.filter(|v| self_ringing::explains_as_well(v, &trial))
            {
                (best.spec, trial) = (vibration.hypothesis.start.spec, vibration);
                best.alike.clear();
            } else {
                let mut own = scores.iter_mut();
                if let Some(own) = own.find(|w| w.spec == best.spec)
                    && !trial.within_initial_state_dof(&state)
                {
                    own.self_ringing_frequency = Some(f);
                }
                break;
            }
        }
        if trial.hypothesis.sequential_time {
            workspace = workspace.as_sequence();
        }
        let effect = SelectedEffect {
            spec: best.spec,
            hypothesis: trial.hypothesis,
            gain: (trial.gain, trial.held_gain),
            alike: best.alike,
            rejected_twin: best.rejected_twin,
        };
        let fits = (trial.train, trial.held_out);
        add_effect(&workspace, &mut state, effect, fits, control)?;
        if only.is_none() {
            prune::backward_eliminate(&workspace, &mut state, control)?;
            if state.named.is_empty() {
                // An effect that turned out superfluous has improved the
                // re-tuning: all hypotheses are evaluated again.
                baseline = state.clone();
                workspace.clone_from(plain);
                scores.clear();
            }
            drop_second_time_constant(&workspace, &mut state, control)?;
        }
    }
    Ok(SelectionResult {
        baseline,
        state,
        scores,
        scales_differ,
    })
}

/// Whether a scale of its own for each reading of each recording would explain more of what `state`
/// lacks than any effect.
fn do_scales_differ(
    workspace: &Workspace,
    state: &ModelState,
    options: &DiagnoseOptions,
) -> Result<bool, DiagnoseError> {
    if state.misread || !reading_scales::are_equal(&state.train.problem) {
        return Ok(false);
    }
    let own = gain_by_own_scales(&state.train, 0)?;
    let held_out = state.held_out.as_ref();
    let locked = |held: &Fitted| gain_by_own_scales(held, held.problem.space.len());
    let held_out = held_out.map(locked).transpose()?;
    log::debug!("scales of their own predict {own:.1}, held-out {held_out:?}");
    let least = OWN_SCALES_MIN_GAIN.max(FURTHER_MIN_SHARE * state.explained());
    if own < least || held_out.is_some_and(|held| held < HELD_GAIN) {
        return Ok(false);
    }
    let asked = |spec: &EffectSpec| is_candidate(state, options, None, spec);
    let known = workspace.cold_fits().filter(|k| asked(k.start.spec));
    let known = known.map(|k| state.train.cost - k.fitted.cost);
    if state.named.is_empty() && known.into_iter().any(|gain| gain > own) {
        return Ok(false);
    }
    let others = propose(workspace, state, &asked)?;
    Ok(others.iter().all(|h| h.predicted_gain < own))
}

/// Whether `trial` must not be named: its gain is insignificant, not confirmed by the held-out
/// recordings, small against what the effects named so far explain, or within the error of
/// their laws' form.
fn is_rejected(
    workspace: &Workspace,
    state: &ModelState,
    trial: &CandidateFit,
) -> Result<bool, DiagnoseError> {
    let held = workspace.held_out.is_none() || trial.held_gain > HELD_GAIN;
    let little = trial.worth() < FURTHER_MIN_SHARE * state.explained();
    let insignificant = trial.is_insignificant()
        || !held
        || little
        || significance::is_at_lower_bound(&trial.hypothesis, &trial.train.model);
    Ok(insignificant || is_form_error(state, trial)?)
}

/// Adds an effect with the fits to both splits, and looks for misread segments anew where the
/// fits became clearer: what was misread did not stand out while everything was far off.
fn add_effect(
    workspace: &Workspace,
    state: &mut ModelState,
    effect: SelectedEffect,
    (train, held_out): (Fitted, Option<Fitted>),
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    state.named.push(effect);
    let clears = |(before, after): (&Fitted, &Fitted)| {
        before.per_value() > REVIEW_MIN_CHI2_RATIO * after.per_value()
    };
    let both = state.held_out.as_ref().zip(held_out.as_ref());
    let clearer = clears((&state.train, &train)) || both.is_some_and(clears);
    state.train = train;
    state.held_out = held_out;
    if (clearer || state.train.set_aside_share() > SET_ASIDE_REVIEW_SHARE) && !state.misread {
        recheck_misread(workspace, state, control)?;
    }
    Ok(())
}
