//! Under what the answer was given: what was re-tuned, held or known of the parameters, what the
//! recordings contradict of it, and what was not asked because the time was used up.

use std::time::Duration;

use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::diagnosis::Diagnosis;
use crate::diagnose::findings::{CandidateRemark, Finding, FindingKind, Remark, RetunedParameter};
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::verdict::decide::Decision;
use crate::diagnose::verdict::known_values::contradicted;
use crate::fit::Contradiction;
use crate::fit::uncertainty::contradiction::held_elsewhere;

/// What the re-tuning did with parameters that a person may think given, and what of them the
/// recordings contradict with the effects named.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn of_parameters(
    workspace: &Workspace,
    decision: &Decision,
) -> Result<Vec<Remark>, DiagnoseError> {
    let found = &decision.found;
    let mut remarks = Vec::new();
    if workspace.free.is_empty() {
        remarks.push(Remark::NothingRetuned);
    }
    let initial = &workspace.initial_model;
    let given = initial.effect_ids();
    let fitted = &found.baseline.train.model;
    let known = &workspace.options.known;
    let asked = |id: &&String| given.contains(id) || known.iter().any(|k| k.id == **id);
    let moved = workspace.free.iter().filter(asked).map(|id| {
        let known = known.iter().find(|known| known.id == *id).cloned();
        Some(RetunedParameter {
            from: initial.get(id)?,
            to: fitted.get(id)?,
            unit: initial.unit_of(id).unwrap_or_default().to_owned(),
            id: id.clone(),
            known,
        })
    });
    let moved: Vec<RetunedParameter> = moved.flatten().collect();
    if !moved.is_empty() {
        remarks.push(Remark::Retuned(moved));
    }
    let state = &found.state.train;
    let is_held = |id: &String| !workspace.free.contains(id) && !workspace.choices.is_fixed(id);
    let mut held: Vec<String> = given.into_iter().filter(is_held).collect();
    if !held.is_empty() && !workspace.free.is_empty() {
        remarks.push(Remark::HeldAsGiven(held.clone()));
    }
    let is_said = |needs: &Contradiction| {
        let said =
            |f: &Finding| matches!(&f.kind, FindingKind::KnownContradicted(own) if own == needs);
        decision.findings.iter().any(said)
    };
    let mut needs = contradicted(state)?;
    needs.retain(|needs| !is_said(needs));
    remarks.extend(needs.into_iter().map(Remark::KnownContradicted));
    let chi2 = state.per_value();
    held.retain(|id| state.model.get(id).is_some());
    let elsewhere = held_elsewhere(&state.problem, &state.point, &held, (ROBUST_LOSS, chi2))?;
    remarks.extend(elsewhere.into_iter().map(Remark::HeldElsewhere));
    Ok(remarks)
}

/// Says of an answer that came before its end what was not asked; `budget` is the time that was used
/// up, if that was the reason.
pub fn mark_unfinished(diagnosis: &mut Diagnosis, budget: Option<Duration>) {
    if !diagnosis.cancelled {
        return;
    }
    let mut not_compared = Vec::new();
    for candidate in &mut diagnosis.candidates {
        let is_open = |r: &CandidateRemark| {
            matches!(r, CandidateRemark::NotFitted | CandidateRemark::NotTested)
        };
        if candidate.remarks.iter().any(is_open) {
            candidate.remarks.retain(|r| !is_open(r));
            candidate.remarks.push(CandidateRemark::NotReached);
            not_compared.push(candidate.name.clone());
        }
    }
    not_compared.sort();
    if let Some(budget) = budget {
        diagnosis.remarks.insert(
            0,
            Remark::OutOfTime {
                seconds: budget.as_secs_f64(),
                not_compared,
            },
        );
    }
}
