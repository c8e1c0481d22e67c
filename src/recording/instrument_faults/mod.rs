//! Faults of the instrument: what is wrong with readings whatever the device does, found without a
//! model, with where and how many.
//!
//! Each kind of fault is one file of [`kinds`], a function of a [`Signal`](signal::Signal): the
//! samples of one channel with those left out that an earlier kind has found. Everything is
//! measured in the recording's own samples, steps and noise, so that no unit and no sampling rate
//! matters. Readings that are not the device's
//! ([`unusable_samples`](InstrumentFaults::unusable_samples)) are left out of fit and diagnosis
//! ([`Recording::usable`](super::Recording::usable)); what is drawn is the recording as it was
//! read.

mod fault;
mod kinds;
mod signal;
#[cfg(test)]
mod tests;
pub(crate) mod thresholds;
mod words;

pub use self::fault::{FaultKind, InstrumentFault};
pub use self::signal::Columns;

use self::kinds::KINDS;
use self::signal::Signal;
use super::channel::Channel;

/// The faults of a recording, and the samples that are no readings of the device.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InstrumentFaults {
    /// What was found: channel by channel, each kind once.
    pub faults: Vec<InstrumentFault>,
    /// Indices of unusable samples of each channel, in the order of [`Channel::ALL`], increasing.
    unusable: [Vec<usize>; 3],
}

impl InstrumentFaults {
    /// Samples of a channel that are no readings of the device, though they are numbers: spikes,
    /// repeated readings, readings at the end of the range. Indices, increasing.
    #[must_use]
    pub fn unusable_samples(&self, channel: Channel) -> &[usize] {
        &self.unusable[channel as usize]
    }

    /// Share of a channel's samples that repeat a reading, 0 to 1.
    #[must_use]
    pub fn held_share(&self, channel: Channel) -> f64 {
        let held = |f: &&InstrumentFault| f.channel == channel && f.kind == FaultKind::HeldReadings;
        self.faults
            .iter()
            .find(held)
            .map_or(0.0, InstrumentFault::share)
    }

    /// The same faults of a copy in which unusable samples are missing.
    #[must_use]
    pub fn with_none_unusable(&self) -> Self {
        Self {
            faults: self.faults.clone(),
            unusable: Default::default(),
        }
    }

    /// How many samples of all channels together are unusable.
    #[must_use]
    pub fn count_unusable(&self) -> usize {
        self.unusable.iter().map(Vec::len).sum()
    }
}

/// Looks for all kinds of faults in all channels.
/// [`Recording::instrument_faults`](super::Recording::instrument_faults) keeps the answer.
///
/// # Examples
/// ```
/// use impactscope::recording::Recording;
/// use impactscope::recording::instrument_faults::FaultKind;
///
/// let time: Vec<f64> = (0..2000).map(|i| 1e-3 * f64::from(i)).collect();
/// let mut xp: Vec<f64> = (0..2000u32)
///     .map(|i| (0.01 * f64::from(i)).sin() + 1e-3 * f64::from(i * 7919 % 1000) / 1000.0)
///     .collect();
/// xp[700] += 0.5;
/// let recording = Recording::new("swing", time, None, xp, None)?;
/// let found = &recording.instrument_faults().faults;
/// assert_eq!((found[0].kind, found[0].count), (FaultKind::Spikes, 1));
/// # Ok::<(), impactscope::recording::RecordingError>(())
/// ```
#[must_use]
pub fn find_faults(columns: &Columns<'_>) -> InstrumentFaults {
    let mut all = InstrumentFaults::default();
    for channel in Channel::ALL {
        let Some(mut signal) = Signal::of(columns, channel) else {
            continue;
        };
        for find in KINDS {
            let Some(found) = find(&signal) else {
                continue;
            };
            signal.leave_out(&found.unusable);
            all.faults.push(found.fault);
            all.unusable[channel as usize].extend(found.unusable);
        }
        all.unusable[channel as usize].sort_unstable();
    }
    all
}
