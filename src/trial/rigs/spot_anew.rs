//! The spots of both readings are set anew for each recording: other scales, other zeros.

use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rng::TrialRng;

/// Standard deviation of each reading's scale between recordings.
const SCALE_SPREAD: f64 = 5e-3;

pub static RIG: RigSpec = RigSpec {
    id: "spot-anew",
    about: "both points, the scale of each reading differs by 0.5 % between recordings, its zero by \
            some um; 20 to 150 nm, 12.5 to 100 kHz",
    maker: Maker::Actuator(draw),
};

fn draw(rng: &mut TrialRng) -> ActuatorRig {
    let mut rig = ActuatorRig::usual(rng);
    rig.vary(rng);
    rig.imperfections.scale_spread = SCALE_SPREAD;
    rig
}
