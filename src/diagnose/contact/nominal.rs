//! Restitution and adhesion of the baseline, fitted to the events.

use super::adhesion::{line, long_pulls};
use super::bounce_readings::{ratios, usual};
use super::robust_curve::curve;
use crate::diagnose::thresholds::MIN_EVENTS;
use crate::fit::ParameterChoices;
use crate::fit::contact_readings::ContactReadings;
use crate::model::Model;
use crate::model::parameter::ParameterId;

/// The model with `alpha`, `Ca0` and `Ca` fitted to the events, each if there are enough of them and the
/// choices of a person leave it open.
pub fn baseline(model: &Model, readings: &ContactReadings, choices: &ParameterChoices) -> Model {
    let mut model = model.clone();
    let is_open = |id: ParameterId| choices.may_change(id.spec().id);
    let bounces = ratios(&readings.bounces, usual([&readings.bounces, &[]]));
    if bounces.len() >= MIN_EVENTS && is_open(ParameterId::Alpha) {
        let fit = curve(&bounces, &[0.4], &|_, p| p[0]);
        let p = &mut model.parameters;
        p.set(ParameterId::Alpha, fit.values[0].clamp(0.0, 1.0));
    }
    let pulls = long_pulls(&readings.releases);
    if pulls.len() >= MIN_EVENTS {
        let fit = line(&pulls);
        for (id, value) in [
            (ParameterId::Ca0, fit.values[0]),
            (ParameterId::Ca, fit.values[1]),
        ] {
            if is_open(id) {
                model.parameters.set(id, value.max(0.0));
            }
        }
    }
    model
}
