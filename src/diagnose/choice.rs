//! Which of the hypotheses weighed is the best, and which others do as well.

use super::bench::Bench;
use super::explain::{Trial, Weighed};
use super::late;
use super::options::DiagnoseError;
use crate::model::effects::EffectSpec;

/// Two hypotheses whose gains differ by less than this share cannot be told apart.
const ALIKE: f64 = 0.03;
/// Nor if they differ by less than this.
const ALIKE_LEAST: f64 = 8.0;
/// Share of the best one's gain from which the one that looks like it is asked as well.
const TWIN: f64 = 0.7;
/// Two that look alike in flight cannot be told there if their gains differ by less than this
/// share: so much a law of somewhat other form makes up for.
const TWIN_ALIKE: f64 = 0.1;

/// The best of a round.
pub struct Choice {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// The fit with it.
    pub trial: Trial,
    /// Others that do as well.
    pub alike: Vec<&'static str>,
    /// Why one that does as well in flight is not among those.
    pub told: Option<String>,
}

/// The best of what was `weighed`; `None` if nothing could be fitted.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn best<'w>(bench: &Bench, weighed: &'w [Weighed]) -> Result<Option<Choice>, DiagnoseError> {
    let trials = || {
        let all = weighed.iter();
        all.filter_map(|w| w.trial.as_ref().map(|t| (w.spec, t)))
    };
    let Some(mut first) = trials().max_by(|a, b| a.1.worth().total_cmp(&b.1.worth())) else {
        return Ok(None);
    };
    // In flight the twin may even suit better, where the law is of somewhat other form.
    let of_first = first.1.worth();
    let twin = trials()
        .find(|(spec, t)| late::looks_like(first.0.id, spec.id) && t.worth() > TWIN * of_first);
    let mut told = None;
    if let Some(twin) = twin {
        let fits = |t: &'w Trial| (&t.train, t.held_out.as_ref());
        if let Some(fall) = late::told(bench, fits(first.1), fits(twin.1))? {
            let (yes, no) = if fall > 0.0 {
                (twin, first)
            } else {
                (first, twin)
            };
            first = yes;
            told = Some((no.0, fall.abs()));
        }
    }
    let least = of_first - (ALIKE * of_first).max(ALIKE_LEAST);
    let other = |spec: &EffectSpec| *spec != *first.0 && told.is_none_or(|t| *spec != *t.0);
    let others = trials().filter(|(spec, t)| {
        let twin = late::looks_like(first.0.id, spec.id);
        let close = t.worth() > least || twin && t.worth() > (1.0 - TWIN_ALIKE) * of_first;
        other(spec) && close
    });
    let alike = others.map(|(spec, _)| spec.id).collect();
    let told = told.map(|(other, fall)| {
        format!(
            "{} would do as well in flight, but not where the mass bounces: chi2 there is {fall:.0} lower with {}",
            other.name, first.0.name
        )
    });
    Ok(Some(Choice {
        spec: first.0,
        trial: first.1.clone(),
        alike,
        told,
    }))
}
