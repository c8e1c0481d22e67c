//! The workspace by its accessibility tree, without a GPU.

use std::sync::Arc;
use std::time::Duration;

use crate::app::plots::pyramid::Pyramid;
use crate::app::setup::{DriveChoice, Mode, Overlay, Setup, View};
use crate::app::snapshot::{LiveState, OverlayComparison, Snapshot};
use crate::app::state::{Cursors, State};
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;

/// The state of a first start without recordings.
pub fn state() -> State {
    let preset = Preset::default();
    let drive = Waveform::parse(&preset.drive, preset.duration).unwrap();
    State {
        setup: Setup {
            drive: DriveChoice::Waveform(drive),
            duration: preset.duration,
            preset,
            locked: Default::default(),
            overlays: Vec::new(),
        },
        view: View::default(),
        snapshot: None,
        ghost: None,
        refusal: None,
        paused: false,
        scrub: None,
        cursors: Cursors::default(),
        selected: None,
        commands: Vec::new(),
        notices: Vec::new(),
        drive_editor_open: false,
    }
}
