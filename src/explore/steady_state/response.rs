//! The answer: kind of response, one cycle of it, stability, closeness to grazing.

use nalgebra::Complex;

use super::grazing::Grazing;
use crate::sim::{Arrival, Event, MotionState, Turn};

/// Periodic or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ResponseKind {
    /// It repeats after `multiple` periods of the drive, and not before.
    Periodic {
        /// Number of periods of the drive.
        multiple: usize,
    },
    /// It did not repeat.
    NotPeriodic(Aperiodicity),
}

/// What is known of a response that did not repeat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aperiodicity {
    /// Neighbouring responses part: by a factor `e` each `1 / exponent` periods of the drive.
    Chaotic {
        /// Largest Lyapunov exponent \[1/period\].
        exponent: f64,
    },
    /// Neighbouring responses do not part clearly: a slow transient, a quasi-periodic response, or
    /// one of more periods than were looked for.
    Undetermined {
        /// Largest Lyapunov exponent \[1/period\], if it was asked for.
        exponent: Option<f64>,
    },
}

/// How the answer was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The transient came to it.
    Transient,
    /// Newton's method on the map.
    Shooting,
}

/// Stability of a periodic response.
#[derive(Debug, Clone, PartialEq)]
pub enum Stability {
    /// Multipliers of the map over the response's cycle, in falling order of their modulus. Smaller
    /// than 1 is stable.
    Multipliers(Vec<Complex<f64>>),
    /// Near grazing, or where a change as small as those of the differences changes the sequence of
    /// events, the map has no Jacobian to rely on. That a transient came here shows that it attracts.
    NotSmooth,
    /// Not asked for, or not periodic.
    NotComputed,
}

impl Stability {
    /// Largest modulus of the multipliers, if there are any.
    #[must_use]
    pub fn largest_modulus(&self) -> Option<f64> {
        match self {
            Self::Multipliers(all) => all.first().map(|m| m.norm()),
            Self::NotSmooth | Self::NotComputed => None,
        }
    }
}

/// The proof mass at one strobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrobePoint {
    /// Displacement, without the sensor's offset \[m\].
    pub displacement: f64,
    /// Velocity [m/s].
    pub velocity: f64,
}

/// One cycle of the response, from a strobe on. Times count from its start \[s\].
#[derive(Debug, Clone, PartialEq)]
pub struct Cycle {
    /// State at the start.
    pub start: MotionState,
    /// Whole periods of the drive.
    pub periods: usize,
    /// Length \[s\].
    pub duration: f64,
    /// Events in order of time; steps of the drive are among them.
    pub events: Vec<Event>,
    /// Where the mass turns in flight, in order of time.
    pub turns: Vec<Turn>,
    /// How it arrives at the ground, in order of time.
    pub arrivals: Vec<Arrival>,
    /// The mass at each strobe; the first is the cycle's start.
    pub strobes: Vec<StrobePoint>,
    /// Largest speed of the mass [m/s].
    pub top_speed: f64,
    /// Highest displacement of the mass, without the sensor's offset \[m\].
    pub highest: f64,
    /// Lowest displacement \[m\].
    pub lowest: f64,
    /// Least share of the adhesion that was still unused in contacts; infinite without contact.
    pub least_hold_share: f64,
    /// Level of the ground at the start \[m\]; minus infinity without one.
    pub ground_level: f64,
    /// Mass that an impulse on the proof mass moves \[kg\].
    pub impact_mass: f64,
    /// Whether the mass sinks into the ground: it then arrives without an impact.
    pub has_compliant_ground: bool,
}

impl Cycle {
    /// Lowest and highest displacement apart \[m\].
    #[must_use]
    pub fn span(&self) -> f64 {
        self.highest - self.lowest
    }
}

/// The steady response of a device under a periodic drive.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyResponse {
    /// Periodic or not.
    pub kind: ResponseKind,
    /// The drive's period \[s\].
    pub period: f64,
    /// One cycle; the last periods where it is not periodic. Its `start` can start a neighbour.
    pub cycle: Cycle,
    /// How it was found.
    pub method: Method,
    /// Distance of the cycle's end from its start, as a share of the response's amplitude.
    pub residual: f64,
    /// Multipliers.
    pub stability: Stability,
    /// Closeness to grazing.
    pub grazing: Grazing,
    /// Device time that was simulated \[s\].
    pub device_seconds: f64,
    /// Periods of the drive from the start to the answer, without those of derivatives.
    pub periods_followed: usize,
}

impl SteadyResponse {
    /// Number of periods of the drive after which it repeats; `None` if it does not.
    #[must_use]
    pub fn multiple(&self) -> Option<usize> {
        match self.kind {
            ResponseKind::Periodic { multiple } => Some(multiple),
            ResponseKind::NotPeriodic(_) => None,
        }
    }
}
