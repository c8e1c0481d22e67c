//! The identification, step by step.

use std::sync::Arc;

use super::error::ModalError;
use super::finish::Work;
use super::result::{InputChoice, ModalFit, ModalOptions};
use super::search::find_modes;
use super::sweeps::{driven_band, names, noise_of, sweeps_of};
use super::thresholds::MIN_STRETCH_PERIODS;
use super::time_domain::data::Data;
use crate::fit::solve::levenberg_marquardt::Control;
use crate::model::Model;
use crate::recording::Recording;

/// Identifies the modes of a device from swept sines; recordings that are none are left aside. `model`
/// gives the drive's branches, the gas film, and `eta`.
///
/// # Errors
/// [`ModalError`] with one clear sentence.
pub fn identify(
    model: &Model,
    recordings: &[Arc<Recording>],
    options: &ModalOptions,
    control: &Control<'_>,
) -> Result<ModalFit, ModalError> {
    let (sweeps, mut remarks) = sweeps_of(recordings)?;
    let piezo = model
        .piezo
        .filter(|_| options.input == InputChoice::Automatic);
    let mut data = Data::new(model, &sweeps, piezo)?;
    let band = driven_band(&data, &sweeps)?;
    data.drop_short(MIN_STRETCH_PERIODS / band.0);
    if data.stretches.is_empty() {
        return Err(ModalError::NoSweep {
            recording: names(&sweeps),
            reason: "the mass touches the ground in every few periods".to_owned(),
        });
    }
    if data.left_out > 0 {
        remarks.push(format!(
            "{:.1} % of the samples are left out: the mass touches the ground there, or between two touches is free for too short.",
            100.0 * data.left_out as f64 / data.samples as f64
        ));
    }
    let noise = noise_of(&sweeps);
    let mut found = find_modes(&mut data, band, noise, options, control)?;
    let mut work = Work {
        model,
        options,
        data,
        band,
        noise,
        film_shares: Vec::new(),
    };
    found = work.finish(found, control)?;
    work.result(&found, &sweeps, remarks)
}
