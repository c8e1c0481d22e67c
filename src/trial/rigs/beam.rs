//! A distributed beam, with more modes than the model has.

use crate::trial::instrument::StructureKind;
use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rng::TrialRng;

pub static RIG: RigSpec = RigSpec {
    id: "beam",
    about: "a distributed beam with four modes, both points, 20 nm, 50 kHz; naming a further mode is \
            then not wrong",
    maker: Maker::Actuator(draw),
};

fn draw(rng: &mut TrialRng) -> ActuatorRig {
    ActuatorRig {
        structure: Some(StructureKind::Beam),
        ..ActuatorRig::usual(rng)
    }
}
