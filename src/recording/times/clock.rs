//! What is said of the clock of a recording, and the times that are used instead.

use super::even_grid::{EvenTimes, Evenness, even_grid};
use super::rounding::{Precision, Printed};
use super::sample_index::SampleIndex;
use super::stamp_jitter::{Readings, Sampling, judge};
use crate::model::unit::format_quantity;
use crate::recording::error::WarningKind;
use crate::recording::median_interval;

/// What was found.
#[derive(Debug)]
pub(in crate::recording) struct ClockFinding {
    pub kind: WarningKind,
    /// Rows that it is about.
    pub count: usize,
    /// The first of them.
    pub row: usize,
    /// The whole sentence.
    pub message: String,
    /// The times to use instead; `None` if they stay.
    pub times: Option<EvenTimes>,
}

/// A judgement of the clock.
#[derive(Debug)]
pub(in crate::recording) enum Judgement {
    /// The clock is even; with what was found where times change.
    Settled(Option<ClockFinding>),
    /// Not from these rows alone.
    Open,
}

/// Judges times \[s\] that do not decrease, each row one tick of the clock: rounded times may repeat,
/// and their rows must not be dropped for it. `start` and `printed` as in [`even_grid`].
pub(in crate::recording) fn judge_rows(time: &[f64], start: f64, printed: Printed) -> Judgement {
    match even_grid(time, start, printed, &SampleIndex::by_row(time.len())) {
        Evenness::Even => Judgement::Settled(None),
        Evenness::Rounded(times, precision) => {
            Judgement::Settled(Some(rounded(time.len(), times, precision)))
        }
        Evenness::Uneven => Judgement::Open,
    }
}

/// Judges increasing times \[s\] with the readings taken at them, after [`judge_rows`] left it open.
/// Rows may be lost; steps of more than `gap_factor` median intervals stop the clock.
pub(in crate::recording) fn judge_steps(
    time: &[f64],
    readings: &[f64],
    start: f64,
    printed: Printed,
    gap_factor: f64,
) -> Option<ClockFinding> {
    let median = median_interval(time);
    let index = SampleIndex::by_steps(time, median, gap_factor * median)?;
    match even_grid(time, start, printed, &index) {
        Evenness::Even => return None,
        Evenness::Rounded(times, precision) => {
            return Some(rounded(time.len(), times, precision));
        }
        Evenness::Uneven => {}
    }
    // Stamps that jitter much look like lost rows.
    let by_row = judge(time, readings, &SampleIndex::by_row(time.len()));
    let sampling = match by_row {
        Sampling::Jittered(..) => by_row,
        _ if index.counts_rows() => by_row,
        _ => judge(time, readings, &index),
    };
    match sampling {
        Sampling::Jittered(times, jitter, readings) => Some(jittered(times, jitter, readings)),
        Sampling::Uneven(interval, spread) => Some(ClockFinding {
            kind: WarningKind::UnevenSampling,
            count: time.len(),
            row: 0,
            message: format!(
                "the samples are not evenly spaced: {} apart on average, with an rms deviation of {}; the times are used as they are",
                shown(interval),
                shown(spread),
            ),
            times: None,
        }),
        Sampling::Unknown => None,
    }
}

fn rounded(rows: usize, times: EvenTimes, precision: Precision) -> ClockFinding {
    let rounding = match precision {
        Precision::Digits => "to the digits in the file",
        Precision::Single => "to single precision",
    };
    ClockFinding {
        kind: WarningKind::RoundedTimes,
        count: times.changed,
        row: times.first_changed,
        message: format!(
            "the times are those of one sample every {}, rounded {rounding}; the unrounded times are used, which changes {} of {rows} times, by at most {}",
            interval_text(times.interval),
            times.changed,
            shown(times.largest_change),
        ),
        times: Some(times),
    }
}

fn jittered(times: EvenTimes, jitter: f64, readings: Readings) -> ClockFinding {
    let reason = match readings {
        Readings::Even => "the readings are smoother against even times",
        Readings::Silent => "the deviations do not add up, and the readings show no difference",
    };
    ClockFinding {
        kind: WarningKind::TimeJitter,
        count: times.changed,
        row: times.first_changed,
        message: format!(
            "the times jitter by {} (rms) around one sample every {} ({reason}); the even times are used, which changes {} of {} times, by at most {}",
            shown(jitter),
            interval_text(times.interval),
            times.changed,
            times.time.len(),
            shown(times.largest_change),
        ),
        times: Some(times),
    }
}

fn interval_text(interval: f64) -> String {
    format_quantity(interval, "s", 6)
}

fn shown(seconds: f64) -> String {
    format_quantity(seconds, "s", 2)
}
