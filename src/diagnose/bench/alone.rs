//! What the recordings of one side show at the ground by themselves.

use super::Side;
use crate::diagnose::drifts;
use crate::fit::Part;
use crate::fit::findings::Findings;
use crate::model::effects::ActiveEffect;
use crate::recording::TimeAxis;
use crate::recording::events::{EventOptions, HOP, Impact, find_events};
use crate::recording::level_change::LevelChange;

impl Side {
    /// Impacts of each recording, as its data show them; none where the ground is not known.
    pub fn impacts(&self) -> Vec<Vec<Impact>> {
        let of = |(part, finding): (&Part, &Findings)| {
            let Ok(contact_level) = finding.level else {
                return Vec::new();
            };
            let options = EventOptions {
                contact_level,
                noise: finding.noise.0,
                hop: HOP,
            };
            let recording = &part.recording;
            let time = TimeAxis::Samples(&recording.time);
            find_events(time, &finding.levelled(recording), &options).impacts
        };
        self.parts.iter().zip(&self.findings).map(of).collect()
    }

    /// The drift of the zero that the ground's level shows, and ids of what is to be fitted of
    /// it.
    pub fn drift(&self) -> Option<(ActiveEffect, Vec<String>)> {
        let of = |finding: &Findings| match finding.change {
            Some(LevelChange::Drift(drift)) => Some(drift),
            _ => None,
        };
        let noise = self.findings.iter().map(|f| f.noise.0);
        let drifts: Vec<_> = self.findings.iter().filter_map(of).collect();
        let finest = noise.clone().fold(f64::INFINITY, f64::min);
        drifts::read(&drifts, (finest, noise.fold(0.0, f64::max)))
    }

    /// Those of `doubtful` recordings that may hover over the ground: a ground that drifts is
    /// told by all its signs, and a model without the drift is far from it.
    pub fn may_hover(&self, mut doubtful: Vec<usize>) -> Vec<usize> {
        let drifts = |k: usize| matches!(self.findings[k].change, Some(LevelChange::Drift(_)));
        doubtful.retain(|&k| !drifts(k));
        doubtful
    }
}
