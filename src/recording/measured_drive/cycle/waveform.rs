//! A cycle as a waveform: its knots in any repetition.

use super::open_numbers::Spread;
use crate::recording::measured_drive::knots::{Knot, Knots};
use crate::recording::measured_drive::samples::Span;
use crate::recording::measured_drive::thresholds::{CLOCK_INTERVALS, EQUAL_VOLTAGE_SIGMAS};

/// A waveform of straight lines that repeats.
#[derive(Debug, Clone, PartialEq)]
pub struct Cycle {
    /// Period \[s\].
    pub period: f64,
    /// Its bounds \[s\].
    pub period_bounds: (f64, f64),
    /// Whether the second half of a period is the first turned over at `offset`.
    pub mirrored: bool,
    /// Mean voltage \[V\] of a mirrored one, else 0.
    pub offset: f64,
    /// The knots of a period, of half of one if mirrored, from the first found on; voltages relative
    /// to `offset`.
    pub knots: Vec<Knot>,
    /// What the samples leave open of it.
    pub spread: Option<Spread>,
}

impl Cycle {
    /// Repetitions of `knots` in a period.
    pub(super) fn factor(&self) -> f64 {
        if self.mirrored { 2.0 } else { 1.0 }
    }

    /// Time from one repetition of `knots` to the next \[s\].
    pub(super) fn step(&self) -> f64 {
        self.period / self.factor()
    }

    /// Knot number `k` from the first found on, voltages included.
    pub(super) fn knot(&self, k: i64) -> Knot {
        let count = self.knots.len() as i64;
        let turn = k.div_euclid(count);
        let own = self.knots[k.rem_euclid(count) as usize];
        let shift = turn as f64 * self.step();
        let sign = if self.mirrored && turn.rem_euclid(2) == 1 {
            -1.0
        } else {
            1.0
        };
        Knot {
            time: own.time + shift,
            bounds: (own.bounds.0 + shift, own.bounds.1 + shift),
            before: self.offset + sign * own.before,
            after: self.offset + sign * own.after,
            sigma: own.sigma,
        }
    }

    /// The same, its bounds as wide as what is open of the whole cycle makes them.
    pub(super) fn bounded_knot(&self, k: i64) -> Knot {
        let count = self.knots.len() as i64;
        let mut knot = self.knot(k);
        if let Some(spread) = &self.spread
            && !(knot.jumps() && spread.is_period_set)
        {
            let turn = k.div_euclid(count) as f64;
            let reach = spread.reach_at(k.rem_euclid(count) as usize, turn);
            knot.bounds.0 = knot.bounds.0.min(knot.time - reach);
            knot.bounds.1 = knot.bounds.1.max(knot.time + reach);
        }
        knot
    }

    /// Makes a line that rises by no more than its error a level.
    pub(super) fn level(&mut self) {
        let count = self.knots.len();
        for k in 0..count {
            let next = (k + 1) % count;
            let sign = if self.mirrored && next == 0 {
                -1.0
            } else {
                1.0
            };
            let (a, b) = (self.knots[k].after, sign * self.knots[next].before);
            let reach = EQUAL_VOLTAGE_SIGMAS * self.knots[k].sigma.hypot(self.knots[next].sigma);
            if a == b || (a - b).abs() > reach {
                continue;
            }
            let mean = 0.5 * (a + b);
            let (one, two) = (self.knots[k].jumps(), self.knots[next].jumps());
            self.knots[k].after = mean;
            if !one {
                self.knots[k].before = mean;
            }
            self.knots[next].before = sign * mean;
            if !two {
                self.knots[next].after = sign * mean;
            }
        }
    }

    /// Where the waveform begins: the rising jump of a square, the zero of a triangle that rises,
    /// the foot of a ramp; as knot and time after it \[s\].
    pub(super) fn reference(&self) -> (usize, f64) {
        let count = self.knots.len();
        let repeats = if self.mirrored { 2 * count } else { count };
        for k in 0..repeats {
            let (before, at, after) = (
                self.knot(k as i64 - 1),
                self.knot(k as i64),
                self.knot(k as i64 + 1),
            );
            let rises = if at.jumps() {
                at.after > at.before
            } else {
                after.before > at.after && before.after >= at.before
            };
            if rises {
                let triangle = self.mirrored && count == 1 && !at.jumps();
                return (k, if triangle { 0.25 * self.period } else { 0.0 });
            }
        }
        (0, 0.0)
    }

    /// Whether the knots follow one another in time.
    pub fn is_ordered(&self) -> bool {
        let last = self.knots.len() - 1;
        self.knots.windows(2).all(|w| w[1].time > w[0].time)
            && self.knots[0].time + self.step() > self.knots[last].time
            && self.step() > 0.0
    }

    /// Number of the last knot at or before `t` \[s\].
    pub fn knot_before(&self, t: f64) -> i64 {
        let count = self.knots.len() as i64;
        let mut k = ((t - self.knots[0].time) / self.step()).floor() as i64 * count;
        while self.knot(k).time > t {
            k -= 1;
        }
        while self.knot(k + 1).time <= t {
            k += 1;
        }
        k
    }

    /// Mean of the knots' voltages \[V\].
    pub(super) fn mean(&self) -> f64 {
        let sum: f64 = self.knots.iter().map(|k| 0.5 * (k.before + k.after)).sum();
        sum / self.knots.len() as f64
    }

    /// Largest distance of a knot's voltage from the middle \[V\].
    pub fn amplitude(&self) -> f64 {
        let middle = if self.mirrored { 0.0 } else { self.mean() };
        self.knots
            .iter()
            .flat_map(|k| [k.before, k.after])
            .fold(0.0, |a: f64, v| a.max((v - middle).abs()))
    }

    /// When the waveform begins \[s\], within half a period of zero.
    pub fn begin(&self) -> f64 {
        let (k, extra) = self.reference();
        let at = self.knot(k as i64).time + extra;
        let begin = at - (at / self.period).round() * self.period;
        // What the last bits of adding whole periods leave.
        if begin.abs() < 1e-10 * self.period {
            0.0
        } else {
            begin
        }
    }

    /// Number of the first knot after the first of the samples.
    pub fn first_knot(&self, span: Span) -> i64 {
        // Before the first sample a jump has passed, one at the first sample too.
        self.knot_before(span.first + CLOCK_INTERVALS * span.interval) + 1
    }

    /// The knots of the samples' span.
    pub fn expand(&self, span: Span) -> Knots {
        self.expand_from(span, self.first_knot(span))
    }

    /// The same of a cycle that was changed a little: jumps before knot number `first_knot` had passed
    /// at the first sample.
    pub fn expand_from(&self, span: Span, first_knot: i64) -> Knots {
        let Span {
            first,
            last,
            interval,
        } = span;
        let fuzz = CLOCK_INTERVALS * interval;
        let mut k = self.first_knot(span);
        while k < first_knot && self.knot(k).jumps() {
            k += 1;
        }
        let end = |a: Knot, b: Knot, time: f64| {
            let value = if a.after == b.before {
                a.after
            } else {
                a.after + (b.before - a.after) * ((time - a.time) / (b.time - a.time))
            };
            Knot {
                time,
                bounds: (time, time),
                before: value,
                after: value,
                sigma: a.sigma,
            }
        };
        let mut knots = vec![end(self.knot(k - 1), self.knot(k), first)];
        // A jump at the last sample may show in it.
        while self.knot(k).time <= last + fuzz {
            let knot = self.bounded_knot(k);
            knots.push(Knot {
                time: knot.time.min(last),
                ..knot
            });
            k += 1;
        }
        knots.push(end(self.knot(k - 1), self.knot(k), last));
        Knots(knots)
    }
}
