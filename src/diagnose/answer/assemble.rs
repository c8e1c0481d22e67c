//! Puts the parts of an answer together.

use super::candidate_table::candidates;
use super::effect_size;
use super::events_seen::{events_seen, mismatches};
use super::named_effects::names;
use super::next_experiment;
use super::proof::Proof;
use super::remaining::remaining;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::contact::event_readings::Ground;
use crate::diagnose::contact::law_test::LawTest;
use crate::diagnose::contact::nominal;
use crate::diagnose::diagnosis::{BalanceForces, Diagnosis};
use crate::diagnose::discrepancy::missing_force::MissingForces;
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::findings::Remark;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::verdict::decide::Decision;
use crate::fit::ParameterChoices;
use crate::fit::problem::Data;
use crate::model::{Model, with_effect};
use crate::recording::quantile_in_place;

/// What the stages have found.
pub struct Parts<'a> {
    /// The verdict and the search's result.
    pub decision: &'a Decision,
    /// What was chosen about parameters.
    pub choices: &'a ParameterChoices,
    /// Events at the ground.
    pub events: &'a Ground,
    /// The last test of each contact law.
    pub law_tests: &'a [LawTest],
    /// Forces of any form that are missing, before and with the named effects.
    pub missing_forces: [&'a MissingForces; 2],
    /// The missing force by the force balance.
    pub balance: Option<BalanceForces>,
    /// Before and after.
    pub proof: &'a Proof,
    /// What limits the answer.
    pub remarks: Vec<Remark>,
}

/// The answer; `done` is called before the last of it is computed.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn assemble(
    parts: Parts<'_>,
    done: &dyn Fn(),
    control: &DiagnoseControl<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let (decision, proof) = (parts.decision, parts.proof);
    let (found, laws) = (&decision.found, &decision.contact_laws[..]);
    let nominal = |state: &ModelState| {
        nominal::baseline(&state.train.model, &parts.events.train, parts.choices)
    };
    let baseline = nominal(&found.baseline);
    let model = with_contact_laws(nominal(&found.state), laws);
    let (before, after) = (&proof.before, &proof.after);
    let named = names(found, laws, after, &model)?;
    let candidates = candidates(decision, parts.law_tests);
    let data = &found.baseline.train.problem.data;
    let noise = median_noise(data);
    let next_experiment =
        next_experiment::next_experiment(found, &named, largest_voltage(data), noise, &baseline);
    let mut mismatch = residual_map::mismatches(&proof.baseline.train, &before.train);
    mismatch.extend(mismatches(laws, parts.events, &found.baseline));
    let (strips, proof_of) = proof.of_recordings();
    let mut forces = parts.missing_forces[0].curves.clone();
    for curve in &mut forces {
        curve.law = effect_size::law_on(curve, found, &before.train);
    }
    let remaining = remaining(decision, proof, parts.missing_forces, control)?;
    done();
    Ok(Diagnosis {
        verdict: decision.verdict,
        remaining,
        named,
        candidates,
        mismatch,
        marginals: residual_map::marginals(&before.train, &after.train),
        forces,
        balance: parts.balance,
        strips,
        events: events_seen(parts.events, &found.baseline, before),
        noise,
        train: proof.of_train(),
        held_out: proof.of_held_out(),
        proof: proof_of,
        next_experiment,
        baseline,
        model,
        remarks: parts.remarks,
        cancelled: control.cancelled(),
        findings: decision.findings.clone(),
    })
}

/// A model with these contact laws.
fn with_contact_laws(mut model: Model, laws: &[LawTest]) -> Model {
    for law in laws {
        model = with_effect(&model, law.effect.clone());
        for (id, value) in &law.sets {
            model.parameters.set(*id, *value);
        }
    }
    model
}

/// Noise of the proof mass's reading \[m\], the median over the recordings.
fn median_noise(data: &[Data]) -> f64 {
    let mut all: Vec<f64> = data.iter().map(|d| d.sigmas.xp).collect();
    quantile_in_place(&mut all, 0.5)
}

/// Largest voltage of all recordings \[V\].
fn largest_voltage(data: &[Data]) -> f64 {
    data.iter()
        .filter_map(|d| d.recording.voltage.as_ref())
        .flat_map(|v| v.iter())
        .filter(|v| v.is_finite())
        .fold(0.0f64, |a, v| a.max(v.abs()))
}
