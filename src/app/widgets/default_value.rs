//! What a reset goes back to: the values of the preset as it was read.

use std::sync::OnceLock;

use crate::app::setup::setup::Setup;
use crate::model::effects::EffectSpec;
use crate::model::parameter::ParameterId;
use crate::model::preset::{EMBEDDED, Preset};

/// The built-in presets, read once.
pub fn embedded() -> &'static [Preset] {
    static PRESETS: OnceLock<Vec<Preset>> = OnceLock::new();
    PRESETS.get_or_init(|| {
        EMBEDDED
            .iter()
            .filter_map(|(name, text)| Preset::parse(name, text).ok())
            .collect()
    })
}

/// Value that a parameter is reset to.
pub fn value(setup: &Setup, id: ParameterId) -> f64 {
    setup.original.model.parameters[id]
}

/// Value that an effect's parameter number `index` is reset to.
pub fn effect_value(setup: &Setup, effect: &EffectSpec, index: usize) -> f64 {
    let own = &setup.original.model.effects;
    own.iter()
        .find(|e| e.spec == effect)
        .map_or(effect.parameters[index].default, |e| e.values[index])
}

/// Whether a value differs from what it is reset to.
pub fn differs(value: f64, original: f64) -> bool {
    (value - original).abs() > 1e-12 * value.abs().max(original.abs())
}
