//! The parts of a diagnosis that are scored.

use serde::{Deserialize, Serialize};

use crate::diagnose::diagnosis;
pub use crate::diagnose::diagnosis::Verdict;
use crate::model::effects::{ActiveEffect, find};

/// A parameter as stated by a diagnosis, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Id of the parameter.
    pub id: String,
    /// Its value.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// An effect as named by a diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Id in the catalogue.
    pub id: String,
    /// Stated probability.
    pub probability: f64,
    /// Ids from which it cannot be distinguished.
    pub confusion_group: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
}

/// Rms \[m\] and chi2 per value of a simulation against recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Misfit {
    /// Rms over the proof mass's channel \[m\].
    pub rms: f64,
    /// Chi2 per value.
    pub chi2: f64,
}

/// Misfit before and after the named effects were added.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeforeAfter {
    /// The re-tuned baseline.
    pub before: Misfit,
    /// With the named effects.
    pub after: Misfit,
}

/// A stretch where simulation and recording differ, as a diagnosis reports it.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Name of the recording.
    pub recording: String,
    /// What the mass is doing there.
    pub regime: diagnosis::Regime,
    /// Share of the whole mismatch.
    pub share: f64,
}

/// What a diagnosis says of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// Its verdict.
    pub verdict: Verdict,
    /// The effects it names, strongest first.
    pub named: Vec<Named>,
    /// Where it sees the mismatch.
    pub places: Vec<Place>,
    /// On the recordings that were fitted.
    pub train: BeforeAfter,
    /// On held-out recordings.
    pub held_out: BeforeAfter,
    /// What would have been named by an information criterion alone.
    pub by_criterion: Option<String>,
}

/// The effect whose fit to the fitted recordings Akaike's information criterion prefers to
/// the baseline's, and to those with the others: its parameters cost 2 of chi2 each. No
/// held-out recording counts, nor how many candidates were tried.
fn by_criterion(candidates: &[diagnosis::Candidate]) -> Option<String> {
    let worth = |c: &diagnosis::Candidate| {
        let own = find(&c.id).map_or(1, |spec| {
            let effect = ActiveEffect::new(spec);
            (0..spec.parameters.len())
                .filter(|&i| effect.bears(i))
                .count()
        });
        let gain = if c.gain.is_finite() { c.gain } else { c.score };
        (gain - 2.0 * own as f64, c.id.clone())
    };
    let best = candidates
        .iter()
        .map(worth)
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.0).then_some(best.1)
}

impl From<&diagnosis::NamedEffect> for Named {
    fn from(effect: &diagnosis::NamedEffect) -> Self {
        Self {
            id: effect.id.clone(),
            probability: effect.probability,
            confusion_group: effect.alike.clone(),
            parameters: effect
                .parameters
                .iter()
                .map(|p| Estimate {
                    id: p.id.clone(),
                    value: p.value,
                    std_error: p.std_error,
                })
                .collect(),
        }
    }
}

impl From<&diagnosis::BeforeAfter> for BeforeAfter {
    fn from(both: &diagnosis::BeforeAfter) -> Self {
        let misfit = |d: &diagnosis::Distance| Misfit {
            rms: d.rms,
            chi2: d.chi2,
        };
        Self {
            before: misfit(&both.before),
            after: misfit(&both.after),
        }
    }
}

impl From<&diagnosis::Diagnosis> for Diagnosis {
    fn from(diagnosis: &diagnosis::Diagnosis) -> Self {
        Self {
            verdict: diagnosis.verdict,
            named: diagnosis.named.iter().map(Named::from).collect(),
            places: diagnosis
                .mismatch
                .iter()
                .map(|m| Place {
                    recording: m.recording.clone(),
                    regime: m.regime,
                    share: m.share,
                })
                .collect(),
            train: (&diagnosis.train).into(),
            held_out: (&diagnosis.held_out).into(),
            by_criterion: by_criterion(&diagnosis.candidates),
        }
    }
}
