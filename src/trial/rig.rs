//! What a rig is: a kind of device with the instruments that it is read by.

use super::instrument::{Imperfections, StructureKind};
use super::one_mode::apparatus::OneModeRig;
use super::rescale::UnitFactors;
use super::rng::TrialRng;

/// An impact actuator and its instruments, as one seed has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActuatorRig {
    /// The kind of device; drawn if `None`.
    pub structure: Option<StructureKind>,
    /// Whether the cantilever is read together with the proof mass.
    pub cantilever: bool,
    /// Rms of the noise of a reading \[m\].
    pub noise: f64,
    /// Samples per second.
    pub rate: f64,
    /// By how much more than usual the clocks of voltage and readings may be apart.
    pub skew_stretch: f64,
    /// What else the instruments do.
    pub imperfections: Imperfections,
}

/// Clocks of the rigs may be 10 us apart, those of [`super::instrument::instruments`] 8 us.
pub const SKEW_STRETCH: f64 = 10.0 / 8.0;
/// Largest share by which a recorder samples faster or slower than it says: 300 ppm.
const LARGEST_CLOCK_ERROR: f64 = 3e-4;
/// Largest rms error of the written times over the interval between samples: with more, neighbours
/// could change places.
const LARGEST_JITTER_SHARE: f64 = 0.1;

impl ActuatorRig {
    /// Both points of a lumped device with 20 nm of noise at 50 kHz; clocks as [`Self::clocks`].
    #[must_use]
    pub fn usual(rng: &mut TrialRng) -> Self {
        let mut rig = Self {
            structure: Some(StructureKind::Lumped),
            cantilever: true,
            noise: 20e-9,
            rate: 50e3,
            skew_stretch: SKEW_STRETCH,
            imperfections: Imperfections::default(),
        };
        rig.clocks(rng);
        rig
    }

    /// Draws how far the recorder's clock is off.
    fn clocks(&mut self, rng: &mut TrialRng) {
        self.imperfections.clock_error = rng.between(-LARGEST_CLOCK_ERROR, LARGEST_CLOCK_ERROR);
    }

    /// Draws sampling rate and noise: 12.5, 25, 50 or 100 kHz, 20 to 150 nm. Every second one
    /// writes its times with an error of 1 to 3 us.
    pub fn vary(&mut self, rng: &mut TrialRng) {
        // Seldom 12.5 kHz: the second mode is hardly sampled then.
        self.rate = [12.5e3, 25e3, 25e3, 50e3, 50e3, 100e3, 100e3][rng.below(7)];
        self.noise = rng.log_between(20e-9, 150e-9);
        if rng.happens(0.5) {
            let jitter = rng.between(1e-6, 3e-6);
            self.imperfections.stamp_jitter = jitter.min(LARGEST_JITTER_SHARE / self.rate);
        }
    }
}

/// Who makes the recordings of a rig.
#[derive(Debug, Clone, Copy)]
pub enum Maker {
    /// An impact actuator, drawn by the function.
    Actuator(fn(&mut TrialRng) -> ActuatorRig),
    /// A mass with one mode at most, without ground and drive.
    OneMode(&'static OneModeRig),
    /// One of these rigs, in other units.
    InOtherUnits(
        &'static [&'static RigSpec],
        fn(&mut TrialRng) -> UnitFactors,
    ),
}

/// A kind of device with its instruments: one file in `rigs`, one line in its table.
#[derive(Debug, Clone, Copy)]
pub struct RigSpec {
    /// As typed: `both-points`.
    pub id: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    /// Who makes its recordings.
    pub maker: Maker,
}

impl RigSpec {
    /// Whether several effects at once can be concealed in this rig.
    #[must_use]
    pub fn conceals_two(&self) -> bool {
        match self.maker {
            Maker::Actuator(_) => true,
            Maker::OneMode(rig) => rig.effects.len() > 1,
            Maker::InOtherUnits(rigs, _) => rigs.iter().any(|rig| rig.conceals_two()),
        }
    }

    /// Whether the effect `id` can be concealed in this rig; `of_actuators` are those that an impact
    /// actuator can have.
    #[must_use]
    pub fn conceals(&self, id: &str, of_actuators: &[&str]) -> bool {
        match self.maker {
            Maker::Actuator(_) => of_actuators.contains(&id),
            Maker::OneMode(rig) => rig.effects.contains(&id) || rig.outside.contains(&id),
            Maker::InOtherUnits(rigs, _) => rigs.iter().any(|rig| rig.conceals(id, of_actuators)),
        }
    }
}
