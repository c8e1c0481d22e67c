//! Measurements: what was recorded, how it is read, and what can be said of it
//! without a model.
//!
//! A [`Recording`] is immutable once it is made and is shared behind an `Arc`.
//! Everything in it is SI. One file per format reads it ([`csv`]); [`align`] lays
//! it over a simulation, [`compare`] measures what is left, [`noise`] says how
//! much of that is noise, [`events`] finds the impacts and [`features`] the
//! numbers of Table A.1. [`instrument_faults`] says which readings are not the device's.

pub mod align;
pub(crate) mod assemble;
mod channel;
pub mod combine;
pub mod compare;
pub mod csv;
pub(crate) mod error;
pub mod events;
pub mod experiment_setup;
pub mod features;
pub mod formats;
pub(crate) mod grid;
pub mod import;
pub mod instrument_faults;
pub mod lag;
pub mod level;
pub mod level_change;
pub mod measured_drive;
pub mod noise;
pub mod rest_positions;
pub mod ring;
mod statistics;
#[cfg(test)]
mod tests;
pub(crate) mod times;
pub mod velocity;

pub use self::assemble::GAP_FACTOR;
pub use self::channel::Channel;
pub use self::error::{ImportError, ImportWarning, WarningKind};
pub use self::grid::{Grid, TimeAxis};
pub(crate) use self::statistics::{extremes, median_in_place, median_interval, quantile_in_place};
pub use self::times::exact_time::ExactTime;

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use thiserror::Error;

use self::combine::spread::TrialSpread;
use self::experiment_setup::{DriveSource, InstrumentUnknowns};
use self::instrument_faults::thresholds::MAX_MISSING_ROW_SHARE;
use self::instrument_faults::{Columns, InstrumentFaults, find_faults};
use self::measured_drive::{MeasuredDrive, measured_drive};
use self::noise::{NoiseError, NoiseEstimate, estimate_noise};
use crate::model::drive::{DriveError, DriveReading};

/// Why columns of numbers are not a recording.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RecordingError {
    /// A channel's length differs from the time axis.
    #[error("{channel} has {found} values for {expected} times; give one value for each time")]
    LengthMismatch {
        /// Symbol of the channel.
        channel: &'static str,
        /// Values in the channel.
        found: usize,
        /// Times.
        expected: usize,
    },
    /// The times do not increase.
    #[error("time does not increase at sample {sample}; sort the samples by time")]
    TimeNotIncreasing {
        /// Index of the offending sample.
        sample: usize,
    },
    /// Fewer than two samples.
    #[error("a recording needs at least two samples, {0} given")]
    TooShort(usize),
}

/// One recording. Missing samples are NaN in their channel.
#[derive(Debug, Clone)]
pub struct Recording {
    /// What the recording is called, normally the file name.
    pub name: String,
    /// Where it was read from.
    pub path: Option<PathBuf>,
    /// SHA-256 of the file's bytes, lower-case hexadecimal.
    pub sha256: Option<String>,
    /// Times \[s\], finite and strictly increasing, at least two. Those of a file count from its
    /// first row, unless the import settings say otherwise.
    pub time: Vec<f64>,
    /// The instant in the file at which `time` is 0 \[s\]. The file's own time of a sample is the
    /// sum.
    pub origin: ExactTime,
    /// Drive voltage \[V\] at each time, if recorded.
    pub voltage: Option<Vec<f64>>,
    /// Displacement of the proof mass \[m\] at each time, up positive.
    pub proof_mass: Vec<f64>,
    /// Displacement of the cantilever's centre \[m\] at each time, if recorded.
    pub cantilever: Option<Vec<f64>>,
    /// What the reader had to leave out or guess; shown to the user.
    pub warnings: Vec<ImportWarning>,
    /// What drove it.
    pub drive_source: DriveSource,
    /// What of its instrument is unknown; `None` leaves it to the options of fit and diagnosis.
    pub instrument: Option<InstrumentUnknowns>,
    /// How the trials differ whose average it is ([`combine::average`]).
    pub spread: Option<Arc<TrialSpread>>,
    /// Kept because it is asked for at every interpolation.
    interval: f64,
    /// What is computed of it when first asked for.
    derived: Derived,
}

/// A drive that was made of a recording's voltage.
type DriveResult = Result<Arc<MeasuredDrive>, DriveError>;

/// Computed once. A clone starts empty: its channels may be changed.
#[derive(Debug, Default)]
struct Derived {
    /// The drive by each reading of the voltage, in the order of [`DriveReading::ALL`].
    drives: [OnceLock<Option<DriveResult>>; DriveReading::ALL.len()],
    /// Noise of each channel, in the order of [`Channel::ALL`].
    noise: [OnceLock<Result<NoiseEstimate, NoiseError>>; 3],
    /// Faults of the instrument.
    faults: OnceLock<Arc<InstrumentFaults>>,
    /// The recording without unusable readings; `None` if it has none.
    usable: OnceLock<Option<Arc<Recording>>>,
}

impl Clone for Derived {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Recording {
    /// A recording from columns in memory (a simulation, a test).
    ///
    /// # Errors
    /// [`RecordingError`] if lengths differ, times do not increase, or there are
    /// fewer than two samples.
    pub fn new(
        name: impl Into<String>,
        time: Vec<f64>,
        voltage: Option<Vec<f64>>,
        proof_mass: Vec<f64>,
        cantilever: Option<Vec<f64>>,
    ) -> Result<Self, RecordingError> {
        let expected = time.len();
        if expected < 2 {
            return Err(RecordingError::TooShort(expected));
        }
        let columns = [
            (Channel::Voltage, voltage.as_ref()),
            (Channel::ProofMass, Some(&proof_mass)),
            (Channel::Cantilever, cantilever.as_ref()),
        ];
        for (channel, column) in columns {
            if let Some(found) = column.map(Vec::len).filter(|n| *n != expected) {
                return Err(RecordingError::LengthMismatch {
                    channel: channel.symbol(),
                    found,
                    expected,
                });
            }
        }
        if !time[0].is_finite() {
            return Err(RecordingError::TimeNotIncreasing { sample: 0 });
        }
        // `>` and finite: a NaN or an infinity must not pass.
        if let Some(i) = (1..expected).find(|&i| !(time[i] > time[i - 1] && time[i].is_finite())) {
            return Err(RecordingError::TimeNotIncreasing { sample: i });
        }
        let interval = median_interval(&time);
        Ok(Self {
            name: name.into(),
            path: None,
            sha256: None,
            time,
            origin: ExactTime::default(),
            voltage,
            proof_mass,
            cantilever,
            warnings: Vec::new(),
            drive_source: DriveSource::default(),
            instrument: None,
            spread: None,
            interval,
            derived: Derived::default(),
        })
    }

    /// Number of samples, at least two.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Never true: a recording has at least two samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// First and last time \[s\].
    #[must_use]
    pub fn span(&self) -> (f64, f64) {
        match (self.time.first(), self.time.last()) {
            (Some(first), Some(last)) => (*first, *last),
            _ => (0.0, 0.0),
        }
    }

    /// Last time minus first time \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        let (first, last) = self.span();
        last - first
    }

    /// Median interval between samples \[s\].
    #[must_use]
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// Samples per second, from the median interval \[Hz\].
    #[must_use]
    pub fn sampling_rate(&self) -> f64 {
        1.0 / self.interval
    }

    /// Whether every interval is within 1 % of the median (a recorder that rounds
    /// its times to a few digits still counts as even).
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        let tolerance = 0.01 * self.interval;
        self.time
            .windows(2)
            .all(|w| (w[1] - w[0] - self.interval).abs() <= tolerance)
    }

    /// The samples of a channel, NaN where missing; `None` if it was not recorded.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> Option<&[f64]> {
        match channel {
            Channel::Voltage => self.voltage.as_deref(),
            Channel::ProofMass => Some(&self.proof_mass),
            Channel::Cantilever => self.cantilever.as_deref(),
        }
    }

    /// The instants of the samples, as the other modules take them.
    #[must_use]
    pub fn axis(&self) -> TimeAxis<'_> {
        TimeAxis::Samples(&self.time)
    }

    /// Whether the step from sample `i` to `i + 1` is a gap (more than
    /// [`GAP_FACTOR`] median intervals).
    #[must_use]
    pub fn is_gap(&self, i: usize) -> bool {
        match (self.time.get(i), self.time.get(i + 1)) {
            (Some(a), Some(b)) => b - a > GAP_FACTOR * self.interval,
            _ => true,
        }
    }

    /// The gaps, as (last time before, first time after) \[s\].
    #[must_use]
    pub fn gaps(&self) -> Vec<(f64, f64)> {
        (0..self.len() - 1)
            .filter(|&i| self.is_gap(i))
            .map(|i| (self.time[i], self.time[i + 1]))
            .collect()
    }

    /// Value of a channel at time `t` \[s\] by straight lines between samples.
    /// `None` outside the recording, in a gap, next to a missing sample, or if the
    /// channel was not recorded.
    #[must_use]
    pub fn value_at(&self, channel: Channel, t: f64) -> Option<f64> {
        let values = self.channel(channel)?;
        self.between(values, self.sample_before(t)?, t)
    }

    /// The last sample at or before `t` \[s\]; `None` before the first.
    #[must_use]
    pub fn sample_before(&self, t: f64) -> Option<usize> {
        // Most recordings are even: it is where it would be in one.
        let first = *self.time.first()?;
        let guess = ((t - first) / self.interval) as usize;
        for i in guess.saturating_sub(1)..=guess.saturating_add(1) {
            let next = self.time.get(i.saturating_add(1));
            if self.time.get(i).is_some_and(|&s| s <= t) && next.is_some_and(|&s| s > t) {
                return Some(i);
            }
        }
        self.time
            .partition_point(|&sample| sample <= t)
            .checked_sub(1)
    }

    /// `values` at `t`, known to lie at or after sample `i`.
    fn between(&self, values: &[f64], i: usize, t: f64) -> Option<f64> {
        let (t_a, a) = (*self.time.get(i)?, *values.get(i)?);
        if t == t_a {
            return a.is_finite().then_some(a);
        }
        let (t_b, b) = (*self.time.get(i + 1)?, *values.get(i + 1)?);
        if self.is_gap(i) {
            return None;
        }
        let value = a + (b - a) * ((t - t_a) / (t_b - t_a));
        value.is_finite().then_some(value)
    }

    /// A channel on the even grid `t0 + i dt`, `n` values, NaN where the recording
    /// says nothing. `None` if the channel was not recorded.
    #[must_use]
    pub fn resampled(&self, channel: Channel, t0: f64, dt: f64, n: usize) -> Option<Vec<f64>> {
        let values = self.channel(channel)?;
        let mut i = 0;
        let grid = (0..n).map(|k| {
            let t = t0 + k as f64 * dt;
            // The grid only moves forward, so the search does too.
            while self.time.get(i + 1).is_some_and(|&next| next <= t) {
                i += 1;
            }
            if t.is_nan() || t < self.time[0] {
                return f64::NAN;
            }
            self.between(values, i, t).unwrap_or(f64::NAN)
        });
        Some(grid.collect())
    }

    /// Whether a voltage was recorded that a drive can be made of: at least two values.
    #[must_use]
    pub fn has_voltage(&self) -> bool {
        let voltage = self.voltage.iter().flatten();
        voltage.filter(|v| v.is_finite()).nth(1).is_some()
    }

    /// The drive that acted, from the recorded voltage; `None` if there are not two values of it.
    /// Made once for each reading.
    #[must_use]
    pub fn drive(&self, reading: DriveReading) -> Option<DriveResult> {
        let make = || {
            let (time, volts) = self.drive_table()?;
            Some(measured_drive(&self.name, &time, &volts, reading).map(Arc::new))
        };
        let slot = &self.derived.drives[reading as usize];
        if let Some(drive) = slot.get() {
            return drive.clone();
        }
        // Made outside of the slot: it is made by several threads, and one that waits for the others
        // may take up work that asks for this drive, too.
        let drive = make();
        slot.get_or_init(|| drive).clone()
    }

    /// The drive that acted, from [`Self::drive_source`]; `None` if that is a voltage that was not
    /// measured.
    #[must_use]
    pub fn own_drive(&self) -> Option<DriveResult> {
        match &self.drive_source {
            DriveSource::Measured(reading) => self.drive(*reading),
            DriveSource::Waveform { waveform, start } => {
                let (first, last) = self.span();
                let span = (first, last, self.interval);
                Some(MeasuredDrive::of_waveform(waveform, *start, span).map(Arc::new))
            }
        }
    }

    /// The noise of a channel; of an average at least what its trials show. Estimated once.
    ///
    /// # Errors
    /// [`NoiseError`] if the channel was not recorded or is too short.
    pub fn estimate_noise(&self, channel: Channel) -> Result<NoiseEstimate, NoiseError> {
        let estimate = || {
            let values = self
                .channel(channel)
                .ok_or(NoiseError::NotRecorded(channel.symbol()))?;
            let mut estimate = estimate_noise(self.axis(), values)?;
            // Both are least values: differences of neighbours see nothing slow, trials nothing that
            // they have in common.
            let spread = self.spread.as_ref();
            let of_average = spread.and_then(|s| s.noise_of_average(channel));
            estimate.sigma = estimate.sigma.max(of_average.unwrap_or(0.0));
            Ok(estimate)
        };
        let slot = &self.derived.noise[channel as usize];
        slot.get_or_init(estimate).clone()
    }

    /// The same; `None` if the channel was not recorded or is too short to tell.
    #[must_use]
    pub fn noise(&self, channel: Channel) -> Option<NoiseEstimate> {
        self.estimate_noise(channel).ok()
    }

    /// Faults of the instrument. Looked for once.
    #[must_use]
    pub fn instrument_faults(&self) -> &InstrumentFaults {
        let find = || {
            let columns = Columns {
                time: &self.time,
                channels: Channel::ALL.map(|channel| self.channel(channel)),
                noise: Channel::ALL.map(|channel| self.noise(channel)),
            };
            Arc::new(find_faults(&columns))
        };
        self.derived.faults.get_or_init(find)
    }

    /// The same if they were looked for already.
    #[must_use]
    pub fn known_faults(&self) -> Option<&InstrumentFaults> {
        self.derived.faults.get().map(|faults| &**faults)
    }

    /// This recording for fit and diagnosis: NaN at samples that are no readings of the device
    /// ([`InstrumentFaults::unusable_samples`]), without these rows where most repeat a reading,
    /// and the faults that were found here. The same recording if it has none. What is drawn is
    /// this recording.
    #[must_use]
    pub fn usable(self: &Arc<Self>) -> Arc<Self> {
        let usable = self.derived.usable.get_or_init(|| {
            let faults = self.instrument_faults();
            let mut copy = (faults.count_unusable() > 0).then(|| (**self).clone())?;
            for channel in Channel::ALL {
                let unusable = faults.unusable_samples(channel);
                let values = match channel {
                    Channel::Voltage => copy.voltage.as_mut(),
                    Channel::ProofMass => Some(&mut copy.proof_mass),
                    Channel::Cantilever => copy.cantilever.as_mut(),
                };
                if let Some(values) = values {
                    unusable.iter().for_each(|&i| values[i] = f64::NAN);
                }
            }
            if faults.unusable_samples(Channel::Voltage).is_empty() {
                // The drive is that of all rows, also where some are dropped.
                let _ = self.own_drive();
                copy.derived.drives.clone_from(&self.derived.drives);
            }
            if faults.held_share(Channel::ProofMass) > MAX_MISSING_ROW_SHARE {
                copy.drop_rows_without_motion();
            }
            // The copy by itself shows what was found as missing readings.
            copy.derived.faults = OnceLock::from(Arc::new(faults.with_none_unusable()));
            copy.derived.usable = OnceLock::from(None);
            Some(Arc::new(copy))
        });
        usable.as_ref().map_or_else(|| Arc::clone(self), Arc::clone)
    }

    /// Drops the rows in which the proof mass was not read, unless fewer than two are left: a
    /// reading that is renewed at every other row is one of half the rate.
    fn drop_rows_without_motion(&mut self) {
        let is_read: Vec<bool> = self.proof_mass.iter().map(|x| x.is_finite()).collect();
        if is_read.iter().filter(|read| **read).nth(1).is_none() {
            return;
        }
        let keep = |values: &mut Vec<f64>| {
            let mut read = is_read.iter();
            values.retain(|_| read.next().is_some_and(|read| *read));
        };
        keep(&mut self.time);
        keep(&mut self.proof_mass);
        self.voltage.iter_mut().for_each(keep);
        self.cantilever.iter_mut().for_each(keep);
        if let Some(spread) = &mut self.spread {
            Arc::make_mut(spread).retain(&is_read);
        }
        self.interval = median_interval(&self.time);
    }

    /// The recorded voltage as samples of a drive, `(times [s], volts [V])` without missing
    /// samples; `None` if no voltage was recorded or fewer than two values are left.
    #[must_use]
    pub fn drive_table(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let voltage = self.voltage.as_ref()?;
        let (times, volts): (Vec<f64>, Vec<f64>) = self
            .time
            .iter()
            .zip(voltage)
            .filter(|(_, v)| v.is_finite())
            .map(|(t, v)| (*t, *v))
            .unzip();
        (times.len() >= 2).then_some((times, volts))
    }
}
