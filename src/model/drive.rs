//! The drive voltage as a sequence of smooth segments.
//!
//! The simulator restarts at each segment's start, so that steps, corners and changes
//! of the hysteresis branch are met exactly.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt;
use std::sync::Arc;

use thiserror::Error;

use super::piezo::Branch;
use super::unit::{UnitError, format_quantity, parse_quantity};

/// A drive that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DriveError {
    /// The text does not name a waveform.
    #[error(
        "\"{0}\" is not a drive; write rest, sine:F:A, square:F:A, triangle:F:A, ramped:F:A:LAMBDA, chirp:F0:F1:A, table:FILE or recorded"
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
    /// A value is out of its range.
    #[error("drive: {0}")]
    Value(String),
    /// A table that is no function of time.
    #[error("voltage table \"{name}\": {reason}")]
    Table { name: String, reason: String },
}

/// Voltage samples joined by straight lines; held before the first and after the last.
#[derive(Debug, Clone)]
pub struct VoltageTable {
    /// Where it is from, for people.
    pub name: String,
    time: Vec<f64>,
    voltage: Vec<f64>,
    /// Branch in force on the interval that starts at each sample.
    branch: Vec<Branch>,
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
    /// Builds a table from samples at increasing times [s]. A reversal smaller than
    /// `deadband` [V] counts as noise and does not change the hysteresis branch.
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
            return Err(fail(format!("sample {} is not a finite number", i + 1)));
        }
        if let Some(i) = time.windows(2).position(|w| w[1] <= w[0]) {
            return Err(fail(format!(
                "time does not increase after sample {}",
                i + 1
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
    /// `interval` [s] between `start` and `end`; jumps take a nanosecond.
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

    /// The samples: times [s] and voltages [V], as many of each.
    pub fn samples(&self) -> (&[f64], &[f64]) {
        (&self.time, &self.voltage)
    }

    /// The samples: times [s] and voltages [V].
    pub fn points(&self) -> (&[f64], &[f64]) {
        (&self.time, &self.voltage)
    }

    /// Time of the last sample [s].
    pub fn end(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    fn segment(&self, index: usize) -> Segment {
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
    /// Sine whose frequency goes linearly from `from` to `to` over `duration` [s].
    Chirp {
        from: f64,
        to: f64,
        amplitude: f64,
        duration: f64,
    },
    /// Straight lines through samples: a file, an editor, or a recording's own voltage.
    Table(Arc<VoltageTable>),
}

/// One smooth stretch of the drive. `shape` may be evaluated outside `start..end`,
/// where it continues smoothly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Begin [s].
    pub start: f64,
    /// End [s]; infinite where nothing more changes.
    pub end: f64,
    /// The voltage.
    pub shape: Shape,
    /// The hysteresis branch in force.
    pub branch: Branch,
}

/// A smooth voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Constant [V].
    Constant { voltage: f64 },
    /// `voltage + slope (t - at)`.
    Line { voltage: f64, slope: f64, at: f64 },
    /// `amplitude sin(omega (t - at))`.
    Sine { amplitude: f64, omega: f64, at: f64 },
    /// `amplitude sin(2 pi (from t + rate t^2 / 2))`.
    Chirp {
        amplitude: f64,
        from: f64,
        rate: f64,
    },
    /// `c0 + c1 u + c2 u^2 + c3 u^3`, `u = (t - at) / unit`.
    Cubic { c: [f64; 4], at: f64, unit: f64 },
}

impl Shape {
    /// Voltage [V] at `t` [s].
    #[inline]
    pub fn voltage(&self, t: f64) -> f64 {
        match *self {
            Shape::Constant { voltage } => voltage,
            Shape::Line { voltage, slope, at } => voltage + slope * (t - at),
            Shape::Sine {
                amplitude,
                omega,
                at,
            } => amplitude * (omega * (t - at)).sin(),
            Shape::Chirp {
                amplitude,
                from,
                rate,
            } => amplitude * (TAU * t * (from + 0.5 * rate * t)).sin(),
            Shape::Cubic { c, at, unit } => {
                let u = (t - at) / unit;
                c[0] + u * (c[1] + u * (c[2] + u * c[3]))
            }
        }
    }
}

fn direction(positive: bool) -> Branch {
    if positive {
        Branch::Rising
    } else {
        Branch::Falling
    }
}

impl Waveform {
    /// The segment of number `index`; segments follow one another without gaps, and
    /// each call costs the same.
    pub fn segment(&self, index: usize) -> Segment {
        match self {
            Waveform::Rest => Segment {
                start: f64::NEG_INFINITY,
                end: f64::INFINITY,
                shape: Shape::Constant { voltage: 0.0 },
                branch: Branch::Poled,
            },
            &Waveform::Square {
                frequency,
                amplitude,
            } => {
                let half = 0.5 / frequency;
                let up = index.is_multiple_of(2);
                let voltage = if up { amplitude } else { -amplitude };
                Segment {
                    start: index as f64 * half,
                    end: (index + 1) as f64 * half,
                    shape: Shape::Constant { voltage },
                    branch: direction(voltage >= 0.0),
                }
            }
            &Waveform::Sine {
                frequency,
                amplitude,
            } => {
                let (start, end, up) = quarter_shifted(index, frequency);
                Segment {
                    start,
                    end,
                    // Each segment counts its phase from its own start, so that late
                    // periods are as exact as the first.
                    shape: Shape::Sine {
                        amplitude: if up { amplitude } else { -amplitude },
                        omega: TAU * frequency,
                        at: index as f64 * 0.5 / frequency,
                    },
                    branch: direction(up == (amplitude >= 0.0)),
                }
            }
            &Waveform::Triangle {
                frequency,
                amplitude,
            } => {
                let (start, end, up) = quarter_shifted(index, frequency);
                let sign = if up { 1.0 } else { -1.0 };
                Segment {
                    start,
                    end,
                    shape: Shape::Line {
                        voltage: 0.0,
                        slope: sign * 4.0 * frequency * amplitude,
                        at: index as f64 * 0.5 / frequency,
                    },
                    branch: direction(up == (amplitude >= 0.0)),
                }
            }
            &Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            } => ramped_segment(index, frequency, amplitude, lambda),
            &Waveform::Chirp {
                from,
                to,
                amplitude,
                duration,
            } => chirp_segment(index, from, to, amplitude, duration),
            Waveform::Table(table) => table.segment(index),
        }
    }

    /// Number of the segment that holds `t` [s] (its start included).
    pub fn index_at(&self, t: f64) -> usize {
        let guess = match self {
            Waveform::Rest => return 0,
            Waveform::Square { frequency, .. } => 2.0 * frequency * t,
            Waveform::Sine { frequency, .. } | Waveform::Triangle { frequency, .. } => {
                2.0 * frequency * t + 0.5
            }
            Waveform::Ramped { frequency, .. } => 4.0 * (frequency * t).floor(),
            Waveform::Chirp {
                from, to, duration, ..
            } => {
                let t = t.clamp(0.0, *duration);
                let cycles = t * (from + 0.5 * (to - from) / duration * t);
                2.0 * cycles - 1.0
            }
            Waveform::Table(table) => {
                return table.time.partition_point(|&start| start <= t);
            }
        };
        let mut index = guess.max(0.0) as usize;
        index = index.saturating_sub(1);
        while self.segment(index).end <= t {
            index += 1;
        }
        index
    }

    /// Voltage [V] at `t` [s].
    pub fn voltage(&self, t: f64) -> f64 {
        self.segment(self.index_at(t)).shape.voltage(t)
    }

    /// The longest time over which the voltage repeats [s], if it does.
    pub fn period(&self) -> Option<f64> {
        match self {
            Waveform::Sine { frequency, .. }
            | Waveform::Square { frequency, .. }
            | Waveform::Triangle { frequency, .. }
            | Waveform::Ramped { frequency, .. } => Some(1.0 / frequency),
            _ => None,
        }
    }

    /// Checks all values.
    ///
    /// # Errors
    /// [`DriveError::Value`] naming the value and its range.
    pub fn check(&self) -> Result<(), DriveError> {
        let within = |what: &str, value: f64, low: f64, high: f64, unit: &str| {
            if value >= low && value <= high {
                Ok(())
            } else {
                Err(DriveError::Value(format!(
                    "{what} {} is outside {} .. {}",
                    format_quantity(value, unit, 5),
                    format_quantity(low, unit, 5),
                    format_quantity(high, unit, 5)
                )))
            }
        };
        let frequency = |f| within("frequency", f, 1e-6, 1e6, "Hz");
        let amplitude = |a: f64| within("amplitude", a, -1e4, 1e4, "V");
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
        }
    }

    /// Largest voltage by magnitude [V].
    pub fn amplitude(&self) -> f64 {
        match self {
            Waveform::Rest => 0.0,
            Waveform::Sine { amplitude, .. }
            | Waveform::Square { amplitude, .. }
            | Waveform::Triangle { amplitude, .. }
            | Waveform::Ramped { amplitude, .. }
            | Waveform::Chirp { amplitude, .. } => amplitude.abs(),
            Waveform::Table(table) => table.amplitude(),
        }
    }

    /// Reads the forms of the command line but for files: `square:15Hz:8V`. A chirp
    /// sweeps over `duration` [s].
    ///
    /// # Errors
    /// [`DriveError`]; `table:` and `recorded` are [`DriveError::Unknown`] here, as they
    /// need a file.
    pub fn parse(text: &str, duration: f64) -> Result<Self, DriveError> {
        let mut fields = text.trim().split(':');
        let name = fields
            .next()
            .unwrap_or_default()
            .trim()
            .to_ascii_lowercase();
        let fields: Vec<&str> = fields.collect();
        let (units, form): (&[&str], &'static str) = match name.as_str() {
            "rest" => (&[], "rest"),
            "sine" => (&["Hz", "V"], "sine:F:A"),
            "square" => (&["Hz", "V"], "square:F:A"),
            "triangle" => (&["Hz", "V"], "triangle:F:A"),
            "ramped" => (&["Hz", "V", ""], "ramped:F:A:LAMBDA"),
            "chirp" => (&["Hz", "Hz", "V"], "chirp:F0:F1:A"),
            _ => return Err(DriveError::Unknown(text.to_owned())),
        };
        if fields.len() != units.len() {
            return Err(DriveError::Fields {
                text: text.to_owned(),
                found: fields.len(),
                needed: units.len(),
                form,
            });
        }
        let mut values = [0.0; 3];
        for ((value, field), unit) in values.iter_mut().zip(&fields).zip(units) {
            *value = parse_quantity(field, unit).map_err(|source| DriveError::Quantity {
                text: text.to_owned(),
                source,
            })?;
        }
        let [a, b, c] = values;
        let waveform = match name.as_str() {
            "sine" => Waveform::Sine {
                frequency: a,
                amplitude: b,
            },
            "square" => Waveform::Square {
                frequency: a,
                amplitude: b,
            },
            "triangle" => Waveform::Triangle {
                frequency: a,
                amplitude: b,
            },
            "ramped" => Waveform::Ramped {
                frequency: a,
                amplitude: b,
                lambda: c,
            },
            "chirp" => Waveform::Chirp {
                from: a,
                to: b,
                amplitude: c,
                duration,
            },
            _ => Waveform::Rest,
        };
        waveform.check()?;
        Ok(waveform)
    }
}

impl fmt::Display for Waveform {
    /// The form that [`Waveform::parse`] reads, and `table:NAME`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Waveform::Rest => write!(f, "rest"),
            Waveform::Sine {
                frequency,
                amplitude,
            } => write!(f, "sine:{frequency}Hz:{amplitude}V"),
            Waveform::Square {
                frequency,
                amplitude,
            } => write!(f, "square:{frequency}Hz:{amplitude}V"),
            Waveform::Triangle {
                frequency,
                amplitude,
            } => write!(f, "triangle:{frequency}Hz:{amplitude}V"),
            Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            } => write!(f, "ramped:{frequency}Hz:{amplitude}V:{lambda}"),
            Waveform::Chirp {
                from,
                to,
                amplitude,
                ..
            } => write!(f, "chirp:{from}Hz:{to}Hz:{amplitude}V"),
            Waveform::Table(table) => write!(f, "table:{}", table.name),
        }
    }
}

/// Segment `index` of a waveform that turns at T/4, 3T/4, ...: start, end, rising.
fn quarter_shifted(index: usize, frequency: f64) -> (f64, f64, bool) {
    let half = 0.5 / frequency;
    let start = if index == 0 {
        f64::NEG_INFINITY
    } else {
        (index as f64 - 0.5) * half
    };
    (start, (index as f64 + 0.5) * half, index.is_multiple_of(2))
}

fn ramped_segment(index: usize, frequency: f64, amplitude: f64, lambda: f64) -> Segment {
    let period = 1.0 / frequency;
    let ramp = lambda * period;
    let half = (index / 2) as f64 * 0.5 * period;
    let up = (index / 2).is_multiple_of(2);
    let target = if up { amplitude } else { -amplitude };
    let branch = direction(target >= 0.0);
    if index.is_multiple_of(2) {
        let shape = if ramp > 0.0 {
            Shape::Line {
                voltage: -target,
                slope: 2.0 * target / ramp,
                at: half,
            }
        } else {
            Shape::Constant { voltage: target }
        };
        Segment {
            start: half,
            end: half + ramp,
            shape,
            branch,
        }
    } else {
        Segment {
            start: half + ramp,
            // At lambda = 1/2 there is no plateau; rounding must not turn it around.
            end: ((index / 2 + 1) as f64 * 0.5 * period).max(half + ramp),
            shape: Shape::Constant { voltage: target },
            branch,
        }
    }
}

/// Segments of a sweep end where its phase passes pi/2 + k pi, and at its end.
fn chirp_segment(index: usize, from: f64, to: f64, amplitude: f64, duration: f64) -> Segment {
    let rate = (to - from) / duration;
    let phase_end = TAU * duration * (from + 0.5 * rate * duration);
    // Turns inside the sweep: k = 0 .. turns.
    let turns = ((phase_end - FRAC_PI_2) / PI).ceil().max(0.0) as usize;
    let turn = |k: usize| -> f64 {
        let cycles = (FRAC_PI_2 + k as f64 * PI) / TAU;
        // from t + rate t^2 / 2 = cycles, in the form that stays exact for rate -> 0.
        let root = (from * from + 2.0 * rate * cycles).max(0.0).sqrt();
        2.0 * cycles / (from + root)
    };
    let start = match index {
        0 => f64::NEG_INFINITY,
        i if i <= turns => turn(i - 1),
        _ => duration,
    };
    if index > turns {
        let voltage = amplitude * phase_end.sin();
        return Segment {
            start,
            end: f64::INFINITY,
            shape: Shape::Constant { voltage },
            branch: direction(turns.is_multiple_of(2) == (amplitude >= 0.0)),
        };
    }
    Segment {
        start,
        end: if index < turns { turn(index) } else { duration },
        shape: Shape::Chirp {
            amplitude,
            from,
            rate,
        },
        branch: direction(index.is_multiple_of(2) == (amplitude >= 0.0)),
    }
}

#[cfg(test)]
#[path = "drive_tests.rs"]
mod tests;
