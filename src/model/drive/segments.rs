//! Each waveform cut where it turns, steps or changes the hysteresis branch.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Segment, Shape, Waveform};
use crate::model::piezo::Branch;

/// Last index: above, neighbouring numbers of segments are the same `f64`.
const MAX_INDEX: f64 = 4e15;

/// Segments by which a guessed index may be wrong.
const MAX_INDEX_CORRECTIONS: usize = 16;

pub(super) fn direction(positive: bool) -> Branch {
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
                        offset: 0.0,
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
            Waveform::Periodic(periodic) => periodic.segment(index),
        }
    }

    /// Number of the segment that holds `t` \[s\] (its start included).
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
            Waveform::Table(table) => return table.index_at(t),
            Waveform::Periodic(periodic) => return periodic.index_at(t),
        };
        let mut index = guess.clamp(0.0, MAX_INDEX) as usize;
        index = index.saturating_sub(1);
        // The guess is off by rounding only. At times so late that segments are shorter than
        // rounding, no index is better than another.
        for _ in 0..MAX_INDEX_CORRECTIONS {
            if self.segment(index).end > t {
                break;
            }
            index = index.saturating_add(1);
        }
        index
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
            phase: 0.0,
            from,
            rate,
            offset: 0.0,
        },
        branch: direction(index.is_multiple_of(2) == (amplitude >= 0.0)),
    }
}
