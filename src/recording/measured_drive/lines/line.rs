//! Straight lines that meet at nodes.

use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{FLAT_SIGMAS, ROUNDING_REACH_STEPS};

/// A straight line through samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Where `value` holds, the middle of its samples \[s\].
    pub at: f64,
    /// Voltage there \[V\].
    pub value: f64,
    /// Slope \[V/s\].
    pub slope: f64,
    /// Standard deviation of `value` \[V\]; half a step of a coarse digitiser on a level.
    pub value_sigma: f64,
    /// Standard deviation of `slope` \[V/s\].
    pub slope_sigma: f64,
}

impl Line {
    /// Voltage \[V\] at `t` \[s\].
    pub fn voltage(&self, t: f64) -> f64 {
        self.value + self.slope * (t - self.at)
    }

    /// Standard deviation \[V\] of the voltage at `t` \[s\].
    pub fn sigma(&self, t: f64) -> f64 {
        self.value_sigma.hypot(self.slope_sigma * (t - self.at))
    }
}

/// Where one line ends and the next begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Best time \[s\].
    pub time: f64,
    /// Earliest time \[s\].
    pub low: f64,
    /// Latest time \[s\].
    pub high: f64,
    /// Whether the voltage jumps there; else it has a corner.
    pub jumps: bool,
}

/// Lines joined at nodes, one line more than nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Lines {
    /// The lines in order of time.
    pub lines: Vec<Line>,
    /// Where they meet, increasing in time.
    pub nodes: Vec<Node>,
}

impl Lines {
    /// Whether a time lies where a corner may be, fast for times in increasing order: which of both
    /// lines a sample is of is not known there.
    pub fn near_corner(&self) -> impl Fn(f64) -> bool + '_ {
        let at = std::cell::Cell::new(0usize);
        move |t| {
            let mut i = at.get();
            if i > 0 && self.nodes[i - 1].high >= t {
                i = 0;
            }
            while self.nodes.get(i).is_some_and(|node| node.high < t) {
                i += 1;
            }
            at.set(i);
            let node = self.nodes.get(i);
            node.is_some_and(|node| !node.jumps && node.low <= t)
        }
    }
}

/// The voltage of `lines`, fast for times in increasing order.
pub fn cursor(lines: &Lines) -> impl Fn(f64) -> f64 {
    let at = std::cell::Cell::new(0usize);
    move |t| {
        let mut i = at.get();
        if i > 0 && lines.nodes[i - 1].time > t {
            i = 0;
        }
        while lines.nodes.get(i).is_some_and(|node| node.time <= t) {
            i += 1;
        }
        at.set(i);
        lines.lines[i].voltage(t)
    }
}

/// By how much the line of least squares, from which samples rounded to steps of `quantum` are off
/// between `low` and `high`, is to move to be within reach of all, and the standard deviation that
/// rounding leaves however many samples there are, all \[V\]. A level, or a line that rises by whole
/// steps, is rounded alike nearly everywhere. All roundings lie within one step, so the line may lie as
/// far aside as those seen leave room in it.
fn lasting_rounding(quantum: f64, (low, high): (f64, f64)) -> (f64, f64) {
    let reach = ROUNDING_REACH_STEPS * quantum;
    let room = (quantum - (high - low)).clamp(0.0, quantum);
    let aside = if high - low < 2.0 * reach {
        0f64.clamp(high - reach, low + reach)
    } else {
        0.0
    };
    (aside, room / 12f64.sqrt())
}

/// The line of least squares through the samples `from..to`; a level if it does not rise.
pub fn line_through(samples: &Samples<'_>, from: usize, to: usize) -> Line {
    let (time, volts) = (&samples.time[from..to], &samples.volts[from..to]);
    let n = time.len() as f64;
    let (t0, v0) = (time[0], volts[0]);
    let (mut st, mut sv) = (0.0, 0.0);
    for (t, v) in time.iter().zip(volts) {
        st += t - t0;
        sv += v - v0;
    }
    let (mt, mv) = (st / n, sv / n);
    let (mut tt, mut tv) = (0.0, 0.0);
    for (t, v) in time.iter().zip(volts) {
        let u = t - t0 - mt;
        tt += u * u;
        tv += u * (v - v0 - mv);
    }
    let slope_sigma = if tt > 0.0 {
        samples.sigma / tt.sqrt()
    } else {
        f64::INFINITY
    };
    let slope = if tt > 0.0 { tv / tt } else { 0.0 };
    let level = slope.abs() <= FLAT_SIGMAS * slope_sigma
        || slope.abs() * (time[time.len() - 1] - t0) < 0.5 * samples.quantum;
    let mut line = Line {
        at: t0 + mt,
        value: v0 + mv,
        slope: if level { 0.0 } else { slope },
        value_sigma: samples.sigma / n.sqrt(),
        slope_sigma: if level { 0.0 } else { slope_sigma },
    };
    if samples.quantum > 0.0 {
        let off = time.iter().zip(volts).map(|(&t, v)| v - line.voltage(t));
        let (low, high) = off.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), off| {
            (low.min(off), high.max(off))
        });
        let (aside, sigma) = lasting_rounding(samples.quantum, (low, high));
        line.value += aside;
        line.value_sigma = line.value_sigma.max(sigma).hypot(aside);
    }
    line
}
