//! Channels of a segment that share their times, and segments that go on.

use super::header::{Role, SegmentHeader};
use crate::recording::formats::raw_table::{RawColumn, RawTable, SampleClock};

/// How far from the next sample a segment may begin to go on \[samples\].
const MAX_GAP_SAMPLES: f64 = 0.5;
/// The same where only the clock of the computer tells when a segment began \[samples\].
const MAX_STAMP_GAP_SAMPLES: f64 = 1.0;

/// Channels with the same times.
#[derive(Debug)]
pub(super) struct Part {
    pub names: Vec<String>,
    units: Vec<Option<String>>,
    /// Times in the file.
    times: Option<Vec<f64>>,
    channels: Vec<Vec<f64>>,
    clock: Option<SampleClock>,
    instant: Option<f64>,
}

/// The channels of a segment, by their times.
pub(super) fn parts(
    header: &SegmentHeader,
    columns: Vec<Vec<f64>>,
    notes: &mut Vec<String>,
) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut times: Option<Vec<f64>> = None;
    let mut new_times = false;
    let mut intervals: Vec<f64> = Vec::new();
    let one_times = header
        .columns
        .iter()
        .filter(|c| c.role == Role::Times)
        .count()
        == 1;
    for (column, values) in header.columns.iter().zip(columns) {
        match column.role {
            Role::Comment => {}
            Role::Times => {
                times = values.iter().any(|t| t.is_finite()).then_some(values);
                new_times = true;
            }
            Role::Channel => {
                let clock = column
                    .interval
                    .and_then(|interval| SampleClock::new(column.start.unwrap_or(0.0), interval));
                if values.iter().any(|v| v.is_finite()) {
                    intervals.extend(column.interval);
                }
                let clock = if times.is_some() { None } else { clock };
                // With one column of times all channels share it; else those with equal times.
                let shared = parts.iter_mut().find(|part| match (&part.times, &times) {
                    (Some(_), Some(_)) if !new_times => true,
                    (Some(a), Some(b)) => same(a, b),
                    (None, None) => part.clock == clock,
                    _ => false,
                });
                if let Some(part) = shared {
                    part.push(column.name.clone(), column.unit.clone(), values);
                } else {
                    let mut part = Part {
                        names: Vec::new(),
                        units: Vec::new(),
                        times: times.clone(),
                        channels: Vec::new(),
                        clock,
                        instant: header.instant,
                    };
                    part.push(column.name.clone(), column.unit.clone(), values);
                    parts.push(part);
                }
                if one_times {
                    new_times = false;
                }
            }
        }
    }
    let differ = intervals.iter().any(|dx| Some(dx) != intervals.first());
    if one_times && times.is_some() && differ {
        notes.push(
            "The channels have different Delta_X, but the file has one column of times; it is right for the first channel only."
                .to_owned(),
        );
    }
    parts.iter_mut().for_each(Part::trim);
    parts
}

/// Equal times, missing ones too.
fn same(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Adds a segment to those before: to the last run if it goes on, else as a new run.
pub(super) fn join(runs: &mut Vec<Vec<Part>>, parts: Vec<Part>) {
    if let Some(last) = runs.last_mut() {
        let goes_on = last.len() == parts.len()
            && last
                .iter()
                .zip(&parts)
                .all(|(before, after)| before.goes_on_in(after));
        if goes_on {
            for (before, after) in last.iter_mut().zip(parts) {
                before.append(after);
            }
            return;
        }
    }
    runs.push(parts);
}

impl Part {
    fn push(&mut self, name: String, unit: Option<String>, values: Vec<f64>) {
        self.names.push(name);
        self.units.push(unit);
        self.channels.push(values);
    }

    fn rows(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// Drops rows at the end in which nothing was recorded: other channels have more samples.
    fn trim(&mut self) {
        let recorded = |values: &Vec<f64>| values.iter().rposition(|v| v.is_finite());
        let columns = self.channels.iter().chain(&self.times);
        let rows = columns
            .filter_map(recorded)
            .max()
            .map_or(0, |last| last + 1);
        let columns = self.channels.iter_mut().chain(&mut self.times);
        columns.for_each(|values| values.truncate(rows));
    }

    /// Whether `next` has the same channels and begins where this ends.
    fn goes_on_in(&self, next: &Self) -> bool {
        if self.names != next.names || self.units != next.units {
            return false;
        }
        match (&self.times, &next.times) {
            (Some(before), Some(after)) => {
                let last = before.iter().rev().find(|t| t.is_finite());
                let first = after.iter().find(|t| t.is_finite());
                last.zip(first).is_some_and(|(last, first)| first > last)
            }
            (None, None) => self.clock_goes_on_in(next),
            _ => false,
        }
    }

    fn clock_goes_on_in(&self, next: &Self) -> bool {
        let (Some(before), Some(after)) = (self.clock, next.clock) else {
            return self.clock.is_none() && next.clock.is_none();
        };
        if before.interval != after.interval {
            return false;
        }
        let rows = self.rows() as f64;
        let gap = (after.start - before.start) / before.interval - rows;
        if gap.abs() <= MAX_GAP_SAMPLES {
            return true;
        }
        // Each segment counts from its own start: then the dates tell.
        let stamps = self.instant.zip(next.instant);
        before.start == after.start
            && stamps.is_some_and(|(begin, end)| {
                let gap = (end - begin) / before.interval - rows;
                gap.abs() <= MAX_STAMP_GAP_SAMPLES
            })
    }

    fn append(&mut self, next: Self) {
        for (before, after) in self.channels.iter_mut().zip(next.channels) {
            before.extend(after);
        }
        if let (Some(before), Some(after)) = (&mut self.times, next.times) {
            before.extend(after);
        }
    }

    /// As a table; `None` without rows.
    pub fn table(self, name: String, notes: &[String]) -> Option<RawTable> {
        if self.rows() == 0 {
            return None;
        }
        let times = self.times.map(|values| RawColumn {
            name: "X_Value".to_owned(),
            unit: Some("s".to_owned()),
            values,
        });
        let mut notes = notes.to_vec();
        if times.is_none() && self.clock.is_none() {
            notes.push(
                "The file gives neither times nor Delta_X; give the sampling rate.".to_owned(),
            );
        }
        let channels = self.names.into_iter().zip(self.units).zip(self.channels);
        let channels = channels.map(|((name, unit), values)| RawColumn { name, unit, values });
        Some(RawTable {
            name,
            columns: times.into_iter().chain(channels).collect(),
            clock: self.clock,
            notes,
        })
    }
}
