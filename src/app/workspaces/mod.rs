//! What the central area shows: one folder for each workspace of
//! [`WorkspaceId`](super::setup::workspace_id::WorkspaceId).

use eframe::egui::Ui;

use super::setup::workspace_id::WorkspaceId;
use super::state::State;

pub mod diagnose;
pub mod explore;
pub mod learn;
pub mod present;
mod recording_faults;
pub mod tune;

/// Draws the workspace in view. An unknown name, for example from a newer session, shows
/// the first one.
pub fn show(ui: &mut Ui, state: &mut State) {
    let known = WorkspaceId::ALL.into_iter();
    let workspace = known.clone().find(|w| w.name() == state.view.workspace);
    match workspace.unwrap_or(WorkspaceId::ALL[0]) {
        WorkspaceId::Tune => tune::show(ui, state),
        WorkspaceId::Diagnose => diagnose::show(ui, state),
        WorkspaceId::Explore => explore::show(ui, state),
        WorkspaceId::Learn => learn::show(ui, state),
    }
}
