//! A voltage of straight lines as the knots that they run between.

use super::lines::{Line, Lines, Node};
use super::round_number::round_between;
use super::samples::Samples;
use super::thresholds::{CLOCK_INTERVALS, ROUNDING_SIGMAS};

/// A corner or a jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// When \[s\].
    pub time: f64,
    /// Earliest and latest time that the samples allow \[s\].
    pub bounds: (f64, f64),
    /// Voltage just before \[V\].
    pub before: f64,
    /// Voltage just after \[V\]; equal to `before` at a corner.
    pub after: f64,
    /// Standard deviation of the two \[V\].
    pub sigma: f64,
}

impl Knot {
    /// Whether the voltage jumps here.
    pub fn jumps(&self) -> bool {
        self.before != self.after
    }
}

/// Straight lines between knots, of which the first and the last are the ends of the samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Knots(pub Vec<Knot>);

impl Knots {
    /// The knots of `lines` through `samples`.
    pub fn of(samples: &Samples<'_>, found: &Lines) -> Self {
        let (first, last) = (samples.time[0], samples.time[samples.len() - 1]);
        let end = |line: Option<&Line>, time: f64| Knot {
            time,
            bounds: (time, time),
            before: line.map_or(0.0, |l| l.voltage(time)),
            after: line.map_or(0.0, |l| l.voltage(time)),
            sigma: line.map_or(0.0, |l| l.sigma(time)),
        };
        let mut knots = vec![end(found.lines.first(), first)];
        for (pair, node) in found.lines.windows(2).zip(&found.nodes) {
            knots.push(inner(pair, node));
        }
        knots.push(end(found.lines.last(), last));
        Self(knots)
    }

    /// Voltage \[V\] at times that mostly increase.
    pub fn cursor(&self) -> impl Fn(f64) -> f64 + '_ {
        let at = std::cell::Cell::new(0usize);
        let knots = &self.0;
        move |t| {
            let mut i = at.get();
            if knots[i].time > t {
                i = 0;
            }
            while i + 2 < knots.len() && knots[i + 1].time <= t {
                i += 1;
            }
            at.set(i);
            line_voltage(&knots[i], &knots[i + 1], t)
        }
    }

    /// Whether these lines are all there is in `samples`.
    pub fn are_all_of(&self, samples: &Samples<'_>) -> bool {
        let curve = self.cursor();
        let fuzz = CLOCK_INTERVALS * samples.interval;
        let knots = &self.0;
        let next = std::cell::Cell::new(0usize);
        samples.are_where_known(|t| {
            let mut i = next.get();
            while i < knots.len() && knots[i].time < t - fuzz {
                i += 1;
            }
            next.set(i);
            let at_jump = knots
                .get(i)
                .is_some_and(|k| k.jumps() && k.time <= t + fuzz);
            (!at_jump).then(|| curve(t))
        })
    }

    /// The same with round voltages and times where the samples allow them, each knot by itself.
    pub fn rounded(&self) -> Self {
        let mut knots = self.clone();
        let last = knots.0.len() - 1;
        for (i, knot) in knots.0.iter_mut().enumerate() {
            let round = |v: f64| {
                let reach = ROUNDING_SIGMAS * knot.sigma;
                round_between(v - reach, v + reach).unwrap_or(v)
            };
            if knot.jumps() {
                (knot.before, knot.after) = (round(knot.before), round(knot.after));
            } else {
                knot.before = round(knot.before);
                knot.after = knot.before;
            }
            if i > 0
                && i < last
                && let Some(time) = round_between(knot.bounds.0, knot.bounds.1)
            {
                knot.time = time;
            }
        }
        // Levels are level: their two ends were rounded apart only if one was not round.
        for i in 0..last {
            let (a, b) = (knots.0[i].after, knots.0[i + 1].before);
            let was = (self.0[i].after, self.0[i + 1].before);
            if was.0 == was.1 && a != b {
                let of_one = if (a - was.0).abs() > (b - was.1).abs() {
                    a
                } else {
                    b
                };
                let (one, two) = (knots.0[i].jumps(), knots.0[i + 1].jumps());
                knots.0[i].after = of_one;
                knots.0[i + 1].before = of_one;
                if !one {
                    knots.0[i].before = of_one;
                }
                if !two {
                    knots.0[i + 1].after = of_one;
                }
            }
        }
        let increasing = knots.0.windows(2).all(|w| w[1].time > w[0].time);
        if increasing { knots } else { self.clone() }
    }
}

/// Voltage \[V\] at `t` on the line from knot `a` to knot `b`.
fn line_voltage(a: &Knot, b: &Knot, t: f64) -> f64 {
    if a.after == b.before {
        return a.after;
    }
    a.after + (b.before - a.after) * ((t - a.time) / (b.time - a.time))
}

fn inner(pair: &[Line], node: &Node) -> Knot {
    let (before, after) = (pair[0].voltage(node.time), pair[1].voltage(node.time));
    let sigma = pair[0].sigma(node.time).max(pair[1].sigma(node.time));
    let bounds = (node.low, node.high);
    if node.jumps {
        return Knot {
            time: node.time,
            bounds,
            before,
            after,
            sigma,
        };
    }
    // A level next to a slope is known better than their corner.
    let value = match (pair[0].slope == 0.0, pair[1].slope == 0.0) {
        (true, false) => before,
        (false, true) => after,
        _ => 0.5 * (before + after),
    };
    Knot {
        time: node.time,
        bounds,
        before: value,
        after: value,
        sigma,
    }
}
