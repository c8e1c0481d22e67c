//! Where a drive goes beyond what an amplifier or a film stands.

use super::error::{WaveformError, named};
use crate::model::drive::{Segment, Shape, Waveform};

/// Parts of a curved piece by which the places are bracketed where its slope passes a limit; the
/// steepest instant is one more.
const SLOPE_PARTS: usize = 64;

/// Halvings that find an instant within a piece to the last bit.
const EDGE_HALVINGS: usize = 60;

/// Excesses with less than this share of the period between them are one.
const SAME_INSTANT: f64 = 1e-9;

/// Steps below this share of the largest voltage are rounding.
const STEP_TOLERANCE: f64 = 1e-9;

/// What a drive should not exceed; `None` is no limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveLimits {
    /// Voltage by magnitude \[V\].
    pub voltage: Option<f64>,
    /// Rate of change by magnitude \[V/s\]; a step exceeds any.
    pub slew: Option<f64>,
}

/// Which limit is exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExcessKind {
    /// The voltage.
    Voltage,
    /// The rate of change.
    Slew,
}

/// A place where a limit is exceeded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Which one.
    pub kind: ExcessKind,
    /// Begin, as a share of the period after which the drive repeats.
    pub from: f64,
    /// End; equal to `from` for a step.
    pub to: f64,
    /// Largest magnitude there, V or V/s; infinite for a step.
    pub value: f64,
}

/// The places of one period where a drive exceeds limits, in order of time, those of the voltage
/// first.
///
/// # Errors
/// [`WaveformError::NoPeriod`] for a drive that does not repeat, unless it never changes.
pub fn excesses(waveform: &Waveform, limits: &DriveLimits) -> Result<Vec<Excess>, WaveformError> {
    if matches!(waveform, Waveform::Rest) {
        return Ok(Vec::new());
    }
    let Some(period) = waveform.period() else {
        return Err(WaveformError::NoPeriod {
            drive: named(waveform),
            action: "limits are shown for",
        });
    };
    let (mut voltage, mut slew) = (Vec::new(), Vec::new());
    for index in waveform.index_at(period).. {
        let whole = waveform.segment(index);
        if whole.start >= (2.0 - SAME_INSTANT) * period {
            break;
        }
        let piece = Segment {
            start: whole.start.max(period),
            end: whole.end.min(2.0 * period),
            ..whole
        };
        let share = |t: f64| (t / period - 1.0).clamp(0.0, 1.0);
        if let Some(limit) = limits.voltage {
            let found = voltage_excesses(&piece, limit);
            add(&mut voltage, found, ExcessKind::Voltage, share);
        }
        if let Some(limit) = limits.slew {
            // A step at the start of the period is one of this period, one at its end is not.
            if whole.start >= period * (1.0 - SAME_INSTANT) && index > 0 {
                let before = waveform.segment(index - 1);
                let step = whole.shape.voltage(whole.start) - before.shape.voltage(before.end);
                if step.abs() > STEP_TOLERANCE * waveform.amplitude() {
                    let at = (whole.start, whole.start, f64::INFINITY);
                    add(&mut slew, vec![at], ExcessKind::Slew, share);
                }
            }
            add(
                &mut slew,
                slew_excesses(&piece, limit),
                ExcessKind::Slew,
                share,
            );
        }
    }
    voltage.append(&mut slew);
    Ok(voltage)
}

/// Adds places \[s\]; one that goes on where the last one of its kind ended is a part of it.
fn add(
    all: &mut Vec<Excess>,
    found: Vec<(f64, f64, f64)>,
    kind: ExcessKind,
    share: impl Fn(f64) -> f64,
) {
    for (from, to, value) in found {
        let (from, to) = (share(from), share(to));
        match all.last_mut() {
            // A step stays a place of its own.
            Some(last)
                if from - last.to <= SAME_INSTANT
                    && value.is_finite()
                    && last.value.is_finite() =>
            {
                last.to = to;
                last.value = last.value.max(value);
            }
            _ => all.push(Excess {
                kind,
                from,
                to,
                value,
            }),
        }
    }
}

/// Where a monotone piece is beyond a voltage by magnitude: begin, end, largest.
fn voltage_excesses(piece: &Segment, limit: f64) -> Vec<(f64, f64, f64)> {
    let (start, end) = (piece.start, piece.end);
    let value = |t: f64| piece.shape.voltage(t);
    let mut found = Vec::new();
    for sign in [1.0, -1.0] {
        let is_beyond = |t: f64| sign * value(t) > limit * (1.0 + VOLTAGE_ROUNDING);
        let largest = value(start).abs().max(value(end).abs());
        match (is_beyond(start), is_beyond(end)) {
            (true, true) => found.push((start, end, largest)),
            (true, false) => found.push((start, edge(start, end, is_beyond), value(start).abs())),
            (false, true) => found.push((edge(end, start, is_beyond), end, value(end).abs())),
            (false, false) => {}
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// A voltage beyond its limit by less than this share of it is at the limit: lines meet their ends
/// but for rounding.
const VOLTAGE_ROUNDING: f64 = 1e-9;

/// Where a piece is steeper than a limit: begin, end, steepest.
fn slew_excesses(piece: &Segment, limit: f64) -> Vec<(f64, f64, f64)> {
    let (start, end) = (piece.start, piece.end);
    let slope = |t: f64| piece.shape.slope(t).abs();
    let steepest = match piece.shape {
        Shape::Constant { .. } => return Vec::new(),
        Shape::Line { .. } => {
            let beyond = slope(start) > limit;
            return if beyond {
                vec![(start, end, slope(start))]
            } else {
                Vec::new()
            };
        }
        Shape::Cubic { c, at, unit } => at - unit * c[2] / (3.0 * c[3]),
        Shape::Sine { at, .. } => at,
        // Of a sweep, its faster end.
        Shape::Chirp { .. } => end,
    };
    let mut times: Vec<f64> = (0..=SLOPE_PARTS)
        .map(|i| start + (end - start) * i as f64 / SLOPE_PARTS as f64)
        .collect();
    if steepest > start && steepest < end {
        times.push(steepest);
        times.sort_by(f64::total_cmp);
    }
    let is_beyond = |t: f64| slope(t) > limit;
    let mut found: Vec<(f64, f64, f64)> = Vec::new();
    let mut open: Option<(f64, f64)> = None;
    for (i, &t) in times.iter().enumerate() {
        open = match (open, is_beyond(t)) {
            (None, true) => {
                let before = i.checked_sub(1).map(|b| times[b]);
                let from = before.map_or(t, |before| edge(t, before, is_beyond));
                Some((from, slope(t)))
            }
            (Some((from, most)), true) => Some((from, most.max(slope(t)))),
            (Some((from, most)), false) => {
                found.push((from, edge(times[i - 1], t, is_beyond), most));
                None
            }
            (None, false) => None,
        };
    }
    found.extend(open.map(|(from, most)| (from, end, most)));
    found
}

/// The last instant at which `holds`, between one where it does and one where it does not.
fn edge(mut holding: f64, mut other: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..EDGE_HALVINGS {
        let middle = 0.5 * (holding + other);
        if holds(middle) {
            holding = middle;
        } else {
            other = middle;
        }
    }
    holding
}
