//! A voltage given by points, or by smooth pieces that were made of a measurement.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{DriveError, Segment, Shape};
use crate::model::piezo::Branch;

/// How measured voltages are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveReading {
    /// As the waveform that the samples are those of; smoothed if they are of none; straight lines
    /// if they are few.
    #[default]
    Recognised,
    /// As the smoothest curve that the samples allow.
    Smoothed,
    /// As straight lines from sample to sample.
    PointByPoint,
}

impl DriveReading {
    /// All, in the order in which they are offered.
    pub const ALL: [DriveReading; 3] = [Self::Recognised, Self::Smoothed, Self::PointByPoint];

    /// What a person reads.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Recognised => "recognised waveform",
            Self::Smoothed => "smoothed voltage",
            Self::PointByPoint => "straight lines between samples",
        }
    }
}

/// Samples of a voltage as a file gave them, and how they were read.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredVoltage {
    /// Times \[s\], increasing.
    pub time: Vec<f64>,
    /// Voltages \[V\], as many.
    pub voltage: Vec<f64>,
    /// How the drive was made of them.
    pub reading: DriveReading,
}

/// A voltage that is no typed waveform; held before its first and after its last instant.
#[derive(Debug, Clone)]
pub struct VoltageTable {
    /// Where it is from, for people.
    pub name: String,
    curve: Curve,
}

#[derive(Debug, Clone, PartialEq)]
enum Curve {
    /// Points joined by straight lines.
    Points(Points),
    /// Smooth pieces.
    Pieces {
        /// In order of time without gaps, from minus to plus infinity.
        pieces: Vec<Segment>,
        /// What they are, in words.
        text: String,
        /// What they were made of; `None` if that is kept elsewhere.
        source: Option<Arc<MeasuredVoltage>>,
    },
}

#[derive(Debug, Clone, PartialEq)]
struct Points {
    time: Vec<f64>,
    voltage: Vec<f64>,
    /// Branch in force on the interval that starts at each point.
    branch: Vec<Branch>,
    /// Period after which the points come again \[s\], and the branches from the second time on.
    repeat: Option<(f64, Vec<Branch>)>,
}

impl PartialEq for VoltageTable {
    /// A table is itself: recorded ones are long, and compared with themselves in each
    /// frame of the window.
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || (self.name == other.name && self.curve == other.curve)
    }
}

impl VoltageTable {
    /// Straight lines through points at increasing times \[s\].
    ///
    /// # Errors
    /// [`DriveError::Table`] if empty, of unequal lengths, not finite or not increasing in time.
    pub fn new(
        name: impl Into<String>,
        time: Vec<f64>,
        voltage: Vec<f64>,
    ) -> Result<Self, DriveError> {
        let name = name.into();
        Self::check(&name, &time, &voltage)?;
        let branch = branches(&voltage);
        let curve = Curve::Points(Points {
            time,
            voltage,
            branch,
            repeat: None,
        });
        Ok(Self { name, curve })
    }

    /// The same points again after each `period` \[s\]; a straight line leads from the last point
    /// to the first one's next time, and where these fall together the voltage jumps.
    ///
    /// # Errors
    /// [`DriveError::Table`] if the period is shorter than the points last, or there are no points.
    pub fn repeating(mut self, period: f64) -> Result<Self, DriveError> {
        let fail = |reason: String| DriveError::Table {
            name: self.name.clone(),
            reason,
        };
        let Curve::Points(points) = &mut self.curve else {
            return Err(fail(
                "a recorded voltage cannot repeat; draw one period as points".to_owned(),
            ));
        };
        let span = points.time[points.time.len() - 1] - points.time[0];
        if !period.is_finite() || period <= 0.0 || period < span * (1.0 - 1e-12) {
            return Err(fail(format!(
                "a period of {period} s is shorter than the points, which last {span} s; make it at least as long"
            )));
        }
        // The second of two periods shows how each interval is entered.
        let twice: Vec<f64> = points
            .voltage
            .iter()
            .chain(&points.voltage)
            .copied()
            .collect();
        let branch = branches(&twice).split_off(points.voltage.len());
        points.repeat = Some((period, branch));
        Ok(self)
    }

    /// Smooth pieces in order of time without gaps, from minus to plus infinity; `text` says what
    /// they are.
    ///
    /// # Panics
    /// Never; without pieces the voltage is zero.
    #[must_use]
    pub fn of_pieces(name: impl Into<String>, mut pieces: Vec<Segment>, text: String) -> Self {
        if pieces.is_empty() {
            pieces.push(super::Waveform::Rest.segment(0));
        }
        Self {
            name: name.into(),
            curve: Curve::Pieces {
                pieces,
                text,
                source: None,
            },
        }
    }

    /// The same with the samples that its pieces were made of, for the session file.
    #[must_use]
    pub fn with_source(mut self, measured: MeasuredVoltage) -> Self {
        if let Curve::Pieces { source, .. } = &mut self.curve {
            *source = Some(Arc::new(measured));
        }
        self
    }

    /// Whether `time` and `voltage` can be a drive.
    ///
    /// # Errors
    /// As [`VoltageTable::new`].
    pub fn check(name: &str, time: &[f64], voltage: &[f64]) -> Result<(), DriveError> {
        let fail = |reason: String| {
            Err(DriveError::Table {
                name: name.to_owned(),
                reason,
            })
        };
        if time.is_empty() || time.len() != voltage.len() {
            return fail(format!(
                "{} times and {} voltages; there must be as many of each, at least one",
                time.len(),
                voltage.len()
            ));
        }
        if let Some(i) = (0..time.len()).find(|&i| !time[i].is_finite() || !voltage[i].is_finite())
        {
            return fail(format!("point {} is not a finite number", i + 1));
        }
        if let Some(i) = time.windows(2).position(|w| w[1] <= w[0]) {
            return fail(format!(
                "time does not increase from point {} ({} s) to point {} ({} s); put the points in order of time, none twice",
                i + 1,
                time[i],
                i + 2,
                time[i + 1]
            ));
        }
        Ok(())
    }

    /// Largest voltage by magnitude.
    pub fn amplitude(&self) -> f64 {
        match &self.curve {
            Curve::Points(points) => points.voltage.iter().fold(0.0, |a, v| a.max(v.abs())),
            Curve::Pieces { pieces, .. } => pieces.iter().fold(0.0, |a, p| {
                let ends = [p.start, p.end, 0.5 * (p.start + p.end)];
                let finite = ends.into_iter().filter(|t| t.is_finite());
                finite.fold(a, |a: f64, t| a.max(p.shape.voltage(t).abs()))
            }),
        }
    }

    /// The points: times \[s\] and voltages \[V\]; `None` if the table is not one of points.
    pub fn points(&self) -> Option<(&[f64], &[f64])> {
        match &self.curve {
            Curve::Points(points) => Some((&points.time, &points.voltage)),
            Curve::Pieces { .. } => None,
        }
    }

    /// Period after which the points come again \[s\].
    pub fn period(&self) -> Option<f64> {
        match &self.curve {
            Curve::Points(points) => points.repeat.as_ref().map(|r| r.0),
            Curve::Pieces { .. } => None,
        }
    }

    /// The samples that the pieces were made of, if the table keeps them.
    pub fn source(&self) -> Option<&MeasuredVoltage> {
        match &self.curve {
            Curve::Points(_) => None,
            Curve::Pieces { source, .. } => source.as_deref(),
        }
    }

    /// What a measured voltage was found to be; `None` for points.
    pub fn text(&self) -> Option<&str> {
        match &self.curve {
            Curve::Points(_) => None,
            Curve::Pieces { text, .. } => Some(text),
        }
    }

    /// The last instant at which something changes \[s\], of one period if it repeats.
    pub fn end(&self) -> f64 {
        match &self.curve {
            Curve::Points(points) => points.time.last().copied().unwrap_or(0.0),
            Curve::Pieces { pieces, .. } => pieces
                .last()
                .map(|p| p.start)
                .filter(|t| t.is_finite())
                .unwrap_or(0.0),
        }
    }

    pub(super) fn segment(&self, index: usize) -> Segment {
        match &self.curve {
            Curve::Points(points) => points.segment(index),
            Curve::Pieces { pieces, .. } => pieces[index.min(pieces.len() - 1)],
        }
    }

    /// Number of the segment that holds `t` \[s\].
    pub(super) fn index_at(&self, t: f64) -> usize {
        match &self.curve {
            Curve::Points(points) => points.index_at(t),
            Curve::Pieces { pieces, .. } => {
                let index = pieces.partition_point(|p| p.end <= t);
                index.min(pieces.len() - 1)
            }
        }
    }
}

impl Points {
    fn segment(&self, index: usize) -> Segment {
        let n = self.time.len();
        let hold = |start, end, at: usize| Segment {
            start,
            end,
            shape: Shape::Constant {
                voltage: self.voltage[at],
            },
            branch: self.branch[at],
        };
        if index == 0 {
            return hold(f64::NEG_INFINITY, self.time[0], 0);
        }
        if let Some((period, branch)) = &self.repeat {
            let (turn, own) = ((index - 1) / n, (index - 1) % n);
            let shift = turn as f64 * period;
            let branch = if turn == 0 { &self.branch } else { branch };
            let (end, to) = if own + 1 < n {
                (self.time[own + 1] + shift, self.voltage[own + 1])
            } else {
                // The way back has its direction from where it leads.
                ((turn + 1) as f64 * period + self.time[0], self.voltage[0])
            };
            let mut line = line((self.time[own] + shift, self.voltage[own]), (end, to));
            line.branch = match (own + 1 < n, to > self.voltage[own], to < self.voltage[own]) {
                (false, true, _) => Branch::Rising,
                (false, _, true) => Branch::Falling,
                _ => branch[own],
            };
            return line;
        }
        if index >= n {
            return hold(self.time[n - 1], f64::INFINITY, n - 1);
        }
        let (a, b) = (index - 1, index);
        Segment {
            branch: self.branch[a],
            ..line(
                (self.time[a], self.voltage[a]),
                (self.time[b], self.voltage[b]),
            )
        }
    }

    fn index_at(&self, t: f64) -> usize {
        let within = |t: f64| self.time.partition_point(|&start| start <= t);
        match &self.repeat {
            Some((period, _)) if t >= self.time[0] => {
                let turn = ((t - self.time[0]) / period).floor();
                // The table's own clock; rounding must not lead out of it.
                let own = within(t - turn * period).max(1);
                (turn as usize)
                    .saturating_mul(self.time.len())
                    .saturating_add(own)
            }
            _ => within(t),
        }
    }
}

/// A straight line from one point to another; level if both are as high or fall together.
fn line((t0, v0): (f64, f64), (t1, v1): (f64, f64)) -> Segment {
    Segment {
        start: t0,
        end: t1,
        shape: if v0 == v1 || t1 <= t0 {
            Shape::Constant { voltage: v0 }
        } else {
            Shape::Line {
                voltage: v0,
                slope: (v1 - v0) / (t1 - t0),
                at: t0,
            }
        },
        branch: Branch::Rising,
    }
}

/// Branch on each interval: that of its line, on a level the last one's. A table that starts on a
/// level counts as having just stepped there.
fn branches(voltage: &[f64]) -> Vec<Branch> {
    let mut last = if voltage[0] >= 0.0 {
        Branch::Rising
    } else {
        Branch::Falling
    };
    let mut branch = Vec::with_capacity(voltage.len());
    for pair in voltage.windows(2) {
        if pair[1] > pair[0] {
            last = Branch::Rising;
        } else if pair[1] < pair[0] {
            last = Branch::Falling;
        }
        branch.push(last);
    }
    branch.push(last);
    branch
}
