//! The steady responses of the feet of a gait, each device solved once.

use std::sync::Arc;

use super::latest::Answers;
use super::steady::SteadyView;
use crate::explore::gait::{Foot, Gait};
use crate::explore::steady_state::{SteadyOptions, SteadySolver};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::EventKind;

/// The devices of a gait under one drive.
#[derive(Debug, Clone, PartialEq)]
pub struct FeetQuestion {
    /// Each device once.
    pub devices: Vec<Arc<Model>>,
    /// The drive of a foot without delay.
    pub drive: Waveform,
}

/// Responses of the devices, in the same order; why a device has none.
#[derive(Debug, Clone)]
pub struct FeetView {
    /// One for each device.
    pub responses: Vec<Result<SteadyView, String>>,
}

/// A foot as it is drawn.
#[derive(Debug, Clone)]
pub struct DrawnFoot {
    /// Name.
    pub name: String,
    /// Index of its device.
    pub device: usize,
    /// Delay as a share of the drive's period.
    pub delay: f64,
}

impl FeetView {
    /// The gait of feet.
    ///
    /// # Errors
    /// Why there is none, with the foot.
    pub fn gait(&self, feet: &[DrawnFoot]) -> Result<Gait, String> {
        let mut parts = Vec::with_capacity(feet.len());
        let mut period = f64::NAN;
        for foot in feet {
            let view = self.response(foot)?;
            period = view.response.period;
            let part = Foot::of_response(&*foot.name, foot.delay, &view.response);
            parts.push(part.map_err(|error| error.to_string())?);
        }
        Gait::new(&parts, period).map_err(|error| error.to_string())
    }

    /// The response of a foot's device.
    ///
    /// # Errors
    /// Why there is none.
    pub fn response(&self, foot: &DrawnFoot) -> Result<&SteadyView, String> {
        match self.responses.get(foot.device) {
            Some(Ok(view)) => Ok(view),
            Some(Err(error)) => Err(format!("{}: {error}", foot.name)),
            None => Err(format!("{} has no device", foot.name)),
        }
    }

    /// Instants of a foot's bounces, as shares of the common cycle of `periods` periods of the drive.
    #[must_use]
    pub fn bounces(&self, foot: &DrawnFoot, periods: u64) -> Vec<f64> {
        let Ok(view) = self.response(foot) else {
            return Vec::new();
        };
        let (period, cycle) = (view.response.period, &view.response.cycle);
        let repetitions = (periods / (cycle.periods.max(1) as u64)).max(1);
        let impacts = cycle.events.iter().filter(|e| e.kind == EventKind::Impact);
        let all = impacts.flat_map(|event| {
            (0..repetitions).map(move |k| {
                let at = event.time / period + foot.delay + (k * cycle.periods as u64) as f64;
                (at / periods as f64).rem_euclid(1.0)
            })
        });
        all.collect()
    }

    /// Height of a foot over the ground \[m\] at a share of the common cycle.
    #[must_use]
    pub fn height(&self, foot: &DrawnFoot, share: f64, periods: u64) -> Option<f64> {
        let view = self.response(foot).ok()?;
        let (trace, response) = (&view.trace, &view.response);
        let own = response.cycle.periods.max(1) as f64;
        let at = (share * periods as f64 - foot.delay).rem_euclid(own) * response.period;
        let index = ((at - trace.t0) / trace.dt).round().max(0.0) as usize;
        let value = trace
            .proof_mass
            .get(index.min(trace.len().checked_sub(1)?))?;
        Some(value - trace.ground_level?)
    }
}

/// The worker behind a [`super::latest::Latest`].
#[derive(Default)]
pub struct FeetWork {
    /// What was answered last: a new delay or one changed device solves no other anew.
    known: Vec<(Arc<Model>, Waveform, Result<SteadyView, String>)>,
}

impl Answers for FeetWork {
    type Question = FeetQuestion;
    type Answer = FeetView;
    const NAME: &'static str = "gait";

    fn answer(
        &mut self,
        question: &FeetQuestion,
        go_on: &dyn Fn() -> bool,
    ) -> Result<FeetView, String> {
        let drive = &question.drive;
        let mut known = Vec::with_capacity(question.devices.len());
        for model in &question.devices {
            let same = self.known.iter().find(|k| k.0 == *model && k.1 == *drive);
            let response = match same {
                Some((_, _, response)) => response.clone(),
                None => solve(model, drive, go_on),
            };
            if !go_on() {
                return Err("given up".to_owned());
            }
            known.push((Arc::clone(model), drive.clone(), response));
        }
        let responses = known.iter().map(|(_, _, response)| response.clone());
        let view = FeetView {
            responses: responses.collect(),
        };
        self.known = known;
        Ok(view)
    }
}

fn solve(model: &Model, drive: &Waveform, go_on: &dyn Fn() -> bool) -> Result<SteadyView, String> {
    if !model.has_ground {
        return Err(format!(
            "the device {} has no ground to tap; choose one with a ground",
            model.name
        ));
    }
    let text = |error: &dyn std::error::Error| error.to_string();
    let mut solver =
        SteadySolver::new(model, SteadyOptions::default()).map_err(|error| text(&error))?;
    SteadyView::compute(&mut solver, (model, drive), go_on).map_err(|error| text(&error))
}

#[cfg(test)]
mod tests {
    use super::super::feet::*;
    use crate::model::preset::Preset;

    #[test]
    fn feet_share_the_response_of_their_device_and_one_without_ground_says_so() {
        let model = Arc::new(Preset::default().model);
        let no_ground = Arc::new(Preset::embedded("oscillator").unwrap().model);
        let question = FeetQuestion {
            devices: vec![model, no_ground],
            drive: Waveform::parse("square:15Hz:8V", 0.1).unwrap(),
        };
        let view = FeetWork::default().answer(&question, &|| true).unwrap();
        let foot = |name: &str, device, delay| DrawnFoot {
            name: name.to_owned(),
            device,
            delay,
        };
        let feet = [foot("left", 0, 0.0), foot("right", 0, 0.5)];
        let gait = view.gait(&feet).unwrap();
        assert_eq!(gait.duty_factors[0], gait.duty_factors[1]);
        assert!(gait.duty_factors[0] > 0.0);
        // On the ground in a contact, over it in flight.
        let bar = gait.bars[1][0];
        let middle = 0.5 * (bar.start + bar.end);
        let height = |share| view.height(&feet[1], share, gait.periods).unwrap();
        assert!(height(middle).abs() < 1e-9, "{}", height(middle));
        assert!((0..50).any(|i| height(f64::from(i) / 50.0) > 1e-6));
        let error = view
            .gait(&[feet[0].clone(), foot("odd", 1, 0.0)])
            .unwrap_err();
        assert!(
            error.contains("odd") && error.contains("no ground"),
            "{error}"
        );
    }
}
