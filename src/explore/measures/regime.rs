//! In which of a few ways a device taps the ground.

use crate::explore::steady_state::{Cycle, ResponseKind, SteadyResponse};
use crate::sim::{EventKind, MotionPhase};

/// What the mass does on the ground in one period of its response. A response of several periods of
/// the drive is classed by its whole cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Regime {
    /// It never touches the ground.
    NoContact,
    /// It bounces once a period of the drive, or less often, and never stays.
    TapsOnce,
    /// It bounces so many times a period of the drive, and never stays. Rounded up for a response of
    /// several periods.
    Bounces(u32),
    /// It bounces before it stays.
    BouncesThenSticks,
    /// It stays at once.
    Sticks,
    /// It stays on the ground for ever.
    NeverLetsGo,
    /// There is no periodic response.
    NotPeriodic,
}

/// Bounces that have a class of their own; more count as so many.
const MOST_BOUNCES_TOLD: u32 = 20;

impl Regime {
    /// Of a response.
    #[must_use]
    pub fn of(response: &SteadyResponse) -> Self {
        match response.kind {
            ResponseKind::NotPeriodic(_) => Self::NotPeriodic,
            ResponseKind::Periodic { .. } => Self::of_cycle(&response.cycle),
        }
    }

    /// Of one cycle of a periodic response.
    fn of_cycle(cycle: &Cycle) -> Self {
        let count = |kind| cycle.events.iter().filter(|e| e.kind == kind).count();
        let (bounces, sticks) = (count(EventKind::Impact), count(EventKind::Stick));
        let begins_in_contact = begins_in_contact(cycle);
        match (bounces, sticks) {
            (0, 0) if begins_in_contact => Self::NeverLetsGo,
            (0, 0) => Self::NoContact,
            (0, _) => Self::Sticks,
            (n, 0) => {
                let each = n.div_ceil(cycle.periods.max(1));
                match u32::try_from(each).unwrap_or(MOST_BOUNCES_TOLD) {
                    1 => Self::TapsOnce,
                    many => Self::Bounces(many.min(MOST_BOUNCES_TOLD)),
                }
            }
            (_, _) => Self::BouncesThenSticks,
        }
    }

    /// A number for files and colours: categories in the order of growing contact.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::NoContact => 0,
            Self::TapsOnce => 1,
            Self::Bounces(n) => n,
            Self::BouncesThenSticks => MOST_BOUNCES_TOLD + 1,
            Self::Sticks => MOST_BOUNCES_TOLD + 2,
            Self::NeverLetsGo => MOST_BOUNCES_TOLD + 3,
            Self::NotPeriodic => MOST_BOUNCES_TOLD + 4,
        }
    }

    /// The category of a code.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        const LAST_COUNT: u32 = MOST_BOUNCES_TOLD;
        Some(match code {
            0 => Self::NoContact,
            1 => Self::TapsOnce,
            2..=LAST_COUNT => Self::Bounces(code),
            _ => match code - LAST_COUNT {
                1 => Self::BouncesThenSticks,
                2 => Self::Sticks,
                3 => Self::NeverLetsGo,
                4 => Self::NotPeriodic,
                _ => return None,
            },
        })
    }

    /// In words.
    #[must_use]
    pub fn label(self) -> String {
        match self {
            Self::NoContact => "no contact".to_owned(),
            Self::TapsOnce => "taps once".to_owned(),
            Self::Bounces(n) if n >= MOST_BOUNCES_TOLD => format!("{n} bounces or more"),
            Self::Bounces(n) => format!("{n} bounces"),
            Self::BouncesThenSticks => "bounces, then sticks".to_owned(),
            Self::Sticks => "sticks".to_owned(),
            Self::NeverLetsGo => "never lets go".to_owned(),
            Self::NotPeriodic => "not periodic".to_owned(),
        }
    }
}

/// Whether the mass is on the ground at the start of the cycle.
pub(super) fn begins_in_contact(cycle: &Cycle) -> bool {
    matches!(cycle.start.phase, MotionPhase::Held { .. }) || cycle.start.sunk.is_some()
}
