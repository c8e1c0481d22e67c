//! One period of a voltage drawn by handles: straight lines, or a smooth curve that never
//! overshoots them.
//!
//! The smooth curve is the monotone cubic of Fritsch and Carlson (SIAM J. Numer. Anal. 17,
//! 238 (1980)) with the slopes of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 300
//! (1984)), which is also SciPy's `PchipInterpolator`. It turns at handles only, so that the
//! hysteresis branch changes at handles only.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::{DriveError, HIGHEST_VOLTAGE, Segment, Shape, within};
use crate::model::piezo::Branch;

/// Most handles of a period: far more than a hand draws; a longer list is a table.
pub const MAX_HANDLES: usize = 1000;

/// Handles at different times are at least this share of a period apart; nearer ones would be
/// steeper than any amplifier, and than rounding allows.
const MIN_HANDLE_GAP: f64 = 1e-9;

/// Parts of a period that are shorter than this share of it are steps.
const MIN_PIECE: f64 = 1e-12;

/// A point of a drawn period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handle {
    /// When, as a share of the period, 0 to 1.
    pub time: f64,
    /// Voltage without the drive's offset \[V\].
    pub voltage: f64,
}

/// What leads from handle to handle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// Straight lines.
    #[default]
    Linear,
    /// A monotone cubic: smooth, and between two handles never beyond them.
    Smooth,
}

impl Interpolation {
    /// The word of the text form.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Smooth => "smooth",
        }
    }
}

/// A drawn period. Two handles at one time are a step; so are one at 0 and one at 1 with other
/// voltages. From the last handle the curve leads to the first one of the next period.
#[derive(Debug, Clone, PartialEq)]
pub struct Handles {
    points: Vec<Handle>,
    interpolation: Interpolation,
}

impl Handles {
    /// Handles in order of time.
    ///
    /// # Errors
    /// [`DriveError::Value`] if there are none or more than [`MAX_HANDLES`], if one lies outside
    /// the period or is out of order, or if three lie at one time.
    pub fn new(points: Vec<Handle>, interpolation: Interpolation) -> Result<Self, DriveError> {
        let fail = |text: String| Err(DriveError::Value(text));
        if points.is_empty() || points.len() > MAX_HANDLES {
            return fail(format!(
                "{} handles; draw a period with 1 to {MAX_HANDLES}",
                points.len()
            ));
        }
        for (i, point) in points.iter().enumerate() {
            let name = |what| format!("{what} of handle {}", i + 1);
            within(&name("time"), point.time, 0.0, 1.0, "")?;
            let limit = HIGHEST_VOLTAGE;
            within(&name("voltage"), point.voltage, -limit, limit, "V")?;
        }
        if let Some(i) = points.windows(2).position(|w| w[1].time < w[0].time) {
            return fail(format!(
                "handle {} at {} comes after handle {} at {}; put them in order of time",
                i + 2,
                points[i + 1].time,
                i + 1,
                points[i].time
            ));
        }
        let next = |i: usize| match points.get(i + 1) {
            Some(point) => point.time,
            None => points[0].time + 1.0,
        };
        let gaps = (0..points.len()).map(|i| (i, next(i) - points[i].time));
        if let Some((i, gap)) = gaps
            .into_iter()
            .find(|&(_, gap)| gap > 0.0 && gap < MIN_HANDLE_GAP)
        {
            return fail(format!(
                "handle {} is {gap:e} of a period before the next one; put them at one time, or {MIN_HANDLE_GAP:e} apart",
                i + 1
            ));
        }
        // The end of the period is the start of the next one.
        let instant = |p: &Handle| if p.time == 1.0 { 0.0 } else { p.time };
        let mut instants: Vec<f64> = points.iter().map(instant).collect();
        instants.sort_by(f64::total_cmp);
        if let Some(three) = instants.windows(3).find(|w| w[0] == w[2]) {
            return fail(format!(
                "three handles at {} of the period; a step has two",
                three[0]
            ));
        }
        Ok(Self {
            points,
            interpolation,
        })
    }

    /// The handles in order of time.
    pub fn points(&self) -> &[Handle] {
        &self.points
    }

    /// What leads from one to the next.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Largest voltage by magnitude \[V\]; between handles none is larger.
    pub fn amplitude(&self) -> f64 {
        let voltages = self.points.iter().map(|p| p.voltage.abs());
        voltages.fold(0.0, f64::max)
    }

    /// All voltages times `factor`.
    ///
    /// # Errors
    /// [`DriveError::Value`] if one is then out of range.
    pub fn scaled(&self, factor: f64) -> Result<Self, DriveError> {
        let scale = |p: &Handle| Handle {
            time: p.time,
            voltage: p.voltage * factor,
        };
        Self::new(self.points.iter().map(scale).collect(), self.interpolation)
    }

    /// The period as smooth pieces in order of time, in shares of the period from 0 to 1. The
    /// branches are still to be found.
    pub(super) fn pieces(&self) -> Vec<Segment> {
        let mut pieces = Vec::new();
        for (arc, is_closed) in self.arcs() {
            let slopes = match self.interpolation {
                Interpolation::Smooth if arc.len() > 2 || is_closed => {
                    monotone_slopes(&arc, is_closed)
                }
                _ => Vec::new(),
            };
            for i in 0..arc.len() - 1 {
                let ends = slopes.get(i).copied().zip(slopes.get(i + 1).copied());
                push_within_period(&mut pieces, piece(arc[i], arc[i + 1], ends));
            }
        }
        pieces.sort_by(|a: &Segment, b| a.start.total_cmp(&b.start));
        pieces
    }

    /// The handles cut at steps, with unwrapped times; closed if there is no step, then the last
    /// is the first one a period later.
    fn arcs(&self) -> Vec<(Vec<Handle>, bool)> {
        let mut points: Vec<Handle> = Vec::with_capacity(self.points.len() + 1);
        for point in &self.points {
            if points.last() != Some(point) {
                points.push(*point);
            }
        }
        let n = points.len();
        let (first, last) = (points[0], points[n - 1]);
        if n > 1 && last.time == first.time + 1.0 && last.voltage == first.voltage {
            points.pop();
        }
        let n = points.len();
        let later = |i: usize| Handle {
            time: points[i % n].time + (i / n) as f64,
            voltage: points[i % n].voltage,
        };
        let is_step = |i: usize| later(i).time == later(i + 1).time;
        let Some(step) = (0..n).find(|&i| is_step(i)) else {
            return vec![((0..=n).map(later).collect(), true)];
        };
        let mut arcs = vec![(Vec::new(), false)];
        for i in step + 1..=step + n {
            if let Some((arc, _)) = arcs.last_mut() {
                arc.push(later(i));
            }
            if is_step(i) && i < step + n {
                arcs.push((Vec::new(), false));
            }
        }
        arcs
    }
}

/// From `a` to `b`, straight or, with slopes at both, as the cubic of Hermite.
fn piece(a: Handle, b: Handle, slopes: Option<(f64, f64)>) -> Segment {
    let (width, rise) = (b.time - a.time, b.voltage - a.voltage);
    let shape = match slopes {
        _ if rise == 0.0 => Shape::Constant { voltage: a.voltage },
        Some((from, to)) => {
            let (from, to) = (from * width, to * width);
            Shape::Cubic {
                c: [
                    a.voltage,
                    from,
                    3.0 * rise - 2.0 * from - to,
                    from + to - 2.0 * rise,
                ],
                at: a.time,
                unit: width,
            }
        }
        None => Shape::Line {
            voltage: a.voltage,
            slope: rise / width,
            at: a.time,
        },
    };
    Segment {
        start: a.time,
        end: b.time,
        shape,
        branch: Branch::Rising,
    }
}

/// Adds a piece to those of the period from 0 to 1, in two if it leads over the end.
fn push_within_period(pieces: &mut Vec<Segment>, piece: Segment) {
    if piece.start >= 1.0 {
        pieces.push(piece.shifted(-1.0));
        return;
    }
    pieces.push(Segment {
        end: piece.end.min(1.0),
        ..piece
    });
    if piece.end > 1.0 {
        pieces.push(Segment {
            start: 0.0,
            ..piece.shifted(-1.0)
        });
    }
}

/// Slopes \[V per period\] of the monotone cubic at the points of an arc.
fn monotone_slopes(arc: &[Handle], is_closed: bool) -> Vec<f64> {
    let n = arc.len();
    let width: Vec<f64> = arc.windows(2).map(|w| w[1].time - w[0].time).collect();
    let secant: Vec<f64> = (0..n - 1)
        .map(|i| (arc[i + 1].voltage - arc[i].voltage) / width[i])
        .collect();
    let inner = |before: usize, after: usize| {
        let (h0, h1, s0, s1) = (width[before], width[after], secant[before], secant[after]);
        // At a turn the curve is level.
        if s0 * s1 <= 0.0 {
            return 0.0;
        }
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / s0 + w1 / s1)
    };
    let mut slopes = vec![0.0; n];
    for (i, slope) in slopes.iter_mut().enumerate().take(n - 1).skip(1) {
        *slope = inner(i - 1, i);
    }
    if is_closed {
        slopes[0] = inner(n - 2, 0);
        slopes[n - 1] = slopes[0];
    } else {
        slopes[0] = end_slope((width[0], width[1]), (secant[0], secant[1]));
        slopes[n - 1] = end_slope((width[n - 2], width[n - 3]), (secant[n - 2], secant[n - 3]));
    }
    slopes
}

/// Slope at an end of an arc: that of the parabola through three points, limited so that the
/// curve stays monotone.
fn end_slope((h0, h1): (f64, f64), (s0, s1): (f64, f64)) -> f64 {
    let slope = ((2.0 * h0 + h1) * s0 - h0 * s1) / (h0 + h1);
    if slope * s0 <= 0.0 {
        0.0
    } else if s0 * s1 <= 0.0 && slope.abs() > 3.0 * s0.abs() {
        3.0 * s0
    } else {
        slope
    }
}

/// A sine of `amplitude` \[V\] over one period, cut where it turns.
pub(super) fn sine_pieces(amplitude: f64) -> Vec<Segment> {
    // Start, end and the zero from which the phase is counted.
    let parts = [(0.0, 0.25, 0.0), (0.25, 0.75, 0.5), (0.75, 1.0, 1.0)];
    parts
        .map(|(start, end, at)| Segment {
            start,
            end,
            shape: Shape::Sine {
                amplitude: if at == 0.5 { -amplitude } else { amplitude },
                omega: TAU,
                at,
                offset: 0.0,
            },
            branch: Branch::Rising,
        })
        .to_vec()
}

/// Straight lines through points at times that do not decrease, from 0 to 1; steps where two
/// fall together.
pub(super) fn line_pieces(points: &[(f64, f64)]) -> Vec<Segment> {
    let handle = |(time, voltage)| Handle { time, voltage };
    let pairs = points.windows(2).filter(|w| w[1].0 - w[0].0 > MIN_PIECE);
    pairs
        .map(|w| piece(handle(w[0]), handle(w[1]), None))
        .collect()
}
