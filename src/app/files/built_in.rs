//! What comes with the program: the first start's device and its two recordings, so that the
//! window is never empty, and the example recordings.

use std::sync::Arc;

use crate::app::setup::command::Command;
use crate::app::setup::current_setup::{DiagnosisChoices, Setup};
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::explore::ExploreChoices;
use crate::app::setup::overlay::{Estimates, Overlay};
use crate::app::setup::own_drive::OwnDrive;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::csv::{ImportSettings, import_bytes_auto};
use crate::trial::demo;

/// The first of two synthetic recordings that come with the program: the `paper` device with
/// other parameters under a square. Its bounces tell alpha.
pub const MADE_UP_CSV: &[u8] = include_bytes!("../../../assets/made-up-paper.csv");
/// Its name in the list of recordings.
pub const MADE_UP_NAME: &str = "synthetic recording";
/// The same device under a sweep: stays on the ground of many lengths tell Ca and Ca0.
pub const SWEEP_CSV: &[u8] = include_bytes!("../../../assets/made-up-sweep.csv");
/// Its name in the list of recordings.
pub const SWEEP_NAME: &str = "synthetic sweep";
/// Its name in older sessions.
const OLD_MADE_UP_NAME: &str = "made-up recording";

/// The hint of the first start: three things to try. A test follows the first one to its end.
pub fn first_start_hint() -> [String; 3] {
    let key = |command: Command| command.keys().unwrap_or_default();
    [
        format!(
            "The recordings are synthetic, of one device with other parameters: drag Cs, alpha, Ca0 and Ca and watch the misfit fall towards 1 x noise. Or press {}, then Fit and Apply: the fit finds them.",
            key(Command::FitPanel)
        ),
        format!(
            "Press {} to watch the device in slow motion, {} to return to the whole span, {} to keep the current curve for comparison.",
            key(Command::SetMode(Mode::Live)),
            key(Command::SetMode(Mode::WholeSpan)),
            key(Command::KeepCurve)
        ),
        format!(
            "Drop a CSV file on the window to compare it with the simulation; press {} for the paper's identification step by step, {} for keys and mouse gestures.",
            key(Command::Identification),
            key(Command::Help)
        ),
    ]
}

/// The `paper` device at its usual drive with the made-up recordings of one other device. Together
/// they determine everything that a fit frees.
pub fn setup() -> Setup {
    let mut setup = from_preset(Preset::default());
    setup.overlays.extend(made_up(1));
    setup.overlays.extend(sweep(2));
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
        kept: Vec::new(),
        diagnosis: DiagnosisChoices::default(),
        explore: ExploreChoices::default(),
    }
}

/// The made-up square as overlay number `id`.
pub fn made_up(id: u64) -> Option<Overlay> {
    let recording = import_bytes_auto(MADE_UP_NAME, MADE_UP_CSV).ok()?;
    Some(unread(id, Arc::new(recording)))
}

/// The made-up sweep as overlay number `id`.
pub fn sweep(id: u64) -> Option<Overlay> {
    let recording = import_bytes_auto(SWEEP_NAME, SWEEP_CSV).ok()?;
    let overlay = unread(id, Arc::new(recording));
    Some(Overlay {
        color: 1,
        ..overlay
    })
}

/// Whether a recording of that name is one of the first start's.
pub fn is_of_first_start(name: &str) -> bool {
    matches!(name, MADE_UP_NAME | SWEEP_NAME)
}

/// The built-in recording of that name as overlay number `id`: one of the first start's or of
/// the example's; the first start's square if `name` is `None`.
pub fn shipped(name: Option<&str>, id: u64) -> Option<Overlay> {
    match name {
        None | Some(MADE_UP_NAME | OLD_MADE_UP_NAME) => made_up(id),
        Some(SWEEP_NAME) => sweep(id),
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
        drive: OwnDrive::default(),
        estimates: Estimates::default(),
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
        for (csv, drive) in [
            (MADE_UP_CSV, "square:15Hz:8V"),
            (SWEEP_CSV, "chirp:5Hz:100Hz:8V"),
        ] {
            let text = String::from_utf8_lossy(&csv[..300]);
            assert!(text.starts_with('#') && text.contains("made up"), "{text}");
            assert!(
                text.contains(drive) && text.contains("Cs=2.4e-21"),
                "{text}"
            );
        }
        let sweep = sweep(2).expect("the sweep can be read");
        assert!(sweep.recording.warnings.is_empty());
        assert!(MADE_UP_CSV.len() + SWEEP_CSV.len() < 1_500_000);
    }

    #[test]
    fn the_built_in_recording_is_found_by_its_name_in_older_sessions() {
        for name in [None, Some(MADE_UP_NAME), Some(OLD_MADE_UP_NAME)] {
            let overlay = shipped(name, 1).expect("it is built in");
            assert_eq!(overlay.recording.name, MADE_UP_NAME);
        }
        let overlay = shipped(Some(SWEEP_NAME), 2).expect("it is built in");
        assert_eq!(overlay.recording.name, SWEEP_NAME);
    }
}
