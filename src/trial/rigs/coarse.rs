//! Both points, noisy and seldom read.

use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rng::TrialRng;

pub static RIG: RigSpec = RigSpec {
    id: "coarse",
    about: "both points, 150 nm, 25 kHz",
    maker: Maker::Actuator(draw),
};

fn draw(rng: &mut TrialRng) -> ActuatorRig {
    ActuatorRig {
        noise: 150e-9,
        rate: 25e3,
        ..ActuatorRig::usual(rng)
    }
}
