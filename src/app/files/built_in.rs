//! What comes with the program: the first start's device and recording, so that the window
//! is never empty, and the example recordings.

use std::sync::Arc;

use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::Overlay;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::csv::{ImportSettings, import_bytes_auto};
use crate::trial::demo;

/// The made-up recording that comes with the program: the `paper` device with other
/// parameters.
pub const MADE_UP_CSV: &[u8] = include_bytes!("../../../assets/made-up-paper.csv");
/// Its name in the list of recordings.
pub const MADE_UP_NAME: &str = "made-up recording";

/// The hint of the first start: three things to try.
pub const FIRST_START_HINT: [&str; 3] = [
    "The orange curve is a made-up recording of a device with other parameters: drag Cs, alpha and Ca0 until the residual is flat.",
    "Press L to watch the device in slow motion, W to return to the whole span, G to set the present curve as the reference for comparison.",
    "Drop a CSV file on the window to compare it with the simulation; press ? for keys and mouse gestures.",
];

/// The `paper` device at its usual drive with the made-up recording over it.
pub fn setup() -> Setup {
    let mut setup = from_preset(Preset::default());
    setup.overlays.extend(made_up(1));
    setup
}

/// A preset at its usual drive, without recordings.
pub fn from_preset(preset: Preset) -> Setup {
    // The drive was checked when the preset was read.
    let drive = Waveform::parse(&preset.drive, preset.duration).unwrap_or_default();
    Setup {
        duration: preset.duration,
        drive: DriveChoice::Waveform(drive),
        original: Arc::new(preset.clone()),
        preset,
        locked: std::collections::BTreeSet::new(),
        overlays: Vec::new(),
    }
}

/// The made-up recording as overlay number `id`.
pub fn made_up(id: u64) -> Option<Overlay> {
    let recording = import_bytes_auto(MADE_UP_NAME, MADE_UP_CSV).ok()?;
    Some(unread(id, Arc::new(recording)))
}

/// The built-in recording of that name as overlay number `id`: one of the example's, or the
/// first start's if `name` is `None`.
pub fn shipped(name: Option<&str>, id: u64) -> Option<Overlay> {
    match name {
        None | Some(MADE_UP_NAME) => made_up(id),
        Some(name) => Some(unread(id, demo::recording(name)?)),
    }
}

/// A recording that comes from no file, as overlay number `id`.
pub fn unread(id: u64, recording: Arc<Recording>) -> Overlay {
    Overlay {
        id,
        recording,
        import: ImportSettings::default(),
        alignment: Alignment::default(),
        visible: true,
        color: 0,
        made_up: true,
        role: None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::built_in::*;

    #[test]
    fn the_built_in_recording_is_valid_and_declared_as_made_up() {
        let overlay = made_up(1).expect("the built-in recording can be read");
        assert!(overlay.recording.warnings.is_empty());
        assert!(overlay.recording.voltage.is_some() && overlay.recording.cantilever.is_some());
        let text = String::from_utf8_lossy(&MADE_UP_CSV[..200]);
        assert!(text.starts_with('#') && text.contains("made up"), "{text}");
    }
}
