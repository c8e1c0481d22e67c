//! Periodic drives: a cycle with offset, phase and bursts, as smooth segments.
//!
//! `V(t) = offset + cycle(f t + phase / 360 deg)`. Of bursts, `on` periods of each `of` are
//! those of the cycle; for the rest the voltage is the offset. The phase moves the whole of it.

use std::sync::Arc;

use super::cycle::{Cycle, EVEN_SHARE};
use super::pattern::{Burst, pattern};
use super::{
    DriveError, HIGHEST_FREQUENCY, HIGHEST_VOLTAGE, LOWEST_FREQUENCY, Segment, Shape, Waveform,
    within,
};

/// Longest pattern of bursts in periods; a longer one is a table.
pub const MAX_BURST_PERIODS: u32 = 1000;

/// Most pieces that one pattern of bursts may have: 100,000 take 10 MB.
const MAX_PIECES: usize = 100_000;

/// Largest phase \[deg\], by magnitude: as many turns as the longest pattern has periods.
const MAX_PHASE: f64 = 360.0 * MAX_BURST_PERIODS as f64;

/// Last piece that is counted: above, neighbouring numbers are the same `f64`.
const MAX_INDEX: f64 = 4e15;

/// Segments by which an index may be wrong through rounding.
const MAX_INDEX_CORRECTIONS: usize = 16;

/// A periodic drive as a person sets it.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicDrive {
    /// The form of a period.
    pub cycle: Cycle,
    /// Periods of the cycle per second \[Hz\].
    pub frequency: f64,
    /// Added to the cycle \[V\].
    pub offset: f64,
    /// How far the drive is ahead of one of phase 0 \[deg\].
    pub phase: f64,
    /// Bursts; `None` is no pause.
    pub burst: Option<Burst>,
}

impl PeriodicDrive {
    /// A cycle without offset, phase and bursts.
    #[must_use]
    pub fn new(cycle: Cycle, frequency: f64) -> Self {
        Self {
            cycle,
            frequency,
            offset: 0.0,
            phase: 0.0,
            burst: None,
        }
    }

    /// A waveform in this form; `None` for rest, chirps and tables.
    #[must_use]
    pub fn of(waveform: &Waveform) -> Option<Self> {
        let (cycle, frequency) = match *waveform {
            Waveform::Sine {
                frequency,
                amplitude,
            } => (Cycle::Sine { amplitude }, frequency),
            Waveform::Square {
                frequency,
                amplitude,
            } => {
                let duty = EVEN_SHARE;
                (Cycle::Square { amplitude, duty }, frequency)
            }
            Waveform::Triangle {
                frequency,
                amplitude,
            } => {
                let asymmetry = EVEN_SHARE;
                (
                    Cycle::Triangle {
                        amplitude,
                        asymmetry,
                    },
                    frequency,
                )
            }
            Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            } => {
                let duty = EVEN_SHARE;
                (
                    Cycle::Ramped {
                        amplitude,
                        lambda,
                        duty,
                    },
                    frequency,
                )
            }
            Waveform::Periodic(ref periodic) => return Some(periodic.drive.clone()),
            Waveform::Rest | Waveform::Chirp { .. } | Waveform::Table(_) => return None,
        };
        Some(Self::new(cycle, frequency))
    }

    /// The waveform; a plain sine, square, triangle or ramped square is that of the same name.
    ///
    /// # Errors
    /// [`DriveError::Value`] naming the value that is out of range.
    pub fn waveform(mut self) -> Result<Waveform, DriveError> {
        self.check()?;
        if self.burst.is_some_and(|burst| burst.on == burst.of) {
            self.burst = None;
        }
        let frequency = self.frequency;
        let is_plain = self.offset == 0.0 && self.phase == 0.0 && self.burst.is_none();
        Ok(match self.cycle {
            Cycle::Sine { amplitude } if is_plain => Waveform::Sine {
                frequency,
                amplitude,
            },
            Cycle::Square { amplitude, duty } if is_plain && duty == EVEN_SHARE => {
                Waveform::Square {
                    frequency,
                    amplitude,
                }
            }
            Cycle::Triangle {
                amplitude,
                asymmetry,
            } if is_plain && asymmetry == EVEN_SHARE => Waveform::Triangle {
                frequency,
                amplitude,
            },
            Cycle::Ramped {
                amplitude,
                lambda,
                duty,
            } if is_plain && duty == EVEN_SHARE => Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            },
            _ => Waveform::Periodic(Arc::new(Periodic::new(self))),
        })
    }

    /// Time after which everything repeats \[s\].
    pub fn period(&self) -> f64 {
        self.periods() / self.frequency
    }

    /// Checks all values.
    ///
    /// # Errors
    /// [`DriveError::Value`] naming the value and its range.
    pub fn check(&self) -> Result<(), DriveError> {
        within(
            "frequency",
            self.frequency,
            LOWEST_FREQUENCY,
            HIGHEST_FREQUENCY,
            "Hz",
        )?;
        self.cycle.check()?;
        let limit = HIGHEST_VOLTAGE;
        within("offset", self.offset, -limit, limit, "V")?;
        within("phase", self.phase, -MAX_PHASE, MAX_PHASE, "deg")?;
        let Some(Burst { on, of }) = self.burst else {
            return Ok(());
        };
        if on == 0 || on > of || of > MAX_BURST_PERIODS {
            return Err(DriveError::Value(format!(
                "a burst of {on} periods of {of}; at least 1 period must be on, and no more than there are, up to {MAX_BURST_PERIODS}"
            )));
        }
        let pieces = (on as usize).saturating_mul(self.cycle.pieces().len());
        if pieces > MAX_PIECES {
            return Err(DriveError::Value(format!(
                "{on} periods of this many handles are {pieces} pieces, and no more than {MAX_PIECES} are possible; use fewer periods or handles"
            )));
        }
        Ok(())
    }

    /// Periods after which everything repeats.
    fn periods(&self) -> f64 {
        self.burst.map_or(1.0, |burst| f64::from(burst.of))
    }
}

/// A periodic drive with its pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct Periodic {
    drive: PeriodicDrive,
    /// The smooth pieces of the pattern in order of time, in periods. The first may begin before
    /// 0; the last ends one pattern later.
    pieces: Vec<Segment>,
    /// Where in the pattern t = 0 is, in periods.
    phase: f64,
    /// Number of the piece in force at t = 0.
    first: usize,
    /// Largest voltage by magnitude \[V\].
    amplitude: f64,
}

impl Periodic {
    /// Of values that were checked.
    fn new(drive: PeriodicDrive) -> Self {
        let pieces = pattern(&drive.cycle, drive.offset, drive.burst);
        let amplitude = pieces.iter().fold(0.0f64, |most, p| {
            let ends = [p.shape.voltage(p.start), p.shape.voltage(p.end)];
            most.max(ends[0].abs()).max(ends[1].abs())
        });
        let mut periodic = Self {
            phase: (drive.phase / 360.0).rem_euclid(drive.periods()),
            drive,
            pieces,
            first: 0,
            amplitude,
        };
        periodic.first = periodic.piece_at(periodic.phase);
        periodic
    }

    /// What a person set.
    pub fn drive(&self) -> &PeriodicDrive {
        &self.drive
    }

    /// Time after which everything repeats \[s\].
    pub fn period(&self) -> f64 {
        self.drive.period()
    }

    /// Largest voltage by magnitude, offset included \[V\].
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Number of the piece that holds `x` periods.
    fn piece_at(&self, x: f64) -> usize {
        let (n, periods) = (self.pieces.len(), self.drive.periods());
        let start = self.pieces[0].start;
        let turn = ((x - start) / periods).floor();
        let turn = turn.clamp(0.0, MAX_INDEX / n as f64).floor();
        let own = x - turn * periods;
        let own = self.pieces.partition_point(|p| p.start <= own).max(1) - 1;
        (turn as usize).saturating_mul(n).saturating_add(own)
    }

    /// Start \[periods\] of the piece of a number.
    fn start_of(&self, piece: usize) -> f64 {
        let (turn, own) = (piece / self.pieces.len(), piece % self.pieces.len());
        turn as f64 * self.drive.periods() + self.pieces[own].start
    }

    pub(super) fn segment(&self, index: usize) -> Segment {
        let piece = index.saturating_add(self.first);
        let own = &self.pieces[piece % self.pieces.len()];
        let time = |x: f64| (x - self.phase) / self.drive.frequency;
        let shift = self.start_of(piece) - own.start;
        Segment {
            start: if index == 0 {
                f64::NEG_INFINITY
            } else {
                time(self.start_of(piece))
            },
            end: time(self.start_of(piece.saturating_add(1))),
            shape: in_seconds(own.shape, self.drive.frequency, |at| time(at + shift)),
            branch: own.branch,
        }
    }

    /// Number of the segment that holds `t` \[s\].
    pub(super) fn index_at(&self, t: f64) -> usize {
        let x = self.drive.frequency * t + self.phase;
        let mut index = self.piece_at(x).saturating_sub(self.first);
        for _ in 0..MAX_INDEX_CORRECTIONS {
            if index == 0 || self.segment(index).start <= t {
                break;
            }
            index -= 1;
        }
        for _ in 0..MAX_INDEX_CORRECTIONS {
            if self.segment(index).end > t {
                break;
            }
            index = index.saturating_add(1);
        }
        index
    }
}

/// A shape over periods as one over seconds; `time` gives the time of an instant in periods.
fn in_seconds(shape: Shape, frequency: f64, time: impl Fn(f64) -> f64) -> Shape {
    match shape {
        Shape::Line { voltage, slope, at } => Shape::Line {
            voltage,
            slope: slope * frequency,
            at: time(at),
        },
        Shape::Sine {
            amplitude,
            omega,
            at,
            offset,
        } => Shape::Sine {
            amplitude,
            omega: omega * frequency,
            at: time(at),
            offset,
        },
        Shape::Cubic { c, at, unit } => Shape::Cubic {
            c,
            at: time(at),
            unit: unit / frequency,
        },
        // A cycle has no sweeps.
        Shape::Constant { .. } | Shape::Chirp { .. } => shape,
    }
}
