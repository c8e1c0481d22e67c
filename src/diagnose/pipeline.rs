//! One diagnosis from beginning to end: its stages in order.
//!
//! 1. Screen the recordings.
//! 2. Re-tune the baseline to them.
//! 3. Read the contact events by it.
//! 4. Select effects that the baseline lacks.
//! 5. Decide which contact laws the events call for.
//! 6. Measure the force that is missing, whatever its form.
//! 7. Decide on the verdict.
//! 8. Compare before and after on the same segments: the proof.
//! 9. Assemble the answer.

use std::borrow::Cow;
use std::sync::Arc;

use super::answer::assemble::{Parts, assemble};
use super::answer::conditions;
use super::answer::proof::Proof;
use super::baseline::retune::RetunedBaseline;
use super::comparison::trial::{ModelState, SelectionResult};
use super::contact::decide::{ContactEvents, ContactLaws, Rules};
use super::data::reading_assumptions::ContactAmbiguity;
use super::data::screening::{ScreenedRecordings, screen};
use super::diagnosis::{BalanceForces, Diagnosis, Verdict};
use super::discrepancy::missing_force::{self, MissingForces};
use super::findings::Remark;
use super::force_balance::forces_without;
use super::hypotheses::raised_level::raised_recordings;
use super::hypotheses::vibration_clock::VibrationClock;
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, Stages, simulated};
use super::score_test::reading_scales::{has_own_scales, largest_difference};
use super::selection::forward;
use super::selection::refit::MAX_FIT_STEPS;
use super::shooting::fitted::Fitted;
use super::shooting::workspace::Workspace;
use super::verdict::decide::{Grounds, decide};
use crate::fit::Part;
use crate::model::Model;
use crate::model::effects::{EffectSpec, base_sinusoid};

/// What one way of reading the recordings says about that way.
#[derive(Debug, Clone)]
pub struct Reading {
    /// If it is uncertain whether the mass touches the ground in some recordings: chi2 per value of
    /// the others at the end of the search, or by the baseline where only that decides it. Not a
    /// number if there are no others.
    pub chi2_of_certain: Option<f64>,
    /// How to read the recordings instead if nothing explains them.
    pub alternative: ContactAmbiguity,
    /// Share of the rows that were set aside, of both sides together.
    pub set_aside: f64,
}

/// Recordings of either side, by index.
type Recordings = (Vec<usize>, Vec<usize>);

/// The re-tuned baseline and the recordings as they were cut for it.
struct Baseline {
    workspace: Workspace,
    state: ModelState,
    /// Recordings in which the mass may rest above the ground.
    uncertain: Recordings,
    /// The base's phase in each recording, if it vibrates with different ones.
    clock: Option<VibrationClock>,
    remarks: Vec<Remark>,
}

/// Forces that are missing, whatever their form.
struct MissingForceChange {
    before: MissingForces,
    after: MissingForces,
}

/// Diagnoses `train`, judged on `held_out`, with the recordings read as `ambiguity` says.
///
/// # Errors
/// [`DiagnoseError`] if a recording or the model cannot be used.
pub fn diagnose_as_read(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    (options, ambiguity): (&DiagnoseOptions, &ContactAmbiguity),
    control: &DiagnoseControl<'_>,
) -> Result<(Diagnosis, Reading), DiagnoseError> {
    let stages = Stages::begin(control);
    stages.enter("recordings", detail(ambiguity), 0.0);
    let screened = screen(model, train, held_out)?;

    let mut baseline = fit_baseline(model, &screened, (options, ambiguity), &stages)?;

    stages.enter("ground", "bounces and releases", 0.3);
    let sound = sound(&baseline.workspace, &baseline.state, control)?;
    let mut events = ContactEvents::read(&baseline.workspace, &sound, None, control)?;

    let first_cost = baseline.state.train.cost;
    let most = if screened.may_name { options.most } else { 0 };
    let mut found = select_effects(&baseline, (options, most), &stages)?;
    if found.scales_differ && !control.cancelled() {
        baseline.free_scales(&found.baseline, control)?;
        found = select_effects(&baseline, (options, most), &stages)?;
    }
    let (workspace, uncertain) = (baseline.workspace, baseline.uncertain);
    let chi2_of_certain = chi2_without(&found.state, &uncertain)?;

    // An effect that turned out not to be needed may have improved the re-tuning.
    if found.baseline.train.cost < first_cost {
        events = ContactEvents::read(&workspace, &found.baseline, Some(&events), control)?;
    }
    let rules = Rules {
        by_hand: options.by_hand.as_deref(),
        held_out: workspace.held_out.is_some(),
    };
    let contact_laws = if screened.may_name {
        let again = || stages.enter("ground", "bounces and releases again", 0.78);
        ContactLaws::decide(&workspace, &events, &found.state, &rules, &again, control)?
    } else {
        ContactLaws::none(&events)
    };

    stages.enter("evidence", "", 0.8);
    let missing_forces = measure_missing_forces(&found)?;

    let grounds = Grounds {
        missing_force: &missing_forces.after,
        noise_error: workspace.noise_error,
        by_hand: options.by_hand.is_some(),
        complete: !control.cancelled(),
    };
    let decision = decide(found, contact_laws.named, &grounds)?;

    stages.enter("proof", "", 0.92);
    let proof = Proof::new(&workspace, &decision.found)?;

    let mut remarks = screened.remarks;
    remarks.extend(baseline.remarks);
    if has_own_scales(&decision.found.state.train.problem) {
        let state = &decision.found.state;
        let sides = std::iter::once(&state.train).chain(&state.held_out);
        let most = sides.map(largest_difference).fold(0.0, f64::max);
        remarks.push(Remark::ScalesDiffer(100.0 * most));
    }
    remarks.extend(decision.refusal().cloned().map(Remark::NamesRefused));
    remarks.extend(proof.misread());
    remarks.extend(conditions::of_parameters(&workspace, &decision)?);
    let set_aside = set_aside(&decision.found.state);
    let parts = Parts {
        decision: &decision,
        choices: &workspace.choices,
        events: &events.ground,
        law_tests: &contact_laws.tests,
        missing_forces: [&missing_forces.before, &missing_forces.after],
        balance: balance_forces(&workspace, &decision.found.state)?,
        proof: &proof,
        remarks,
    };
    let done = || stages.enter("done", "", 1.0);
    let mut diagnosis = assemble(parts, &done, control)?;
    if let Some(clock) = baseline.clock {
        clock.undo(&mut diagnosis);
    }
    let mut reading = Reading {
        chi2_of_certain,
        alternative: ContactAmbiguity::Opposite,
        set_aside,
    };
    let at_first = *ambiguity == ContactAmbiguity::AsFitted;
    // Effects chosen by hand are not doubted.
    let doubts = at_first && options.by_hand.is_none() && !control.cancelled();
    if doubts && decision.verdict == Verdict::Unexplained && chi2_of_certain.is_none() {
        let raised = raised_recordings(&workspace, &decision.found.baseline)?;
        reading.chi2_of_certain = chi2_without(&decision.found.baseline, &raised)?;
        reading.alternative = ContactAmbiguity::HoveringIn(raised.0, raised.1);
    }
    Ok((diagnosis, reading))
}

/// The state by which events are read: with the effect for lack of which the baseline has lost its way,
/// if it has.
fn sound<'s>(
    workspace: &Workspace,
    state: &'s ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<Cow<'s, ModelState>, DiagnoseError> {
    let required = workspace.required_effect.as_ref();
    let Some(required) = required.filter(|_| state.train.is_lost()) else {
        return Ok(Cow::Borrowed(state));
    };
    let fitted = required.fitted.clone();
    Ok(Cow::Owned(ModelState {
        held_out: workspace.fit_held_out(&fitted.model, (&fitted, None), control)?,
        train: fitted,
        named: Vec::new(),
        misread: state.misread,
    }))
}

/// What the first stage says about the way of reading.
fn detail(ambiguity: &ContactAmbiguity) -> &'static str {
    match ambiguity {
        ContactAmbiguity::AsFitted => "",
        ContactAmbiguity::Opposite | ContactAmbiguity::HoveringIn(..) => {
            "again, with the mass resting above the ground in some recordings"
        }
    }
}

/// Re-tunes the baseline; once more, if the base vibrates, with the recordings' clocks set to its
/// phase.
fn fit_baseline(
    model: &Model,
    screened: &ScreenedRecordings,
    (options, ambiguity): (&DiagnoseOptions, &ContactAmbiguity),
    stages: &Stages<'_>,
) -> Result<Baseline, DiagnoseError> {
    let control = stages.control;
    let mut remarks = Vec::new();
    let workspace = Workspace::new(model, &screened.train, &screened.held_out, options)?;
    if workspace.held_out.is_none() {
        remarks.push(Remark::NothingHeldOut);
    }
    stages.enter("baseline", "re-tuning", 0.05);
    let judging = || stages.enter("baseline", "held-out recordings", 0.25);
    let mut tuned: RetunedBaseline =
        workspace.retune_baseline(model, (options, ambiguity), control, &judging)?;
    let mut clock = None;
    // A baseline that is lost without an effect that the re-tuning has found determines no phases.
    let sound = tuned.workspace.required_effect.is_none() && screened.may_name;
    let is_asked = base_sinusoid().is_some_and(|vibration| options.asks(vibration.id));
    if is_asked && sound && !control.cancelled() {
        clock = VibrationClock::of(&tuned.train, tuned.held_out.as_ref())?;
    }
    if let Some(clock) = &clock {
        remarks.push(Remark::VibrationPhasesDiffer);
        let (train, held_out) = clock.shift_recordings(&screened.train, &screened.held_out);
        let workspace = Workspace::new(model, &train, &held_out, options)?;
        tuned = workspace.retune_baseline(model, (options, ambiguity), control, &judging)?;
    }
    remarks.extend(tuned.remarks);
    Ok(Baseline {
        workspace: tuned.workspace,
        state: ModelState {
            train: tuned.train,
            held_out: tuned.held_out,
            named: Vec::new(),
            misread: false,
        },
        uncertain: tuned.ambiguous,
        clock,
        remarks,
    })
}

impl Baseline {
    /// Gives each reading of each recording a scale of its own, from the fits of `state`.
    fn free_scales(
        &mut self,
        state: &ModelState,
        control: &DiagnoseControl<'_>,
    ) -> Result<(), DiagnoseError> {
        let freed = self.workspace.with_own_scales();
        let before = &state.train;
        let train = freed.fit(&before.model, &[], &[], before, MAX_FIT_STEPS, control)?;
        let near = (&train, state.held_out.as_ref());
        let held_out = freed.fit_held_out(&train.model, near, control)?;
        self.workspace = freed;
        if !train.is_lost() {
            self.workspace.required_effect = None;
            self.workspace.rival_effects = Arc::default();
        }
        self.state = ModelState {
            train,
            held_out,
            named: Vec::new(),
            misread: false,
        };
        Ok(())
    }
}

/// Selects the effects that the baseline lacks, at most so many.
fn select_effects(
    baseline: &Baseline,
    (options, most): (&DiagnoseOptions, usize),
    stages: &Stages<'_>,
) -> Result<SelectionResult, DiagnoseError> {
    stages.enter("naming", "", 0.35);
    let options = DiagnoseOptions {
        most,
        ..options.clone()
    };
    let report = |detail: &str, share: f64| stages.enter("naming", detail, 0.35 + 0.4 * share);
    let (workspace, state) = (&baseline.workspace, baseline.state.clone());
    forward::select_effects(workspace, state, &options, stages.control, &report)
}

fn measure_missing_forces(found: &SelectionResult) -> Result<MissingForceChange, DiagnoseError> {
    let before = missing_force::measure(&found.baseline.train)?;
    let after = if found.state.named.is_empty() {
        before.clone()
    } else {
        missing_force::measure(&found.state.train)?
    };
    Ok(MissingForceChange { before, after })
}

/// The missing force by the balance of forces in flight; `None` where it cannot tell.
fn balance_forces(
    workspace: &Workspace,
    state: &ModelState,
) -> Result<Option<BalanceForces>, DiagnoseError> {
    let named: Vec<&'static EffectSpec> = state.named.iter().map(|n| n.spec).collect();
    let forces = forces_without(&named, &state.train.model, workspace);
    Ok(simulated(forces)?.flatten())
}

/// Share of the rows that were set aside on the fitted recordings, plus that on held-out ones.
fn set_aside(state: &ModelState) -> f64 {
    let held_out = state.held_out.as_ref().map_or(0.0, Fitted::set_aside_share);
    state.train.set_aside_share() + held_out
}

/// Chi2 per value of all but these recordings of either side; `None` if there are none of these.
fn chi2_without(state: &ModelState, recordings: &Recordings) -> Result<Option<f64>, DiagnoseError> {
    if recordings.0.is_empty() && recordings.1.is_empty() {
        return Ok(None);
    }
    let (mut cost, mut rows) = state.train.cost_without(&recordings.0)?;
    if let Some(held_out) = &state.held_out {
        let own = held_out.cost_without(&recordings.1)?;
        (cost, rows) = (cost + own.0, rows + own.1);
    }
    Ok(Some(cost / rows as f64))
}
