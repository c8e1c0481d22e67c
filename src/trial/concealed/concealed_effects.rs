//! What can be concealed: the catalogue's effects in formulations of the trial's own,
//! and laws that the catalogue does not have. Sizes are those of this device.

use super::drawn::Drawn;
use super::law::Law;
use super::{catalogue_draws, outside_draws};
use crate::trial::device::Device;
use crate::trial::rng::TrialRng;

/// Ids of the catalogue.
pub const CATALOGUE: [&str; 18] = [
    "amplifier_lag",
    "piezo_creep",
    "hysteresis_memory",
    "electrostatic",
    "extra_mode",
    "cubic_stiffness",
    "quadratic_drag",
    "dry_friction",
    "film_spring",
    "long_range_attraction",
    "adhesion_saturation",
    "velocity_restitution",
    "compliant_ground",
    "gap_step",
    "base_vibration",
    "zero_drift",
    "sensor_lag",
    "gravity",
];

/// Of [`CATALOGUE`], what a trial conceals only on request. A constant weight goes into the zero.
const ON_REQUEST: [&str; 1] = ["gravity"];

/// The effects that a trial draws from.
pub fn drawn_effects() -> impl Iterator<Item = &'static str> {
    (CATALOGUE.into_iter()).filter(|id| !ON_REQUEST.contains(id))
}

/// Laws outside the catalogue.
pub const OUTSIDE: [&str; 9] = [
    "outside_voltage_damping",
    "outside_pumped_stiffness",
    "outside_bilinear_spring",
    "outside_gain_walk",
    "outside_dead_zone",
    "outside_load_friction",
    "outside_bursts",
    "outside_negative_damping",
    "outside_product_force",
];

/// Ids of the catalogue that say the same as a law which was once outside it: it keeps its place here,
/// and with it the seeds of earlier trials.
#[must_use]
pub fn same_as(id: &str) -> &'static [&'static str] {
    match id {
        "outside_load_friction" => &["load_friction"],
        _ => &[],
    }
}

/// A law with its name and the room for its strength.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Id in the catalogue, or one of [`OUTSIDE`].
    pub id: String,
    /// Which formulation of it.
    pub formulation: &'static str,
    /// The law as drawn.
    pub law: Law,
    /// How many times stronger it may become and stay realistic.
    pub most: f64,
}

/// Draws one effect's law for a device; the flag picks one of its two formulations.
type Draw = fn(&Device, bool, &mut TrialRng) -> Drawn;

/// How each effect is drawn, by its id.
const DRAWS: [(&str, Draw); 27] = [
    ("amplifier_lag", catalogue_draws::amplifier_lag),
    ("piezo_creep", catalogue_draws::piezo_creep),
    ("hysteresis_memory", catalogue_draws::hysteresis_memory),
    ("electrostatic", catalogue_draws::electrostatic),
    ("extra_mode", catalogue_draws::extra_mode),
    ("cubic_stiffness", catalogue_draws::cubic_stiffness),
    ("quadratic_drag", catalogue_draws::quadratic_drag),
    ("dry_friction", catalogue_draws::dry_friction),
    ("film_spring", catalogue_draws::film_spring),
    (
        "long_range_attraction",
        catalogue_draws::long_range_attraction,
    ),
    ("adhesion_saturation", catalogue_draws::adhesion_saturation),
    (
        "velocity_restitution",
        catalogue_draws::velocity_restitution,
    ),
    ("compliant_ground", catalogue_draws::compliant_ground),
    ("gap_step", catalogue_draws::gap_step),
    ("base_vibration", catalogue_draws::base_vibration),
    ("zero_drift", catalogue_draws::zero_drift),
    ("sensor_lag", catalogue_draws::sensor_lag),
    ("gravity", catalogue_draws::gravity),
    ("outside_voltage_damping", outside_draws::voltage_damping),
    ("outside_pumped_stiffness", outside_draws::pumped_stiffness),
    ("outside_bilinear_spring", outside_draws::bilinear_spring),
    ("outside_gain_walk", outside_draws::gain_walk),
    ("outside_dead_zone", outside_draws::dead_zone),
    ("outside_load_friction", outside_draws::load_friction),
    ("outside_bursts", outside_draws::bursts),
    ("outside_negative_damping", outside_draws::negative_damping),
    ("outside_product_force", outside_draws::product_force),
];

/// Draws the effect `id` for a device at a realistic size; `None` for an unknown id.
#[must_use]
pub fn choose(id: &str, device: &Device, rng: &mut TrialRng) -> Option<Choice> {
    let other = rng.happens(0.5);
    let (_, draw) = DRAWS.iter().find(|(known, _)| *known == id)?;
    let (formulation, most, law) = draw(device, other, rng)?;
    Some(Choice {
        id: id.to_owned(),
        formulation,
        law,
        most: most.max(1.0),
    })
}
