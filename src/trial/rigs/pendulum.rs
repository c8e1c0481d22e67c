//! Pendulums, their angle read by an encoder or from video. Without the sine it is one that a wire
//! or two threads turn back, in proportion to the angle.

use crate::trial::one_mode::apparatus::{Apparatus, OneModeDevice, OneModeRig, Reading, Run};
use crate::trial::one_mode::law_draws::{
    DRY_FRICTION, GUSTS, PUMPED_STIFFNESS, QUADRATIC_DRAG, SINE_STIFFNESS,
};
use crate::trial::rig::{Maker, RigSpec};
use crate::trial::rng::TrialRng;

/// Samples per second of encoders and cameras.
const RATES: [f64; 4] = [25.0, 30.0, 50.0, 60.0];

pub static RIG: RigSpec = RigSpec {
    id: "pendulum",
    about: "pendulums in free decay, angle read at 25 to 60 Hz",
    maker: Maker::OneMode(&OneModeRig {
        effects: &[QUADRATIC_DRAG, DRY_FRICTION, SINE_STIFFNESS],
        outside: &[PUMPED_STIFFNESS, GUSTS],
        draw,
    }),
};

fn draw(rng: &mut TrialRng) -> Apparatus {
    let device = OneModeDevice {
        mass: 1.0,
        frequency: rng.log_between(0.4, 1.2),
        zeta: rng.log_between(1e-3, 1e-2),
        gravity: 0.0,
    };
    let amplitude = rng.between(0.2, 0.8);
    let run = |rng: &mut TrialRng, held_out| Run {
        x: amplitude * rng.sign() * rng.between(0.6, 1.0),
        v: 0.0,
        duration: rng.between(30.0, 60.0),
        held_out,
    };
    let runs = [false, false, true, true].map(|held_out| run(rng, held_out));
    Apparatus {
        name: "pendulum",
        device,
        nominal: OneModeDevice {
            frequency: device.frequency * (1.0 + 0.02 * rng.between(-1.0, 1.0)),
            zeta: device.zeta * rng.log_between(0.4, 2.5),
            ..device
        },
        reading: Reading {
            rate: RATES[rng.below(RATES.len())],
            noise: rng.log_between(5e-4, 5e-3),
            step: 4.4e-4,
            scale: 1.0 + 0.005 * rng.between(-1.0, 1.0),
            zero: 0.02 * rng.between(-1.0, 1.0),
        },
        runs: runs.into(),
        swings: true,
    }
}
