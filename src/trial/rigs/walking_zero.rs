//! A decoder that integrates velocity: the zero of each reading walks at random.

use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rng::TrialRng;

/// The longest recording of a trial \[s\], at whose end the walk has the rms that is drawn.
pub const LONGEST_RECORDING: f64 = 0.4;

pub static RIG: RigSpec = RigSpec {
    id: "walking-zero",
    about: "both points, the zeros walk at random by 5 to 30 nm rms within a recording; \
            20 to 150 nm, 12.5 to 100 kHz",
    maker: Maker::Actuator(draw),
};

fn draw(rng: &mut TrialRng) -> ActuatorRig {
    let mut rig = ActuatorRig::usual(rng);
    rig.vary(rng);
    rig.imperfections.zero_walk = rng.log_between(5e-9, 30e-9) / LONGEST_RECORDING.sqrt();
    rig
}
