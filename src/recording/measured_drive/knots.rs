//! A voltage of straight lines as the knots that they run between.

use super::lines::{Line, Lines, Node};
use super::round_number::round_between;
use super::samples::Samples;
use super::thresholds::{
    CLOCK_INTERVALS, CORNER_REACH_SIGMAS, MAX_TYPED_ACCIDENT, MAX_TYPED_SHARE, MIN_TYPED_PER_OTHER,
    ROUNDING_SIGMAS, TYPED_DECADES,
};

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

    /// The same with the voltages and times that a person may have typed, all with as many decimals:
    /// those that are well known show how many, and with these the levels that a coarse digitiser reads
    /// only within a step, and the corners beside them, are known too. `None` where no such decimals
    /// show.
    pub fn typed(&self, samples: &Samples<'_>) -> Option<Self> {
        let mut knots = self.clone();
        let last = knots.0.len() - 1;
        let inner = 1..last;
        let known = inner
            .clone()
            .map(|i| (self.0[i].before, self.voltage_sigma(i)));
        let step = typed_step(known)?;
        for i in 0..=last {
            let (knot, sigma) = (&mut knots.0[i], self.voltage_sigma(i));
            let typed = |v: f64| {
                let near = (v / step).round() * step;
                ((near - v).abs() <= ROUNDING_SIGMAS * sigma).then_some(near)
            };
            // A table need not begin or end where the recording does, and a corner that hardly turns is
            // not seen: the knots beside it lie elsewhere.
            knot.before = typed(knot.before).unwrap_or(knot.before);
            knot.after = typed(knot.after).unwrap_or(knot.after);
        }
        let mut sigmas = vec![f64::INFINITY; self.0.len()];
        for i in inner.clone() {
            let knot = &self.0[i];
            if knot.jumps() {
                continue;
            }
            let (time, sigma) = self.corner_at(i, knots.0[i].before, samples);
            knots.0[i].time = time;
            sigmas[i] = sigma;
        }
        let times = inner.clone().map(|i| (knots.0[i].time, sigmas[i]));
        if let Some(step) = typed_step(times) {
            for i in inner.clone() {
                let near = (knots.0[i].time / step).round() * step;
                if (near - knots.0[i].time).abs() <= ROUNDING_SIGMAS * sigmas[i].min(step) {
                    knots.0[i].time = near;
                }
            }
        }
        for i in inner {
            let near = (knots.0[i - 1].time, knots.0[i + 1].time);
            let from = samples.time.partition_point(|&t| t < near.0);
            let to = samples.time.partition_point(|&t| t < near.1);
            let fits = near.0 < knots.0[i].time && knots.0[i].time < near.1;
            if !fits || !knots.are_all_of(&samples.part(from, to)) {
                knots.0[i] = self.0[i];
            }
        }
        let increasing = knots.0.windows(2).all(|w| w[1].time > w[0].time);
        (increasing && knots.are_all_of(samples)).then_some(knots)
    }

    /// Standard deviation of the voltage at knot `i` \[V\]. Where two slopes meet, that of the instant
    /// adds to it.
    fn voltage_sigma(&self, i: usize) -> f64 {
        let knot = &self.0[i];
        if i == 0 || i + 1 == self.0.len() || knot.jumps() {
            return knot.sigma;
        }
        let slope = |a: &Knot, b: &Knot| ((b.before - a.after) / (b.time - a.time)).abs();
        let slopes = (slope(&self.0[i - 1], knot), slope(knot, &self.0[i + 1]));
        knot.sigma
            .hypot(slopes.0.min(slopes.1) * corner_sigma(knot))
    }

    /// When the lines beside corner `i` reach `voltage`, and the standard deviation of that \[s\]: by the
    /// one that turns the corner into the more certain time.
    fn corner_at(&self, i: usize, voltage: f64, samples: &Samples<'_>) -> (f64, f64) {
        let knot = &self.0[i];
        let by_line = |a: &Knot, b: &Knot| {
            let duration = b.time - a.time;
            let slope = (b.before - a.after) / duration;
            let count = (duration / samples.interval).max(1.0);
            // The end of a line is twice as uncertain as its middle.
            let sigma = 2.0 * samples.sigma / count.sqrt() / slope.abs();
            (knot.time + (voltage - knot.before) / slope, sigma)
        };
        let before = by_line(&self.0[i - 1], knot);
        let after = by_line(knot, &self.0[i + 1]);
        let own = corner_sigma(knot);
        let best = if before.1 < after.1 { before } else { after };
        if best.1.is_finite() {
            // Lines that hardly turn leave the time open, however steep they are.
            let level = self.0[i - 1].after == knot.before || knot.after == self.0[i + 1].before;
            (best.0, if level { best.1 } else { best.1.max(own) })
        } else {
            (knot.time, own)
        }
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

/// Standard deviation of the instant of a corner \[s\].
fn corner_sigma(knot: &Knot) -> f64 {
    0.5 * (knot.bounds.1 - knot.bounds.0) / CORNER_REACH_SIGMAS
}

/// The step of the numbers that a person typed, if those of `values` that are known well enough, each
/// with its standard deviation, are multiples of it by no accident, but for few; the widest such step.
fn typed_step(values: impl Iterator<Item = (f64, f64)> + Clone) -> Option<f64> {
    let size = values.clone().map(|(v, _)| v.abs()).fold(0.0, f64::max);
    if size == 0.0 {
        return None;
    }
    let top = size.log10().ceil() as i32;
    (top - TYPED_DECADES..=top).rev().find_map(|decade| {
        let step = 10f64.powi(decade);
        let (mut accident, mut known, mut others) = (0.0, 0, 0);
        for (v, sigma) in values.clone() {
            let reach = ROUNDING_SIGMAS * sigma;
            let share = 2.0 * reach / step;
            if share > MAX_TYPED_SHARE {
                continue;
            }
            known += 1;
            let off = v - (v / step).round() * step;
            if off.abs() > reach {
                others += 1;
            } else {
                accident += share.max(1e-3).ln();
            }
        }
        // Beside a corner that was not seen, a knot lies elsewhere.
        let are_few = others * MIN_TYPED_PER_OTHER < known;
        (are_few && accident < MAX_TYPED_ACCIDENT.ln()).then_some(step)
    })
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
