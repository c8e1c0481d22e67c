//! The guided identification: which steps the recordings at hand allow, and what is
//! missing for the others. A quick look at the data, no fit.

use std::sync::Arc;

use crate::fit::Part;
use crate::fit::prepare::{Findings, look};
use crate::model::Model;
use crate::recording::Recording;
use crate::recording::events::{EventOptions, HOP, find_events};

use super::StepError;
use super::drive::fit_drive;

/// Fewest impacts and contacts that a step needs.
const LEAST: usize = 3;
/// Contact longer than this counts as a stay [s].
const STAY: f64 = 0.5e-3;
/// Slower impacts tell little of restitution [m/s].
const FAST: f64 = 0.02;
/// The longest stay over the shortest, for a slope.
const SPREAD: f64 = 1.3;

/// A step of the paper's identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// The branches of the drive.
    Drive,
    /// The coefficient of restitution.
    Restitution,
    /// The adhesion law.
    Adhesion,
    /// The gas film.
    Film,
    /// The sensitivity to the contact distance.
    Sensitivity,
}

impl Step {
    /// All, in the paper's order.
    pub const ALL: [Step; 5] = [
        Step::Drive,
        Step::Restitution,
        Step::Adhesion,
        Step::Film,
        Step::Sensitivity,
    ];

    /// As typed on the command line.
    pub fn id(self) -> &'static str {
        match self {
            Step::Drive => "drive",
            Step::Restitution => "restitution",
            Step::Adhesion => "adhesion",
            Step::Film => "film",
            Step::Sensitivity => "sensitivity",
        }
    }

    /// What it finds.
    pub fn title(self) -> &'static str {
        match self {
            Step::Drive => "drive: the two branches of gc(V)",
            Step::Restitution => "restitution: alpha",
            Step::Adhesion => "adhesion: Ca and Ca0",
            Step::Film => "film: Cs and gp",
            Step::Sensitivity => "sensitivity: all again with dp shifted by 20 um",
        }
    }

    /// The recording that it needs.
    pub fn recipe(self) -> &'static str {
        match self {
            Step::Drive => "whole slow cycles, for example 5 Hz sines of 6 V and 8 V",
            Step::Restitution => "a 300 Hz square or sine that just begins to hit the ground",
            Step::Adhesion => "5 Hz ramped squares of 8 V with several lambda",
            Step::Film => "a 5 Hz ramped square of 8 V, with the ring after break-off",
            Step::Sensitivity => "what restitution, adhesion and film need together",
        }
    }
}

/// Whether a step can be taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Allowance {
    /// The step.
    pub step: Step,
    /// Names of the recordings that allow it; or what is missing.
    pub by: Result<Vec<String>, String>,
}

/// What one recording shows.
struct Sight {
    name: String,
    /// Impacts fast enough to tell restitution.
    impacts: usize,
    /// Durations of stays with a release [s].
    stays: Vec<f64>,
}

/// Looks at the recordings.
pub fn guide(model: &Model, recordings: &[Arc<Recording>]) -> Vec<Allowance> {
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let findings = look(model, &parts);
    let pairs = recordings.iter().zip(&findings);
    let sights: Vec<Sight> = pairs.map(|(r, f)| see(r, f)).collect();
    let together = |step: Step, count: &dyn Fn(&Sight) -> usize, what: &str| {
        let total: usize = sights.iter().map(count).sum();
        let by = if !model.has_ground {
            Err(format!("the device {} has no ground", model.name))
        } else if total >= LEAST {
            let able = sights.iter().filter(|s| count(s) > 0);
            Ok(able.map(|s| s.name.clone()).collect())
        } else {
            Err(format!("{total} {what} seen, {LEAST} are needed"))
        };
        Allowance { step, by }
    };
    let slices: Vec<&Recording> = recordings.iter().map(Arc::as_ref).collect();
    let drive = Allowance {
        step: Step::Drive,
        by: match fit_drive(model, &slices) {
            Ok(_) => Ok(recordings.iter().map(|r| r.name.clone()).collect()),
            Err(StepError::Unsuited { reason, .. }) => Err(reason),
            Err(error) => Err(error.to_string()),
        },
    };
    let restitution = together(
        Step::Restitution,
        &|s| s.impacts,
        "impacts that tell it were",
    );
    let mut adhesion = together(
        Step::Adhesion,
        &|s| s.stays.len(),
        "stays with a release were",
    );
    let all: Vec<f64> = sights
        .iter()
        .flat_map(|s| s.stays.iter().copied())
        .collect();
    let (shortest, longest) = all
        .iter()
        .fold((f64::INFINITY, 0.0f64), |(s, l), &t| (s.min(t), l.max(t)));
    if adhesion.by.is_ok() && longest < SPREAD * shortest {
        adhesion.by = Err(format!("all stays last about {:.0} ms", 1e3 * longest));
    }
    let film = together(Step::Film, &|s| LEAST * s.stays.len(), "break-offs were");
    let missing: Vec<&str> = [&restitution, &adhesion, &film]
        .into_iter()
        .filter(|allowance| allowance.by.is_err())
        .map(|allowance| allowance.step.id())
        .collect();
    let sensitivity = Allowance {
        step: Step::Sensitivity,
        by: if missing.is_empty() {
            Ok(sights.iter().map(|s| s.name.clone()).collect())
        } else {
            Err(format!("{} cannot be had yet", missing.join(", ")))
        },
    };
    vec![drive, restitution, adhesion, film, sensitivity]
}

fn see(recording: &Recording, findings: &Findings) -> Sight {
    let events = findings.level.as_ref().map(|level| {
        let options = EventOptions {
            contact_level: *level,
            noise: findings.noise.0,
            hop: HOP,
        };
        find_events(recording.axis(), &recording.proof_mass, &options)
    });
    let events = events.unwrap_or_default();
    Sight {
        name: recording.name.clone(),
        impacts: events
            .impacts
            .iter()
            .filter(|i| i.v_before < -FAST && i.v_after > 0.1 * FAST)
            .count(),
        stays: events
            .contacts
            .iter()
            .filter(|c| !c.cut && c.touching > STAY)
            .map(|c| c.touching)
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::recording;
    use super::*;
    use crate::model::preset::Preset;

    fn allowed(recordings: &[Arc<Recording>]) -> Vec<&'static str> {
        guide(&Preset::default().model, recordings)
            .into_iter()
            .filter(|allowance| allowance.by.is_ok())
            .map(|allowance| allowance.step.id())
            .collect()
    }

    #[test]
    fn each_recording_allows_its_step_and_the_rest_is_named() {
        let taps = recording("square:300Hz:6V", 0.05);
        let ramps = [0.1, 0.2, 0.3].map(|l| recording(&format!("ramped:5Hz:8V:{l}"), 0.4));
        let cycles = [6, 8].map(|v| recording(&format!("sine:5Hz:{v}V"), 0.4));
        assert_eq!(allowed(std::slice::from_ref(&taps)), ["restitution"]);
        assert_eq!(allowed(&ramps), ["adhesion", "film"]);
        let mut all = vec![taps];
        all.extend(ramps);
        all.extend(cycles);
        let ids: Vec<&str> = Step::ALL.iter().map(|step| step.id()).collect();
        assert_eq!(allowed(&all), ids);
        for allowance in guide(&Preset::default().model, &[]) {
            assert!(allowance.by.is_err(), "{allowance:?}");
        }
    }
}
