//! A recording as a person has set it up.

use std::sync::Arc;

use super::Alignment;
use crate::recording::experiment_setup::{DriveSource, InstrumentUnknowns};
use crate::recording::{Channel, Recording};

/// `recording` with its readings scaled and set off as `alignment` says, but not shifted, under
/// `drive`, with what is unknown of its `instrument`. What was computed of channels that stay as they
/// are is not computed again.
#[must_use]
pub fn set_up(
    recording: &Recording,
    alignment: &Alignment,
    drive: DriveSource,
    instrument: Option<InstrumentUnknowns>,
) -> Recording {
    let mut copy = recording.clone();
    let mut stay: Vec<Channel> = Vec::new();
    if matches!(drive, DriveSource::Measured(_)) {
        stay.push(Channel::Voltage);
        copy.derived.drives.clone_from(&recording.derived.drives);
    }
    for channel in [Channel::ProofMass, Channel::Cantilever] {
        if [0.0, 1.0]
            .iter()
            .all(|x| alignment.value(channel, *x) == *x)
        {
            stay.push(channel);
            continue;
        }
        let values = match channel {
            Channel::Cantilever => copy.cantilever.as_mut(),
            _ => Some(&mut copy.proof_mass),
        };
        for x in values.into_iter().flatten() {
            *x = alignment.value(channel, *x);
        }
        if let Some(spread) = &mut copy.spread {
            let factor = alignment.value(channel, 1.0) - alignment.value(channel, 0.0);
            Arc::make_mut(spread).scale(channel, factor);
        }
    }
    // A motion is looked at together with the voltage: nothing of either may have changed.
    if stay.iter().filter(|c| **c != Channel::Voltage).count() == 2 {
        copy.derived.faults.clone_from(&recording.derived.faults);
    }
    for channel in stay {
        let slot = channel as usize;
        copy.derived.noise[slot].clone_from(&recording.derived.noise[slot]);
    }
    copy.drive_source = drive;
    copy.instrument = instrument;
    copy
}

#[cfg(test)]
mod tests {
    use super::super::set_up::*;
    use crate::model::drive::DriveReading;

    #[test]
    fn readings_are_scaled_and_what_stays_is_not_computed_again() {
        let time: Vec<f64> = (0..500).map(|i| f64::from(i) * 1e-4).collect();
        let wave = |k: f64| time.iter().map(|t| (k * t).sin()).collect::<Vec<f64>>();
        let (volts, xp, xc) = (wave(100.0), wave(50.0), wave(20.0));
        let of = Recording::new("r", time.clone(), Some(volts), xp, Some(xc)).unwrap();
        let own = of.drive(DriveReading::Recognised).unwrap().unwrap();
        let noise = of.noise(Channel::Cantilever);
        let alignment = Alignment {
            xp_scale: 2.0,
            xp_offset: 0.5,
            ..Alignment::default()
        };
        let made = set_up(&of, &alignment, DriveSource::default(), None);
        assert_eq!(made.proof_mass[7], 2.0 * of.proof_mass[7] + 0.5);
        assert_eq!(made.cantilever, of.cantilever);
        let again = made.own_drive().unwrap().unwrap();
        assert!(std::sync::Arc::ptr_eq(&own, &again));
        assert!(
            made.derived.noise[Channel::ProofMass as usize]
                .get()
                .is_none()
        );
        assert_eq!(made.noise(Channel::Cantilever), noise);
    }
}
