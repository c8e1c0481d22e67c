//! The rigs that a trial can use, one file each. A new one is a file here and a line in [`RIGS`].

mod ball;
mod beam;
mod both_points;
mod coarse;
mod pendulum;
mod proof_mass_alone;
mod rescaled;
mod spot_anew;
mod spring;
mod voltage_noise;
mod walking_zero;

use super::rig::RigSpec;

/// All rigs, in the order of the table of results.
pub static RIGS: [&RigSpec; 11] = [
    &both_points::RIG,
    &voltage_noise::RIG,
    &proof_mass_alone::RIG,
    &coarse::RIG,
    &walking_zero::RIG,
    &spot_anew::RIG,
    &beam::RIG,
    &spring::RIG,
    &ball::RIG,
    &pendulum::RIG,
    &rescaled::RIG,
];

/// The rig of that name.
#[must_use]
pub fn find(id: &str) -> Option<&'static RigSpec> {
    RIGS.into_iter().find(|rig| rig.id == id)
}
