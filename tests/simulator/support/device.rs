//! The paper's device with effects switched on.

use impactscope::model::Model;
use impactscope::model::effects::{ActiveEffect, find};
use impactscope::model::preset::Preset;

/// The model with an effect at given values.
pub fn with(id: &str, values: &[(&str, f64)]) -> Model {
    let mut model = Preset::default().model;
    add(&mut model, id, values);
    model
}

/// Switches an effect on at given values, the others at their defaults.
pub fn add(model: &mut Model, id: &str, values: &[(&str, f64)]) {
    let mut effect = ActiveEffect::new(find(id).unwrap());
    for (parameter, value) in values {
        assert!(effect.set(parameter, *value), "{id} has no {parameter}");
    }
    model.effects.push(effect);
}
