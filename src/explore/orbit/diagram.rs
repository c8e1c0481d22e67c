//! The diagram, value by value.

use crate::explore::map::Axis;
use crate::explore::measures::Regime;
use crate::explore::steady_state::{SteadyResponse, StrobePoint};
use crate::sim::EventKind;

/// Which way a value was come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From the axis' first value to its last.
    Up,
    /// Back.
    Down,
}

/// What is drawn over one value.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitAnswer {
    /// How the mass meets the ground.
    pub regime: Regime,
    /// Periods of the drive after which it repeats; `None` if it does not.
    pub multiple: Option<usize>,
    /// The mass at each strobe of the cycle: as many as periods.
    pub strobes: Vec<StrobePoint>,
    /// Speeds of arrival over the cycle [m/s].
    pub impact_speeds: Vec<f64>,
    /// Bounces in each period of the cycle.
    pub bounces: Vec<usize>,
    /// Largest Lyapunov exponent \[1/period of the drive\]; `None` if it was not asked for, or no
    /// neighbour can be made, such as of a mass that never moves.
    pub lyapunov: Option<f64>,
    /// Why the state before was not carried along, and the value began from rest; `None` if it was.
    pub began_anew: Option<String>,
}

impl OrbitAnswer {
    pub(super) fn of(response: &SteadyResponse) -> Self {
        let cycle = &response.cycle;
        let mut bounces = vec![0; cycle.periods];
        let impacts = cycle.events.iter().filter(|e| e.kind == EventKind::Impact);
        for impact in impacts {
            let period = (impact.time / response.period).floor().max(0.0) as usize;
            if let Some(count) = bounces.get_mut(period.min(cycle.periods.saturating_sub(1))) {
                *count += 1;
            }
        }
        Self {
            regime: Regime::of(response),
            multiple: response.multiple(),
            strobes: cycle.strobes.clone(),
            impact_speeds: cycle.arrivals.iter().map(|a| a.speed).collect(),
            bounces,
            lyapunov: None,
            began_anew: None,
        }
    }
}

/// One value of the axis, one way.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitSlice {
    /// Which way.
    pub direction: Direction,
    /// Index on the axis.
    pub index: usize,
    /// Value of the axis.
    pub value: f64,
    /// What is drawn, or why the value is impossible.
    pub answer: Result<OrbitAnswer, String>,
}

/// Both ways. What was cancelled is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitDiagram {
    /// The axis.
    pub axis: Axis,
    /// From the first value on.
    pub up: Vec<OrbitSlice>,
    /// From the last value back; empty if it was not asked for.
    pub down: Vec<OrbitSlice>,
}

impl OrbitDiagram {
    /// Indices at which both ways lead to different responses: another regime or period, or strobes that
    /// differ by more than `share` of the diagram's extent.
    #[must_use]
    pub fn coexisting(&self, share: f64) -> Vec<usize> {
        let own = self.up.iter().chain(&self.down);
        let answers = own.filter_map(|slice| slice.answer.as_ref().ok());
        let all = answers
            .flat_map(|answer| &answer.strobes)
            .map(|s| s.displacement);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let tolerance = share * (high - low).max(0.0);
        let differs = |a: &OrbitAnswer, b: &OrbitAnswer| {
            if a.regime != b.regime || a.multiple != b.multiple {
                return true;
            }
            let order = |answer: &OrbitAnswer| {
                let mut all: Vec<f64> = answer.strobes.iter().map(|s| s.displacement).collect();
                all.sort_by(f64::total_cmp);
                all
            };
            // The strobes of a response without period differ each time.
            a.multiple.is_some()
                && order(a)
                    .iter()
                    .zip(order(b))
                    .any(|(a, b)| (a - b).abs() > tolerance)
        };
        let pairs = self.up.iter().filter_map(|up| {
            let down = self.down.iter().find(|down| down.index == up.index)?;
            Some((
                up.index,
                up.answer.as_ref().ok()?,
                down.answer.as_ref().ok()?,
            ))
        });
        pairs
            .filter(|(_, a, b)| differs(a, b))
            .map(|(index, _, _)| index)
            .collect()
    }
}
