//! How far a cycle is from one with other events.

use super::regime::begins_in_contact;
use crate::explore::steady_state::{Cycle, SteadyResponse};
use crate::sim::EventKind;

/// What would change next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MarginKind {
    /// Nothing is near: without ground, or never over it.
    Nothing,
    /// An arrival at the ground would be missed.
    MissedArrival,
    /// A low turn would become an arrival.
    NewArrival,
    /// A bounce would become a contact that lasts, or the reverse.
    BounceOrStick,
    /// The contact that lasts for ever would end.
    Release,
}

impl MarginKind {
    /// In words.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Nothing => "nothing near",
            Self::MissedArrival => "an arrival is lost",
            Self::NewArrival => "an arrival is gained",
            Self::BounceOrStick => "a bounce sticks, or a contact bounces",
            Self::Release => "the contact ends",
        }
    }
}

/// Distance to the nearest change of regime, without units: 0 is at the change. Speeds of arrival as
/// a share of the largest speed of the flight before; square roots of the heights of low turns as a
/// share of the largest height, which grow as those speeds do; pull-off forces or speeds from the
/// limit at which the mass sticks, and forces from the adhesion, as shares of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// The least of them; infinite if nothing is near.
    pub distance: f64,
    /// Which it is.
    pub kind: MarginKind,
}

impl Margin {
    /// Of a response.
    #[must_use]
    pub fn of(response: &SteadyResponse) -> Self {
        let (cycle, grazing) = (&response.cycle, &response.grazing);
        let decisions = cycle.arrivals.iter().map(|a| a.decision_share);
        let candidates = [
            (grazing.least_speed_share, MarginKind::MissedArrival),
            (grazing.least_height_share.sqrt(), MarginKind::NewArrival),
            (
                decisions.fold(f64::INFINITY, f64::min),
                MarginKind::BounceOrStick,
            ),
            (hold_share(cycle), MarginKind::Release),
        ];
        let nothing = Self {
            distance: f64::INFINITY,
            kind: MarginKind::Nothing,
        };
        candidates
            .into_iter()
            .fold(nothing, |least, (distance, kind)| {
                if distance < least.distance {
                    Self { distance, kind }
                } else {
                    least
                }
            })
    }
}

/// What the adhesion of a contact without end could still hold, as a share of it.
fn hold_share(cycle: &Cycle) -> f64 {
    let ends = cycle.events.iter().any(|e| e.kind == EventKind::Release);
    if begins_in_contact(cycle) && !ends {
        cycle.least_hold_share
    } else {
        f64::INFINITY
    }
}
