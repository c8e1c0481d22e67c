//! One kind of fault in one channel, as a value.

use serde::{Deserialize, Serialize};

use crate::recording::channel::Channel;

/// What kind of fault, with what only this kind has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// Samples that are missing or no numbers.
    MissingReadings,
    /// Readings at the end of the sensor's range.
    Clipping,
    /// One reading repeated while the motion goes on. The size is the longest run \[samples\].
    HeldReadings,
    /// Single samples, or a few in a row, far off their neighbours. The size is the largest
    /// distance.
    Spikes,
    /// Steps of the reading by multiples of one size inside smooth motion. The size is that one.
    FringeJumps,
    /// A line at one frequency, of the size's amplitude, that is there while the mass is held by
    /// the ground.
    SteadyLine {
        /// Frequency \[Hz\].
        frequency: f64,
    },
    /// The slow part of the reading decays to zero with one time constant, the size \[s\].
    AcCoupling,
    /// The reading goes in steps, the size, that are coarser than its noise.
    Quantised,
}

/// One kind of fault in one channel of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InstrumentFault {
    /// What it is.
    pub kind: FaultKind,
    /// Where it was read.
    pub channel: Channel,
    /// How many places, at least one.
    pub count: usize,
    /// How many samples are affected.
    pub samples: usize,
    /// Samples of the channel.
    pub of_samples: usize,
    /// First and last time of each place \[s\]; the first [`MAX_PLACES`](super::thresholds::MAX_PLACES)
    /// of them.
    pub places: Vec<(f64, f64)>,
    /// How large, in [`Self::unit`]; what it is the size of is said at [`FaultKind`].
    pub size: f64,
}

impl InstrumentFault {
    /// Unit of the size.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self.kind {
            FaultKind::MissingReadings | FaultKind::HeldReadings => "samples",
            FaultKind::AcCoupling => "s",
            FaultKind::Clipping
            | FaultKind::Spikes
            | FaultKind::FringeJumps
            | FaultKind::SteadyLine { .. }
            | FaultKind::Quantised => self.channel.base_unit(),
        }
    }

    /// Share of the channel's samples that are affected, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.samples as f64 / self.of_samples.max(1) as f64
    }
}
