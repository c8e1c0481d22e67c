//! Default values: those of the preset that is loaded. A reset goes back to them.

use std::sync::OnceLock;

use crate::app::setup::current_setup::Setup;
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

/// Default of a parameter \[SI\].
pub fn value(setup: &Setup, id: ParameterId) -> f64 {
    setup.original.model.parameters[id]
}

/// Default of parameter number `index` of an effect \[SI\]: from the preset if that has the
/// effect, else from the catalogue.
pub fn effect_value(setup: &Setup, effect: &EffectSpec, index: usize) -> f64 {
    let own = &setup.original.model.effects;
    own.iter()
        .find(|e| e.spec == effect)
        .map_or(effect.parameters[index].default, |e| e.values[index])
}

/// Whether a value differs from its default by more than rounding.
pub fn differs(value: f64, original: f64) -> bool {
    (value - original).abs() > 1e-12 * value.abs().max(original.abs())
}
