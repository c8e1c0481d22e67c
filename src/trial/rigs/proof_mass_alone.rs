//! The cantilever is not read.

use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rng::TrialRng;

pub static RIG: RigSpec = RigSpec {
    id: "proof-mass-alone",
    about: "proof mass alone, 20 nm, 50 kHz",
    maker: Maker::Actuator(draw),
};

fn draw(rng: &mut TrialRng) -> ActuatorRig {
    ActuatorRig {
        cantilever: false,
        ..ActuatorRig::usual(rng)
    }
}
