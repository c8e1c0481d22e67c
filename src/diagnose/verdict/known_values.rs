//! Known values of parameters that the recordings contradict: a model that follows the recordings
//! only with another value is not adequate.

use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::findings::{Finding, FindingKind};
use crate::diagnose::shooting::fitted::Fitted;
use crate::fit::Contradiction;
use crate::fit::uncertainty::contradiction::contradictions;
use crate::sim::SimError;

/// The known values that the recordings of a fit contradict, the worst first.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn contradicted(fitted: &Fitted) -> Result<Vec<Contradiction>, SimError> {
    let chi2 = fitted.per_value();
    let mut all = contradictions(&fitted.problem, &fitted.point, ROBUST_LOSS, chi2)?;
    all.sort_by(|a, b| b.z().total_cmp(&a.z()));
    Ok(all)
}

/// The worst of them as a finding.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn finding(fitted: &Fitted) -> Result<Option<Finding>, SimError> {
    let worst = contradicted(fitted)?.into_iter().next();
    Ok(worst.map(|found| Finding {
        statistic: found.z(),
        kind: FindingKind::KnownContradicted(found),
    }))
}
