//! The times of a recording: exact digits, and what they say of the clock that gave them.
//!
//! A recording counts its time from its first row, and the difference is taken in decimal
//! digits, before anything is rounded: a file that counts from 1970 gives the same numbers,
//! bit for bit, as the same file from 0. The first row is the only instant that every file
//! has. A file's own zero may be a trigger, the start of the recorder or 1970, and nothing in
//! the file says which; it is kept as the recording's `origin`, and a person who knows that it
//! has a meaning chooses it in the import settings.
//!
//! That the first row is t = 0 is what the rest of the program means by it too: a recording is
//! simulated from its first row on, under its own voltage. Nothing is kept back for a file whose
//! zero looks near (a row that was not stored, a trigger): where the drive is a typed waveform
//! rather than the voltage, its phase against the recording is estimated by the alignment, as
//! for any other file.

pub(in crate::recording) mod clock;
pub(in crate::recording) mod correct_rounding;
mod even_grid;
pub(crate) mod exact_time;
pub(in crate::recording) mod rounding;
mod sample_index;
mod short_number;
mod stamp_jitter;
#[cfg(test)]
mod tests;

use self::short_number::Interval;

/// Largest relative difference between an interval and the short number that it stands for: the
/// rounding of one division.
const INTERVAL_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// `count` times `interval` \[s\] apart, from 0: each rounded once where the interval or its inverse is a
/// short number.
pub(in crate::recording) fn even_times(interval: f64, count: usize) -> Vec<f64> {
    let (low, high) = (
        interval * (1.0 - INTERVAL_ROUNDING),
        interval * (1.0 + INTERVAL_ROUNDING),
    );
    let clock = Interval::within(low, high);
    (0..count as u64).map(|i| clock.times(i)).collect()
}

/// Turns sample numbers into times `interval` \[s\] apart, as [`even_times`] does.
pub(in crate::recording) fn time_samples(interval: f64, samples: &mut [f64]) {
    let (low, high) = (
        interval * (1.0 - INTERVAL_ROUNDING),
        interval * (1.0 + INTERVAL_ROUNDING),
    );
    let clock = Interval::within(low, high);
    for sample in samples {
        let is_whole = sample.fract() == 0.0 && (0.0..9e15).contains(sample);
        *sample = if is_whole {
            clock.times(*sample as u64)
        } else {
            *sample * interval
        };
    }
}
