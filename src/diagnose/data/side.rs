//! One side: the recordings that are fitted, or those kept out, and what they show by themselves.

use super::event_free_segments::Calm;
use super::level_drift;
use super::noise_model::Noise;
use crate::diagnose::shooting::workspace::Workspace;
use crate::fit::Part;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::segment::Segment;
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::recording::events::Impact;

/// A drift of the zero, and ids of what is to be fitted of it.
pub type Drift = (ActiveEffect, Vec<String>);

/// Recordings on one side: fitted, or kept out.
#[derive(Debug, Clone)]
pub struct Split {
    /// The recordings.
    pub parts: Vec<Part>,
    pub(crate) findings: Vec<RecordingSummary>,
    /// The drift of the zero that they show.
    pub(crate) drift: Option<Drift>,
    /// Cut into calm stretches.
    pub calm: Calm,
}

/// The drift of the zero that the ground's level shows.
pub(crate) fn drift_of(findings: &[RecordingSummary]) -> Option<Drift> {
    let noise = findings.iter().map(|f| f.noise.0);
    let drifts: Vec<_> = findings.iter().filter_map(|f| f.change?.drift()).collect();
    let finest = noise.clone().fold(f64::INFINITY, f64::min);
    level_drift::read(&drifts, (finest, noise.fold(0.0, f64::max)))
}

impl Split {
    /// Takes over what was found of the noise.
    pub(crate) fn colour(&mut self, noise: &Noise) {
        for data in &mut self.calm.prepared.problem.data {
            data.sigmas.xp *= noise.factor;
            data.sigmas.xc *= noise.factor;
            data.sigmas.colour = noise.colour;
        }
    }

    /// The stretches as first guessed.
    pub fn segments(&self) -> &[Segment] {
        &self.calm.prepared.segments
    }

    /// Impacts of each recording, as its data show them; none where the ground is not known.
    pub fn impacts(&self) -> Vec<Vec<Impact>> {
        let both = self.parts.iter().zip(&self.findings);
        both.map(|(part, finding)| finding.events(&part.recording).impacts)
            .collect()
    }
}

impl Workspace {
    /// Those of `doubtful` recordings of `side` that may hover over the ground: not one in which the
    /// ground drifts or steps by all its signs. None at all where it steps in a recording that is
    /// not doubtful: others lie higher or lower for that.
    pub fn may_hover(&self, side: &Split, mut doubtful: Vec<usize>) -> Vec<usize> {
        let steps = |s: &Split| {
            let doubted = |k: usize| std::ptr::eq(s, side) && doubtful.contains(&k);
            let all = s.findings.iter().enumerate();
            let mut sure = all.filter(|(k, _)| !doubted(*k));
            sure.any(|(_, f)| f.change.is_some_and(|c| c.drift().is_none()))
        };
        let mut sides = std::iter::once(&self.train).chain(&self.held_out);
        if sides.any(steps) {
            return Vec::new();
        }
        doubtful.retain(|&k| side.findings[k].change.is_none());
        doubtful
    }

    /// The drift that the level in the fitted recordings shows, if `model` has none yet.
    pub fn drift_beyond(&self, model: &Model) -> Option<&Drift> {
        let known = |spec| model.effects.iter().any(|e| e.spec == spec);
        let drift = self.train.drift.as_ref();
        drift.filter(|(effect, _)| !known(effect.spec))
    }
}
