//! A mass on a spring in free decay, read by a sonar or a laser at 100 Hz.

use crate::trial::one_mode::apparatus::{Apparatus, OneModeDevice, OneModeRig, Reading, Run};
use crate::trial::one_mode::law_draws::{
    CUBIC_STIFFNESS, DRY_FRICTION, EVEN_STIFFNESS, GUSTS, LOAD_FRICTION, NEGATIVE_DAMPING,
    PUMPED_STIFFNESS, QUADRATIC_DRAG, SINE_STIFFNESS,
};
use crate::trial::rig::{Maker, RigSpec};
use crate::trial::rng::TrialRng;

/// Steps of the readings \[m\]: a laser, a good sonar, a plain sonar.
const READING_STEPS: [f64; 3] = [1e-4, 1e-3, 1e-2];

pub static RIG: RigSpec = RigSpec {
    id: "spring",
    about: "a mass on a spring in free decay, read at 100 Hz in steps of 0.1, 1 or 10 mm",
    maker: Maker::OneMode(&OneModeRig {
        effects: &[
            QUADRATIC_DRAG,
            DRY_FRICTION,
            LOAD_FRICTION,
            CUBIC_STIFFNESS,
            EVEN_STIFFNESS,
            SINE_STIFFNESS,
        ],
        outside: &[NEGATIVE_DAMPING, PUMPED_STIFFNESS, GUSTS],
        draw,
    }),
};

fn draw(rng: &mut TrialRng) -> Apparatus {
    let device = OneModeDevice {
        mass: rng.log_between(0.05, 1.0),
        frequency: rng.log_between(0.7, 3.0),
        zeta: rng.log_between(1e-3, 1e-2),
        gravity: 0.0,
    };
    let amplitude = rng.between(0.05, 0.15);
    let run = |rng: &mut TrialRng, held_out| Run {
        x: amplitude * rng.sign() * rng.between(0.5, 1.0),
        v: amplitude * device.frequency * rng.between(-1.0, 1.0),
        duration: rng.between(25.0, 35.0),
        held_out,
    };
    let runs = [false, false, true, true].map(|held_out| run(rng, held_out));
    Apparatus {
        name: "mass on a spring",
        device,
        nominal: OneModeDevice {
            // Weighed to 1 %; its frequency counted to 2 %; its damping guessed.
            mass: device.mass * (1.0 + 0.01 * rng.between(-1.0, 1.0)),
            frequency: device.frequency * (1.0 + 0.02 * rng.between(-1.0, 1.0)),
            zeta: device.zeta * rng.log_between(0.4, 2.5),
            gravity: 0.0,
        },
        reading: Reading {
            rate: 100.0,
            noise: rng.log_between(2e-4, 2e-3),
            step: READING_STEPS[rng.below(READING_STEPS.len())],
            scale: 1.0 + 0.01 * rng.between(-1.0, 1.0),
            zero: rng.between(0.2, 0.6),
        },
        runs: runs.into(),
        swings: false,
    }
}
