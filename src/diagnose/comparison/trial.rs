//! TODO-doc

use super::hypothesis::Hypothesis;
use super::significance;
use super::significance::is_insignificant;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{LEAVES_MUCH_RATIO, LEAVES_NOTHING_CHI2, REACHABLE_MIN_CHI2};
use crate::model::effects::EffectSpec;
use crate::model::effects::extra_mode::EFFECT;

/// A hypothesis after a fit with it.
#[derive(Debug, Clone)]
pub struct CandidateScore {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Fall of chi2 promised.
    pub promise: f64,
    /// The fit, if it was worth one.
    pub trial: Option<CandidateFit>,
    /// Frequency of a further mode that is not named though its fit is good, for it rings by
    /// itself \[Hz\].
    pub by_itself: Option<f64>,
}

/// A fit with one more effect, judged.
#[derive(Debug, Clone)]
pub struct CandidateFit {
    /// Of the fitted recordings.
    pub train: Fitted,
    /// Of those kept out.
    pub held_out: Option<Fitted>,
    /// Fall of chi2 on the fitted recordings.
    pub gain: f64,
    /// Fall on those kept out; 0 if there are none.
    pub held_gain: f64,
    /// The hypothesis.
    pub hypothesis: Hypothesis,
}

impl CandidateFit {
    /// Both gains.
    pub fn worth(&self) -> f64 {
        self.gain + self.held_gain
    }

    /// Whether the fitted recordings improve by far more than chance lets them, and those kept
    /// out, if there are any, do not.
    pub fn fails_held_out(&self) -> bool {
        self.held_out.is_some()
            && significance::fails_held_out(&self.hypothesis, self.gain, self.held_gain)
    }

    /// Whether either side improves by no more than the beginnings of its own let it that the
    /// hypothesis has in each stretch, beside those that `stand` has.
    pub(crate) fn within_initial_state_dof(&self, stand: &ModelState) -> bool {
        let more = |before: &Fitted, after: &Fitted| {
            after
                .local_unknowns()
                .saturating_sub(before.local_unknowns())
        };
        let side =
            |before, after, gain| significance::within_initial_state_dof(more(before, after), gain);
        let held_out = stand.held_out.as_ref().zip(self.held_out.as_ref());
        side(&stand.train, &self.train, self.gain)
            || held_out.is_some_and(|(before, after)| side(before, after, self.held_gain))
    }

    /// Whether the fitted recordings improve by no more than chance lets them.
    pub fn is_insignificant(&self) -> bool {
        is_insignificant(&self.hypothesis, self.gain, self.held_gain)
    }

    /// Whether the effect leaves nothing of the fitted recordings.
    pub fn leaves_nothing(&self) -> bool {
        self.train.per_value() < LEAVES_NOTHING_CHI2
    }

    /// Whether it leaves nothing of them where `other` leaves much: no other form of its law is
    /// needed then, however large the shares are that both bring.
    pub fn excels(&self, other: &Self) -> bool {
        self.leaves_nothing()
            && other.train.per_value() > LEAVES_MUCH_RATIO * self.train.per_value()
    }
}

/// Where the search stands: a model with the effects named so far.
#[derive(Debug, Clone)]
pub struct ModelState {
    /// Fit to the recordings to be fitted.
    pub train: Fitted,
    /// Those kept out, judged.
    pub held_out: Option<Fitted>,
    /// The effects named, in the order found.
    pub named: Vec<SelectedEffect>,
    /// Whether stretches that were misread for the baseline are in it.
    pub misread: bool,
}

impl ModelState {
    /// The effects named.
    pub fn specs(&self) -> Vec<&'static EffectSpec> {
        self.named.iter().map(|n| n.spec).collect()
    }

    /// What the effects named have explained that may be of a somewhat other form. The law of a
    /// mode is of no uncertain form: what it leaves is no matter of that.
    pub(crate) fn explained(&self) -> f64 {
        let formed = self.named.iter().filter(|n| *n.spec != EFFECT);
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
    /// Its freedoms.
    pub hypothesis: Hypothesis,
    /// Fall of chi2 that it brought on either side.
    pub gain: (f64, f64),
    /// Others that did as well.
    pub alike: Vec<&'static str>,
    /// Why one that does as well in flight is not among those.
    pub told: Option<String>,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct SelectionResult {
    /// The re-tuned baseline.
    pub baseline: ModelState,
    /// With the effects named.
    pub stand: ModelState,
    /// Everything weighed against the baseline.
    pub weighed: Vec<CandidateScore>,
}
