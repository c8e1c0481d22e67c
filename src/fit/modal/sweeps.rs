//! Which recordings are swept sines, and the band that they drive.

use std::sync::Arc;

use super::error::ModalError;
use super::frequency_domain::spectra::{Spectra, block_length, spectra};
use super::thresholds::{MIN_BAND_RATIO, MIN_DRIVEN_FILL, MIN_DRIVEN_LINES, MIN_DRIVEN_SHARE};
use super::time_domain::data::{Data, stays_clear_of_ground};
use crate::model::Model;
use crate::model::unit::{counted, format_quantity};
use crate::recording::{Channel, Recording};

/// Share of the longest stretch that a block of the first spectra has.
const FIRST_BLOCK_SHARE: f64 = 0.25;

/// Whether a recording's voltage goes over a band of frequencies: its turns are many, and not evenly
/// apart.
#[must_use]
pub fn is_sweep(recording: &Recording) -> bool {
    let Some(Ok(drive)) = recording.own_drive() else {
        return false;
    };
    let mut turns: Vec<f64> = Vec::new();
    for pair in drive.pieces.windows(2) {
        if pair[0].branch != pair[1].branch {
            turns.push(pair[1].start);
        }
    }
    let mut apart: Vec<f64> = turns.windows(2).map(|w| w[1] - w[0]).collect();
    if apart.len() < MIN_DRIVEN_LINES {
        return false;
    }
    apart.sort_by(f64::total_cmp);
    let at = |share: f64| apart[((apart.len() - 1) as f64 * share) as usize];
    at(0.9) > MIN_BAND_RATIO * at(0.1)
}

/// Names of the recordings that are sweeps in which the mass stays clear of the ground of `model`.
#[must_use]
pub fn sweeps_clear_of_ground(model: &Model, recordings: &[Arc<Recording>]) -> Vec<String> {
    let clear = recordings
        .iter()
        .filter(|r| stays_clear_of_ground(model, r));
    let all = clear.filter(|r| is_sweep(r));
    all.map(|r| r.name.clone()).collect()
}

pub(super) fn names(recordings: &[Arc<Recording>]) -> String {
    let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
    names.join(", ")
}

/// The recordings that are sweeps, and a remark on the others.
pub(super) fn sweeps_of(
    recordings: &[Arc<Recording>],
) -> Result<(Vec<Arc<Recording>>, Vec<String>), ModalError> {
    if recordings.is_empty() {
        return Err(ModalError::NoRecording);
    }
    if let Some(mute) = recordings.iter().find(|r| r.own_drive().is_none()) {
        return Err(ModalError::NoVoltage {
            recording: mute.name.clone(),
        });
    }
    let (sweeps, others): (Vec<_>, Vec<_>) = recordings.iter().cloned().partition(|r| is_sweep(r));
    if sweeps.is_empty() {
        return Err(ModalError::NoSweep {
            recording: names(recordings),
            reason: "the voltage is no swept sine".to_owned(),
        });
    }
    let aside =
        (!others.is_empty()).then(|| format!("No swept sine, so not used: {}.", names(&others)));
    Ok((sweeps, aside.into_iter().collect()))
}

/// The band of frequencies that the input drives \[Hz\].
pub(super) fn driven_band(
    data: &Data,
    sweeps: &[Arc<Recording>],
) -> Result<(f64, f64), ModalError> {
    let fail = |reason: String| ModalError::NoSweep {
        recording: names(sweeps),
        reason,
    };
    // The voltage tells the band: the jumps of the branches drive all frequencies a little.
    let mut by_voltage = data.clone();
    by_voltage.piezo = None;
    let found = first_spectra(&by_voltage, &readings(data));
    let spectra = found
        .iter()
        .flatten()
        .find(|s| s.blocks > 0)
        .ok_or_else(|| {
            fail("there is no uninterrupted stretch to take a spectrum of".to_owned())
        })?;
    let lines = spectra.driven(MIN_DRIVEN_SHARE);
    let (Some(first), Some(last)) = (lines.first(), lines.last()) else {
        return Err(fail("the voltage is constant".to_owned()));
    };
    let band = (
        *first as f64 * spectra.resolution,
        *last as f64 * spectra.resolution,
    );
    let fill = lines.len() as f64 / (last - first + 1) as f64;
    if lines.len() < MIN_DRIVEN_LINES || band.1 < MIN_BAND_RATIO * band.0 || fill < MIN_DRIVEN_FILL
    {
        return Err(fail(format!(
            "the voltage drives only {} from {} to {}",
            counted(lines.len(), "frequency line"),
            format_quantity(band.0, "Hz", 3),
            format_quantity(band.1, "Hz", 3)
        )));
    }
    Ok(band)
}

pub(super) fn readings(data: &Data) -> Vec<[Option<Vec<f64>>; 2]> {
    data.stretches.iter().map(|s| s.readings.clone()).collect()
}

pub(super) fn first_spectra(
    data: &Data,
    readings: &[[Option<Vec<f64>>; 2]],
) -> [Option<Spectra>; 2] {
    let longest = data.longest_stretch().max(1) as f64;
    let resolution = 1.0 / (FIRST_BLOCK_SHARE * longest * data.interval);
    spectra(data, readings, block_length(data, resolution), false)
}

/// Noise of each reading, estimated without the model \[m\]: that of the noisiest recording.
pub(super) fn noise_of(sweeps: &[Arc<Recording>]) -> [Option<f64>; 2] {
    [Channel::ProofMass, Channel::Cantilever].map(|channel| {
        let all = sweeps.iter().filter_map(|r| r.noise(channel));
        all.map(|n| n.sigma).reduce(f64::max)
    })
}
