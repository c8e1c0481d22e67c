//! Turns the chosen drive into the waveform that the simulator takes: the choice itself,
//! or the measured voltage of a recording.

use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::model::drive::{DriveReading, Waveform};

/// How a drive was made of a recording's voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveMaking {
    /// Time shift of the recording \[s\].
    pub shift: f64,
    /// How its voltage was read.
    pub reading: DriveReading,
}

impl DriveMaking {
    /// That of a recording as it is set up.
    fn of(overlay: &Overlay) -> Self {
        Self {
            shift: overlay.alignment.time_shift,
            reading: overlay.reading(),
        }
    }
}

/// The last recorded drive. Its table is built once, not in every frame.
#[derive(Debug, Default)]
pub struct RecordedDriveCache {
    /// The recording, how its voltage was used, and the drive made of it.
    entry: Option<((OverlayId, DriveMaking), Result<Waveform, String>)>,
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
        let making = DriveMaking::of(overlay);
        if let Some((known, drive)) = &self.entry
            && *known == (id, making)
        {
            return drive.clone();
        }
        let drive = recorded_drive(overlay, making);
        self.entry = Some(((id, making), drive.clone()));
        drive
    }

    /// How recording `id` was made into `drive`; `None` if this drive came from elsewhere.
    pub fn making_of(&self, id: OverlayId, drive: &Waveform) -> Option<DriveMaking> {
        match &self.entry {
            Some(((known, making), Ok(made))) if id == *known && made == drive => Some(*making),
            _ => None,
        }
    }
}

/// The voltage of a recording as a drive, shifted as the recording is drawn.
///
/// # Errors
/// Why it cannot be used.
pub fn recorded_drive(overlay: &Overlay, making: DriveMaking) -> Result<Waveform, String> {
    let name = &overlay.recording.name;
    match overlay.recording.drive(making.reading) {
        None => Err(format!("{name} has no voltage; choose another drive")),
        Some(Ok(drive)) => Ok(drive.waveform(name, making.shift)),
        Some(Err(error)) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::files::built_in;
    use crate::app::setup::own_drive::OwnDrive;

    #[test]
    fn a_voltage_read_in_another_way_is_another_drive() {
        let mut setup = built_in::setup();
        let id = setup.overlays[0].id;
        setup.drive = DriveChoice::Recorded(id);
        let mut cache = RecordedDriveCache::default();
        let recognised = cache.resolve(&setup).unwrap();
        setup.overlays[0].drive = OwnDrive::Measured(DriveReading::PointByPoint);
        let points = cache.resolve(&setup).unwrap();
        assert_ne!(points, recognised);
        let making = cache.making_of(id, &points).unwrap();
        assert_eq!(making.reading, DriveReading::PointByPoint);
        assert_eq!(cache.making_of(id, &recognised), None);
        setup.overlays[0].drive = OwnDrive::default();
        assert_eq!(cache.resolve(&setup).unwrap(), recognised);
    }
}
