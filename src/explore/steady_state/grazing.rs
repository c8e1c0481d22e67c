//! How close a cycle comes to grazing.

use crate::sim::{Arrival, Turn};

/// Below this closeness a response counts as near grazing. The square root of the map then bends
/// within 1.4 % of the speed of the flight.
const NEAR_GRAZING: f64 = 1e-4;

/// Closeness to grazing, without units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grazing {
    /// The least, over the cycle, of half the squared speed of arrival over the largest speed of the
    /// flight before, and of the height of a low turn over the largest height. Both say how far the
    /// mass would have to move, as a share of its way, to just touch the ground. Infinite without
    /// ground.
    pub closeness: f64,
    /// Least speed of arrival over the largest speed of the flight before; infinite without
    /// arrivals. A hop falls as fast as it rises, and so counts as far from grazing.
    pub least_speed_share: f64,
    /// Least height of a low turn over the largest height; infinite without one.
    pub least_height_share: f64,
}

impl Grazing {
    /// From the arrivals and turns of a cycle, over a ground at `level` \[m\] and under its highest
    /// displacement \[m\].
    pub(super) fn of(arrivals: &[Arrival], turns: &[Turn], level: f64, highest: f64) -> Self {
        let shares = arrivals.iter().map(|a| {
            if a.fastest > 0.0 {
                a.speed / a.fastest
            } else {
                0.0
            }
        });
        let least_speed_share = shares.fold(f64::INFINITY, f64::min);
        let lows = turns.iter().filter(|turn| turn.is_low);
        let least_height_share = if level.is_finite() && highest > level {
            let heights = lows.map(|turn| ((turn.displacement - level) / (highest - level)).abs());
            heights.fold(f64::INFINITY, f64::min)
        } else {
            f64::INFINITY
        };
        Self {
            closeness: (0.5 * least_speed_share * least_speed_share).min(least_height_share),
            least_speed_share,
            least_height_share,
        }
    }

    /// Whether the map's square root may be felt.
    #[must_use]
    pub fn is_near(&self) -> bool {
        self.closeness < NEAR_GRAZING
    }
}
