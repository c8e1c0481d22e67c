//! What a one-mode rig draws from a seed: the device, how it is read, and its runs.

use serde::{Deserialize, Serialize};

use crate::trial::rng::TrialRng;

/// Standard error with which gravity is known, as a share of it: that of the preset `faller`.
const GRAVITY_RELATIVE_ERROR: f64 = 5e-3;

/// A kind of one-mode device: what can be concealed in it, and how it is drawn.
#[derive(Debug)]
pub struct OneModeRig {
    /// Effects of the catalogue.
    pub effects: &'static [&'static str],
    /// Laws outside it.
    pub outside: &'static [&'static str],
    /// Device, readings and runs.
    pub draw: fn(&mut TrialRng) -> Apparatus,
}

/// The device. SI; of a pendulum angles \[rad\] stand for metres and moments of inertia for masses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OneModeDevice {
    /// Mass \[kg\].
    pub mass: f64,
    /// Natural frequency \[Hz\]; zero for a free mass.
    pub frequency: f64,
    /// Damping ratio of the viscous damping.
    pub zeta: f64,
    /// Gravity, where it is the load \[m/s^2\]; else zero.
    pub gravity: f64,
}

/// One run: its start and its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Displacement from equilibrium, or height \[m\].
    pub x: f64,
    /// Velocity \[m/s\].
    pub v: f64,
    /// How long \[s\].
    pub duration: f64,
    /// Whether it is held out.
    pub held_out: bool,
}

/// How the proof mass is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Samples per second.
    pub rate: f64,
    /// Rms of the noise \[m\].
    pub noise: f64,
    /// Step to which readings are rounded \[m\]; zero for none.
    pub step: f64,
    /// Scale of the readings.
    pub scale: f64,
    /// Reading at zero \[m\].
    pub zero: f64,
}

/// A device with its runs and its readings, and what a person knows of it beforehand.
#[derive(Debug, Clone, PartialEq)]
pub struct Apparatus {
    /// What it is called in its preset.
    pub name: &'static str,
    /// The device as it is.
    pub device: OneModeDevice,
    /// The device as its preset has it: weighed, measured, guessed.
    pub nominal: OneModeDevice,
    /// How it is read.
    pub reading: Reading,
    /// The runs.
    pub runs: Vec<Run>,
    /// Whether its restoring force is the sine of the angle if that is concealed: then the swing,
    /// not the law, decides how large the effect is.
    pub swings: bool,
}

impl Apparatus {
    /// Largest displacement at the start of a run \[m\].
    #[must_use]
    pub fn amplitude(&self) -> f64 {
        let omega = self.omega();
        let of = |run: &Run| {
            let lead = if omega > 0.0 { run.v / omega } else { 0.0 };
            run.x.hypot(lead)
        };
        self.runs.iter().map(of).fold(0.0, f64::max)
    }

    /// Angular frequency \[rad/s\].
    #[must_use]
    pub fn omega(&self) -> f64 {
        std::f64::consts::TAU * self.device.frequency
    }

    /// The same, begun with swings `factor` times as large.
    #[must_use]
    pub fn with_swings(&self, factor: f64) -> Self {
        let mut other = self.clone();
        for run in &mut other.runs {
            run.x *= factor;
            run.v *= factor;
        }
        other
    }

    /// Times of the samples of a run \[s\].
    #[must_use]
    pub fn times(&self, run: &Run) -> Vec<f64> {
        let count = (run.duration * self.reading.rate).round() as usize + 1;
        (0..count).map(|i| i as f64 / self.reading.rate).collect()
    }

    /// Standard deviation of a reading \[m\]: its noise and its rounding.
    #[must_use]
    pub fn reading_sigma(&self) -> f64 {
        self.reading.noise.hypot(self.reading.step / 12f64.sqrt())
    }

    /// The preset that a person would write for it: what is known of the device, no effect but
    /// gravity, which is known.
    #[must_use]
    pub fn preset(&self) -> String {
        let OneModeDevice {
            mass,
            frequency,
            zeta,
            gravity,
        } = self.nominal;
        let stiffness = mass * (std::f64::consts::TAU * frequency).powi(2);
        let first = self.runs.first().copied();
        // As read from a ruler, to two digits.
        let start = first.map_or(0.0, |run| two_digits(run.x));
        let duration = first.map_or(1.0, |run| run.duration);
        let reach = 5.0 * self.amplitude().max(1e-9);
        let speed =
            5.0 * (self.amplitude() * self.omega()).max((gravity * self.amplitude()).sqrt());
        let damping = if frequency > 0.0 {
            format!("zeta1 = {zeta:.1e}\n")
        } else {
            String::new()
        };
        let ranges = if frequency > 0.0 {
            format!(
                "f1 = [{:.2e}, {:.2e}]\nzeta1 = [1e-5, 0.3]\n",
                frequency / 5.0,
                frequency * 5.0
            )
        } else {
            String::new()
        };
        let effects = if gravity > 0.0 {
            // A person knows where on earth it falls only roughly.
            let error = GRAVITY_RELATIVE_ERROR * gravity;
            format!(
                "\n[effects.gravity]\ng = {gravity:e}\n\n[known]\n\"gravity.g\" = [{gravity:e}, {error:.1e}]\n"
            )
        } else {
            String::new()
        };
        format!(
            "format = 1\nname = \"{name}\"\nabout = \"{name}, no ground and no drive\"\n\n\
             [start]\ndrive = \"rest\"\nduration = {duration:.2e}\n\n\
             [[mode]]\nmass = {mass:.3e}\nstiffness = {stiffness:.3e}\n\n\
             [device]\nproof_mass = {mass:.3e}\nground = false\ncantilever = false\n\n\
             [parameters]\n{damping}x0 = {start:e}\nv0 = 0.0\n\n\
             [ranges]\n{ranges}x0 = [{:.1e}, {reach:.1e}]\nv0 = [{:.1e}, {speed:.1e}]\n\
             offset_p = [{:.1e}, {reach:.1e}]\nnoise = [0.0, {reach:.1e}]\n{effects}",
            -reach,
            -speed,
            -reach,
            name = self.name,
        )
    }
}

fn two_digits(value: f64) -> f64 {
    // A finite number printed with two digits reads back.
    format!("{value:.1e}").parse().unwrap_or(value)
}
