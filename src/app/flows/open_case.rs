//! A case of the Explore workspace in Tune: its device and its drive become the present ones, which
//! can be undone. And a path through a map, played as a sweep in the live run.

use eframe::egui::Context;

use crate::app::analysis::explore::path_play::PathPlay;
use crate::app::setup::drive_choice::{DriveChoice, Mode};
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::state::State;
use crate::model::Model;
use crate::model::drive::Waveform;

/// Periods of a new drive that the whole span shows at least.
const SHOWN_PERIODS: f64 = 6.0;

/// Shows a drive, and a device if one is given, in Tune.
pub fn open(state: &mut State, model: Option<Model>, drive: Waveform) {
    if let Some(period) = drive.period() {
        state.setup.duration = state.setup.duration.max(SHOWN_PERIODS * period);
    }
    if let Some(model) = model {
        state.setup.preset.model = model;
    }
    state.setup.drive = DriveChoice::Waveform(drive);
    state.view.workspace = WorkspaceId::Tune.name().to_owned();
    state.view.time_range = None;
}

/// Shows the case at the chosen point of the map in Tune.
pub fn open_point(state: &mut State) {
    let Some(index) = state.exploring.map.point else {
        return;
    };
    if let Ok((model, drive)) = state.exploring.map.setting(index) {
        open(state, Some(model), drive);
    }
}

/// Begins to play the path through the present map in the live run.
pub fn play(state: &mut State) {
    let mapping = &state.exploring.map;
    let Some(request) = mapping.run.asked() else {
        return;
    };
    state.exploring.playing = PathPlay::new(request.clone(), mapping.path.clone());
    if state.exploring.playing.is_some() {
        state.view.workspace = WorkspaceId::Tune.name().to_owned();
        state.view.mode = Mode::Live;
        state.paused = false;
        state.scrub = None;
    }
}

/// Moves device and drive on along the path that is played. It ends with its path, and when the
/// person does something else.
pub fn advance(state: &mut State, context: &Context) {
    let Some(mut play) = state.exploring.playing.take() else {
        return;
    };
    let is_watched =
        state.view.workspace == WorkspaceId::Tune.name() && state.view.mode == Mode::Live;
    if !is_watched {
        return;
    }
    let Some(setting) = play.at(context.input(|input| input.time)) else {
        return;
    };
    // A part of the path that is impossible is passed over.
    if let Ok((model, drive)) = setting {
        state.setup.preset.model = model;
        state.setup.drive = DriveChoice::Waveform(drive);
    }
    state.exploring.playing = Some(play);
    context.request_repaint();
}
