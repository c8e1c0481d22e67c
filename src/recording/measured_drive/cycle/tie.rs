//! Which knots repeat, and what that says of each: the period of a waveform narrows down each of
//! its edges.

use super::waveform::Cycle;
use crate::recording::measured_drive::knots::{Knot, Knots};
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CLOCK_INTERVALS, CORNER_REACH_SIGMAS, EQUAL_VOLTAGE_SIGMAS, MAX_CYCLE_KNOTS, PERIOD_STEPS,
    ROUNDING_SIGMAS, UNSEEN_CORNER_INTERVALS,
};

/// Times \[s\] between which knot `turn` of a class lies.
#[derive(Debug, Clone, Copy)]
pub struct Bound {
    pub turn: f64,
    pub low: f64,
    pub high: f64,
}

/// The shortest cycle that `knots`, found in `samples`, are. `None` if they do not repeat.
pub fn find_cycle(samples: &Samples<'_>, knots: &Knots) -> Option<Cycle> {
    let inner = &knots.0[1..knots.0.len() - 1];
    let most = MAX_CYCLE_KNOTS.min(inner.len().saturating_sub(1));
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
        let reach = EQUAL_VOLTAGE_SIGMAS * a.sigma.hypot(b.sigma).max(1e-9 * samples.span());
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
        spread: None,
    };
    cycle.knots = merged(samples, inner, count, step, (offset, sign))?;
    cycle.level();
    Some(cycle)
}

/// Bounds of the knots of each class, those that must lie outside the samples included.
pub fn classes(samples: &Samples<'_>, inner: &[Knot], count: usize) -> Vec<Vec<Bound>> {
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
                UNSEEN_CORNER_INTERVALS
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
    (0.5 * (knot.bounds.1 - knot.bounds.0) / CORNER_REACH_SIGMAS).max(1e-13)
}

/// What all bounds of a class leave for its knot of turn 0 \[s\].
pub fn common(class: &[Bound], step: f64) -> (f64, f64) {
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
pub fn merged(
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
