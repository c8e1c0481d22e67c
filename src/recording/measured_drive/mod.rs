//! The drive that acted, from a measured voltage.
//!
//! A recorder gives the voltage at instants, with noise. What acted between them matters: an edge
//! placed 10 us late moves the proof mass by micrometres, and a branch of the hysteresis loop chosen
//! by noise by as much. [`measured_drive`] therefore asks what waveform the samples are those of,
//! within their own error: a level, straight lines with corners and edges (repeating or not),
//! sinusoids, sweeps, sums of sines. Where they are, it is that waveform, with the settings a person
//! would have chosen where the samples allow them. Else it is the smoothest curve that the samples
//! allow. Few or uneven points that somebody typed are joined by straight lines.

mod chosen;
mod cycle;
mod freedom;
mod knots;
mod least_squares;
mod lines;
mod pieces;
mod round_number;
mod samples;
mod sinusoid;
mod smooth;
#[cfg(test)]
mod tests;
mod thresholds;
mod words;

use std::sync::Arc;

use self::cycle::{Cycle, cycle_of};
pub use self::freedom::DriveFreedom;
use self::knots::Knots;
use self::lines::{Lines, find_lines};
use self::samples::{Samples, Span};
use self::sinusoid::{Sinusoids, find_sinusoids};
use self::thresholds::{FIRST_LINE_SAMPLES, MAX_FIT_SAMPLES};
pub use crate::model::drive::DriveReading;
use crate::model::drive::{DriveError, MeasuredVoltage, Segment, VoltageTable, Waveform};

/// A table of fewer samples than this is somebody's list of points, not a recording of a
/// digitiser: straight lines join them.
pub const MIN_MEASURED_SAMPLES: usize = 64;

/// An instant at which the drive's force jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveEdge {
    /// Index of the piece that begins there.
    pub piece: usize,
    /// Best estimate \[s\].
    pub time: f64,
    /// Its standard deviation \[s\].
    pub sigma: f64,
    /// Farthest from the estimate that the samples allow \[s\].
    pub reach: f64,
}

/// What the samples were found to be.
#[derive(Debug, Clone, PartialEq)]
enum Found {
    /// Straight lines that repeat.
    Cycle(Cycle),
    /// Straight lines.
    Lines(Knots),
    /// Sines, sweeps.
    Sinusoids(Sinusoids),
    /// No known waveform.
    Smooth,
    /// Few points, or told so.
    Points,
    /// Not asked: a waveform was chosen, with this period \[s\] if it has one.
    Chosen(Option<f64>),
}

/// The drive of a measured voltage.
#[derive(Debug, Clone)]
pub struct MeasuredDrive {
    /// Smooth pieces in order of time, without gaps, the first from minus and the last to plus
    /// infinity.
    pub pieces: Vec<Segment>,
    /// Where the force jumps.
    pub edges: Vec<DriveEdge>,
    /// Standard deviation of a voltage sample's error \[V\].
    pub noise: f64,
    /// What was found, in words: `square 15 Hz ±8 V, edges known to 0.3 us, noise 4 mV`.
    pub text: String,
    /// The same as typed on the command line where there is such a form: `square:15Hz:8V`.
    pub command: Option<String>,
    /// Whether the samples are those of a known waveform.
    pub recognised: bool,
    /// What of the waveform the samples leave open.
    pub freedoms: Vec<DriveFreedom>,
    span: Span,
    found: Found,
}

/// The drive that acted when `volts` \[V\] were measured at `time` \[s\], increasing.
///
/// # Errors
/// [`DriveError::Table`] if there are none, not as many of each, or times do not increase.
///
/// # Examples
/// ```
/// use impactscope::model::drive::Waveform;
/// use impactscope::recording::measured_drive::{DriveReading, measured_drive};
///
/// let drive = Waveform::parse("ramped:5Hz:8V:0.25", 1.0)?;
/// let time: Vec<f64> = (0..50_000).map(|i| f64::from(i) / 50e3).collect();
/// let volts: Vec<f64> = time.iter().map(|&t| drive.voltage(t)).collect();
/// let found = measured_drive("scope.csv", &time, &volts, DriveReading::Recognised)?;
/// assert_eq!(found.command.as_deref(), Some("ramped:5Hz:8V:0.25"));
/// # Ok::<(), impactscope::model::drive::DriveError>(())
/// ```
pub fn measured_drive(
    name: &str,
    time: &[f64],
    volts: &[f64],
    reading: DriveReading,
) -> Result<MeasuredDrive, DriveError> {
    VoltageTable::check(name, time, volts)?;
    let samples = Samples::new(time, volts);
    let found = match reading {
        DriveReading::PointByPoint => Found::Points,
        _ if samples.len() < MIN_MEASURED_SAMPLES => Found::Points,
        DriveReading::Recognised if !samples.are_of_a_digitiser() => Found::Points,
        DriveReading::Smoothed => Found::Smooth,
        DriveReading::Recognised => recognise(&samples),
    };
    let span = samples.in_time();
    let (pieces, edges) = match &found {
        Found::Cycle(cycle) => pieces::of_knots(span, &cycle.expand(span)),
        Found::Lines(knots) => pieces::of_knots(span, knots),
        Found::Sinusoids(sinusoids) => pieces::of_sinusoids(span, sinusoids),
        Found::Smooth => pieces::smoothed(&samples),
        Found::Points | Found::Chosen(_) => pieces::of_knots(span, &pieces::points(&samples)),
    };
    let text = words::describe(&samples, &found, &edges);
    let freedoms = freedom::of(&samples, &found, &pieces, &edges);
    Ok(MeasuredDrive {
        pieces,
        edges,
        noise: samples.sigma,
        text,
        command: words::command(&found),
        recognised: !matches!(found, Found::Smooth | Found::Points),
        freedoms,
        span,
        found,
    })
}

/// The waveform that the samples are those of, the plainest first.
fn recognise(samples: &Samples<'_>) -> Found {
    if let Some(sinusoids) = sinusoids_before_lines(samples) {
        return Found::Sinusoids(sinusoids);
    }
    let lines = are_likely_lines(samples)
        .then(|| find_lines(samples))
        .flatten();
    let Some(lines) = lines else {
        return find_sinusoids(samples).map_or(Found::Smooth, Found::Sinusoids);
    };
    if let Some(cycle) = cycle_of(samples, samples, &Knots::of(samples, &lines)) {
        return Found::Cycle(cycle);
    }
    // A first or last line of few samples is not seen well; what the others repeat says what it is.
    let (from, to) = inner_samples(samples, &lines);
    if (from, to) != (0, samples.len()) {
        let inner = samples.part(from, to);
        let cycle = find_lines(&inner)
            .and_then(|lines| cycle_of(samples, &inner, &Knots::of(&inner, &lines)));
        if let Some(cycle) = cycle {
            return Found::Cycle(cycle);
        }
    }
    let knots = Knots::of(samples, &lines);
    if let Some(typed) = knots.typed(samples) {
        return Found::Lines(typed);
    }
    let rounded = knots.rounded();
    if rounded.are_all_of(samples) {
        return Found::Lines(rounded);
    }
    Found::Lines(knots)
}

/// Whether the first samples of a long voltage are lines: a smooth one is not cut into many.
fn are_likely_lines(samples: &Samples<'_>) -> bool {
    samples.len() <= 2 * FIRST_LINE_SAMPLES
        || find_lines(&samples.part(0, FIRST_LINE_SAMPLES)).is_some()
}

/// The range of samples without the first and the last line.
fn inner_samples(samples: &Samples<'_>, lines: &Lines) -> (usize, usize) {
    let index = |t: f64| samples.time.partition_point(|&s| s <= t);
    if let [first, .., last] = lines.nodes[..] {
        let (from, to) = (index(first.high) + 1, index(last.low).saturating_sub(1));
        if to >= from + MIN_MEASURED_SAMPLES {
            return (from, to);
        }
    }
    (0, samples.len())
}

/// A sinusoid is asked for first where it is likely: lines would follow it in many short pieces.
fn sinusoids_before_lines(samples: &Samples<'_>) -> Option<Sinusoids> {
    // The middle half of a sine's span holds a third of its samples, of a triangle's half of them.
    let (low, high) = samples.range;
    let quarter = 0.25 * (high - low);
    let middle = samples.thinned(MAX_FIT_SAMPLES).filter(|&i| {
        let v = samples.volts[i];
        v > low + quarter && v < high - quarter
    });
    let share = middle.count() as f64 / samples.thinned(MAX_FIT_SAMPLES).count() as f64;
    (share > 0.2 && share < 0.45)
        .then(|| find_sinusoids(samples))
        .flatten()
}

impl MeasuredDrive {
    /// The time after which the waveform comes again \[s\], if it does.
    #[must_use]
    pub fn period(&self) -> Option<f64> {
        match &self.found {
            Found::Cycle(cycle) => Some(cycle.period),
            Found::Sinusoids(s) => match s.parts[..] {
                [part] if part.rate == 0.0 => Some(1.0 / part.from.abs()),
                _ => None,
            },
            Found::Chosen(period) => *period,
            Found::Lines(_) | Found::Smooth | Found::Points => None,
        }
    }

    /// By how much all edges together may lie earlier or later \[s\].
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.edges.iter().map(|e| e.reach).fold(0.0, f64::max)
    }

    /// The same with its freedoms at other values, as many as there are, each 0 for what was found.
    #[must_use]
    pub fn changed(&self, values: &[f64]) -> Self {
        let first_knot = match &self.found {
            Found::Cycle(cycle) => cycle.first_knot(self.span),
            _ => 0,
        };
        let (pieces, edges) = match freedom::changed(&self.found, values) {
            Some(Found::Cycle(cycle)) => {
                pieces::of_knots(self.span, &cycle.expand_from(self.span, first_knot))
            }
            Some(Found::Sinusoids(sinusoids)) => pieces::of_sinusoids(self.span, &sinusoids),
            _ if matches!(self.found, Found::Smooth) => {
                pieces::with_turns(&self.pieces, &self.edges, values)
            }
            _ => return self.clone(),
        };
        Self {
            pieces,
            edges,
            ..self.clone()
        }
    }

    /// As a waveform for the simulator, `shift` \[s\] later than measured.
    #[must_use]
    pub fn waveform(&self, name: &str, shift: f64) -> Waveform {
        let pieces = self.pieces.iter().map(|p| p.shifted(shift)).collect();
        Waveform::Table(Arc::new(VoltageTable::of_pieces(
            name,
            pieces,
            self.text.clone(),
        )))
    }
}

/// Samples of a file as a drive: few of them as points that can be edited, more as the drive that
/// acted when they were measured.
///
/// # Errors
/// As [`measured_drive`].
pub fn drive_of_samples(
    name: &str,
    time: Vec<f64>,
    voltage: Vec<f64>,
    reading: DriveReading,
) -> Result<Waveform, DriveError> {
    let table = if time.len() < MIN_MEASURED_SAMPLES || reading == DriveReading::PointByPoint {
        VoltageTable::new(name, time, voltage)?
    } else {
        let drive = measured_drive(name, &time, &voltage, reading)?;
        VoltageTable::of_pieces(name, drive.pieces, drive.text).with_source(MeasuredVoltage {
            time,
            voltage,
            reading,
        })
    };
    Ok(Waveform::Table(Arc::new(table)))
}
