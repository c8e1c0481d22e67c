//! Drive voltages as smooth pieces, and what the amplifier makes of them.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Distance of the points of a delayed voltage \[s\].
const DELAY_GRID_STEP: f64 = 1e-6;

/// A periodic drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "shape")]
pub enum Waveform {
    /// `A sin(2 pi f t)`.
    Sine { frequency: f64, amplitude: f64 },
    /// `+A` for half a period, then `-A`.
    Square { frequency: f64, amplitude: f64 },
    /// Rises over `lambda T`, holds to `T/2`, falls over `lambda T`, holds.
    Ramped {
        frequency: f64,
        amplitude: f64,
        lambda: f64,
    },
}

impl Waveform {
    /// As typed on the command line: `square:15Hz:8V`.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Waveform::Sine {
                frequency,
                amplitude,
            } => format!("sine:{frequency}Hz:{amplitude}V"),
            Waveform::Square {
                frequency,
                amplitude,
            } => format!("square:{frequency}Hz:{amplitude}V"),
            Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            } => format!("ramped:{frequency}Hz:{amplitude}V:{lambda}"),
        }
    }
}

/// Values and slopes at even times, joined by cubics.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    start: f64,
    step: f64,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Samples {
    fn at(&self, t: f64) -> f64 {
        let u = ((t - self.start) / self.step).clamp(0.0, (self.values.len() - 1) as f64);
        let i = (u as usize).min(self.values.len() - 2);
        let s = u - i as f64;
        let (a, b) = (self.values[i], self.values[i + 1]);
        let (da, db) = (self.step * self.slopes[i], self.step * self.slopes[i + 1]);
        let r = 1.0 - s;
        a * r * r * (1.0 + 2.0 * s) + b * s * s * (3.0 - 2.0 * s) + s * r * (da * r - db * s)
    }
}

/// A smooth stretch of voltage.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// `v + slope (t - start)`, `start` that of the piece's own waveform.
    Line { start: f64, v: f64, slope: f64 },
    /// `amplitude sin(omega t)`.
    Sine { amplitude: f64, omega: f64 },
    /// A delayed voltage.
    Samples(Arc<Samples>),
}

impl Shape {
    /// Voltage \[V\] at `t` \[s\].
    #[inline]
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        match self {
            Shape::Line { start, v, slope } => v + slope * (t - start),
            Shape::Sine { amplitude, omega } => amplitude * (omega * t).sin(),
            Shape::Samples(samples) => samples.at(t),
        }
    }
}

/// A stretch on which the voltage is smooth and monotone.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// From \[s\].
    pub start: f64,
    /// To \[s\].
    pub end: f64,
    /// The voltage.
    pub shape: Shape,
    /// Whether the rising branch is in force.
    pub rising: bool,
    /// Earlier extremes of the voltage that are still remembered, oldest first.
    pub memory: Vec<f64>,
}

/// The pieces of a drive from 0 to `duration` \[s\] and a little beyond.
#[must_use]
pub fn pieces(waveform: &Waveform, duration: f64) -> Vec<Piece> {
    let end = duration + 1e-3;
    let mut list = Vec::new();
    let mut add = |start: f64, stop: f64, shape: Shape, rising: bool| {
        if stop > start && start < end {
            list.push(Piece {
                start,
                end: stop.min(end),
                shape,
                rising,
                memory: Vec::new(),
            });
        }
    };
    let line = |start, v, slope| Shape::Line { start, v, slope };
    match *waveform {
        Waveform::Square {
            frequency,
            amplitude,
        } => {
            let half = 0.5 / frequency;
            let count = (end / half).ceil() as usize;
            for i in 0..count {
                let start = i as f64 * half;
                let up = i % 2 == 0;
                let v = if up { amplitude } else { -amplitude };
                add(start, (i + 1) as f64 * half, line(start, v, 0.0), up);
            }
        }
        Waveform::Sine {
            frequency,
            amplitude,
        } => {
            let omega = TAU * frequency;
            let count = (end * frequency * 2.0 + 1.0).ceil() as usize;
            for i in 0..count {
                let start = (i as f64 - 0.5).max(0.0) * 0.5 / frequency;
                let stop = (i as f64 + 0.5) * 0.5 / frequency;
                add(start, stop, Shape::Sine { amplitude, omega }, i % 2 == 0);
            }
        }
        Waveform::Ramped {
            frequency,
            amplitude,
            lambda,
        } => {
            let period = 1.0 / frequency;
            let ramp = lambda * period;
            let slope = 2.0 * amplitude / ramp;
            let count = (end * frequency).ceil() as usize;
            for i in 0..count {
                let t = i as f64 * period;
                add(t, t + ramp, line(t, -amplitude, slope), true);
                add(t + ramp, t + 0.5 * period, line(t, amplitude, 0.0), true);
                let half = t + 0.5 * period;
                add(half, half + ramp, line(half, amplitude, -slope), false);
                let next = (i + 1) as f64 * period;
                add(half + ramp, next, line(half, -amplitude, 0.0), false);
            }
        }
    }
    list
}

/// Voltage \[V\] of a list of pieces at `t` \[s\].
#[must_use]
pub fn voltage(pieces: &[Piece], t: f64) -> f64 {
    let i = pieces.partition_point(|piece| piece.end <= t);
    pieces
        .get(i)
        .or(pieces.last())
        .map_or(0.0, |piece| piece.shape.at(t.max(piece.start)))
}

/// How an amplifier falls short.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "circuit")]
pub enum Amplifier {
    /// Resistors and capacitors in a ladder: first-order lags one behind the other \[s\].
    Ladder { first: f64, second: f64 },
    /// A bounded rate of change \[V/s\], with a small lag \[s\] at the end of the slope.
    Slew { rate: f64, lag: f64 },
}

impl Amplifier {
    /// The voltage behind the amplifier, as monotone pieces. It starts at zero volts.
    #[must_use]
    pub fn apply(&self, drive: &[Piece]) -> Vec<Piece> {
        let mut out: Vec<Piece> = Vec::new();
        let (mut a, mut b, mut rising) = (0.0f64, 0.0f64, true);
        for piece in drive {
            let length = piece.end - piece.start;
            let n = ((length / DELAY_GRID_STEP).ceil() as usize).max(1);
            let step = length / n as f64;
            let mut values = Vec::with_capacity(n + 1);
            let mut slopes = Vec::with_capacity(n + 1);
            // Lags below the grid are followed no faster than the grid can show.
            let slope = |u: f64, a: f64, b: f64| match *self {
                Amplifier::Ladder { second, .. } if second > 0.0 => (a - b) / second.max(step),
                Amplifier::Ladder { first, .. } => (u - a) / first.max(step),
                Amplifier::Slew { rate, lag } => ((u - b) / lag.max(step)).clamp(-rate, rate),
            };
            for i in 0..=n {
                let t = piece.start + i as f64 * step;
                let u = piece.shape.at(t);
                values.push(b);
                slopes.push(slope(u, a, b));
                if i == n {
                    break;
                }
                let next = piece.shape.at(t + step);
                match *self {
                    Amplifier::Ladder { first, second } => {
                        let a_next = lagged(a, u, next, step, first);
                        b = if second > 0.0 {
                            lagged(b, a, a_next, step, second)
                        } else {
                            a_next
                        };
                        a = a_next;
                    }
                    Amplifier::Slew { rate, lag } => {
                        let wish = lagged(b, u, next, step, lag);
                        b += (wish - b).clamp(-rate * step, rate * step);
                        a = b;
                    }
                }
            }
            let shape = Shape::Samples(Arc::new(Samples {
                start: piece.start,
                step,
                values,
                slopes: slopes.clone(),
            }));
            // A new piece wherever the delayed voltage turns.
            let mut start = piece.start;
            let mut push = |start: f64, end: f64, rising: bool| {
                out.push(Piece {
                    start,
                    end,
                    shape: shape.clone(),
                    rising,
                    memory: Vec::new(),
                });
            };
            for i in 0..=n {
                // Slopes too small to matter are a plateau: the branch is held.
                if slopes[i].abs() < 1e-3 || (slopes[i] > 0.0) == rising {
                    continue;
                }
                let turn = if i == 0 {
                    piece.start
                } else {
                    let (s0, s1) = (slopes[i - 1], slopes[i]);
                    let share = if s0 * s1 < 0.0 { s0 / (s0 - s1) } else { 1.0 };
                    piece.start + (i as f64 - 1.0 + share) * step
                };
                if turn > start {
                    push(start, turn, rising);
                    start = turn;
                }
                rising = slopes[i] > 0.0;
            }
            if piece.end > start {
                push(start, piece.end, rising);
            }
        }
        out
    }
}

/// A first-order lag over one step in which its input goes straight from `u` to `next`.
fn lagged(y: f64, u: f64, next: f64, step: f64, tau: f64) -> f64 {
    let decay = (-step / tau).exp();
    let ramp = (next - u) / step * tau;
    next - ramp + (y - u + ramp) * decay
}

/// Notes in each piece which earlier extremes a memory of loops still knows, having
/// come from `rest` \[V\] upwards.
pub fn remember(pieces: &mut [Piece], rest: f64) {
    let mut memory = vec![rest];
    let mut last = rest;
    for piece in pieces {
        let to = piece.shape.at(piece.start);
        visit(&mut memory, last, to);
        let end = piece.shape.at(piece.end);
        turn(&mut memory, to, end);
        piece.memory = memory.clone();
        close(&mut memory, end);
        last = end;
    }
}

/// Moves the memory from the voltage `from` to `to`: a turn is noted, loops that close
/// are forgotten. Extremes alternate; the first is the lower saturation.
fn visit(memory: &mut Vec<f64>, from: f64, to: f64) {
    turn(memory, from, to);
    close(memory, to);
}

/// Notes `from` as an extreme if the way to `to` leaves the open branch, which goes up
/// after an even place.
fn turn(memory: &mut Vec<f64>, from: f64, to: f64) {
    let open_up = memory.len() % 2 == 1;
    if to != from && (to > from) != open_up {
        memory.push(from);
    }
}

/// Forgets the loops that the voltage `v`, reached on the open branch, closes.
pub fn close(memory: &mut Vec<f64>, v: f64) {
    while memory.len() >= 3 {
        let beyond = memory[memory.len() - 2];
        let up = memory.len() % 2 == 1;
        if (up && v >= beyond) || (!up && v <= beyond) {
            memory.truncate(memory.len() - 2);
        } else {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::voltage::*;

    #[test]
    fn a_ladder_answers_a_step_as_the_closed_form() {
        let drive = pieces(
            &Waveform::Square {
                frequency: 300.0,
                amplitude: 8.0,
            },
            3e-3,
        );
        let tau = 1e-4;
        let out = Amplifier::Ladder {
            first: tau,
            second: 0.0,
        }
        .apply(&drive);
        for k in 0..300 {
            let t = 5e-6 * f64::from(k);
            let exact = 8.0 * (1.0 - (-t / tau).exp());
            assert!((voltage(&out, t) - exact).abs() < 1e-9);
        }
    }

    #[test]
    fn memory_forgets_closed_loops() {
        let mut memory = vec![-9.0];
        for (from, to) in [(-9.0, 5.0), (5.0, -3.0), (-3.0, 2.0), (2.0, -4.0)] {
            visit(&mut memory, from, to);
        }
        assert_eq!(memory, [-9.0, 5.0]);
        visit(&mut memory, -4.0, 6.0);
        assert_eq!(memory, [-9.0]);
    }
}
