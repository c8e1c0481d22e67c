//! Physics beyond the baseline, one file per effect.
//!
//! # How to add an effect
//!
//! 1. Write one file here. Its header states equation and source. It holds one static
//!    [`EffectSpec`]: id, name, sentence, parameters with defaults and ranges, and `build`, which
//!    makes an [`Action`] from values. All that it does not state comes from
//!    [`EffectSpec::DEFAULT`]. `gravity.rs` is the shortest example.
//! 2. Implement [`Action`] for what it does: a force, a change of the drive, of the ground, of the
//!    structure or of the readings. Every method has a default that does nothing. A model in which
//!    the effect has strength zero must be the baseline (`does_nothing`).
//! 3. Name in `facts.strengths` the parameters whose zero switches it off: a test holds that
//!    against the baseline.
//! 4. Declare the file below (`mod`) and add one line to [`CATALOGUE`].
//!
//! The simulator, the presets, the sliders, the command line, fits and the reports then have it.
//! For the diagnosis to look for it, state in the same file
//!
//! - `search.found_by`: [`FoundBy::Starts`] for a law whose strength moves the simulation in
//!   proportion, with first guesses sized by the [`Motion`] of the device;
//! - `search.form_errors`: what its law leaves if its form is somewhat off;
//! - `facts`: the properties of its law that decisions ask for (see [`Facts`]);
//! - `figure`: the picture in which it shows.
//!
//! Nothing outside this folder knows an effect by its id, but for the sealed trials: they conceal
//! effects by formulations of their own, so that the diagnosis is not tested against itself.

mod adhesion_saturation;
mod amplifier_lag;
mod base_vibration;
mod compliant_ground;
mod cubic_stiffness;
mod definition;
mod dry_friction;
mod electrostatic;
mod even_stiffness;
pub mod extra_mode;
mod film_spring;
mod gap_step;
mod gravity;
mod hysteresis_memory;
mod load_friction;
mod long_range_attraction;
mod piezo_creep;
mod quadratic_drag;
mod sensor_lag;
#[cfg(test)]
mod tests;
mod velocity_restitution;
mod zero_drift;

pub use definition::{
    Action, ActiveEffect, ColdStart, ContactLaw, EdgeLag, EffectSpec, EventFigure, EvidenceFigure,
    Facts, FallOff, FormError, FormTolerance, FoundBy, Kinematics, LagKind, ModeLayout, Motion,
    Need, Quantity, RefinedBounds, Refinement, Search, Start, Surroundings, followed_time_constant,
    own_ids,
};

/// The weight of a device, for those who describe one.
#[must_use]
pub fn weight() -> &'static EffectSpec {
    &gravity::EFFECT
}

/// A stiffness that is not linear, for devices known to have one (a pendulum).
#[must_use]
pub fn nonlinear_stiffness() -> &'static EffectSpec {
    &cubic_stiffness::EFFECT
}

/// All effects that are known, in the order in which they are listed and searched.
pub static CATALOGUE: &[&EffectSpec] = &[
    &amplifier_lag::EFFECT,
    &piezo_creep::EFFECT,
    &hysteresis_memory::EFFECT,
    &electrostatic::EFFECT,
    &extra_mode::EFFECT,
    &cubic_stiffness::EFFECT,
    &even_stiffness::EFFECT,
    &quadratic_drag::EFFECT,
    &dry_friction::EFFECT,
    &load_friction::EFFECT,
    &film_spring::EFFECT,
    &long_range_attraction::EFFECT,
    &adhesion_saturation::EFFECT,
    &velocity_restitution::EFFECT,
    &compliant_ground::EFFECT,
    &gap_step::EFFECT,
    &base_vibration::EFFECT,
    &zero_drift::EFFECT,
    &sensor_lag::EFFECT,
    &gravity::EFFECT,
];

/// Finds an effect by its id.
pub fn find(id: &str) -> Option<&'static EffectSpec> {
    first(|effect| effect.id == id)
}

/// The effect that changes a law of the ground.
pub fn of_contact_law(law: ContactLaw) -> Option<&'static EffectSpec> {
    first(|effect| effect.contact_law() == Some(law))
}

/// The step of the ground's level.
pub fn level_step() -> Option<&'static EffectSpec> {
    first(EffectSpec::is_level_step)
}

/// The sinusoidal vibration of the base.
pub fn base_sinusoid() -> Option<&'static EffectSpec> {
    first(EffectSpec::is_base_sinusoid)
}

/// The drift of the readings' zero by `a (1 - exp(-t/tau)) + b t`, with the values a, tau, b.
pub fn zero_course() -> Option<&'static EffectSpec> {
    first(|effect| effect.facts.is_zero_course)
}

/// The effect by which readings are late as a whole, and which parameter is that time \[s\].
pub fn reading_delay() -> Option<(&'static EffectSpec, usize)> {
    let delays = |effect: &&'static EffectSpec| Some((*effect, effect.facts.reading_delay?));
    CATALOGUE.iter().find_map(delays)
}

/// The effect that looks like `id` in flight. It is enough that one of the two names the other.
pub fn twin_in_flight(id: &str) -> Option<&'static EffectSpec> {
    let own = find(id)?;
    let names = |a: &EffectSpec, b: &EffectSpec| a.facts.twin_in_flight == Some(b.id);
    first(|other| names(own, other) || names(other, own))
}

/// The first effect of the catalogue with a property.
fn first(has: impl Fn(&EffectSpec) -> bool) -> Option<&'static EffectSpec> {
    CATALOGUE.iter().copied().find(|effect| has(effect))
}
