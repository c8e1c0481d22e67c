//! Responses told apart by their states at the strobe.

use crate::explore::measures::Regime;
use crate::explore::steady_state::{ResponseKind, SteadyResponse, StrobePoint};

/// A response to which beginnings lead.
#[derive(Debug, Clone, PartialEq)]
pub struct BasinResponse {
    /// How the mass meets the ground.
    pub regime: Regime,
    /// Periods of the drive after which it repeats; `None` for all that do not repeat.
    pub multiple: Option<usize>,
    /// The mass at each strobe of its cycle; of those that do not repeat, of one of them.
    pub strobes: Vec<StrobePoint>,
    /// Index of the first beginning that led to it.
    pub first: usize,
    /// Beginnings that lead to it.
    pub count: usize,
    /// Their share of all that led anywhere.
    pub share: f64,
}

/// What tells a response.
#[derive(Debug, Clone)]
pub(super) struct Signature {
    regime: Regime,
    kind: ResponseKind,
    strobes: Vec<StrobePoint>,
    span: f64,
    top_speed: f64,
}

impl Signature {
    pub fn of(response: &SteadyResponse) -> Self {
        Self {
            regime: Regime::of(response),
            kind: response.kind,
            strobes: response.cycle.strobes.clone(),
            span: response.cycle.span(),
            top_speed: response.cycle.top_speed,
        }
    }

    fn multiple(&self) -> Option<usize> {
        match self.kind {
            ResponseKind::Periodic { multiple } => Some(multiple),
            ResponseKind::NotPeriodic(_) => None,
        }
    }

    pub fn response(&self, first: usize) -> BasinResponse {
        BasinResponse {
            regime: self.regime,
            multiple: self.multiple(),
            strobes: self.strobes.clone(),
            first,
            count: 0,
            share: 0.0,
        }
    }

    /// Whether both are one response: the same period, and strobes within `tolerance` of the
    /// responses' size, from one of the cycle's periods on.
    pub fn is_one_with(&self, other: &Self, tolerance: f64) -> bool {
        let (Some(own), Some(others)) = (self.multiple(), other.multiple()) else {
            return self.multiple() == other.multiple();
        };
        if own != others || self.strobes.len() != other.strobes.len() {
            return false;
        }
        let span = tolerance * self.span.max(other.span);
        let speed = tolerance * self.top_speed.max(other.top_speed);
        let is_near = |a: &StrobePoint, b: &StrobePoint| {
            (a.displacement - b.displacement).abs() <= span
                && (a.velocity - b.velocity).abs() <= speed
        };
        (0..own).any(|shift| {
            let shifted = other.strobes.iter().cycle().skip(shift);
            self.strobes.iter().zip(shifted).all(|(a, b)| is_near(a, b))
        })
    }
}
