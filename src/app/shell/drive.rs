//! The drive that the simulator is given: a waveform, or the voltage of a recording.

use std::sync::Arc;

use super::window::Shell;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::Overlay;
use crate::model::drive::{VoltageTable, Waveform};

impl Shell {
    /// The drive with a recording's voltage resolved; made once per recording.
    pub(super) fn drive(&mut self) -> Result<Waveform, String> {
        let id = match &self.state.setup.drive {
            DriveChoice::Waveform(waveform) => return Ok(waveform.clone()),
            DriveChoice::Recorded(id) => *id,
        };
        let overlay = self.state.setup.overlays.iter().find(|o| o.id == id);
        let Some(overlay) = overlay else {
            return Err("the recording that drives is gone; choose another drive".to_owned());
        };
        let shift = overlay.alignment.time_shift;
        if let Some((known, drive)) = &self.recorded
            && *known == (id, shift)
        {
            return drive.clone();
        }
        let drive = recorded_drive(overlay, shift);
        self.recorded = Some(((id, shift), drive.clone()));
        drive
    }
}

/// A recording's voltage as drive, on the recording's clock as it is drawn: shifted by
/// `shift` [s].
pub(super) fn recorded_drive(overlay: &Overlay, shift: f64) -> Result<Waveform, String> {
    let name = overlay.recording.name.clone();
    match overlay.recording.drive_table() {
        None => Err(format!("{name} has no voltage; choose another drive")),
        Some((time, voltage)) => VoltageTable::from_recording(
            name,
            time.into_iter().map(|t| t + shift).collect(),
            voltage,
        )
        .map(|table| Waveform::Table(Arc::new(table)))
        .map_err(|error| error.to_string()),
    }
}
