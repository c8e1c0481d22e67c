//! One split of the recordings, fitted or held out, with what its recordings show by themselves.

use super::event_free_segments::EventFreeSegments;
use super::level_drift;
use super::noise_model::Noise;
use crate::fit::Part;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::segment::Segment;
use crate::model::effects::ActiveEffect;
use crate::recording::events::Impact;

/// A drift of the zero, and the ids of its fitted parameters.
pub type Drift = (ActiveEffect, Vec<String>);

/// Recordings of one split: fitted or held out.
#[derive(Debug, Clone)]
pub struct Split {
    /// The recordings.
    pub parts: Vec<Part>,
    /// What each recording shows without a model of the motion.
    pub findings: Vec<RecordingSummary>,
    /// The drift of the zero that their contacts show.
    pub(crate) drift: Option<Drift>,
    /// The recordings cut into event-free segments.
    pub event_free: EventFreeSegments,
}

/// The drift of the zero that the level of the ground shows.
pub(crate) fn level_drift_of(findings: &[RecordingSummary]) -> Option<Drift> {
    let noise = findings.iter().map(|f| f.noise.0);
    let drifts: Vec<_> = findings.iter().filter_map(|f| f.change?.drift()).collect();
    let finest = noise.clone().fold(f64::INFINITY, f64::min);
    level_drift::drift_from_levels(&drifts, (finest, noise.fold(0.0, f64::max)))
}

impl Split {
    /// Applies the estimated size and colour of the noise.
    pub(crate) fn set_noise(&mut self, noise: &Noise) {
        for data in &mut self.event_free.prepared.problem.data {
            data.sigmas.xp *= noise.factor;
            data.sigmas.xc *= noise.factor;
            data.sigmas.colour = noise.colour;
        }
    }

    /// The segments with their first guesses.
    pub fn segments(&self) -> &[Segment] {
        &self.event_free.prepared.segments
    }

    /// Impacts of each recording as its data show them; none where the ground is unknown.
    pub fn impacts(&self) -> Vec<Vec<Impact>> {
        let both = self.parts.iter().zip(&self.findings);
        both.map(|(part, finding)| finding.events(&part.recording).impacts)
            .collect()
    }
}
