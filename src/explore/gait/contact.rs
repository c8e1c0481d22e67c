//! One foot: when it is down.

use super::error::GaitError;

/// A cycle is a whole number of the drive's periods within this share of one.
const WHOLE_PERIODS: f64 = 1e-6;

/// Contacts with less than this share of the common cycle between them are one; shorter parts are
/// rounding.
pub(super) const SAME_INSTANT: f64 = 1e-12;

/// A contact may be longer than the cycle by this share through rounding.
const LENGTH_SLACK: f64 = 1e-9;

/// The contacts of a foot over one cycle of its steady response.
#[derive(Debug, Clone, PartialEq)]
pub struct Foot {
    /// What a person calls it.
    pub name: String,
    /// By how much its drive is later, as a share of the drive's period.
    pub delay: f64,
    /// Length of its cycle \[s\]: the drive's period, or several of them.
    pub cycle: f64,
    /// Begin and end \[s\] of each contact, counted from the start of its own drive's period. One
    /// that goes on over the end of the cycle ends after it. None is a foot that never touches;
    /// one from 0 to `cycle` is a foot that never lets go.
    pub contacts: Vec<(f64, f64)>,
}

/// A part of the common cycle in which a foot is down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Begin, as a share of the common cycle.
    pub start: f64,
    /// End.
    pub end: f64,
    /// Whether the contact began before the cycle's start.
    pub is_from_before: bool,
    /// Whether it goes on after the cycle's end.
    pub goes_on: bool,
}

impl Foot {
    fn fail(&self, reason: String) -> GaitError {
        GaitError::Foot {
            foot: self.name.clone(),
            reason,
        }
    }

    /// Checks delay and contacts; returns the periods of the drive in a cycle.
    pub(super) fn periods(&self, period: f64) -> Result<u64, GaitError> {
        if !self.delay.is_finite() {
            return Err(self.fail(format!("a delay of {} is no number", self.delay)));
        }
        let ratio = self.cycle / period;
        let periods = ratio.round();
        if !(ratio.is_finite() && periods >= 1.0 && (ratio - periods).abs() <= WHOLE_PERIODS) {
            return Err(self.fail(format!(
                "its cycle of {} s is no whole number of the drive's periods of {period} s, so it does not repeat with the drive; choose a drive under which it does",
                self.cycle
            )));
        }
        for &(start, end) in &self.contacts {
            if !(start.is_finite() && end.is_finite() && start <= end) {
                return Err(self.fail(format!(
                    "a contact from {start} s to {end} s; its end must come after its begin"
                )));
            }
            if end - start > self.cycle * (1.0 + LENGTH_SLACK) {
                return Err(self.fail(format!(
                    "a contact from {start} s to {end} s is longer than the cycle of {} s; a foot that never lets go is down from 0 to its cycle",
                    self.cycle
                )));
            }
        }
        Ok(periods as u64)
    }

    /// The bars in a common cycle of `common` periods of the drive, in order of time; `own` is how
    /// many its cycle has.
    pub(super) fn bars(&self, own: u64, common: u64) -> Vec<Bar> {
        let common = common as f64;
        let repetitions = (common / own as f64).round() as u64;
        let mut parts: Vec<(f64, f64)> = Vec::new();
        for &(start, end) in &self.contacts {
            // In periods; the cycle's own length takes up the rounding of its period.
            let scale = own as f64 / self.cycle;
            let length = (end - start) * scale / common;
            if length >= own as f64 / common - SAME_INSTANT {
                return vec![Bar {
                    start: 0.0,
                    end: 1.0,
                    is_from_before: true,
                    goes_on: true,
                }];
            }
            for k in 0..repetitions {
                let at = start * scale + self.delay + (k * own) as f64;
                let from = (at / common).rem_euclid(1.0);
                // A remainder may be rounded up to the whole.
                let from = if from >= 1.0 { 0.0 } else { from };
                parts.push((from, (from + length).min(1.0)));
                if from + length > 1.0 {
                    parts.push((0.0, from + length - 1.0));
                }
            }
        }
        bars_of(joined(parts))
    }
}

/// Overlapping and touching parts as one, in order.
fn joined(mut parts: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut joined: Vec<(f64, f64)> = Vec::with_capacity(parts.len());
    for (from, to) in parts {
        match joined.last_mut() {
            Some(last) if from <= last.1 + SAME_INSTANT => last.1 = last.1.max(to),
            _ => joined.push((from, to)),
        }
    }
    joined.retain(|(from, to)| to - from > SAME_INSTANT);
    joined
}

fn bars_of(parts: Vec<(f64, f64)>) -> Vec<Bar> {
    let ends = |(from, to): &(f64, f64)| (*from <= SAME_INSTANT, *to >= 1.0 - SAME_INSTANT);
    // Down at both ends: what goes on at the end is what began before the start.
    let wraps = parts.first().is_some_and(|p| ends(p).0) && parts.last().is_some_and(|p| ends(p).1);
    let bar = |part: &(f64, f64)| Bar {
        start: part.0,
        end: part.1,
        is_from_before: wraps && ends(part).0,
        goes_on: wraps && ends(part).1,
    };
    parts.iter().map(bar).collect()
}
