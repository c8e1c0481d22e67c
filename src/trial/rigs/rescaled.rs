//! One of the other devices with all its lengths, times and masses multiplied.

use super::{ball, both_points, pendulum, spring};
use crate::trial::rescale::UnitFactors;
use crate::trial::rig::{Maker, RigSpec};
use crate::trial::rng::TrialRng;

pub static RIG: RigSpec = RigSpec {
    id: "rescaled",
    about: "both points, a spring, a ball or a pendulum with all lengths, times and masses multiplied",
    maker: Maker::InOtherUnits(
        &[&both_points::RIG, &spring::RIG, &ball::RIG, &pendulum::RIG],
        draw,
    ),
};

fn draw(rng: &mut TrialRng) -> UnitFactors {
    UnitFactors {
        length: rng.log_between(1e-3, 1e3),
        time: rng.log_between(1e-2, 1e2),
        mass: rng.log_between(1e-4, 1e4),
    }
}
