//! Turns the chosen drive into the waveform that the simulator takes: the choice itself,
//! or the measured voltage of a recording.

use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::model::drive::Waveform;

/// The last recorded drive. Its table is built once, not in every frame.
#[derive(Debug, Default)]
pub struct RecordedDriveCache {
    /// Recording and its time shift \[s\], and the drive made of them.
    entry: Option<((OverlayId, f64), Result<Waveform, String>)>,
}

impl RecordedDriveCache {
    /// The waveform of the setup's drive.
    ///
    /// # Errors
    /// Why the recording gives no drive, and what to do.
    pub fn resolve(&mut self, setup: &Setup) -> Result<Waveform, String> {
        let id = match &setup.drive {
            DriveChoice::Waveform(waveform) => return Ok(waveform.clone()),
            DriveChoice::Recorded(id) => *id,
        };
        let Some(overlay) = setup.overlays.iter().find(|o| o.id == id) else {
            return Err(
                "the recording that supplies the drive was removed; choose another drive"
                    .to_owned(),
            );
        };
        let shift = overlay.alignment.time_shift;
        if let Some((known, drive)) = &self.entry
            && *known == (id, shift)
        {
            return drive.clone();
        }
        let drive = recorded_drive(overlay, shift);
        self.entry = Some(((id, shift), drive.clone()));
        drive
    }

    /// The time shift \[s\] with which recording `id` was made into `drive`; `None` if this
    /// drive came from elsewhere.
    pub fn shift_of(&self, id: OverlayId, drive: &Waveform) -> Option<f64> {
        match &self.entry {
            Some(((known, shift), Ok(made))) if id == *known && made == drive => Some(*shift),
            _ => None,
        }
    }
}

/// The voltage of a recording as a drive, shifted by `shift` \[s\] as the recording is drawn.
///
/// # Errors
/// Why it cannot be used.
pub fn recorded_drive(overlay: &Overlay, shift: f64) -> Result<Waveform, String> {
    let name = &overlay.recording.name;
    match overlay.recording.drive(overlay.reading()) {
        None => Err(format!("{name} has no voltage; choose another drive")),
        Some(Ok(drive)) => Ok(drive.waveform(name, shift)),
        Some(Err(error)) => Err(error.to_string()),
    }
}
