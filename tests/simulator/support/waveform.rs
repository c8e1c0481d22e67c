//! The reference's drives as the simulator's own.

use crate::oracle::Drive;
use impactscope::model::drive::Waveform;

/// The simulator's waveform for a drive of the reference.
pub fn waveform(drive: Drive) -> Waveform {
    match drive {
        Drive::Rest => Waveform::Rest,
        Drive::Square { hz, volt } => Waveform::Square {
            frequency: hz,
            amplitude: volt,
        },
        Drive::Sine { hz, volt } => Waveform::Sine {
            frequency: hz,
            amplitude: volt,
        },
        Drive::Ramped { hz, volt, lambda } => Waveform::Ramped {
            frequency: hz,
            amplitude: volt,
            lambda,
        },
    }
}
