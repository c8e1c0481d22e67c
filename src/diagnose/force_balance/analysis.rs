//! The force balance of recordings from beginning to end.

use super::measured_run::MeasuredRun;
use super::regression::{FittedEffect, Knowledge, Runs};
use super::selection::{Balance, BalanceChi2, is_significant, parameter_errors};
use super::structure::AccelerationModel;
use super::windows::{half_width, windows};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::score_test::forms::{CatalogueDirection, Scale, catalogue_directions};
use crate::diagnose::shooting::workspace::Workspace;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::problem::prepare::Prepared;
use crate::model::Model;
use crate::model::effects::ActiveEffect;

/// Time over which the motion is smoothed on either side, as a share of a test function's half width.
const SMOOTHING_SHARE: f64 = 0.25;

/// An effect that the force balance calls for.
#[derive(Debug, Clone, PartialEq)]
pub struct BalancedEffect {
    /// The effect with its parameters.
    pub effect: ActiveEffect,
    /// Indices of its fitted parameters.
    pub free: Vec<usize>,
    /// Standard errors of these.
    pub errors: Vec<f64>,
    /// Falls of chi2 that it brought, on fitted and held-out recordings.
    pub gain: (f64, f64),
}

/// What an effect would have brought in the first round.
#[derive(Debug, Clone, PartialEq)]
pub struct BalanceCandidate {
    /// Id of the effect.
    pub id: &'static str,
    /// Falls of chi2 on fitted and held-out recordings.
    pub gain: (f64, f64),
    /// Chi2 per equation of the held-out recordings with it.
    pub held_out_per_row: f64,
}

/// The result.
#[derive(Debug, Clone)]
pub struct ForceBalance {
    /// Chi2 of the baseline.
    pub before: BalanceChi2,
    /// Chi2 with the effects.
    pub after: BalanceChi2,
    /// The effects, in the order found.
    pub effects: Vec<BalancedEffect>,
    /// Every effect that was compared, by what it alone brings.
    pub candidates: Vec<BalanceCandidate>,
    /// What is known at the end.
    pub structure: AccelerationModel,
}

/// The force balance of recordings made ready, or `None` where the readings do not say where each
/// mode is, or where there is no flight to speak of.
///
/// # Errors
/// [`DiagnoseError`] if the model makes no sense.
pub fn analyse(
    workspace: &Workspace,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Option<ForceBalance>, DiagnoseError> {
    let model = &workspace.initial_model;
    let Some((balance, mut known)) = prepare(workspace, model)? else {
        return Ok(None);
    };
    let mut solved = balance.settle(&mut known)?;
    let before = solved.chi2();
    log::debug!(
        "force balance: {:.3} per row of {} fitted, {:.3} of {} held out",
        before.train_per_row(),
        before.train_freedom,
        before.held_out_per_row(),
        before.held_out_freedom
    );
    let forms = asked_forms(workspace, model, options);
    let mut effects: Vec<BalancedEffect> = Vec::new();
    let mut candidates: Vec<BalanceCandidate> = Vec::new();
    let has_held_out = !balance.held_out.runs.is_empty();
    for round in 0..options.most {
        if control.cancelled() {
            break;
        }
        let free: Vec<CatalogueDirection> = forms
            .iter()
            .filter(|f| known.effects.iter().all(|e| e.effect.spec != f.spec))
            .cloned()
            .collect();
        let gains = balance.gains(&known, &free)?;
        if round == 0 {
            for gain in &gains {
                let id = free[gain.form].spec.id;
                if candidates.iter().all(|c| c.id != id) {
                    candidates.push(BalanceCandidate {
                        id,
                        gain: gain.gain,
                        held_out_per_row: gain.held_out_per_row,
                    });
                }
            }
        }
        let now = solved.chi2();
        let Some(best) = gains.first() else {
            break;
        };
        let excess = (
            (now.train - best.gain.0) / now.train_freedom.max(1.0),
            (now.held_out - best.gain.1) / now.held_out_freedom.max(1.0),
        );
        for gain in gains.iter().take(6) {
            log::debug!("  {} {:?}", free[gain.form].spec.id, gain);
        }
        if !is_significant(best, excess, has_held_out) {
            break;
        }
        let form = &free[best.form];
        let mut trial = known.clone();
        trial.effects.push(FittedEffect {
            effect: form.effect(best.theta),
            free: form.free.clone(),
        });
        let next = balance.refine(&mut trial)?;
        let after = next.chi2();
        log::debug!(
            "  with {:?}: {:.3}, held out {:.3}",
            trial.effects,
            after.train_per_row(),
            after.held_out_per_row()
        );
        effects.push(BalancedEffect {
            effect: form.effect(best.theta),
            free: form.free.clone(),
            errors: Vec::new(),
            gain: (now.train - after.train, now.held_out - after.held_out),
        });
        (known, solved) = (trial, next);
    }
    let errors = parameter_errors(&known, &solved);
    for ((out, found), errors) in effects.iter_mut().zip(&known.effects).zip(errors) {
        out.effect = found.effect.clone();
        out.errors = errors;
    }
    Ok(Some(ForceBalance {
        before,
        after: solved.chi2(),
        effects,
        candidates,
        structure: known.structure,
    }))
}

/// The recordings with their windows, and what is known at first.
fn prepare(
    workspace: &Workspace,
    model: &Model,
) -> Result<Option<(Balance, Knowledge)>, DiagnoseError> {
    let both = model.has_cantilever
        && workspace
            .train
            .parts
            .iter()
            .all(|p| p.recording.cantilever.is_some());
    let readings = if both { 2 } else { 1 };
    let Some(structure) = AccelerationModel::of(model, readings)? else {
        return Ok(None);
    };
    let parts = workspace.train.parts.iter();
    let interval = parts
        .clone()
        .map(|p| p.recording.interval())
        .fold(0.0, f64::max);
    let duration = parts
        .map(|p| p.recording.duration())
        .fold(f64::INFINITY, f64::min);
    let w = half_width(interval, structure.fastest(), duration);
    let runs = |prepared: &Prepared, summaries: &[RecordingSummary]| {
        let runs = MeasuredRun::of_recordings(prepared, summaries, model, SMOOTHING_SHARE * w);
        let windows = runs.iter().map(|run| windows(run, w)).collect();
        Runs { runs, windows }
    };
    let empty = Runs {
        runs: Vec::new(),
        windows: Vec::new(),
    };
    let balance = Balance {
        train: runs(&workspace.train.event_free.prepared, &workspace.train.findings),
        held_out: workspace.held_out.as_ref().map_or(empty, |held| {
            runs(&held.event_free.prepared, &held.findings)
        }),
    };
    if balance.train.runs.is_empty() {
        return Ok(None);
    }
    let known = Knowledge {
        model: model.clone(),
        structure,
        effects: Vec::new(),
    };
    Ok(Some((balance, known)))
}

/// The forms of the effects that are asked about and that act in flight or on the readings.
fn asked_forms(
    workspace: &Workspace,
    model: &Model,
    options: &DiagnoseOptions,
) -> Vec<CatalogueDirection> {
    let parts = || workspace.train.parts.iter();
    let heights = parts().flat_map(|p| &p.recording.proof_mass);
    let length = heights
        .filter(|x| x.is_finite())
        .fold(0.0f64, |a, x| a.max(x.abs()));
    let interval = parts()
        .map(|p| p.recording.interval())
        .fold(f64::INFINITY, f64::min);
    let scale = Scale::new(model, length.max(f64::MIN_POSITIVE), interval);
    let mut all = catalogue_directions(model, &scale);
    let own = |f: &CatalogueDirection| model.effects.iter().any(|e| e.spec == f.spec);
    all.retain(|f| options.asks(f.spec.id) && !own(f));
    all
}
