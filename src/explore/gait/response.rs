//! A foot from its steady response.

use super::contact::Foot;
use super::error::GaitError;
use crate::explore::steady_state::{Cycle, SteadyResponse};
use crate::sim::{EventKind, MotionPhase};

impl Foot {
    /// A foot with the contacts of a periodic response that was computed with the strobe at phase 0
    /// of the drive. Bounces off a rigid ground take no time and are no contacts.
    ///
    /// # Errors
    /// [`GaitError::Foot`] for a response that does not repeat.
    pub fn of_response(
        name: impl Into<String>,
        delay: f64,
        response: &SteadyResponse,
    ) -> Result<Self, GaitError> {
        let name = name.into();
        let Some(multiple) = response.multiple() else {
            return Err(GaitError::Foot {
                foot: name,
                reason: "its response does not repeat, so it has no place in a gait; choose another drive or device"
                    .to_owned(),
            });
        };
        Ok(Self {
            name,
            delay,
            cycle: response.period * multiple as f64,
            contacts: contacts(&response.cycle),
        })
    }
}

/// Begin and end of each contact \[s\]; one that goes on over the end of the cycle ends after it.
fn contacts(cycle: &Cycle) -> Vec<(f64, f64)> {
    let starts_down =
        matches!(cycle.start.phase, MotionPhase::Held { .. }) || cycle.start.sunk.is_some();
    let mut contacts = Vec::new();
    let mut first_release = None;
    let mut begin = None;
    for event in &cycle.events {
        match event.kind {
            EventKind::Stick => begin = begin.or(Some(event.time)),
            EventKind::Release => match begin.take() {
                Some(from) => contacts.push((from, event.time)),
                None => first_release = first_release.or(Some(event.time)),
            },
            EventKind::Impact | EventKind::DriveStep => {}
        }
    }
    match (begin, first_release) {
        (Some(from), release) => contacts.push((from, cycle.duration + release.unwrap_or(0.0))),
        // What is left over rounding at the strobe: down from the start, and from nowhere before.
        (None, Some(release)) => contacts.push((0.0, release)),
        (None, None) if starts_down && contacts.is_empty() => contacts.push((0.0, cycle.duration)),
        (None, None) => {}
    }
    contacts
}

#[cfg(test)]
mod tests {
    use super::super::timeline::Gait;
    use super::*;
    use crate::explore::measures::{MeasureId, value};
    use crate::explore::steady_state::{Start, SteadyOptions, SteadySolver};
    use crate::model::drive::Waveform;
    use crate::model::preset::Preset;

    #[test]
    fn a_foot_is_down_for_the_contact_share_of_its_response() {
        let model = Preset::default().model;
        let mut solver = SteadySolver::new(&model, SteadyOptions::default()).unwrap();
        for text in ["square:15Hz:8V", "square:50Hz:7V", "sine:15Hz:8V", "rest"] {
            let drive = Waveform::parse(text, 0.1).unwrap();
            let Ok(response) = solver.solve(&drive, Start::Rest) else {
                assert_eq!(text, "rest");
                continue;
            };
            let Ok(foot) = Foot::of_response("one", 0.0, &response) else {
                continue;
            };
            let other = Foot {
                name: "other".to_owned(),
                delay: 0.3,
                ..foot.clone()
            };
            let gait = Gait::new(&[foot, other], response.period).unwrap();
            let share = value(MeasureId::ContactShare, &response, None).unwrap();
            for duty in &gait.duty_factors {
                assert!((duty - share).abs() < 1e-9, "{text}: {duty}, {share}");
            }
        }
    }
}
