//! The map: what is asked of it, its growth, and the response under the pointer.

use std::sync::Arc;

use eframe::egui::Context;

use super::latest::Latest;
use super::run::Run;
use super::steady::{SteadyQuestion, SteadyWork};
use crate::app::setup::explore::{AxisChoice, MapChoices};
use crate::explore::map::{Axis, MapError, MapRequest, MapResult, compute};
use crate::explore::measures::{Basis, MEASURES, MeasureId};
use crate::model::Model;
use crate::model::drive::Waveform;

/// State of the map panel.
#[derive(Debug, Clone, Default)]
pub struct Mapping {
    /// The map.
    pub run: Run<MapRequest, MapResult>,
    /// Whether it was stopped by hand: it then waits for a change or for the button.
    pub is_stopped: bool,
    /// The response under the pointer.
    pub steady: Latest<SteadyWork>,
    /// Index of the point under the pointer, or of the one that the keys moved to.
    pub point: Option<usize>,
    /// Points of a path that is being drawn or was drawn; SI.
    pub path: Vec<[f64; 2]>,
}

/// The axis of a choice.
///
/// # Errors
/// [`MapError`] of an id that neither device nor drive has, or of a range.
pub fn axis_of(
    choice: &AxisChoice,
    of: (&Model, &Waveform),
    count: usize,
) -> Result<Axis, MapError> {
    let mut axis = Axis::offered(&choice.id, of, count)?;
    (axis.from, axis.to) = (choice.from, choice.to);
    axis.is_logarithmic = choice.is_logarithmic;
    axis.check()?;
    Ok(axis)
}

/// The measure of a choice; the first one for an unknown id, for example of a newer session.
pub fn measure_of(choices: &MapChoices) -> MeasureId {
    MeasureId::from_id(&choices.measure).unwrap_or(MEASURES[0].measure)
}

/// What is asked for choices. Measures of events come with every map, so that choosing another one
/// computes nothing anew.
///
/// # Errors
/// [`MapError`].
pub fn request_of(
    choices: &MapChoices,
    (model, drive): (&Model, &Waveform),
) -> Result<MapRequest, MapError> {
    let of = (model, drive);
    let axes = vec![
        axis_of(&choices.x, of, choices.points)?,
        axis_of(&choices.y, of, choices.points)?,
    ];
    let shown = measure_of(choices);
    let mut measures: Vec<MeasureId> = MEASURES
        .iter()
        .filter(|row| row.basis == Basis::Events && row.measure != MeasureId::LargestMultiplier)
        .map(|row| row.measure)
        .filter(|measure| model.has_ground || is_free_of_ground(*measure))
        .collect();
    if !measures.contains(&shown) {
        measures.push(shown);
    }
    let request = MapRequest::new(model.clone(), drive.clone(), axes, measures);
    request.check()?;
    Ok(request)
}

/// Measures of events that mean something without a ground.
fn is_free_of_ground(measure: MeasureId) -> bool {
    matches!(measure, MeasureId::Multiple | MeasureId::Peak)
}

impl Mapping {
    /// Begins the map anew if its question has changed, or if `again` says so.
    pub fn update(&mut self, request: Result<MapRequest, String>, again: bool, context: &Context) {
        self.run.poll();
        let request = match request {
            Ok(request) => request,
            Err(reason) => {
                self.point = None;
                self.run.refuse(reason);
                return;
            }
        };
        let is_outdated = self.run.is_outdated(&request);
        if !(again || is_outdated) {
            return;
        }
        if is_outdated {
            self.point = None;
            self.path.clear();
        }
        self.is_stopped = false;
        let empty = MapResult::pending(&request);
        self.run
            .start("map", request, empty, context, |request, parts| {
                let found = compute(request, parts.cancel, &|update| {
                    let share = update.solved as f64 / update.total.max(1) as f64;
                    parts.add(share, |map| map.apply(&update));
                });
                found.map(|_| ()).map_err(|error| error.to_string())
            });
    }

    /// Ends the work by hand.
    pub fn stop(&mut self) {
        self.is_stopped = true;
        self.run.stop();
    }

    /// Device and drive of a point of the present map.
    ///
    /// # Errors
    /// Why the point is impossible.
    pub fn setting(&self, index: usize) -> Result<(Model, Waveform), String> {
        let request = self.run.asked().ok_or("there is no map yet")?;
        request.setting(index)
    }

    /// Asks for the response at a point, once.
    pub fn look_at(&mut self, index: usize, context: &Context) {
        if self.point == Some(index) && self.steady.asked().is_some() {
            return;
        }
        self.point = Some(index);
        if let Ok((model, drive)) = self.setting(index) {
            let model = Arc::new(model);
            self.steady.ask(SteadyQuestion { model, drive }, context);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::mapping::*;
    use crate::model::preset::Preset;

    #[test]
    fn a_choice_becomes_a_request_and_bad_ones_say_why() {
        let model = Preset::default().model;
        let drive = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
        let mut choices = MapChoices {
            points: 4,
            ..MapChoices::default()
        };
        let request = request_of(&choices, (&model, &drive)).unwrap();
        assert_eq!(request.points(), 16);
        assert!(request.measures.contains(&MeasureId::Margin));
        choices.measure = "energy_lost".to_owned();
        let more = request_of(&choices, (&model, &drive)).unwrap();
        assert_eq!(more.measures.len(), request.measures.len() + 1);
        choices.x.to = choices.x.from;
        let error = request_of(&choices, (&model, &drive)).unwrap_err();
        assert!(error.to_string().contains("empty"), "{error}");
        choices.x = AxisChoice::new("lambda", (0.0, 0.5), false);
        assert!(request_of(&choices, (&model, &drive)).is_err(), "a square");
        let free = Preset::embedded("oscillator").unwrap().model;
        choices.x = AxisChoice::new("f1", (1.0, 2.0), false);
        choices.y = AxisChoice::new("x0", (0.0, 1.0), false);
        choices.measure = "regime".to_owned();
        let error = request_of(&choices, (&free, &Waveform::Rest)).unwrap_err();
        assert!(error.to_string().contains("no ground"), "{error}");
    }

    #[test]
    fn a_map_is_computed_on_its_thread() {
        let model = Preset::default().model;
        let drive = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
        let choices = MapChoices {
            points: 3,
            ..MapChoices::default()
        };
        let context = Context::default();
        let mut mapping = Mapping::default();
        for _ in 0..5000 {
            let request = request_of(&choices, (&model, &drive)).map_err(|e| e.to_string());
            mapping.update(request, false, &context);
            if mapping.run.job().is_none() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let growing = mapping.run.growing().unwrap();
        assert!(growing.lock().answer.is_complete());
        let (_, drive) = mapping.setting(8).unwrap();
        assert_eq!(
            crate::explore::waveform::get(&drive, "frequency"),
            Some(100.0)
        );
    }
}
