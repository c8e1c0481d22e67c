//! What an ensemble says of one case.

use crate::explore::measures::{MeasureId, Regime};

/// Probabilities at which quantiles are given.
pub(super) const QUANTILE_PROBABILITIES: [f64; 3] = [0.05, 0.5, 0.95];
/// A difference of means counts from this many of its standard errors.
const CLEAR_STANDARD_ERRORS: f64 = 2.0;

/// Quantiles of a measure over the members that have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantiles {
    /// The measure.
    pub measure: MeasureId,
    /// Value below which 5 % lie; NaN if no member has one.
    pub low: f64,
    /// Median.
    pub median: f64,
    /// Value below which 95 % lie.
    pub high: f64,
    /// Members that have a value.
    pub count: usize,
}

impl Quantiles {
    /// Of values, in any order; those that are NaN are left out.
    pub(super) fn of(measure: MeasureId, values: impl Iterator<Item = f64>) -> Self {
        let mut own: Vec<f64> = values.filter(|value| !value.is_nan()).collect();
        own.sort_by(f64::total_cmp);
        let [low, median, high] = QUANTILE_PROBABILITIES.map(|p| quantile(&own, p));
        Self {
            measure,
            low,
            median,
            high,
            count: own.len(),
        }
    }
}

/// Linear between sorted values; NaN without any.
fn quantile(sorted: &[f64], probability: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let at = probability * last as f64;
    let below = at.floor() as usize;
    let share = at - below as f64;
    let above = sorted[(below + 1).min(last)];
    if share == 0.0 {
        sorted[below]
    } else {
        sorted[below] + share * (above - sorted[below])
    }
}

/// The coefficient whose values differ most between members that keep the wish and those that lose
/// it.
#[derive(Debug, Clone, PartialEq)]
pub struct Breaker {
    /// Its id.
    pub id: String,
    /// Mean of those that lose it less mean of those that keep it, in standard deviations of the
    /// ensemble: positive where larger values break it.
    pub difference: f64,
}

/// What an ensemble says of one case.
#[derive(Debug, Clone, PartialEq)]
pub struct Robustness {
    /// Members of the ensemble.
    pub members: usize,
    /// Those that are impossible; they count as losing the wish.
    pub failed: usize,
    /// Why the first of them is.
    pub first_failure: Option<String>,
    /// Share of the members that keep the wish.
    pub probability: f64,
    /// Mean shortfall from the wish, see [`super::Wish::shortfall`]; 1 for those that fail.
    pub mean_shortfall: f64,
    /// Regimes with their shares, the most frequent first.
    pub regimes: Vec<(Regime, f64)>,
    /// Quantiles of each measure that was asked for.
    pub quantiles: Vec<Quantiles>,
    /// The coefficient that breaks the wish first; `None` if all members agree, or none differs
    /// clearly.
    pub breaker: Option<Breaker>,
}

impl Robustness {
    /// Standard error of the probability: the ensemble is a sample.
    #[must_use]
    pub fn std_error(&self) -> f64 {
        let p = self.probability;
        (p * (1.0 - p) / self.members.max(1) as f64).sqrt()
    }
}

/// One member's answer.
#[derive(Debug, Clone)]
pub(super) struct MemberAnswer {
    pub regime: Regime,
    pub shortfall: f64,
    /// NaN where it has none.
    pub values: Vec<f64>,
}

/// Puts the members' answers together; `deviations` are theirs, `ids` those of the coefficients.
pub(super) fn summed_up(
    answers: &[Result<MemberAnswer, String>],
    deviations: &[&[f64]],
    ids: &[&str],
    measures: &[MeasureId],
) -> Robustness {
    let n = answers.len();
    let share = |count: usize| count as f64 / n.max(1) as f64;
    let keeps =
        |answer: &Result<MemberAnswer, String>| matches!(answer, Ok(own) if own.shortfall == 0.0);
    let failures = answers.iter().filter_map(|answer| answer.as_ref().err());
    let mut counts: Vec<(Regime, usize)> = Vec::new();
    for answer in answers.iter().flatten() {
        match counts
            .iter_mut()
            .find(|(regime, _)| *regime == answer.regime)
        {
            Some((_, count)) => *count += 1,
            None => counts.push((answer.regime, 1)),
        }
    }
    counts.sort_by_key(|(regime, count)| (std::cmp::Reverse(*count), *regime));
    let all = measures.iter().enumerate();
    let quantiles = all.map(|(k, measure)| {
        Quantiles::of(*measure, answers.iter().flatten().map(|own| own.values[k]))
    });
    let shortfalls = answers
        .iter()
        .map(|a| a.as_ref().map_or(1.0, |own| own.shortfall));
    let kept: Vec<bool> = answers.iter().map(keeps).collect();
    Robustness {
        members: n,
        failed: failures.clone().count(),
        first_failure: failures.clone().next().cloned(),
        probability: share(kept.iter().filter(|keeps| **keeps).count()),
        mean_shortfall: shortfalls.sum::<f64>() / n.max(1) as f64,
        regimes: counts.into_iter().map(|(r, c)| (r, share(c))).collect(),
        quantiles: quantiles.collect(),
        breaker: breaker(&kept, deviations, ids),
    }
}

fn breaker(kept: &[bool], deviations: &[&[f64]], ids: &[&str]) -> Option<Breaker> {
    let keeping = kept.iter().filter(|keeps| **keeps).count() as f64;
    let losing = kept.len() as f64 - keeping;
    if keeping == 0.0 || losing == 0.0 {
        return None;
    }
    let mean = |of: bool, k: usize, count: f64| {
        let own = kept
            .iter()
            .zip(deviations)
            .filter(|(keeps, _)| **keeps == of);
        own.map(|(_, d)| d[k]).sum::<f64>() / count
    };
    // The deviations have variance 1.
    let error = (1.0 / keeping + 1.0 / losing).sqrt();
    let all = ids.iter().enumerate().map(|(k, id)| Breaker {
        id: (*id).to_owned(),
        difference: mean(false, k, losing) - mean(true, k, keeping),
    });
    all.max_by(|a, b| a.difference.abs().total_cmp(&b.difference.abs()))
        .filter(|most| most.difference.abs() > CLEAR_STANDARD_ERRORS * error)
}
