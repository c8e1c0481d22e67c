//! A voltage given by samples: a file, an editor, a recording.

use super::{DriveError, Segment, Shape};
use crate::model::piezo::Branch;

/// Voltage samples joined by straight lines; held before the first and after the last.
#[derive(Debug, Clone)]
pub struct VoltageTable {
    /// Where it is from, for people.
    pub name: String,
    time: Vec<f64>,
    voltage: Vec<f64>,
    /// Branch in force on the interval that starts at each sample.
    pub(super) branch: Vec<Branch>,
}

impl PartialEq for VoltageTable {
    /// A table is itself: recorded ones are long, and compared with themselves in each
    /// frame of the window.
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
            || (self.name == other.name
                && self.time == other.time
                && self.voltage == other.voltage
                && self.branch == other.branch)
    }
}

impl VoltageTable {
    /// Builds a table from samples at increasing times \[s\]. A reversal smaller than
    /// `deadband` \[V\] counts as noise and does not change the hysteresis branch.
    ///
    /// # Errors
    /// [`DriveError::Table`] if empty, of unequal lengths, not finite or not increasing in time.
    pub fn new(
        name: impl Into<String>,
        time: Vec<f64>,
        voltage: Vec<f64>,
        deadband: f64,
    ) -> Result<Self, DriveError> {
        let name = name.into();
        let fail = |reason: String| DriveError::Table {
            name: name.clone(),
            reason,
        };
        if time.is_empty() || time.len() != voltage.len() {
            return Err(fail(format!(
                "{} times and {} voltages; there must be as many of each, at least one",
                time.len(),
                voltage.len()
            )));
        }
        if let Some(i) = (0..time.len()).find(|&i| !time[i].is_finite() || !voltage[i].is_finite())
        {
            return Err(fail(format!("point {} is not a finite number", i + 1)));
        }
        if let Some(i) = time.windows(2).position(|w| w[1] <= w[0]) {
            return Err(fail(format!(
                "time does not increase from point {} ({} s) to point {} ({} s); put the points in order of time, none twice",
                i + 1,
                time[i],
                i + 2,
                time[i + 1]
            )));
        }
        let branch = branches(&voltage, deadband.max(0.0));
        Ok(Self {
            name,
            time,
            voltage,
            branch,
        })
    }

    /// A table from a recorded voltage, whose noise must not flip the hysteresis branch:
    /// reversals below 2 % of its span do not count.
    ///
    /// # Errors
    /// As [`VoltageTable::new`].
    pub fn from_recording(
        name: impl Into<String>,
        time: Vec<f64>,
        voltage: Vec<f64>,
    ) -> Result<Self, DriveError> {
        let low = voltage.iter().copied().fold(f64::INFINITY, f64::min);
        let high = voltage.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self::new(name, time, voltage, 0.02 * (high - low))
    }

    /// A table that follows `pieces` in order of time, with a point at least every
    /// `interval` \[s\] between `start` and `end`; jumps take a nanosecond.
    ///
    /// # Errors
    /// As [`VoltageTable::new`].
    pub fn from_pieces(
        pieces: &[Segment],
        start: f64,
        end: f64,
        interval: f64,
    ) -> Result<Self, DriveError> {
        let (mut time, mut voltage, mut branch) = (Vec::new(), Vec::new(), Vec::new());
        for piece in pieces {
            let (from, to) = (piece.start.max(start), piece.end.min(end));
            if to - from < 4e-9 {
                continue;
            }
            let count = ((to - from) / interval).ceil().max(1.0) as usize;
            for i in 0..=count {
                let share = i as f64 / count as f64;
                let t = (from + share * (to - from)).clamp(from + 5e-10, to - 5e-10);
                time.push(t);
                voltage.push(piece.shape.voltage(t));
                branch.push(piece.branch);
            }
        }
        let mut table = Self::new("pieces", time, voltage, 0.0)?;
        table.branch = branch;
        Ok(table)
    }

    /// Largest voltage by magnitude.
    pub fn amplitude(&self) -> f64 {
        self.voltage.iter().fold(0.0, |a, v| a.max(v.abs()))
    }

    /// The samples: times \[s\] and voltages \[V\], as many of each.
    pub fn samples(&self) -> (&[f64], &[f64]) {
        (&self.time, &self.voltage)
    }

    /// The samples: times \[s\] and voltages \[V\].
    pub fn points(&self) -> (&[f64], &[f64]) {
        (&self.time, &self.voltage)
    }

    /// Time of the last sample \[s\].
    pub fn end(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    pub(super) fn segment(&self, index: usize) -> Segment {
        let n = self.time.len();
        let hold = |start, end, voltage, branch| Segment {
            start,
            end,
            shape: Shape::Constant { voltage },
            branch,
        };
        if index == 0 {
            return hold(
                f64::NEG_INFINITY,
                self.time[0],
                self.voltage[0],
                self.branch[0],
            );
        }
        if index >= n {
            return hold(
                self.time[n - 1],
                f64::INFINITY,
                self.voltage[n - 1],
                self.branch[n - 1],
            );
        }
        let (t0, t1) = (self.time[index - 1], self.time[index]);
        let (v0, v1) = (self.voltage[index - 1], self.voltage[index]);
        Segment {
            start: t0,
            end: t1,
            shape: if v0 == v1 {
                Shape::Constant { voltage: v0 }
            } else {
                Shape::Line {
                    voltage: v0,
                    slope: (v1 - v0) / (t1 - t0),
                    at: t0,
                }
            },
            branch: self.branch[index - 1],
        }
    }
}

/// Branch on each interval. The direction turns once the voltage has come back from
/// its extremum by more than `deadband`, and then counts from the extremum on.
fn branches(voltage: &[f64], deadband: f64) -> Vec<Branch> {
    // A table that starts on a plateau counts as having just stepped there.
    let first = if voltage[0] >= 0.0 {
        Branch::Rising
    } else {
        Branch::Falling
    };
    let mut branch = vec![first; voltage.len()];
    let mut rising: Option<bool> = None;
    // Before the first turn both extrema are followed, after it the one ahead.
    let (mut low, mut high) = (0, 0);
    for i in 1..voltage.len() {
        if rising != Some(false) && voltage[i] >= voltage[high] {
            high = i;
        }
        if rising != Some(true) && voltage[i] <= voltage[low] {
            low = i;
        }
        if rising != Some(true) && voltage[i] > voltage[low] + deadband {
            rising = Some(true);
            branch[last_at(voltage, low, i, deadband)..].fill(Branch::Rising);
            high = i;
        } else if rising != Some(false) && voltage[i] < voltage[high] - deadband {
            rising = Some(false);
            branch[last_at(voltage, high, i, deadband)..].fill(Branch::Falling);
            low = i;
        }
    }
    branch
}

/// Where the voltage leaves its extremum for good: on a plateau the branch last in
/// force is held until then. Last sample before `end` that is still within `deadband` of the extremum at `from`.
fn last_at(voltage: &[f64], from: usize, end: usize, deadband: f64) -> usize {
    (from..end)
        .rev()
        .find(|&i| (voltage[i] - voltage[from]).abs() <= deadband)
        .unwrap_or(from)
}
