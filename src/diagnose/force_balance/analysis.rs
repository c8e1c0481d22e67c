//! The force balance of recordings from beginning to end.

use super::measured_run::MeasuredRun;
use super::regression::{FittedEffect, Knowledge, Runs};
use super::selection::{
    Balance, BalanceChi2, BalanceGain, Solved, is_significant, parameter_errors,
};
use super::slow_mode::SlowMode;
use super::windows::half_width;
use crate::diagnose::data::screening::screen;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::score_test::forms::{CatalogueDirection, Scale, catalogue_directions};
use crate::diagnose::shooting::workspace::Workspace;
use crate::fit::Part;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::problem::prepare::Prepared;
use crate::model::Model;
use crate::model::effects::ActiveEffect;

/// Time over which the motion is smoothed on either side, as a share of a test function's half width.
const SMOOTHING_SHARE: f64 = 0.25;

/// Distance of the instants at which forces are evaluated, as a share of it: a test function needs no
/// more.
const SPACING_SHARE: f64 = 0.06;

/// Most effects that are refined in a round.
const MAX_REFINED_RIVALS: usize = 3;
/// Share of the largest gain that an effect's unrefined one must reach for that.
const RIVAL_MIN_SHARE: f64 = 0.1;

/// Factor by which a constant may leave the range that was tried.
const CONSTANT_BOUND_FACTOR: f64 = 3.0;

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
    /// The slowest mode, with them.
    pub mode: SlowMode,
}

/// The force balance of `train`, judged on `held_out`, or `None` where there is no flight to speak of.
///
/// # Errors
/// [`DiagnoseError`] if a recording or the model cannot be used.
pub fn force_balance(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Option<ForceBalance>, DiagnoseError> {
    let options = DiagnoseOptions {
        choices: options.choices.of(model)?,
        ..options.clone()
    };
    let model = options.choices.start(model)?;
    let screened = screen(&model, train, held_out)?;
    let workspace = Workspace::new(&model, &screened.train, &screened.held_out, &options)?;
    analyse(&workspace, &options, control)
}

/// The force balance of recordings made ready, or `None` where the readings do not say where each
/// mode is, or where there is no flight to speak of.
///
/// # Errors
/// [`DiagnoseError`] if the model makes no sense.
fn analyse(
    workspace: &Workspace,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Option<ForceBalance>, DiagnoseError> {
    let model = &workspace.initial_model;
    let Some((mut balance, mut known)) = prepare(workspace, model)? else {
        return Ok(None);
    };
    let mut solved = balance.settle_clocks(&mut known)?;
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
    for round in 0..options.most {
        if control.cancelled() {
            break;
        }
        let free: Vec<CatalogueDirection> = forms
            .iter()
            .filter(|f| known.effects.iter().all(|e| e.effect.spec != f.spec))
            .cloned()
            .collect();
        let gains = best_of_each_effect(balance.gains(&known, &free)?, &free);
        if round == 0 {
            candidates = gains.iter().map(|g| candidate(g, &free)).collect();
        }
        let Some(best) = best_refined(&balance, (&known, &solved), &gains, &free)? else {
            break;
        };
        log::debug!("force balance: {:?} brings {:?}", best.added, best.gain);
        effects.push(BalancedEffect {
            effect: best.added.effect,
            free: best.added.free,
            errors: Vec::new(),
            gain: best.gain,
        });
        (known, solved) = (best.known, best.solved);
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
        mode: known.mode,
    }))
}

/// The best form of each effect, best first.
fn best_of_each_effect(gains: Vec<BalanceGain>, forms: &[CatalogueDirection]) -> Vec<BalanceGain> {
    let mut out: Vec<BalanceGain> = Vec::new();
    for gain in gains {
        let spec = forms[gain.form].spec;
        if out.iter().all(|g| forms[g.form].spec != spec) {
            out.push(gain);
        }
    }
    out
}

fn candidate(gain: &BalanceGain, forms: &[CatalogueDirection]) -> BalanceCandidate {
    BalanceCandidate {
        id: forms[gain.form].spec.id,
        gain: gain.gain,
        held_out_per_row: gain.held_out_per_row,
    }
}

/// Bounds of the fitted parameters of `form`. A constant stays near those that were tried: far from
/// them one law becomes another, an attraction that reaches farther than the mass moves a spring.
fn bounds(form: &CatalogueDirection, all: &[CatalogueDirection]) -> Vec<(f64, f64)> {
    let one = |&i: &usize| {
        let (low, high) = form.spec.parameters[i].limits;
        if i == form.strength {
            return (low, high);
        }
        let same = all.iter().filter(|f| f.spec == form.spec);
        let tried = same.map(|f| f.values[i]).filter(|v| *v > 0.0);
        let (least, most) = tried.fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
        if least <= most {
            (
                low.max(least / CONSTANT_BOUND_FACTOR),
                high.min(most * CONSTANT_BOUND_FACTOR),
            )
        } else {
            (low, high)
        }
    };
    form.free.iter().map(one).collect()
}

/// A state of knowledge with one effect more.
struct Extended {
    known: Knowledge,
    solved: Solved,
    added: FittedEffect,
    gain: (f64, f64),
}

/// The effect that brings most once its parameters are refined, if that is beyond chance. A form's
/// strength is that of a small effect: how much of a large one it carries says little about what the
/// refined effect does.
fn best_refined(
    balance: &Balance,
    (known, solved): (&Knowledge, &Solved),
    gains: &[BalanceGain],
    forms: &[CatalogueDirection],
) -> Result<Option<Extended>, DiagnoseError> {
    let has_held_out = !balance.held_out.runs.is_empty();
    let most = gains.first().map_or(0.0, BalanceGain::total);
    let rivals = gains.iter().take(MAX_REFINED_RIVALS);
    let mut best: Option<Extended> = None;
    for gain in rivals.filter(|g| g.total() > RIVAL_MIN_SHARE * most) {
        let form = &forms[gain.form];
        let added = FittedEffect {
            effect: form.effect(gain.theta),
            free: form.free.clone(),
            bounds: bounds(form, forms),
        };
        let mut trial = known.clone();
        trial.effects.push(added.clone());
        let next = balance.refine(&mut trial)?;
        let (before, after) = (solved.chi2(), next.chi2());
        let gain = (before.train - after.train, before.held_out - after.held_out);
        let excess = (after.train_per_row(), after.held_out_per_row());
        let sum = |e: &Extended| e.gain.0 + e.gain.1;
        if is_significant(gain, excess, has_held_out)
            && best.as_ref().is_none_or(|b| gain.0 + gain.1 > sum(b))
        {
            best = Some(Extended {
                known: trial,
                solved: next,
                added,
                gain,
            });
        }
    }
    Ok(best)
}

/// The recordings with their windows, and what is known at first.
fn prepare(
    workspace: &Workspace,
    model: &Model,
) -> Result<Option<(Balance, Knowledge)>, DiagnoseError> {
    let Some(mode) = SlowMode::of(model) else {
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
    let w = half_width(interval, mode.frequency(), duration);
    let runs = |prepared: &Prepared, summaries: &[RecordingSummary]| {
        let runs = MeasuredRun::of_recordings(
            prepared,
            summaries,
            model,
            (SMOOTHING_SHARE * w, SPACING_SHARE * w),
        );
        Runs::new(runs, w)
    };
    let empty = Runs::new(Vec::new(), w);
    let balance = Balance {
        train: runs(
            &workspace.train.event_free.prepared,
            &workspace.train.findings,
        ),
        held_out: workspace.held_out.as_ref().map_or(empty, |held| {
            runs(&held.event_free.prepared, &held.findings)
        }),
    };
    if balance.train.runs.is_empty() {
        return Ok(None);
    }
    let known = Knowledge::new(model, mode);
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
