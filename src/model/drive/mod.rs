//! The drive voltage as a sequence of smooth segments.
//!
//! The simulator restarts at each segment's start, so that steps, corners and changes
//! of the hysteresis branch are met exactly.

mod cycle;
mod handles;
mod pattern;
mod periodic;
#[cfg(test)]
mod periodic_tests;
mod periodic_text;
mod segments;
pub(crate) mod table;
#[cfg(test)]
mod tests;
mod text;

use std::f64::consts::TAU;
use std::sync::Arc;

use thiserror::Error;

use super::piezo::Branch;
use super::unit::{UnitError, format_quantity};

pub use self::cycle::Cycle;
pub use self::handles::{Handle, Handles, Interpolation, MAX_HANDLES};
pub use self::pattern::Burst;
pub use self::periodic::{MAX_BURST_PERIODS, Periodic, PeriodicDrive};
pub use self::table::{DriveReading, MeasuredVoltage, VoltageTable};

/// Frequencies of a drive \[Hz\]: beyond them a period holds no motion of any device, or all of it.
const LOWEST_FREQUENCY: f64 = 1e-6;
const HIGHEST_FREQUENCY: f64 = 1e6;
/// Voltages of a drive \[V\], by magnitude: no piezo film stands more.
const HIGHEST_VOLTAGE: f64 = 1e4;

/// A drive that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DriveError {
    /// The text does not name a waveform.
    #[error(
        "\"{0}\" is not a drive; write rest, sine:F:A, square:F:A, triangle:F:A, ramped:F:A:LAMBDA, drawn:F:linear:T/V,T/V..., chirp:F0:F1:A, table:FILE, handles:FILE or recorded"
    )]
    Unknown(String),
    /// Too few or too many fields.
    #[error("\"{text}\" has {found} values after the name; {form} needs {needed}")]
    Fields {
        text: String,
        found: usize,
        needed: usize,
        form: &'static str,
    },
    /// A field is not a quantity.
    #[error("drive \"{text}\": {source}")]
    Quantity { text: String, source: UnitError },
    /// A named field, or a list of handles, that cannot be read.
    #[error("drive \"{text}\": {problem}")]
    Field { text: String, problem: String },
    /// A value is out of its range.
    #[error("drive: {0}")]
    Value(String),
    /// A table that is no function of time.
    #[error("voltage table \"{name}\": {reason}")]
    Table { name: String, reason: String },
}

/// The drive voltage as a function of time. Frequencies in Hz, amplitudes in V.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Waveform {
    /// No voltage since poling: no force.
    #[default]
    Rest,
    /// `A sin(2 pi f t)`.
    Sine { frequency: f64, amplitude: f64 },
    /// Starts with `+A`.
    Square { frequency: f64, amplitude: f64 },
    /// Starts at 0, rising.
    Triangle { frequency: f64, amplitude: f64 },
    /// Rises from `-A` over `lambda T`, holds to `T/2`, falls over `lambda T`, holds (fig. 6).
    Ramped {
        frequency: f64,
        amplitude: f64,
        lambda: f64,
    },
    /// Sine whose frequency goes linearly from `from` to `to` over `duration` \[s\].
    Chirp {
        from: f64,
        to: f64,
        amplitude: f64,
        duration: f64,
    },
    /// Points joined by straight lines, or what a measured voltage was found to be.
    Table(Arc<VoltageTable>),
    /// A cycle with offset, phase, duty, asymmetry or bursts, or drawn by handles; made by
    /// [`PeriodicDrive::waveform`].
    Periodic(Arc<Periodic>),
}

/// One smooth stretch of the drive. `shape` may be evaluated outside `start..end`,
/// where it continues smoothly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Begin \[s\].
    pub start: f64,
    /// End \[s\]; infinite where nothing more changes.
    pub end: f64,
    /// The voltage.
    pub shape: Shape,
    /// The hysteresis branch in force.
    pub branch: Branch,
}

/// A smooth voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Constant \[V\].
    Constant { voltage: f64 },
    /// `voltage + slope (t - at)`.
    Line { voltage: f64, slope: f64, at: f64 },
    /// `offset + amplitude sin(omega (t - at))`.
    Sine {
        amplitude: f64,
        omega: f64,
        at: f64,
        offset: f64,
    },
    /// `offset + amplitude sin(2 pi (phase + from t + rate t^2 / 2))`.
    Chirp {
        amplitude: f64,
        phase: f64,
        from: f64,
        rate: f64,
        offset: f64,
    },
    /// `c0 + c1 u + c2 u^2 + c3 u^3`, `u = (t - at) / unit`.
    Cubic { c: [f64; 4], at: f64, unit: f64 },
}

impl Shape {
    /// Voltage \[V\] at `t` \[s\].
    #[inline]
    pub fn voltage(&self, t: f64) -> f64 {
        match *self {
            Shape::Constant { voltage } => voltage,
            Shape::Line { voltage, slope, at } => voltage + slope * (t - at),
            Shape::Sine {
                amplitude,
                omega,
                at,
                offset,
            } => offset + amplitude * (omega * (t - at)).sin(),
            Shape::Chirp {
                amplitude,
                phase,
                from,
                rate,
                offset,
            } => offset + amplitude * (TAU * (phase + t * (from + 0.5 * rate * t))).sin(),
            Shape::Cubic { c, at, unit } => {
                let u = (t - at) / unit;
                c[0] + u * (c[1] + u * (c[2] + u * c[3]))
            }
        }
    }

    /// Rate of change [V/s] at `t` \[s\].
    pub fn slope(&self, t: f64) -> f64 {
        match *self {
            Shape::Constant { .. } => 0.0,
            Shape::Line { slope, .. } => slope,
            Shape::Sine {
                amplitude,
                omega,
                at,
                ..
            } => amplitude * omega * (omega * (t - at)).cos(),
            Shape::Chirp {
                amplitude,
                phase,
                from,
                rate,
                ..
            } => {
                let turns = phase + t * (from + 0.5 * rate * t);
                amplitude * TAU * (from + rate * t) * (TAU * turns).cos()
            }
            Shape::Cubic { c, at, unit } => {
                let u = (t - at) / unit;
                (c[1] + u * (2.0 * c[2] + u * 3.0 * c[3])) / unit
            }
        }
    }

    /// A rate of change [V/s] that is not exceeded between `from` and `to` \[s\].
    pub fn steepest(&self, from: f64, to: f64) -> f64 {
        match *self {
            Shape::Constant { .. } => 0.0,
            Shape::Line { slope, .. } => slope.abs(),
            Shape::Sine {
                amplitude, omega, ..
            } => (amplitude * omega).abs(),
            Shape::Chirp {
                amplitude,
                from: f,
                rate,
                ..
            } => amplitude.abs() * TAU * (f + rate * from).abs().max((f + rate * to).abs()),
            Shape::Cubic { c, at, unit } => {
                let u = ((from - at) / unit).abs().max(((to - at) / unit).abs());
                (c[1].abs() + u * (2.0 * c[2].abs() + u * 3.0 * c[3].abs())) / unit.abs()
            }
        }
    }
}

impl Segment {
    /// The same `by` \[s\] later.
    #[must_use]
    pub fn shifted(&self, by: f64) -> Self {
        if by == 0.0 {
            return *self;
        }
        let shape = match self.shape {
            Shape::Constant { .. } => self.shape,
            Shape::Line { voltage, slope, at } => Shape::Line {
                voltage,
                slope,
                at: at + by,
            },
            Shape::Sine {
                amplitude,
                omega,
                at,
                offset,
            } => Shape::Sine {
                amplitude,
                omega,
                at: at + by,
                offset,
            },
            // In the shifted time t, the old one is t - by.
            Shape::Chirp {
                amplitude,
                phase,
                from,
                rate,
                offset,
            } => Shape::Chirp {
                amplitude,
                phase: phase - by * (from - 0.5 * rate * by),
                from: from - rate * by,
                rate,
                offset,
            },
            Shape::Cubic { c, at, unit } => Shape::Cubic {
                c,
                at: at + by,
                unit,
            },
        };
        Self {
            start: self.start + by,
            end: self.end + by,
            shape,
            branch: self.branch,
        }
    }
}

impl Waveform {
    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        let segment = self.segment(self.index_at(t));
        // At times so late that segments are shorter than rounding, the last one reached counts.
        segment.shape.voltage(t.max(segment.start).min(segment.end))
    }

    /// The longest time over which the voltage repeats \[s\], if it does.
    pub fn period(&self) -> Option<f64> {
        match self {
            Waveform::Sine { frequency, .. }
            | Waveform::Square { frequency, .. }
            | Waveform::Triangle { frequency, .. }
            | Waveform::Ramped { frequency, .. } => Some(1.0 / frequency),
            Waveform::Table(table) => table.period(),
            Waveform::Periodic(periodic) => Some(periodic.period()),
            Waveform::Rest | Waveform::Chirp { .. } => None,
        }
    }

    /// Checks all values.
    ///
    /// # Errors
    /// [`DriveError::Value`] naming the value and its range.
    pub fn check(&self) -> Result<(), DriveError> {
        let frequency = |f| within("frequency", f, LOWEST_FREQUENCY, HIGHEST_FREQUENCY, "Hz");
        let amplitude = |a: f64| within("amplitude", a, -HIGHEST_VOLTAGE, HIGHEST_VOLTAGE, "V");
        match *self {
            Waveform::Rest => Ok(()),
            Waveform::Sine {
                frequency: f,
                amplitude: a,
            }
            | Waveform::Square {
                frequency: f,
                amplitude: a,
            }
            | Waveform::Triangle {
                frequency: f,
                amplitude: a,
            } => frequency(f).and(amplitude(a)),
            Waveform::Ramped {
                frequency: f,
                amplitude: a,
                lambda,
            } => frequency(f)
                .and(amplitude(a))
                .and(within("lambda", lambda, 0.0, 0.5, "")),
            Waveform::Chirp {
                from,
                to,
                amplitude: a,
                duration,
            } => frequency(from)
                .and(frequency(to))
                .and(amplitude(a))
                .and(within("sweep time", duration, 1e-9, 1e6, "s")),
            Waveform::Table(ref table) => amplitude(table.amplitude()),
            Waveform::Periodic(ref periodic) => periodic.drive().check(),
        }
    }

    /// Largest voltage by magnitude \[V\].
    pub fn amplitude(&self) -> f64 {
        match self {
            Waveform::Rest => 0.0,
            Waveform::Sine { amplitude, .. }
            | Waveform::Square { amplitude, .. }
            | Waveform::Triangle { amplitude, .. }
            | Waveform::Ramped { amplitude, .. }
            | Waveform::Chirp { amplitude, .. } => amplitude.abs(),
            Waveform::Table(table) => table.amplitude(),
            Waveform::Periodic(periodic) => periodic.amplitude(),
        }
    }
}

/// Whether a value lies in its range; NaN does not.
fn within(what: &str, value: f64, low: f64, high: f64, unit: &str) -> Result<(), DriveError> {
    if value >= low && value <= high {
        return Ok(());
    }
    Err(DriveError::Value(format!(
        "{what} {} is outside {} .. {}",
        format_quantity(value, unit, 5),
        format_quantity(low, unit, 5),
        format_quantity(high, unit, 5)
    )))
}
