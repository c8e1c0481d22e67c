//! The voltage is recorded with noise, or by a converter of 8 bits.

use crate::trial::rig::{ActuatorRig, Maker, RigSpec};
use crate::trial::rng::TrialRng;

/// Noise of the recorded voltage \[V\]: none, a good recorder, a usual one, a poor one.
const NOISES: [f64; 4] = [0.0, 1e-3, 5e-3, 20e-3];
/// Step of a converter of 8 bits for some +-10 V \[V\].
const STEP_OF_8_BITS: f64 = 80e-3;

pub static RIG: RigSpec = RigSpec {
    id: "voltage-noise",
    about: "both points, 20 nm, 50 kHz; V with 0, 1, 5 or 20 mV of noise, or of 8 bits (80 mV)",
    maker: Maker::Actuator(draw),
};

fn draw(rng: &mut TrialRng) -> ActuatorRig {
    let mut rig = ActuatorRig::usual(rng);
    match NOISES.get(rng.below(NOISES.len() + 1)) {
        Some(noise) => rig.imperfections.voltage_noise = *noise,
        None => rig.imperfections.voltage_step = STEP_OF_8_BITS,
    }
    rig
}
