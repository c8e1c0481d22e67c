//! What the named effects do not carry: how much, where, and on what it depends.

use super::proof::Proof;
use crate::diagnose::diagnosis::{ForceCurve, Quantity, Regime, Remaining};
use crate::diagnose::discrepancy::missing_force::MissingForces;
use crate::diagnose::discrepancy::residual_map::Sample;
use crate::diagnose::discrepancy::whole_runs;
use crate::diagnose::findings::{Finding, FindingKind};
use crate::diagnose::options::DiagnoseControl;
use crate::diagnose::shooting::fitted::{Fitted, excess_chi2};
use crate::diagnose::thresholds::ANY_FORCE_MIN_GAIN;
use crate::diagnose::verdict::decide::Decision;
use crate::sim::SimError;

/// What is left where the checks found something, else `None`. `missing_forces` are those of any form
/// before and with the named effects.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn remaining(
    decision: &Decision,
    proof: &Proof,
    [before, after]: [&MissingForces; 2],
    control: &DiagnoseControl<'_>,
) -> Result<Option<Remaining>, SimError> {
    if decision.findings.is_empty() {
        return Ok(None);
    }
    let is_named = !decision.found.state.named.is_empty();
    let missing = if is_named { after } else { before };
    let depends_on = depends_on(&decision.findings, missing);
    let share = if is_named || !decision.contact_laws.is_empty() {
        share_of_stretches(proof, missing)
    } else {
        1.0
    };
    let share_of_runs = if is_named && !control.cancelled() {
        share_of_runs(proof)?
    } else {
        None
    };
    let samples = proof.after.train.iter().chain(&proof.after.held_out);
    Ok(Some(Remaining {
        share,
        share_of_runs,
        regime: worst_regime(samples),
        depends_on,
        force: depends_on.and_then(|quantity| curve(missing, quantity)),
    }))
}

/// The two fits of the proof, side by side: before and with the named effects.
fn sides(proof: &Proof) -> impl Iterator<Item = (&Fitted, &Fitted)> {
    let held_out = (proof.baseline.held_out.as_ref()).zip(proof.state.held_out.as_ref());
    std::iter::once((&proof.baseline.train, &proof.state.train)).chain(held_out)
}

/// Part of a mismatch that is left, 0 to 1; 0 where there is none.
fn share(left: f64, carried: f64) -> f64 {
    let whole = left + carried.max(0.0);
    if whole > 0.0 { left / whole } else { 0.0 }
}

/// Share of the stretches' mismatch that is left, of fitted or held-out recordings, whichever is more:
/// the counterpart of the share that names must carry. What a force of any form would still bring
/// counts as left even where the mean square is at the noise.
fn share_of_stretches(proof: &Proof, missing: &MissingForces) -> f64 {
    let still_missing = std::iter::once(missing.joint.max(0.0)).chain([0.0]);
    let of = |((before, after), force): ((&Fitted, &Fitted), f64)| {
        share(excess_chi2(after) + force, before.cost - after.cost)
    };
    sides(proof).zip(still_missing).map(of).fold(0.0, f64::max)
}

/// The same of whole runs; `None` if no recording is one uninterrupted flight.
fn share_of_runs(proof: &Proof) -> Result<Option<f64>, SimError> {
    let mut most: Option<f64> = None;
    for (before, after) in sides(proof) {
        let (before, after) = (
            whole_runs::excess_chi2(before)?,
            whole_runs::excess_chi2(after)?,
        );
        let both = before.into_iter().zip(after).filter_map(|(b, a)| b.zip(a));
        let sum = |sum: (f64, f64), one: (f64, f64)| (sum.0 + one.0, sum.1 + one.1);
        if let Some((whole, left)) = both.reduce(sum) {
            let own = share(left, whole - left);
            most = Some(most.map_or(own, |most| most.max(own)));
        }
    }
    Ok(most)
}

/// What the mass does where the squares of the residuals exceed those of noise most.
fn worst_regime<'a>(samples: impl Iterator<Item = &'a Sample>) -> Regime {
    let mut excess = Regime::ALL.map(|regime| (regime, 0.0));
    for sample in samples {
        let of_regime = excess.iter_mut().find(|(r, _)| *r == sample.regime);
        let white = [sample.white.0, sample.white.1];
        let own = white.iter().filter(|w| w.is_finite()).map(|w| w * w - 1.0);
        if let Some((_, sum)) = of_regime {
            *sum += own.sum::<f64>();
        }
    }
    let [first, others @ ..] = excess;
    let worst = others.into_iter().fold(
        first,
        |worst, one| if one.1 > worst.1 { one } else { worst },
    );
    worst.0
}

/// On what the rest depends: what a finding says of it, else the quantity over which a force would
/// carry most of it, if that is beyond chance.
fn depends_on(findings: &[Finding], missing: &MissingForces) -> Option<Quantity> {
    let strongest = missing
        .strongest
        .filter(|(_, gain)| *gain > ANY_FORCE_MIN_GAIN);
    let by_force = || Quantity::of_symbol(strongest?.0.symbol());
    findings.iter().find_map(said_by).or_else(by_force)
}

fn said_by(finding: &Finding) -> Option<Quantity> {
    match &finding.kind {
        FindingKind::MissingForce { over } => Quantity::of_symbol(over),
        FindingKind::VibrationWithDisplacement
        | FindingKind::ForceOfBothDisplacements
        | FindingKind::FrictionByHeight
        | FindingKind::OneForceInTheirPlace { .. } => Some(Quantity::Displacement),
        // They are about certain instants.
        FindingKind::LocalSegment | FindingKind::SelfRinging => Some(Quantity::Time),
        _ => None,
    }
}

fn curve(missing: &MissingForces, quantity: Quantity) -> Option<ForceCurve> {
    let mut curves = missing.curves.iter();
    curves
        .find(|curve| curve.against == quantity.symbol())
        .cloned()
}

#[cfg(test)]
mod tests {
    use super::super::remaining::*;
    use crate::diagnose::score_test::basis_forces::Against;

    fn missing(strongest: Option<(Against, f64)>) -> MissingForces {
        MissingForces {
            joint: 100.0,
            curves: vec![ForceCurve {
                against: "xp'",
                unit: "m/s",
                at: vec![0.0],
                force: vec![1e-9],
                std_error: vec![1e-10],
                law: Vec::new(),
            }],
            strongest,
        }
    }

    fn found(kind: FindingKind) -> [Finding; 1] {
        [Finding {
            kind,
            statistic: 100.0,
        }]
    }

    #[test]
    fn a_share_is_what_is_left_of_all() {
        assert_eq!(share(20.0, 60.0), 0.25);
        assert_eq!(share(0.0, 60.0), 0.0);
        // Nothing was missing, or the names made it worse.
        assert_eq!(share(0.0, 0.0), 0.0);
        assert_eq!(share(20.0, -5.0), 1.0);
    }

    #[test]
    fn what_it_depends_on_is_that_of_the_finding_or_of_the_strongest_force() {
        let strong = missing(Some((Against::Velocity, 90.0)));
        let square = found(FindingKind::MeanSquare);
        assert_eq!(depends_on(&square, &strong), Some(Quantity::Velocity));
        let weak = missing(Some((Against::Velocity, 9.0)));
        assert_eq!(depends_on(&square, &weak), None);
        assert_eq!(depends_on(&square, &missing(None)), None);
        let damping = missing(Some((Against::DampingAtHeight, 90.0)));
        assert_eq!(depends_on(&square, &damping), Some(Quantity::Displacement));
        let ringing = found(FindingKind::SelfRinging);
        assert_eq!(depends_on(&ringing, &strong), Some(Quantity::Time));
        let force = found(FindingKind::MissingForce { over: "V" });
        assert_eq!(depends_on(&force, &strong), Some(Quantity::Voltage));
        assert!(curve(&strong, Quantity::Velocity).is_some());
        assert!(curve(&strong, Quantity::Time).is_none());
    }
}
