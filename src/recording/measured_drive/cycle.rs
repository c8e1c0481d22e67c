//! Knots that repeat: the period of a waveform narrows down each of its edges.

use super::knots::{Knot, Knots, ROUNDING_SIGMAS};
use super::lines::CORNER_SIGMAS;
use super::round_number::round_between;
use super::samples::{CLOCK_INTERVALS, Samples, Span};

/// Most different knots in a period (or half of one, where the second half is the first turned
/// over).
const MAX_KNOTS: usize = 64;
/// Standard deviations by which voltages at the same place of two periods may differ.
const EQUAL_SIGMAS: f64 = 5.5;
/// Intervals near the ends of the samples within which a corner can stay unseen.
const UNSEEN_CORNER_SAMPLES: f64 = 12.0;
/// Steps of the search for the period.
const PERIOD_STEPS: usize = 200;

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
}

/// Times \[s\] between which knot `turn` of a class lies.
#[derive(Debug, Clone, Copy)]
struct Bound {
    turn: f64,
    low: f64,
    high: f64,
}

/// The shortest cycle that `knots`, found in `samples`, are. `None` if they do not repeat.
pub fn find_cycle(samples: &Samples<'_>, knots: &Knots) -> Option<Cycle> {
    let inner = &knots.0[1..knots.0.len() - 1];
    let most = MAX_KNOTS.min(inner.len().saturating_sub(1));
    for count in 1..=most {
        if let Some(cycle) = tie(samples, inner, count, true) {
            return Some(cycle);
        }
        if inner.len() >= count + 2
            && let Some(cycle) = tie(samples, inner, count, false)
        {
            return Some(cycle);
        }
    }
    None
}

fn tie(samples: &Samples<'_>, inner: &[Knot], count: usize, mirrored: bool) -> Option<Cycle> {
    let pairs = || inner.iter().zip(&inner[count..]);
    if pairs().any(|(a, b)| a.jumps() != b.jumps()) {
        return None;
    }
    let offset = if mirrored {
        let sums: f64 = pairs()
            .map(|(a, b)| 0.5 * (a.before + b.before + a.after + b.after))
            .sum();
        0.5 * sums / pairs().count() as f64
    } else {
        0.0
    };
    let sign = if mirrored { -1.0 } else { 1.0 };
    let alike = |(a, b): (&Knot, &Knot)| {
        let reach = EQUAL_SIGMAS * a.sigma.hypot(b.sigma).max(1e-9 * samples.span());
        let off = |u: f64, v: f64| ((u - offset) - sign * (v - offset)).abs();
        off(a.before, b.before) <= reach && off(a.after, b.after) <= reach
    };
    if !pairs().all(alike) {
        return None;
    }
    let (step, step_bounds) = find_step(samples, inner, count)?;
    let factor = if mirrored { 2.0 } else { 1.0 };
    let mut cycle = Cycle {
        period: factor * step,
        period_bounds: (factor * step_bounds.0, factor * step_bounds.1),
        mirrored,
        offset,
        knots: Vec::new(),
    };
    cycle.knots = merged(samples, inner, count, step, (offset, sign))?;
    cycle.level();
    Some(cycle)
}

/// Bounds of the knots of each class, those that must lie outside the samples included.
fn classes(samples: &Samples<'_>, inner: &[Knot], count: usize) -> Vec<Vec<Bound>> {
    let mut classes = vec![Vec::new(); count];
    for (k, knot) in inner.iter().enumerate() {
        classes[k % count].push(Bound {
            turn: (k / count) as f64,
            low: knot.bounds.0,
            high: knot.bounds.1,
        });
    }
    let slack = |knot: &Knot| {
        samples.interval
            * if knot.jumps() {
                1e-6
            } else {
                UNSEEN_CORNER_SAMPLES
            }
    };
    let before = (count - 1, -1.0);
    classes[before.0].push(Bound {
        turn: before.1,
        low: f64::NEG_INFINITY,
        high: samples.time[0] + slack(&inner[count - 1]),
    });
    let after = inner.len();
    classes[after % count].push(Bound {
        turn: (after / count) as f64,
        low: samples.time[samples.len() - 1] - slack(&inner[after - count]),
        high: f64::INFINITY,
    });
    classes
}

/// The time from one repetition to the next, and its bounds \[s\].
fn find_step(samples: &Samples<'_>, inner: &[Knot], count: usize) -> Option<(f64, (f64, f64))> {
    let classes = classes(samples, inner, count);
    // How much room the tightest class leaves at a step; concave in the step.
    let room = |step: f64| {
        classes
            .iter()
            .map(|class| {
                let (low, high) = common(class, step);
                high - low
            })
            .fold(f64::INFINITY, f64::min)
    };
    let (mut low, mut high): (f64, f64) = (0.0, f64::INFINITY);
    for k in 0..inner.len() - count {
        // Neighbouring repetitions bracket it; far ones narrow it below.
        let last = k + (inner.len() - 1 - k) / count * count;
        let turns = ((last - k) / count) as f64;
        low = low.max((inner[last].bounds.0 - inner[k].bounds.1) / turns);
        high = high.min((inner[last].bounds.1 - inner[k].bounds.0) / turns);
        if k >= count {
            break;
        }
    }
    // Rounding of the times themselves: an edge at the instant of a sample falls to either side.
    let fuzz = CLOCK_INTERVALS * samples.interval;
    if !(low <= high + fuzz && high.is_finite()) {
        return None;
    }
    let (mut a, mut b) = (low.min(high), high.max(low));
    for _ in 0..PERIOD_STEPS {
        let (left, right) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if room(left) < room(right) {
            a = left;
        } else {
            b = right;
        }
        if b - a <= 1e-15 * b {
            break;
        }
    }
    let best = 0.5 * (a + b);
    if room(best) < -fuzz {
        return None;
    }
    let edge = |outer: f64| {
        let (mut inside, mut outside) = (best, outer);
        for _ in 0..60 {
            let middle = 0.5 * (inside + outside);
            if room(middle) >= -fuzz {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    };
    let wide = 1e-9 * best;
    let bounds = (edge(low - wide), edge(high + wide));
    if inner.iter().any(Knot::jumps) {
        return Some((best, bounds));
    }
    let (step, sigma) = regression(inner, count)?;
    let reach = ROUNDING_SIGMAS * sigma;
    Some((step, (step - reach, step + reach)))
}

/// Step of corners by weighted least squares, and its standard deviation \[s\].
fn regression(inner: &[Knot], count: usize) -> Option<(f64, f64)> {
    let (mut uu, mut uv) = (0.0, 0.0);
    for class in 0..count {
        let own = || inner.iter().skip(class).step_by(count).enumerate();
        let (mut w, mut wm, mut wt) = (0.0, 0.0, 0.0);
        let reference = inner[class].time;
        for (turn, knot) in own() {
            let weight = corner_sigma(knot).powi(-2);
            w += weight;
            wm += weight * turn as f64;
            wt += weight * (knot.time - reference);
        }
        for (turn, knot) in own() {
            let weight = corner_sigma(knot).powi(-2);
            let u = turn as f64 - wm / w;
            uu += weight * u * u;
            uv += weight * u * (knot.time - reference - wt / w);
        }
    }
    (uu > 0.0).then(|| (uv / uu, uu.sqrt().recip()))
}

fn corner_sigma(knot: &Knot) -> f64 {
    (0.5 * (knot.bounds.1 - knot.bounds.0) / CORNER_SIGMAS).max(1e-13)
}

/// What all bounds of a class leave for its knot of turn 0 \[s\].
fn common(class: &[Bound], step: f64) -> (f64, f64) {
    class
        .iter()
        .fold((f64::NEG_INFINITY, f64::INFINITY), |(low, high), b| {
            (
                low.max(b.low - b.turn * step),
                high.min(b.high - b.turn * step),
            )
        })
}

/// The knots of one repetition from all of them.
fn merged(
    samples: &Samples<'_>,
    inner: &[Knot],
    count: usize,
    step: f64,
    (offset, sign): (f64, f64),
) -> Option<Vec<Knot>> {
    let classes = classes(samples, inner, count);
    (0..count)
        .map(|class| {
            let own = || inner.iter().skip(class).step_by(count).enumerate();
            let number = own().count() as f64;
            let mut bounds = common(&classes[class], step);
            let jumps = inner[class].jumps();
            let time = if jumps {
                let fuzz = CLOCK_INTERVALS * samples.interval;
                if bounds.0 > bounds.1 + 2.0 * fuzz {
                    return None;
                }
                0.5 * (bounds.0 + bounds.1)
            } else {
                let (mut w, mut wt) = (0.0, 0.0);
                for (turn, knot) in own() {
                    let weight = corner_sigma(knot).powi(-2);
                    w += weight;
                    wt += weight * (knot.time - turn as f64 * step - inner[class].time);
                }
                let time = inner[class].time + wt / w;
                let reach = ROUNDING_SIGMAS / w.sqrt();
                bounds = (time - reach, time + reach);
                time
            };
            let mean = |value: &dyn Fn(&Knot) -> f64| {
                own()
                    .map(|(turn, knot)| {
                        let turned = if turn % 2 == 1 { sign } else { 1.0 };
                        turned * (value(knot) - offset)
                    })
                    .sum::<f64>()
                    / number
            };
            let sigma = own().map(|(_, k)| k.sigma).sum::<f64>() / number;
            let before = mean(&|k| k.before);
            Some(Knot {
                time,
                bounds,
                before,
                after: if jumps { mean(&|k| k.after) } else { before },
                // Rounding by a digitiser is the same in every period.
                sigma: if samples.quantum > 0.0 {
                    sigma
                } else {
                    sigma / number.sqrt()
                },
            })
        })
        .collect()
}

impl Cycle {
    /// Repetitions of `knots` in a period.
    fn factor(&self) -> f64 {
        if self.mirrored { 2.0 } else { 1.0 }
    }

    /// Time from one repetition of `knots` to the next \[s\].
    fn step(&self) -> f64 {
        self.period / self.factor()
    }

    /// Knot number `k` from the first found on, voltages included.
    fn knot(&self, k: i64) -> Knot {
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

    /// Makes a line that rises by no more than its error a level.
    fn level(&mut self) {
        let count = self.knots.len();
        for k in 0..count {
            let next = (k + 1) % count;
            let sign = if self.mirrored && next == 0 {
                -1.0
            } else {
                1.0
            };
            let (a, b) = (self.knots[k].after, sign * self.knots[next].before);
            let reach = EQUAL_SIGMAS * self.knots[k].sigma.hypot(self.knots[next].sigma);
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

    /// The same with the frequency, the phase (counted from `start` \[s\]) and the voltages that a
    /// person would have set, where the samples allow them.
    pub fn rounded(&self, start: f64, samples: &Samples<'_>, knots: &Knots) -> Self {
        let mut cycle = self.clone();
        let (low, high) = self.period_bounds;
        if let Some(frequency) = round_between(1.0 / high, 1.0 / low) {
            cycle.period = 1.0 / frequency;
            let inner = &knots.0[1..knots.0.len() - 1];
            let sign = if self.mirrored { -1.0 } else { 1.0 };
            let count = self.knots.len();
            let Some(again) = merged(samples, inner, count, cycle.step(), (self.offset, sign))
            else {
                return self.clone();
            };
            cycle.knots = again;
            cycle.level();
        }
        cycle.round_phase(start, CLOCK_INTERVALS * samples.interval);
        cycle.round_voltages();
        cycle
    }

    /// Where the waveform begins: the rising jump of a square, the zero of a triangle that rises,
    /// the foot of a ramp; as knot and time after it \[s\].
    fn reference(&self) -> (usize, f64) {
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

    /// Times count from the first sample, at `start` \[s\]; `fuzz` is their rounding \[s\].
    fn round_phase(&mut self, start: f64, fuzz: f64) {
        let (k, extra) = self.reference();
        let at = self.knot(k as i64);
        let turns = ((at.time + extra - start) / self.period).round();
        let shift = extra - start - turns * self.period;
        if let Some(round) = round_between(at.bounds.0 + shift - fuzz, at.bounds.1 + shift + fuzz) {
            let off = round - (at.time + shift);
            for knot in &mut self.knots {
                knot.time += off;
            }
        }
        // The others as shares of the period after the first.
        let first = self.knot(k as i64).time;
        let count = self.knots.len();
        for j in 1..count {
            let at = self.knot((k + j) as i64);
            let share = |t: f64| (t - first) / self.period;
            if let Some(round) = round_between(share(at.bounds.0 - fuzz), share(at.bounds.1 + fuzz))
            {
                let off = first + round * self.period - at.time;
                self.knots[(k + j) % count].time += off;
            }
        }
    }

    fn round_voltages(&mut self) {
        let round = |v: f64, sigma: f64| {
            let reach = ROUNDING_SIGMAS * sigma;
            round_between(v - reach, v + reach).unwrap_or(v)
        };
        let sigma = self.knots.iter().map(|k| k.sigma).fold(0.0, f64::max);
        if self.mirrored {
            self.offset = round(self.offset, sigma);
        }
        for knot in &mut self.knots {
            let (before, after) = (
                round(knot.before, knot.sigma),
                round(knot.after, knot.sigma),
            );
            (knot.before, knot.after) = if knot.jumps() {
                (before, after)
            } else {
                (before, before)
            };
        }
    }

    /// The same with another period, its first knot kept; a factor on the voltages and what is added
    /// to them, about their mean; and the other knots shifted by shares of the period.
    pub fn changed(&self, stretch: f64, factor: f64, added: f64, shares: &[f64]) -> Self {
        let mut cycle = self.clone();
        let first = self.knots[0].time;
        let middle = if self.mirrored { 0.0 } else { self.mean() };
        cycle.period *= 1.0 + stretch;
        cycle.offset += if self.mirrored { added } else { 0.0 };
        for (j, knot) in cycle.knots.iter_mut().enumerate() {
            knot.time = first + (knot.time - first) * (1.0 + stretch);
            if j > 0 {
                knot.time += shares.get(j - 1).copied().unwrap_or(0.0) * cycle.period;
            }
            let apart = if self.mirrored { 0.0 } else { added };
            let moved = |v: f64| middle + factor * (v - middle) + apart;
            (knot.before, knot.after) = (moved(knot.before), moved(knot.after));
        }
        cycle
    }

    /// Mean of the knots' voltages \[V\].
    fn mean(&self) -> f64 {
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

    /// The knots of the samples' span.
    pub fn expand(&self, span: Span) -> Knots {
        let Span {
            first,
            last,
            interval,
        } = span;
        let count = self.knots.len();
        let guess = ((first - self.knots[0].time) / self.step()).floor() as i64 * count as i64;
        // Before the first sample a jump has passed, one at the first sample too.
        let fuzz = CLOCK_INTERVALS * interval;
        let mut k = guess - count as i64 - 1;
        while self.knot(k).time <= first + fuzz {
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
            let knot = self.knot(k);
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
