//! The devices of the feet, and the drive of each.

use std::sync::Arc;

use super::error::GaitError;
use crate::model::Model;
use crate::model::drive::{PeriodicDrive, Waveform};

/// A foot before its response is known.
#[derive(Debug, Clone, PartialEq)]
pub struct FootDevice {
    /// What a person calls it.
    pub name: String,
    /// The device.
    pub model: Arc<Model>,
    /// By how much its drive is later, as a share of the drive's period.
    pub delay: f64,
}

impl FootDevice {
    /// Numbers of the feet by device: those of one group have the same response but for their
    /// delays. In order of each group's first foot.
    #[must_use]
    pub fn groups(feet: &[Self]) -> Vec<Vec<usize>> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (i, foot) in feet.iter().enumerate() {
            let same = |g: &&mut Vec<usize>| {
                let first = &feet[g[0]].model;
                Arc::ptr_eq(first, &foot.model) || first == &foot.model
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.push(i),
                None => groups.push(vec![i]),
            }
        }
        groups
    }
}

/// The drive later by `delay` of its period, as if it had always run.
///
/// # Errors
/// [`GaitError::Delay`] for rest, chirps and tables; [`GaitError::Drive`] for a delay that is no
/// number.
pub fn delayed(waveform: &Waveform, delay: f64) -> Result<Waveform, GaitError> {
    let Some(mut drive) = PeriodicDrive::of(waveform) else {
        return Err(GaitError::Delay(waveform.to_string()));
    };
    let periods = drive.burst.map_or(1.0, |burst| f64::from(burst.of));
    let turn = 360.0 * periods;
    // Within a turn either way, however often it is delayed.
    drive.phase = (drive.phase - turn * delay) % turn;
    Ok(drive.waveform()?)
}
