//! How events are looked for: the contact level, the noise and the height of a hop.

use crate::recording::grid::TimeAxis;
use crate::recording::noise::estimate_noise;
use crate::recording::statistics::extremes;

/// Departures up to this height do not end a contact \[m\] (Table A.1's features).
pub const HOP_HEIGHT: f64 = 5e-6;

/// Least and most of that height as shares of the travel: a device that moves by other lengths than
/// the paper's has other hops. Travels of 50 to 250 um keep the paper's height.
const HOP_TRAVEL_SHARES: (f64, f64) = (0.02, 0.1);

/// Departures that do not end a contact in a motion over `travel` \[m\].
#[must_use]
pub fn hop_height(travel: f64) -> f64 {
    if !(travel > 0.0 && travel.is_finite()) {
        return HOP_HEIGHT;
    }
    let (least, most) = HOP_TRAVEL_SHARES;
    HOP_HEIGHT.max(least * travel).min(most * travel)
}

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
        let noise = estimate_noise(time, xp).map_or(0.0, |n| n.sigma);
        Self::for_travel(contact_level, noise, xp)
    }

    /// Options for a level and a noise \[m\] in `xp`, whose travel decides what a hop is.
    #[must_use]
    pub fn for_travel(contact_level: f64, noise: f64, xp: &[f64]) -> Self {
        let (low, high) = extremes(xp);
        Self {
            contact_level,
            noise,
            hop: hop_height(high - low),
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
