//! Which drive a panel starts from.

use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::explore::DriveSource;
use crate::model::drive::Waveform;

/// The drive of a source.
///
/// # Errors
/// Why there is none, and what to do.
pub fn drive_of(setup: &Setup, source: DriveSource) -> Result<Waveform, String> {
    if setup.preset.model.piezo.is_none() {
        return Err(format!(
            "the device {} has no drive; choose one with a drive in File, Open preset",
            setup.preset.model.name
        ));
    }
    match (source, &setup.drive) {
        (DriveSource::Drawn, _) => setup
            .explore
            .drawn
            .waveform()
            .map_err(|error| format!("drawn waveform: {error}")),
        (DriveSource::Tune, DriveChoice::Waveform(waveform)) => match waveform.period() {
            Some(_) => Ok(waveform.clone()),
            None => Err(format!(
                "the drive of Tune, {waveform}, does not repeat; choose sine, square, triangle or ramped there, or the drawn waveform here"
            )),
        },
        (DriveSource::Tune, DriveChoice::Recorded(_)) => Err(
            "the drive of Tune is a recorded voltage, which does not repeat; choose a waveform there, or the drawn one here"
                .to_owned(),
        ),
    }
}
