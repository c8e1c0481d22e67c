//! The settings that a person would have chosen, where the samples allow them.
//!
//! One after the other: what is taken for set makes the others better known.

use super::estimate::Estimate;
use super::open_numbers::STEP;
use super::spread::reach_sigmas;
use super::tie::merged;
use super::waveform::Cycle;
use crate::recording::measured_drive::knots::Knots;
use crate::recording::measured_drive::round_number::round_between;
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CLOCK_INTERVALS, MAX_ACCIDENT_SHARE, ROUNDING_SIGMAS,
};

/// The estimated cycle of `samples` with round frequency, voltages, phase (counted from the first
/// sample) and shares of the period. `knots` were found in `part` of the samples.
pub fn rounded(
    samples: &Samples<'_>,
    part: &Samples<'_>,
    knots: &Knots,
    exact: &Estimate,
) -> Cycle {
    let reach = reach_sigmas(samples, &exact.cycle).min(ROUNDING_SIGMAS);
    let mut set = exact.clone();
    set.set_bounds(reach);
    round_frequency(&mut set, part, knots);
    for k in set.numbers.voltages() {
        let (value, reach) = (set.value(k), reach * set.sigma(k));
        if let Some(round) = round_between(value - reach, value + reach) {
            set = set.given(k, round);
        }
    }
    set.set_bounds(reach);
    let known: Vec<(f64, f64)> = set.cycle.knots.iter().map(|k| k.bounds).collect();
    round_times(&mut set, samples, reach);
    for (knot, bounds) in set.cycle.knots.iter_mut().zip(known) {
        knot.bounds = (bounds.0.min(knot.time), bounds.1.max(knot.time));
    }
    set.cycle
}

fn round_frequency(set: &mut Estimate, part: &Samples<'_>, knots: &Knots) {
    let (low, high) = set.cycle.period_bounds;
    let Some(frequency) = round_between(1.0 / high, 1.0 / low) else {
        return;
    };
    let step = 1.0 / (frequency * set.cycle.factor());
    if set.is_free(STEP) {
        *set = set.given(STEP, step);
        return;
    }
    // Another period leaves the jumps other instants.
    let inner = &knots.0[1..knots.0.len() - 1];
    let sign = if set.cycle.mirrored { -1.0 } else { 1.0 };
    let (count, offset) = (set.cycle.knots.len(), set.cycle.offset);
    let Some(again) = merged(part, inner, count, step, (offset, sign)) else {
        return;
    };
    let mut change = vec![0.0; set.numbers.len()];
    change[STEP] = step - set.cycle.step();
    let mut cycle = set.numbers.moved(&set.cycle, &change);
    for (knot, again) in cycle.knots.iter_mut().zip(again) {
        if knot.jumps() {
            (knot.time, knot.bounds) = (again.time, again.bounds);
        }
    }
    if cycle.is_ordered() {
        set.cycle = cycle;
        if let Some(spread) = &mut set.cycle.spread {
            spread.is_period_set = true;
        }
    }
}

/// Where knot number `k` lies \[s\]: of a jump what its samples leave, of a corner `reach` standard
/// deviations.
fn bounds_of(set: &Estimate, k: usize, reach: f64) -> (f64, f64) {
    let (count, at) = (set.cycle.knots.len(), set.cycle.knot(k as i64));
    if !set.is_free(set.numbers.time(k % count)) {
        return if at.jumps() {
            at.bounds
        } else {
            (at.time, at.time)
        };
    }
    let reach = reach * set.sigma_at(k % count, (k / count) as f64);
    (at.time - reach, at.time + reach)
}

/// Moves the knot that knot number `k` repeats.
fn shift(set: &mut Estimate, k: usize, by: f64) {
    let j = k % set.cycle.knots.len();
    let number = set.numbers.time(j);
    if set.is_free(number) {
        *set = set.given(number, set.value(number) + by);
    } else {
        set.cycle.knots[j].time += by;
    }
}

fn round_times(set: &mut Estimate, samples: &Samples<'_>, reach: f64) {
    let fuzz = CLOCK_INTERVALS * samples.interval;
    let start = samples.time[0];
    let (k, extra) = set.cycle.reference();
    let period = set.cycle.period;
    // Any phase lies within a wide interval by accident.
    let is_known = |(low, high): (f64, f64)| high - low <= MAX_ACCIDENT_SHARE * period;
    let bounds = bounds_of(set, k, reach);
    let at = set.cycle.knot(k as i64).time;
    let turns = ((at + extra - start) / period).round();
    let offset = extra - start - turns * period;
    if is_known(bounds)
        && let Some(round) = round_between(bounds.0 + offset - fuzz, bounds.1 + offset + fuzz)
    {
        let by = round - (at + offset);
        if set.cycle.knot(k as i64).jumps() {
            // All keep their distances.
            set.cycle.knots.iter_mut().for_each(|k| k.time += by);
        } else {
            shift(set, k, by);
        }
    }
    // The others as shares of the period after the first.
    let first = set.cycle.knot(k as i64).time;
    for j in 1..set.cycle.knots.len() {
        let bounds = bounds_of(set, k + j, reach);
        let at = set.cycle.knot((k + j) as i64).time;
        let share = |t: f64| (t - first) / period;
        if is_known(bounds)
            && let Some(round) = round_between(share(bounds.0 - fuzz), share(bounds.1 + fuzz))
        {
            shift(set, k + j, first + round * period - at);
        }
    }
}
