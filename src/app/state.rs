//! The state that all panels see. Panels change `setup` and `view` in place and push
//! commands; the shell notices changes, sends them to the worker and runs the commands.

use std::sync::Arc;

use super::analysis::diagnosis::Diagnosing;
use super::analysis::fit::Fitting;
use super::analysis::identification::Identification;
use super::setup::command::Command;
use super::setup::setup::{OverlayId, Picture, Setup, View};
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

/// A parameter that the simulator or the model refused, shown at its slider while the
/// last good curve stays.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// Id of the parameter, `effect.parameter` for an effect's.
    pub parameter: String,
    /// What is wrong and what to do.
    pub message: String,
}

/// What a notice is about, and so what its button does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// How a recording was read: its import can be looked at again.
    Recording(OverlayId),
    /// A session's recording that is not where it was: it can be looked for.
    Lost(OverlayId),
}

/// Something said over the window.
#[derive(Debug, Clone)]
pub struct Notice {
    /// Errors are drawn in their colour and stay until they are dismissed.
    pub is_error: bool,
    /// What, where, what to do.
    pub text: String,
    /// What it is about, if something can be done. Such a notice stays too.
    pub about: Option<About>,
    /// Since when it has been shown, on the window's clock [s].
    pub since: Option<f64>,
}

impl Notice {
    /// Says it once it is drawn.
    pub fn new(is_error: bool, text: impl Into<String>) -> Self {
        Self {
            is_error,
            text: text.into(),
            about: None,
            since: None,
        }
    }

    /// Whether it goes by itself.
    pub fn is_timed(&self) -> bool {
        !self.is_error && self.about.is_none()
    }

    /// How long it stays [s], if it goes by itself: long enough to be read twice.
    pub fn seconds(&self) -> Option<f64> {
        self.is_timed()
            .then(|| 4.0 + 0.08 * self.text.chars().count() as f64)
    }

    /// Whether it says the same.
    pub fn says(&self, other: &Self) -> bool {
        (self.is_error, self.about, &self.text) == (other.is_error, other.about, &other.text)
    }
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
