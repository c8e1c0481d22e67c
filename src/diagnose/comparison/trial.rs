//! Fits with one more effect, and the state of the search.

use super::hypothesis::Hypothesis;
use super::significance;
use super::significance::is_insignificant;
use crate::diagnose::findings::Evidence;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{LEAVES_MUCH_RATIO, LEAVES_NOTHING_CHI2, REACHABLE_MIN_CHI2};
use crate::model::effects::EffectSpec;

/// The score of a hypothesis, with its fit.
#[derive(Debug, Clone)]
pub struct CandidateScore {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Predicted fall of chi2.
    pub predicted_gain: f64,
    /// The fit, if it was worth one.
    pub fit: Option<CandidateFit>,
    /// Frequency of a further mode that is not named although it fits well, because nothing in the
    /// device excites it \[Hz\].
    pub self_ringing_frequency: Option<f64>,
}

/// A fit with one more effect, compared with the state before.
#[derive(Debug, Clone)]
pub struct CandidateFit {
    /// Of the fitted recordings.
    pub train: Fitted,
    /// Of held-out recordings.
    pub held_out: Option<Fitted>,
    /// Fall of chi2 on the fitted recordings.
    pub gain: f64,
    /// Fall on held-out recordings; 0 if there are none.
    pub held_gain: f64,
    /// The hypothesis.
    pub hypothesis: Hypothesis,
}

impl CandidateFit {
    /// Both gains.
    pub fn worth(&self) -> f64 {
        self.gain + self.held_gain
    }

    /// Whether the fitted recordings improve by far more than chance would, and held-out ones, if
    /// there are any, do not.
    pub fn fails_held_out(&self) -> bool {
        self.held_out.is_some()
            && significance::fails_held_out(&self.hypothesis, self.gain, self.held_gain)
    }

    /// Whether either side improves by no more than the free initial states bring that the hypothesis
    /// adds in each segment.
    pub(crate) fn within_initial_state_dof(&self, state: &ModelState) -> bool {
        let more = |before: &Fitted, after: &Fitted| {
            after
                .local_unknowns()
                .saturating_sub(before.local_unknowns())
        };
        let side =
            |before, after, gain| significance::within_initial_state_dof(more(before, after), gain);
        let held_out = state.held_out.as_ref().zip(self.held_out.as_ref());
        side(&state.train, &self.train, self.gain)
            || held_out.is_some_and(|(before, after)| side(before, after, self.held_gain))
    }

    /// Whether the fitted recordings improve by no more than chance would.
    pub fn is_insignificant(&self) -> bool {
        is_insignificant(&self.hypothesis, self.gain, self.held_gain)
    }

    /// Whether the effect explains the fitted recordings down to the noise.
    pub fn leaves_nothing(&self) -> bool {
        self.train.per_value() < LEAVES_NOTHING_CHI2
    }

    /// Whether it explains them down to the noise and `other` does not: then no other form of its law
    /// is needed, however large both gains are.
    pub fn excels(&self, other: &Self) -> bool {
        self.leaves_nothing()
            && other.train.per_value() > LEAVES_MUCH_RATIO * self.train.per_value()
    }
}

/// The state of the search: a model with the effects named so far.
#[derive(Debug, Clone)]
pub struct ModelState {
    /// Fit to the recordings to be fitted.
    pub train: Fitted,
    /// Fit of the initial states of held-out recordings.
    pub held_out: Option<Fitted>,
    /// The effects named, in the order found.
    pub named: Vec<SelectedEffect>,
    /// Whether segments that the baseline misread are in it.
    pub misread: bool,
}

impl ModelState {
    /// The effects named.
    pub fn specs(&self) -> Vec<&'static EffectSpec> {
        self.named.iter().map(|n| n.spec).collect()
    }

    /// Gain of the named effects whose law may have another form. The law of a mode has none.
    pub(crate) fn explained(&self) -> f64 {
        let formed = self.named.iter().filter(|n| !n.spec.adds_modes());
        formed.map(|n| n.gain.0 + n.gain.1).sum()
    }

    /// Fall of chi2 that no further effect could exceed.
    pub(crate) fn most_left(&self) -> f64 {
        let sides = std::iter::once(&self.train).chain(&self.held_out);
        sides
            .map(|fitted| (fitted.cost - REACHABLE_MIN_CHI2 * fitted.point.rows as f64).max(0.0))
            .sum()
    }
}

/// An effect that was named.
#[derive(Debug, Clone)]
pub struct SelectedEffect {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Its starts, free parameters and bounds.
    pub hypothesis: Hypothesis,
    /// Fall of chi2 that it brought on fitted and on held-out recordings.
    pub gain: (f64, f64),
    /// Effects that cannot be distinguished from it.
    pub alike: Vec<&'static str>,
    /// Why an effect that fits flight as well is not among those.
    pub rejected_twin: Option<Evidence>,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct SelectionResult {
    /// The re-tuned baseline.
    pub baseline: ModelState,
    /// With the effects named.
    pub state: ModelState,
    /// Every hypothesis that was compared with the baseline.
    pub scores: Vec<CandidateScore>,
    /// Whether it ended because scales of the readings that differ from recording to recording explain
    /// more than any further effect.
    pub scales_differ: bool,
}
