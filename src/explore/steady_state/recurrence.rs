//! When a transient has come back to where it was.

use std::collections::VecDeque;

use super::coordinates::Scale;
use super::stroboscope::PeriodRecord;
use crate::sim::MotionState;

/// Distances below this share of the tolerance count as none, however they change: they are
/// roundings of the simulation.
const ROUNDING_SHARE: f64 = 1e-2;

/// A response of several periods is not one of fewer if its state then is farther away than so many
/// tolerances.
const DISTINCT_TOLERANCES: f64 = 30.0;

/// A number of periods after which states come back, and how closely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Recurrence {
    /// Periods.
    pub multiple: usize,
    /// Distance of the latest state from that so many periods before.
    pub distance: f64,
    /// Factor by which the distance shrinks over so many periods; 1 or more where it does not, or
    /// where that is not known yet.
    pub contraction: f64,
}

impl Recurrence {
    /// Distance of the latest state from where the transient leads.
    pub fn error(&self) -> f64 {
        if self.contraction < 1.0 {
            self.distance * (self.contraction / (1.0 - self.contraction)).max(1.0)
        } else {
            f64::INFINITY
        }
    }

    /// Whether the latest state is within `tolerance` of where the transient leads.
    pub fn is_within(&self, tolerance: f64) -> bool {
        self.error() <= tolerance || self.distance <= ROUNDING_SHARE * tolerance
    }

    /// Periods until it is, at the present pace.
    pub fn periods_left(&self, tolerance: f64) -> f64 {
        let factor = tolerance / self.error();
        if factor >= 1.0 {
            0.0
        } else {
            self.multiple as f64 * factor.ln() / self.contraction.ln()
        }
    }
}

/// The latest periods of a transient.
#[derive(Debug, Clone)]
pub(super) struct History {
    records: VecDeque<PeriodRecord>,
    latest: MotionState,
    /// Distances over 1, 2, ... periods, of the latest state and of those before.
    distances: VecDeque<Vec<f64>>,
    /// Periods that are kept, and multiples that are looked for.
    kept: usize,
    max_multiple: usize,
}

impl History {
    /// From a first state on.
    pub fn new(start: MotionState, max_multiple: usize, kept: usize) -> Self {
        Self {
            records: VecDeque::new(),
            latest: start,
            distances: VecDeque::new(),
            kept: kept.max(2 * max_multiple),
            max_multiple,
        }
    }

    pub fn latest(&self) -> &MotionState {
        &self.latest
    }

    /// Adds a period that led to `state`. Its scale is that of the latest periods.
    pub fn push(&mut self, record: PeriodRecord, state: MotionState, scale: &mut Scale, mass: f64) {
        if self.records.len() == self.kept {
            self.records.pop_front();
        }
        self.records.push_back(record);
        self.latest = state;
        scale.forget();
        scale.include(&self.latest);
        for record in self.records.iter().rev().take(2 * self.max_multiple) {
            scale.include(&record.start);
            let turns = record.notes.turns.iter().map(|t| t.displacement.abs());
            let reach = turns.fold(0.0, f64::max);
            scale.include_motion(record.notes.top_speed, mass, reach);
        }
        let before = self.records.iter().rev().take(self.max_multiple);
        let distances = before.map(|record| scale.distance(&record.start, &self.latest));
        let distances = distances.collect();
        if self.distances.len() == 2 * self.max_multiple {
            self.distances.pop_front();
        }
        self.distances.push_back(distances);
    }

    /// The recurrence after `multiple` periods, if so many have passed.
    fn recurrence(&self, multiple: usize) -> Option<Recurrence> {
        let over = |back: usize| {
            let row = self.distances.len().checked_sub(1 + back)?;
            self.distances[row].get(multiple - 1).copied()
        };
        let distance = over(0)?;
        let ratio = |before: Option<f64>, turns: i32| {
            let before = before?;
            if before == 0.0 {
                return Some(if distance == 0.0 { 0.0 } else { f64::INFINITY });
            }
            Some((distance / before).powf(1.0 / f64::from(turns)))
        };
        // Over two turns as well: a pair of complex multipliers makes single ones uneven.
        let once = ratio(over(multiple), 1);
        let twice = ratio(over(2 * multiple), 2);
        let contraction = match (once, twice) {
            (Some(a), Some(b)) => a.max(b),
            (Some(a), None) => a,
            (None, _) => f64::INFINITY,
        };
        Some(Recurrence {
            multiple,
            distance,
            contraction,
        })
    }

    /// The fewest periods after which the response repeats within `tolerance`, once it is clear that
    /// it does not after fewer.
    pub fn found(&self, tolerance: f64) -> Option<Recurrence> {
        let mut all = (1..=self.max_multiple).filter_map(|n| self.recurrence(n));
        let found = all.find(|r| r.is_within(tolerance))?;
        let parts = (1..found.multiple).filter(|m| found.multiple.is_multiple_of(*m));
        let apart = parts.filter_map(|m| self.recurrence(m));
        let nearest = apart.fold(f64::INFINITY, |a, r| a.min(r.distance));
        let is_clear = nearest > DISTINCT_TOLERANCES * tolerance
            || found.distance <= ROUNDING_SHARE * tolerance;
        is_clear.then_some(found)
    }

    /// The recurrence that comes closest.
    pub fn closest(&self) -> Option<Recurrence> {
        let all = (1..=self.max_multiple).filter_map(|n| self.recurrence(n));
        all.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Whether the last `multiple` periods had the events of those before.
    pub fn repeats_events(&self, multiple: usize) -> bool {
        let n = self.records.len();
        n >= 2 * multiple
            && (n - multiple..n).all(|i| self.records[i].has_events_of(&self.records[i - multiple]))
    }

    /// The last `count` periods.
    pub fn last(&self, count: usize) -> Vec<PeriodRecord> {
        let from = self.records.len().saturating_sub(count);
        self.records.range(from..).cloned().collect()
    }
}
