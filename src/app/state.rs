//! The state that all panels see. Panels change `setup` and `view` in place and push
//! commands; the shell notices changes, sends them to the worker and runs the commands.

use std::sync::Arc;

use super::analysis::diagnosis::Diagnosing;
use super::analysis::fit::Fitting;
use super::analysis::identification::Identification;
use super::setup::command::Command;
use super::setup::notice::{Notice, Refusal};
use super::setup::overlay::OverlayId;
use super::setup::setup::Setup;
use super::setup::view::{Picture, View};
use super::simulation::snapshot::Snapshot;

/// The two time cursors, shared by all plots. Times in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cursors {
    /// Where the pointer is, while it is over a plot against time.
    pub hover: Option<f64>,
    /// Set by a click; values are read out here.
    pub first: Option<f64>,
    /// Set by a click with Shift; differences are read out between the two.
    pub second: Option<f64>,
}

/// Everything the panels of a workspace draw and change.
#[derive(Debug, Clone)]
pub struct State {
    /// Device, drive, recordings: what undo covers.
    pub setup: Setup,
    /// How it is looked at.
    pub view: View,
    /// The newest result, if there is one yet.
    pub snapshot: Option<Arc<Snapshot>>,
    /// The curve kept for comparison.
    pub ghost: Option<Arc<Snapshot>>,
    /// Why the newest parameters gave no result.
    pub refusal: Option<Refusal>,
    /// Live mode: what the person asked for. The state reached is in the snapshot.
    pub paused: bool,
    /// Live mode: time that is looked at [s] while scrubbing; `None` follows the run.
    pub scrub: Option<f64>,
    /// Cursors of the plots.
    pub cursors: Cursors,
    /// The picture that was just switched on, to be brought into view.
    pub reveal: Option<Picture>,
    /// The recording that commands act on.
    pub selected: Option<OverlayId>,
    /// Commands for the shell, run after the frame is drawn.
    pub commands: Vec<Command>,
    /// What is said over the window, the newest last.
    pub notices: Vec<Notice>,
    /// Whether the drive editor is open.
    pub drive_editor_open: bool,
    /// Whether the window with all 16 cases of Table A.1 is open.
    pub validation_open: bool,
    /// The fit panel.
    pub fitting: Fitting,
    /// The guided identification.
    pub identification: Identification,
    /// The Diagnose workspace.
    pub diagnosing: Diagnosing,
}

impl State {
    /// Asks the shell for a command.
    pub fn ask(&mut self, command: Command) {
        self.commands.push(command);
    }
}

/// A state around a setup, nothing computed yet.
pub fn state(setup: Setup, view: View) -> State {
    State {
        selected: setup.overlays.first().map(|overlay| overlay.id),
        setup,
        view,
        snapshot: None,
        ghost: None,
        refusal: None,
        paused: false,
        scrub: None,
        cursors: Cursors::default(),
        reveal: None,
        commands: Vec::new(),
        notices: Vec::new(),
        drive_editor_open: false,
        validation_open: false,
        fitting: Fitting::default(),
        identification: Identification::default(),
        diagnosing: Diagnosing::default(),
    }
}
