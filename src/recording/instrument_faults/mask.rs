//! A recording without the samples that are no readings of the device.

use super::InstrumentFaults;
use crate::recording::{Channel, Recording};

/// A copy of `recording` with NaN at spikes, repeated readings and readings at the end of the range;
/// `None` if it has none of these.
pub fn without_unusable(recording: &Recording, faults: &InstrumentFaults) -> Option<Recording> {
    if Channel::ALL
        .iter()
        .all(|channel| faults.unusable_samples(*channel).is_empty())
    {
        return None;
    }
    let mut copy = recording.clone();
    for channel in Channel::ALL {
        let values = match channel {
            Channel::Voltage => copy.voltage.as_mut(),
            Channel::ProofMass => Some(&mut copy.proof_mass),
            Channel::Cantilever => copy.cantilever.as_mut(),
        };
        if let Some(values) = values {
            for &i in faults.unusable_samples(channel) {
                values[i] = f64::NAN;
            }
        }
    }
    Some(copy)
}
