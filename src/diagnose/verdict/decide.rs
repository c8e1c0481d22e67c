//! The verdict: what the checks find, whether names stand, and which answer follows.

use super::abstention::{AbstentionEvidence, attraction_reaches_far, of_displacement};
use super::adequacy::{Adequacy, breaks};
use super::known_values;
use crate::diagnose::comparison::trial::{ModelState, SelectionResult};
use crate::diagnose::contact::free_flights::is_free;
use crate::diagnose::contact::law_test::LawTest;
use crate::diagnose::diagnosis::Verdict;
use crate::diagnose::discrepancy::missing_force::MissingForces;
use crate::diagnose::discrepancy::segment_joins::JoinBreaks;
use crate::diagnose::discrepancy::{law_form, probes, residual_map};
use crate::diagnose::findings::{Finding, FindingKind};
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::score_test::basis_forces::Against;
use crate::diagnose::shooting::fitted::{Fitted, excess_chi2};
use crate::diagnose::thresholds::{
    ADEQUATE_MAX_CHI2, FORM_EXPLAINS_SHARE, JOINS_MAX_Z, MUCH_MISSING_SHARE, NOISE_MAX_Z,
};
use crate::model::effects::{ContactLaw, EffectSpec};
use crate::sim::SimError;

/// What the verdict rests on besides the search's result.
pub struct Grounds<'a> {
    /// Forces of any form that are still missing with the named effects.
    pub missing_force: &'a MissingForces,
    /// Relative standard error of the noise.
    pub noise_error: f64,
    /// Whether the effects were chosen by hand: then nothing is refused.
    pub by_hand: bool,
    /// Whether the search ran to its end.
    pub complete: bool,
}

/// The verdict with what it leaves of the search's result.
pub struct Decision {
    /// The answer.
    pub verdict: Verdict,
    /// What the checks found: what is missing first, then why names are refused.
    pub findings: Vec<Finding>,
    /// The search's result, without its names if they are refused.
    pub found: SelectionResult,
    /// Named laws of the ground.
    pub contact_laws: Vec<LawTest>,
    /// Ids of the effects whose names are refused.
    pub refused: Vec<&'static str>,
}

impl Decision {
    /// Why names were refused, if they were.
    pub fn refusal(&self) -> Option<&Finding> {
        self.findings.iter().find(|f| f.kind.refuses_names())
    }
}

/// Decides what the answer is.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn decide(
    mut found: SelectionResult,
    mut contact_laws: Vec<LawTest>,
    grounds: &Grounds<'_>,
) -> Result<Decision, DiagnoseError> {
    let named = !found.state.named.is_empty();
    let joins = breaks(&found.state)?;
    let adequacy = Adequacy {
        state: &found.state,
        scores: &found.scores,
        missing_force: grounds.missing_force,
        joins,
        // Chi2 scales as the inverse square of the noise.
        chi2_limit: ADEQUATE_MAX_CHI2 + 2.0 * NOISE_MAX_Z * grounds.noise_error,
        // A search that was cancelled proves nothing either way.
        may_doubt: !named && contact_laws.is_empty() && grounds.complete,
    };
    let mut findings: Vec<Finding> = adequacy.first_finding().into_iter().collect();
    // Events are else read with a model of flight that does not hold.
    let events_hold = is_free(&found.state.train.model);
    if !named && !findings.is_empty() && !grounds.by_hand && !events_hold {
        // Only a compliant ground shows in the stays on it as well.
        contact_laws.retain(|t| t.law() == Some(ContactLaw::Compliance));
    }
    if named && !grounds.by_hand {
        let evidence = abstention_evidence(
            &found,
            grounds.missing_force,
            joins,
            findings.first().cloned(),
        )?;
        log::debug!("{evidence:?}");
        if findings.is_empty() {
            findings.extend(evidence.further_inadequacy());
        }
        findings.extend(evidence.first_refusal());
    }
    if findings.is_empty() && !grounds.by_hand {
        findings.extend(known_values::finding(&found.state.train)?);
    }
    let verdict = verdict(named || !contact_laws.is_empty(), &findings);
    let mut refused = Vec::new();
    if findings.iter().any(|f| f.kind.refuses_names()) {
        refused.extend(found.state.named.iter().map(|n| n.spec.id));
        found.state = found.baseline.clone();
        if !events_hold {
            refused.extend(contact_laws.iter().map(|t| t.id));
            contact_laws.clear();
        }
    }
    Ok(Decision {
        verdict,
        findings,
        found,
        contact_laws,
        refused,
    })
}

/// The verdict as a fold over the findings: what is only missing takes from names that they explain
/// everything, and nothing holds against a refusal.
fn verdict(named: bool, findings: &[Finding]) -> Verdict {
    let at_first = if named {
        Verdict::MissingPhysics
    } else {
        Verdict::Adequate
    };
    findings.iter().fold(at_first, |verdict, finding| {
        match (finding.kind.refuses_names(), verdict) {
            (false, Verdict::MissingPhysics | Verdict::PartlyExplained) => Verdict::PartlyExplained,
            (true, _) | (false, Verdict::Adequate | Verdict::Unexplained) => Verdict::Unexplained,
        }
    })
}

/// What the named effects leave.
fn abstention_evidence(
    found: &SelectionResult,
    missing_force: &MissingForces,
    joins: JoinBreaks,
    inadequacy: Option<Finding>,
) -> Result<AbstentionEvidence, DiagnoseError> {
    let state = &found.state;
    let specs = state.specs();
    // Other forms of the named laws may carry what is missing.
    let form_gain = if inadequacy.is_some() {
        law_form::form_error_gain(&state.train, &specs)?
    } else {
        0.0
    };
    let carried = carried_shares(found, missing_force, joins, form_gain, inadequacy.as_ref())?;
    Ok(AbstentionEvidence {
        inadequacy,
        names: specs.iter().map(|s| s.name).collect(),
        of_displacement: state.specs().into_iter().filter(of_displacement).collect(),
        long_range: attraction_reaches_far(&state.train.model),
        over_displacement: missing_force
            .strongest
            .is_some_and(|s| s.0 == Against::Height),
        any_force_gain: missing_force.joint,
        form_gain,
        vibration_gain: probes::swinging_stiffness_gain(&state.train)?,
        friction_gains: probe_gains(
            state,
            &|spec| spec.facts.friction_force.is_some(),
            probes::friction_at_height_gain,
        )?,
        named_gain: state.named.iter().map(|n| n.gain.0).sum(),
        product_gains: probe_gains(state, &of_displacement, probes::displacement_product_gain)?,
        carried_share: carried.overall,
        carried_of_segments: carried.of_segments,
    })
}

/// Shares of what was missing that the named effects carry, 0 to 1.
struct CarriedShares {
    /// Of segments each by itself.
    of_segments: f64,
    /// Of these and of the joins between them, whichever is less.
    overall: f64,
}

fn carried_shares(
    found: &SelectionResult,
    missing_force: &MissingForces,
    joins: JoinBreaks,
    form_gain: f64,
    inadequacy: Option<&Finding>,
) -> Result<CarriedShares, DiagnoseError> {
    let state = &found.state;
    let carried: f64 = state.named.iter().map(|n| n.gain.0).sum();
    let rest = missing_force.joint.max(0.0) + excess_chi2(&state.train);
    let mut share = carried / (carried + (rest - form_gain).max(0.0));
    if let Some(held) = &state.held_out {
        let held_carried: f64 = state.named.iter().map(|n| n.gain.1).sum();
        let form_gain = form_gain * (held_carried / carried).clamp(0.0, 1.0);
        let rest = (excess_chi2(held) - form_gain).max(0.0);
        share = share.min(held_carried / (held_carried + rest));
        if let Some(before) = &found.baseline.held_out {
            share = share.min(least_share_of_recordings(before, held)?);
        }
    }
    let of_segments = share;
    // A law of another form also breaks the motion at the joins.
    if joins.sigmas > JOINS_MAX_Z && form_gain < FORM_EXPLAINS_SHARE * rest {
        // A baseline that sets aside what it cannot explain may look unbroken.
        let before = breaks(&found.baseline)?.rise.max(joins.rise);
        let of_joins = (1.0 - joins.rise / before).max(0.0);
        // Where only the joins are broken, the segments themselves are explained.
        let joins_alone = inadequacy.is_some_and(|f| f.kind == FindingKind::BrokenJoins);
        share = if joins_alone {
            of_joins
        } else {
            share.min(of_joins)
        };
    }
    Ok(CarriedShares {
        of_segments,
        overall: share,
    })
}

/// The least share of what is missing in a held-out recording that the named effects carry, of those
/// recordings in which much is missing: a law that imitates another fails where the drive differs.
fn least_share_of_recordings(before: &Fitted, after: &Fitted) -> Result<f64, DiagnoseError> {
    let squares = |fitted: &Fitted| {
        let mut sums = vec![0.0; fitted.problem.data.len()];
        for sample in residual_map::samples(fitted)? {
            let white = [sample.white.0, sample.white.1].into_iter();
            sums[sample.recording] += white.filter(|w| w.is_finite()).map(|w| w * w).sum::<f64>();
        }
        Ok::<Vec<f64>, DiagnoseError>(sums)
    };
    let (before, after) = (squares(before)?, squares(after)?);
    let most = before.iter().copied().fold(0.0, f64::max);
    let both = before.into_iter().zip(after);
    let much = both.filter(|(before, _)| *before > MUCH_MISSING_SHARE * most);
    Ok(much.fold(1.0, |least, (before, after)| {
        f64::min(least, 1.0 - after / before)
    }))
}

/// Gains by a probe in place of the named effects that `imitates` picks, and by these; the probe is
/// not computed where there is no such effect.
fn probe_gains(
    state: &ModelState,
    imitates: &dyn Fn(&&'static EffectSpec) -> bool,
    probe: fn(&Fitted) -> Result<f64, SimError>,
) -> Result<(f64, f64), SimError> {
    let imitating = state.named.iter().filter(|n| imitates(&n.spec));
    let named: f64 = imitating.map(|n| n.gain.0).sum();
    let probed = if named > 0.0 {
        probe(&state.train)?
    } else {
        0.0
    };
    Ok((probed, named))
}

#[cfg(test)]
mod tests {
    use super::super::decide::*;

    fn finding(kind: FindingKind) -> Finding {
        Finding {
            kind,
            statistic: 2.0,
        }
    }

    #[test]
    fn names_stand_unless_they_are_refused_and_explain_all_unless_something_remains() {
        let missing = [finding(FindingKind::MeanSquare)];
        let twice = [
            finding(FindingKind::BrokenJoins),
            finding(FindingKind::SelfRinging),
        ];
        let refused = [
            finding(FindingKind::MeanSquare),
            finding(FindingKind::FrictionByHeight),
        ];
        assert_eq!(verdict(false, &[]), Verdict::Adequate);
        assert_eq!(verdict(false, &missing), Verdict::Unexplained);
        assert_eq!(verdict(true, &[]), Verdict::MissingPhysics);
        assert_eq!(verdict(true, &missing), Verdict::PartlyExplained);
        assert_eq!(verdict(true, &twice), Verdict::PartlyExplained);
        assert_eq!(verdict(false, &twice), Verdict::Unexplained);
        assert_eq!(verdict(true, &refused), Verdict::Unexplained);
        let turned = [refused[1].clone(), refused[0].clone()];
        assert_eq!(verdict(true, &turned), Verdict::Unexplained);
    }
}
