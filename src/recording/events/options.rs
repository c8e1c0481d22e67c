//! How events are looked for: the contact level, the noise and the height of a hop.

use crate::recording::grid::TimeAxis;
use crate::recording::noise::estimate_noise;

/// Departures up to this height do not end a contact \[m\] (Table A.1's features).
pub const HOP_HEIGHT: f64 = 5e-6;

/// Flattest thing that counts as touching, where there is no noise \[m\].
const MIN_TOLERANCE: f64 = 5e-8;

/// How events are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventOptions {
    /// Height of the mass at contact \[m\], `-dp` in the model.
    pub contact_level: f64,
    /// Standard deviation of the noise \[m\].
    pub noise: f64,
    /// Departures up to this height do not end a contact \[m\].
    pub hop: f64,
}

impl EventOptions {
    /// Options for a level; the noise is estimated from the data.
    #[must_use]
    pub fn for_data(contact_level: f64, time: TimeAxis, xp: &[f64]) -> Self {
        Self {
            contact_level,
            noise: estimate_noise(time, xp).map_or(0.0, |n| n.sigma),
            hop: HOP_HEIGHT,
        }
    }

    /// How far from the level still counts as touching \[m\].
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        (4.0 * self.noise).max(MIN_TOLERANCE)
    }

    /// The hop height, kept clear of the noise \[m\].
    pub(super) fn clear_hop(&self) -> f64 {
        self.hop.max(2.0 * self.tolerance())
    }
}
