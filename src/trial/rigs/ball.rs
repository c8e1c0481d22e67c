//! Balls in free fall, from video.

use crate::trial::one_mode::apparatus::{Apparatus, OneModeDevice, OneModeRig, Reading, Run};
use crate::trial::one_mode::law_draws::{GUSTS, QUADRATIC_DRAG};
use crate::trial::rig::{Maker, RigSpec};
use crate::trial::rng::TrialRng;

/// Frames per second.
const VIDEO_RATES: [f64; 5] = [15.0, 30.0, 60.0, 120.0, 240.0];
/// Fewest frames of a fall: with fewer the camera is a faster one.
const MIN_FRAMES: f64 = 40.0;
/// Gravity that the preset states \[m/s^2\].
const STANDARD_GRAVITY: f64 = 9.80665;

pub static RIG: RigSpec = RigSpec {
    id: "ball",
    about: "balls in free fall with and without drag, from video of 15 to 240 frames a second",
    maker: Maker::OneMode(&OneModeRig {
        effects: &[QUADRATIC_DRAG],
        outside: &[GUSTS],
        draw,
    }),
};

fn draw(rng: &mut TrialRng) -> Apparatus {
    let device = OneModeDevice {
        mass: rng.log_between(3e-3, 0.6),
        frequency: 0.0,
        zeta: 0.0,
        gravity: rng.between(9.78, 9.83),
    };
    let height = rng.log_between(1.5, 50.0);
    let wanted = VIDEO_RATES[rng.below(VIDEO_RATES.len())];
    let shortest = (2.0 * 0.8 * height / device.gravity).sqrt();
    let fast_enough = VIDEO_RATES
        .into_iter()
        .find(|rate| *rate >= wanted && rate * shortest >= MIN_FRAMES);
    let run = |rng: &mut TrialRng, held_out| {
        let x = height * rng.between(0.8, 1.0);
        Run {
            x,
            v: 0.3 * rng.between(-1.0, 1.0),
            // Until shortly before the ground.
            duration: 0.95 * (2.0 * x / device.gravity).sqrt(),
            held_out,
        }
    };
    let runs = [false, false, true, true].map(|held_out| run(rng, held_out));
    Apparatus {
        name: "falling ball",
        device,
        nominal: OneModeDevice {
            mass: device.mass * (1.0 + 0.01 * rng.between(-1.0, 1.0)),
            gravity: STANDARD_GRAVITY,
            ..device
        },
        reading: Reading {
            rate: fast_enough.unwrap_or(VIDEO_RATES[VIDEO_RATES.len() - 1]),
            // Half a line to two lines of a picture.
            noise: height * rng.log_between(3e-4, 2e-3),
            step: 0.0,
            scale: 1.0 + 0.005 * rng.between(-1.0, 1.0),
            zero: 0.0,
        },
        runs: runs.into(),
        swings: false,
    }
}
