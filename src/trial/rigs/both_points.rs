//! Proof mass and cantilever read by good instruments.

use crate::trial::rig::{ActuatorRig, Maker, RigSpec};

pub static RIG: RigSpec = RigSpec {
    id: "both-points",
    about: "both points, 20 nm, 50 kHz",
    maker: Maker::Actuator(ActuatorRig::usual),
};
