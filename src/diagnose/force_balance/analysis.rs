//! The force balance of recordings from beginning to end.

use super::measured_run::MeasuredRun;
use super::missing_force::missing_forces;
use super::regression::{FittedEffect, Knowledge, Runs};
use super::selection::{
    Balance, BalanceChi2, BalanceGain, Solved, is_significant, parameter_errors,
};
use super::slow_mode::SlowMode;
use super::windows::half_width;
use crate::diagnose::data::screening::screen;
use crate::diagnose::diagnosis::BalanceForces;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::score_test::forms::{CatalogueDirection, Scale, catalogue_directions};
use crate::diagnose::score_test::reading_scales::EQUAL_SCALE_SIGMA;
use crate::diagnose::shooting::fitted::Bound;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::OWN_SCALES_MIN_CHI2_RATIO;
use crate::fit::Part;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::problem::prepare::Prepared;
use crate::model::effects::{ActiveEffect, EffectSpec};
use crate::model::parameter::ParameterId;
use crate::model::{Model, with_effect};

/// Time over which the motion is smoothed on either side, as a share of a test function's half width.
const SMOOTHING_SHARE: f64 = 0.25;

/// Distance of the instants at which forces are evaluated, as a share of it: a test function needs no
/// more.
const SPACING_SHARE: f64 = 0.06;

/// Chi2 per row up to which the slowest mode is worth starting a fit from.
const TUNED_MAX_CHI2: f64 = 10.0;

/// Most effects that are refined in a round.
const MAX_REFINED_RIVALS: usize = 3;
/// Share of the largest gain that an effect's unrefined one must reach for that.
const RIVAL_MIN_SHARE: f64 = 0.1;

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
    /// The missing force as curves, before and with the effects.
    pub forces: BalanceForces,
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
    let forms = asked_forms(workspace, model, &|spec| options.asks(spec.id));
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
        let rivals = refined(&balance, (&known, &solved), &gains, &free)?;
        let Some(best) = rivals.into_iter().next() else {
            break;
        };
        log::debug!("force balance: {:?} brings {:?}", best.added(), best.gain);
        effects.push(BalancedEffect {
            effect: best.added().effect.clone(),
            free: best.added().free.clone(),
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
        forces: missing_forces(&balance, &known)?,
    }))
}

/// The missing force as curves over each quantity without and with the `named` effects of `model`, these
/// as strong as they are in it; `None` where no flight is long enough.
///
/// # Errors
/// [`DiagnoseError`] if the model makes no sense.
pub fn forces_without(
    named: &[&'static EffectSpec],
    model: &Model,
    workspace: &Workspace,
) -> Result<Option<BalanceForces>, DiagnoseError> {
    let mut baseline = model.clone();
    baseline.effects.retain(|e| !named.contains(&e.spec));
    let Some((mut balance, mut known)) = prepare(workspace, &baseline)? else {
        return Ok(None);
    };
    let found = model.effects.iter().filter(|e| named.contains(&e.spec));
    known.effects.extend(found.map(|effect| FittedEffect {
        effect: effect.clone(),
        free: Vec::new(),
        bounds: Vec::new(),
    }));
    balance.settle_clocks(&mut known)?;
    Ok(Some(missing_forces(&balance, &known)?))
}

/// An effect that may be missing, with everything else as the balance has settled it beside: where a
/// fit may begin.
#[derive(Debug, Clone)]
pub struct BalanceRival {
    /// The form that it began with.
    pub form: CatalogueDirection,
    /// Bounds of its fitted parameters.
    pub bounds: Vec<Bound>,
    /// The device with the effect, and with the slowest mode as it was found.
    pub model: Model,
    /// The effect.
    pub effect: ActiveEffect,
    /// Falls of chi2 that it brings, on fitted and held-out recordings.
    pub gain: (f64, f64),
    /// Chi2 per row of the fitted recordings that it leaves.
    pub left: f64,
}

/// What the balance of forces says before anything is fitted.
#[derive(Debug, Clone, Default)]
pub struct BalanceGuide {
    /// The effects that are missing most, best first. Empty where little is left per row of the
    /// fitted recordings.
    pub rivals: Vec<BalanceRival>,
    /// Whether the scales of the readings differ from recording to recording.
    pub scales_differ: bool,
    /// The model with its slowest mode as the balance has found it, where little is missing.
    pub tuned: Option<Model>,
}

/// What the balance of forces says of `model`: rivals where more than `min_chi2` is left per row of
/// the fitted recordings, and scales that differ where more than that is left with equal ones. Nothing
/// where the balance cannot tell.
///
/// # Errors
/// [`DiagnoseError`] if the model makes no sense.
pub fn guide(
    workspace: &Workspace,
    model: &Model,
    asked: &dyn Fn(&EffectSpec) -> bool,
    min_chi2: f64,
) -> Result<BalanceGuide, DiagnoseError> {
    let Some((mut balance, mut known)) = prepare(workspace, model)? else {
        return Ok(BalanceGuide::default());
    };
    let first = known.mode;
    let solved = balance.settle_clocks(&mut known)?;
    let near = solved.chi2().train_per_row() < TUNED_MAX_CHI2;
    let tuned = near.then(|| retuned(workspace, model, &known.mode.tuned(model, &first)));
    if solved.chi2().train_per_row() < min_chi2 {
        let scales_differ = do_scales_differ(&balance, (&known, &solved), min_chi2)?;
        return Ok(BalanceGuide {
            rivals: Vec::new(),
            scales_differ,
            tuned,
        });
    }
    let forms = asked_forms(workspace, model, asked);
    let gains = best_of_each_effect(balance.gains(&known, &forms)?, &forms);
    let found = refined(&balance, (&known, &solved), &gains, &forms)?;
    let best = found.first().map(|e| (&e.known, &e.solved));
    let best = best.unwrap_or((&known, &solved));
    let scales_differ = do_scales_differ(&balance, best, min_chi2)?;
    let one = |e: Extended| {
        let form = forms[e.form].clone();
        let effect = e.added().effect.clone();
        log::debug!("force balance: {effect:?} brings {:?}", e.gain);
        BalanceRival {
            bounds: form.bounds(&forms),
            model: {
                let with = with_effect(model, effect.clone());
                retuned(workspace, &with, &e.known.mode.tuned(&with, &first))
            },
            form,
            effect,
            gain: e.gain,
            left: e.solved.chi2().train_per_row(),
        }
    };
    Ok(BalanceGuide {
        rivals: found.into_iter().map(one).collect(),
        scales_differ,
        tuned,
    })
}

/// `model` with those parameters of `tuned` that are free.
fn retuned(workspace: &Workspace, model: &Model, tuned: &Model) -> Model {
    let mut out = model.clone();
    for id in [ParameterId::F1, ParameterId::Zeta1, ParameterId::Eta] {
        if workspace.free.iter().any(|free| free == id.spec().id) {
            out.parameters.set(id, tuned.parameters[id]);
        }
    }
    out
}

/// Whether the balance with what is `known` leaves much more where the scales of all readings are
/// equal.
fn do_scales_differ(
    balance: &Balance,
    (known, solved): (&Knowledge, &Solved),
    min_chi2: f64,
) -> Result<bool, DiagnoseError> {
    let with_equal = |runs: &Runs| runs.clone().with_scale_sigma(EQUAL_SCALE_SIGMA);
    let equal = Balance {
        train: with_equal(&balance.train),
        held_out: with_equal(&balance.held_out),
    };
    let equal = equal.settle(&mut known.clone())?.chi2().train_per_row();
    let own = solved.chi2().train_per_row();
    log::debug!("force balance: {equal:.3} per row with equal scales, {own:.3} with own ones");
    Ok(equal > min_chi2 && equal > OWN_SCALES_MIN_CHI2_RATIO * own)
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

/// The effect of `form`, `theta` times as strong, with its fitted parameters.
fn fitted_effect(
    form: &CatalogueDirection,
    theta: f64,
    all: &[CatalogueDirection],
) -> FittedEffect {
    let near = form.bounds(all);
    let bounds = form.free.iter().zip(form.free_ids()).map(|(&i, id)| {
        let limits = form.spec.parameters[i].limits;
        let own = near.iter().filter(|bound| bound.0 == id);
        own.fold(limits, |(low, high), (_, (least, most))| {
            (low.max(*least), high.min(*most))
        })
    });
    FittedEffect {
        effect: form.effect(theta),
        bounds: bounds.collect(),
        free: form.free.clone(),
    }
}

/// A state of knowledge with one effect more.
struct Extended {
    known: Knowledge,
    solved: Solved,
    /// Which form was added.
    form: usize,
    gain: (f64, f64),
}

impl Extended {
    /// The effect that was added.
    fn added(&self) -> &FittedEffect {
        let last = self.known.effects.last();
        last.expect("an effect was added")
    }
}

/// The effects that bring most, once their parameters are refined, of those that bring more than
/// chance would; best first. A form's strength is that of a small effect: how much of a large one it
/// carries says little about what the refined effect does.
fn refined(
    balance: &Balance,
    (known, solved): (&Knowledge, &Solved),
    gains: &[BalanceGain],
    forms: &[CatalogueDirection],
) -> Result<Vec<Extended>, DiagnoseError> {
    let has_held_out = !balance.held_out.runs.is_empty();
    let most = gains.first().map_or(0.0, BalanceGain::total);
    let rivals = gains.iter().take(MAX_REFINED_RIVALS);
    let mut out: Vec<Extended> = Vec::new();
    for gain in rivals.filter(|g| g.total() > RIVAL_MIN_SHARE * most) {
        let form = &forms[gain.form];
        let mut trial = known.clone();
        trial.effects.push(fitted_effect(form, gain.theta, forms));
        let next = balance.refine(&mut trial)?;
        let (before, after) = (solved.chi2(), next.chi2());
        let fall = (before.train - after.train, before.held_out - after.held_out);
        let excess = (after.train_per_row(), after.held_out_per_row());
        if is_significant(fall, excess, has_held_out) {
            out.push(Extended {
                known: trial,
                solved: next,
                form: gain.form,
                gain: fall,
            });
        }
    }
    let sum = |e: &Extended| e.gain.0 + e.gain.1;
    out.sort_by(|a, b| sum(b).total_cmp(&sum(a)));
    Ok(out)
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
    asked: &dyn Fn(&EffectSpec) -> bool,
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
    all.retain(|f| asked(f.spec) && !own(f));
    all
}
