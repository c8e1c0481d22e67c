//! One reading repeated while the motion goes on: a sample-and-hold that was not renewed, a frame of
//! a video that is there twice.
//!
//! Two things give it away. Where the noise is finer than the steps of the recorder, equal readings
//! in a row are not chance. And where a reading is held, the motion that it did not follow shows
//! as a jump at its end: as large as the speed before and after has carried the mass meanwhile. A
//! mass at rest goes on from where it rested, and lands and starts with different speeds.

use std::ops::Range;

use crate::recording::channel::Channel;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::signal::{Found, Signal};
use crate::recording::instrument_faults::thresholds::{
    EQUAL_RUN_CHANCE, HELD_JUMP_LATTICE_STEPS, HELD_JUMP_MAX_RATIO, HELD_JUMP_SIGMAS, HELD_MIN_RUN,
    HELD_MIN_STEP_SIGMAS, HELD_NEIGHBOURS, MAX_RECURRING_SHARE, MIN_NOISE_SHARE_OF_SPAN,
    RECURRENCE_LAGS,
};
use crate::recording::statistics::quantile_in_place;

/// Repeated readings. The first of a run is one of the device; the others are unusable. The size is
/// the longest run.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    // A voltage rests at its levels.
    if signal.channel == Channel::Voltage {
        return None;
    }
    let runs = equal_runs(&signal.values);
    let levels = Levels::of(signal, &runs);
    let no_chance = |k: usize| {
        levels
            .as_ref()
            .is_some_and(|l| is_no_chance(signal, &runs, k, l))
    };
    let held: Vec<Range<usize>> = (0..runs.len())
        .filter(|&k| no_chance(k) || follows_no_motion(signal, &runs, k))
        .map(|k| runs[k].start + 1..runs[k].end)
        .collect();
    let longest = held.iter().map(|run| run.len() + 1).max()?;
    Some(Found {
        fault: signal.fault(FaultKind::HeldReadings, longest as f64, &held)?,
        unusable: held.into_iter().flatten().collect(),
    })
}

/// All samples that are numbers, as runs of equal ones.
fn equal_runs(values: &[f64]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (i, value) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        match runs.last_mut() {
            Some(run) if run.end == i && values[run.start] == *value => run.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}

/// Whether equal readings in run `k` are no chance, judged by how much the readings around it
/// differ. Nothing is said where readings lie exactly at the same value elsewhere, as those of a
/// mass at rest in a simulation do.
fn is_no_chance(signal: &Signal<'_>, runs: &[Range<usize>], k: usize, levels: &Levels) -> bool {
    let Levels { values, recurring } = levels;
    let repeats = runs[k].len() - 1;
    if repeats == 0 {
        return false;
    }
    let value = signal.values[runs[k].start];
    let first = values.partition_point(|v| *v < value);
    let recurs = values.get(first + 1).is_some_and(|next| *next == value);
    let is_extreme = first == 0 || first + 1 == values.len();
    if recurs || is_extreme {
        return false;
    }
    let around =
        &runs[k.saturating_sub(HELD_NEIGHBOURS)..(k + 1 + HELD_NEIGHBOURS).min(runs.len())];
    let at = |run: &Range<usize>| signal.values[run.start];
    let mut steps: Vec<f64> = around
        .windows(2)
        .map(|w| (at(&w[1]) - at(&w[0])).abs())
        .collect();
    let usual = quantile_in_place(&mut steps, 0.25);
    // So often two readings fall into one step of the recorder.
    let alike = (signal.lattice() / usual).max(*recurring);
    let moves = usual > HELD_MIN_STEP_SIGMAS * signal.sigma();
    moves
        && alike < 1.0
        && signal.values.len() as f64 * alike.powi(repeats as i32) < EQUAL_RUN_CHANCE
}

/// What the values of a channel say of the recorder's levels.
struct Levels {
    /// The values of all runs, increasing.
    values: Vec<f64>,
    /// How often two readings near each other are equal with another between them: a held reading
    /// is never so.
    recurring: f64,
}

impl Levels {
    /// `None` where equal readings say nothing: without noise, in steps as coarse as it, or if
    /// there are so few levels, even or not, that they recur.
    fn of(signal: &Signal<'_>, runs: &[Range<usize>]) -> Option<Self> {
        let noise = signal.noise?;
        if noise.quantised || noise.sigma <= MIN_NOISE_SHARE_OF_SPAN * signal.span() {
            return None;
        }
        let of_runs: Vec<f64> = runs.iter().map(|run| signal.values[run.start]).collect();
        let lags = 2..=RECURRENCE_LAGS;
        let tried = of_runs.len() * lags.clone().count();
        let alike = |lag| {
            of_runs
                .iter()
                .zip(&of_runs[of_runs.len().min(lag)..])
                .filter(|(a, b)| a == b)
        };
        let again: usize = lags.map(|lag| alike(lag).count()).sum();
        let mut values = of_runs.clone();
        values.sort_unstable_by(f64::total_cmp);
        let same = values.windows(2).filter(|w| w[0] == w[1]).count();
        let few = same as f64 <= MAX_RECURRING_SHARE * values.len() as f64;
        (few || noise.step.is_some()).then_some(Self {
            values,
            recurring: again as f64 / tried as f64,
        })
    }
}

/// Whether run `k` ends with a jump as large as the motion before and after it would have gone
/// meanwhile, both in the same direction.
fn follows_no_motion(signal: &Signal<'_>, runs: &[Range<usize>], k: usize) -> bool {
    if k == 0 || k + 2 >= runs.len() || runs[k].len() < HELD_MIN_RUN {
        return false;
    }
    // They must follow one another.
    if (k - 1..k + 2).any(|j| runs[j].end != runs[j + 1].start) {
        return false;
    }
    let at = |j: usize| signal.values[runs[j].start];
    let speed = |j: usize| (at(j + 1) - at(j)) / runs[j].len() as f64;
    let jump = at(k + 1) - at(k);
    let least = (HELD_JUMP_SIGMAS * signal.sigma()).max(HELD_JUMP_LATTICE_STEPS * signal.lattice());
    let around = 0.5 * (speed(k - 1) + speed(k + 1));
    let one_way = speed(k - 1) * jump > 0.0 && speed(k + 1) * jump > 0.0;
    let ratio = speed(k) / around;
    jump.abs() > least
        && one_way
        && ratio < HELD_JUMP_MAX_RATIO
        && ratio > 1.0 / HELD_JUMP_MAX_RATIO
}
