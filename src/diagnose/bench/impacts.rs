//! Impacts in the recordings of one side.

use super::Side;
use crate::fit::Part;
use crate::fit::prepare::Findings;
use crate::recording::TimeAxis;
use crate::recording::events::{EventOptions, HOP, Impact, find_events};

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
}
