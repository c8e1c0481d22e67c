//! Whether a model explains the recordings: by the mean square of the residuals, forces of any
//! form, single segments, the joins between segments, self-sustained ringing, and effects that
//! improve the fitted recordings alone.

use crate::diagnose::comparison::trial::{CandidateFit, CandidateScore, ModelState};
use crate::diagnose::discrepancy::missing_force::MissingForces;
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::discrepancy::segment_joins::{JoinBreaks, join_breaks};
use crate::diagnose::findings::{Finding, FindingKind};
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{ANY_FORCE_MIN_GAIN, JOINS_MAX_Z, SEGMENT_MAX_Z};

/// Fewer recordings than this do not say by themselves whether what is off shows again.
const FEW_RECORDINGS: usize = 3;

/// What the checks of adequacy look at.
pub struct Adequacy<'a> {
    /// The model with the named effects, fitted.
    pub state: &'a ModelState,
    /// Every hypothesis that was scored.
    pub scores: &'a [CandidateScore],
    /// Forces of any form that `state` still lacks.
    pub missing_force: &'a MissingForces,
    /// How motion continues from segment to segment.
    pub joins: JoinBreaks,
    /// Chi2 per value up to which nothing is missing.
    pub chi2_limit: f64,
    /// Whether an effect that fails on held-out recordings speaks for something missing.
    pub may_doubt: bool,
}

/// The checks, in the order in which they are asked: those that speak of most first.
const CHECKS: [fn(&Adequacy<'_>) -> Option<Finding>; 6] = [
    mean_square,
    missing_force,
    local_segment,
    broken_joins,
    self_ringing,
    fails_held_out,
];

impl Adequacy<'_> {
    /// The first check that fails, if one does. Later ones are not computed then.
    pub fn first_finding(&self) -> Option<Finding> {
        CHECKS.iter().find_map(|check| check(self))
    }
}

/// A finding if the statistic exceeds the threshold.
fn above(kind: FindingKind, statistic: f64, threshold: f64) -> Option<Finding> {
    (statistic > threshold).then_some(Finding { kind, statistic })
}

fn mean_square(of: &Adequacy<'_>) -> Option<Finding> {
    let worst = of
        .state
        .held_out
        .iter()
        .map(Fitted::per_value)
        .fold(of.state.train.per_value(), f64::max);
    log::debug!(
        "chi2 per value {worst:.4}, gain by any force {:.1} ({:?}), joins {:.1}",
        of.missing_force.joint,
        of.missing_force.strongest,
        of.joins.sigmas
    );
    above(FindingKind::MeanSquare, worst, of.chi2_limit)
}

fn missing_force(of: &Adequacy<'_>) -> Option<Finding> {
    let strongest = of.missing_force.strongest;
    let over = strongest.map_or("", |s| s.0.symbol());
    let kind = FindingKind::MissingForce { over };
    above(kind, of.missing_force.joint, ANY_FORCE_MIN_GAIN)
}

/// Segments that are far off in a third of the recordings at least, or in two places of few
/// recordings: what is off in one recording alone was misread there; physics that is missing shows
/// again.
fn local_segment(of: &Adequacy<'_>) -> Option<Finding> {
    let sides = std::iter::once(&of.state.train).chain(&of.state.held_out);
    let all: Vec<(f64, f64)> = sides.flat_map(residual_map::segment_excesses).collect();
    let mut excesses: Vec<f64> = if all.len() < FEW_RECORDINGS {
        all.iter()
            .flat_map(|(worst, again)| [*worst, *again])
            .collect()
    } else {
        all.iter().map(|(worst, _)| *worst).collect()
    };
    excesses.sort_unstable_by(|a, b| b.total_cmp(a));
    let least = all.len().div_ceil(3).max(2);
    let local = excesses.get(least - 1).copied().unwrap_or(0.0);
    above(FindingKind::LocalSegment, local, SEGMENT_MAX_Z)
}

fn broken_joins(of: &Adequacy<'_>) -> Option<Finding> {
    above(FindingKind::BrokenJoins, of.joins.sigmas, JOINS_MAX_Z)
}

fn self_ringing(of: &Adequacy<'_>) -> Option<Finding> {
    let frequency = of.scores.iter().find_map(|w| w.self_ringing_frequency)?;
    Some(Finding {
        kind: FindingKind::SelfRinging,
        statistic: frequency,
    })
}

/// The effect with the largest gain on the fitted recordings among those that fail on held-out
/// recordings.
fn fails_held_out(of: &Adequacy<'_>) -> Option<Finding> {
    let fits = of.scores.iter().filter_map(|w| Some((w, w.fit.as_ref()?)));
    let failing = |(w, t): (&CandidateScore, &CandidateFit)| {
        log::debug!("{}: {:.0}, held-out {:.0}", w.spec.id, t.gain, t.held_gain);
        t.fails_held_out().then_some(Finding {
            kind: FindingKind::FailsHeldOut {
                effect: w.spec.name,
            },
            statistic: t.gain,
        })
    };
    let largest = fits
        .filter_map(failing)
        .max_by(|a, b| a.statistic.total_cmp(&b.statistic));
    largest.filter(|_| of.may_doubt)
}

/// How motion continues across the joins of segments, fitted and held-out recordings together.
///
/// # Errors
/// [`DiagnoseError`] if the model cannot be simulated.
pub fn breaks(state: &ModelState) -> Result<JoinBreaks, DiagnoseError> {
    let train = join_breaks(&state.train)?;
    let Some(held) = &state.held_out else {
        return Ok(train);
    };
    let held = join_breaks(held)?;
    Ok(JoinBreaks {
        sigmas: (train.sigmas + held.sigmas) / std::f64::consts::SQRT_2,
        rise: train.rise + held.rise,
    })
}
