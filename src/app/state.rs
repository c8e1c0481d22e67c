//! The state that all panels see. Panels change `setup` and `view` in place and push
//! commands. The window sends changes to the simulator and runs the commands.

use std::sync::Arc;

use super::analysis::diagnosis::Diagnosing;
use super::analysis::explore::Exploring;
use super::analysis::fit::Fitting;
use super::analysis::identification::Identification;
use super::analysis::learning::Learning;
use super::analysis::learning::presenting::{Presenting, SavedScenes};
use super::analysis::sensitivity::Sensing;
use super::setup::command::Command;
use super::setup::current_setup::Setup;
use super::setup::kept_curve::KeptCurve;
use super::setup::notice::{Notice, Refusal};
use super::setup::overlay::OverlayId;
use super::setup::view::{Picture, View};
use super::simulation::kept::KeptRuns;
use super::simulation::misfit_history::MisfitHistory;
use super::simulation::snapshot::Snapshot;

/// The two time cursors, shared by all plots. Times in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cursors {
    /// Where the pointer is, while it is over a plot against time.
    pub hover: Option<f64>,
    /// Set by a click; values are read here.
    pub first: Option<f64>,
    /// Set by Shift and click; differences between the two cursors are shown.
    pub second: Option<f64>,
}

/// Everything that the panels of a workspace draw and change.
#[derive(Debug, Clone)]
pub struct State {
    /// Device, drive and recordings; undo covers them.
    pub setup: Setup,
    /// Mode, pictures, theme and zoom.
    pub view: View,
    /// The newest result, if there is one yet.
    pub snapshot: Option<Arc<Snapshot>>,
    /// Total misfit before and after the last change.
    pub misfit_history: MisfitHistory,
    /// The runs of the kept curves, as far as they are computed.
    pub kept_runs: KeptRuns,
    /// Why the present values give no result.
    pub refusal: Option<Refusal>,
    /// Live mode: whether the person paused it. Whether it has paused is in the snapshot.
    pub paused: bool,
    /// Live mode: the scrubbed time \[s\]; `None` follows the run.
    pub scrub: Option<f64>,
    /// Cursors of the plots.
    pub cursors: Cursors,
    /// The picture just switched on; it is scrolled into view.
    pub reveal: Option<Picture>,
    /// The recording that commands act on.
    pub selected: Option<OverlayId>,
    /// Commands, run after the frame is drawn.
    pub commands: Vec<Command>,
    /// Notices over the window, the newest last.
    pub notices: Vec<Notice>,
    /// Whether the drive editor is open.
    pub drive_editor_open: bool,
    /// Whether the panel with all 16 cases of Table A.1 is open.
    pub validation_open: bool,
    /// Whether the table of the kept curves is open.
    pub kept_open: bool,
    /// The fit panel.
    pub fitting: Fitting,
    /// The guided identification.
    pub identification: Identification,
    /// What each slider changes in the residual.
    pub sensing: Sensing,
    /// The Diagnose workspace.
    pub diagnosing: Diagnosing,
    /// The Explore workspace.
    pub exploring: Exploring,
    /// The Learn workspace.
    pub learning: Learning,
    /// The presenter, while it fills the screen.
    pub presenting: Option<Presenting>,
    /// Scenes that the presenter shows by key.
    pub scenes: SavedScenes,
}

impl State {
    /// A state around a setup, with nothing computed yet.
    pub fn new(setup: Setup, view: View) -> Self {
        Self {
            selected: setup.overlays.first().map(|overlay| overlay.id),
            setup,
            view,
            snapshot: None,
            misfit_history: MisfitHistory::default(),
            kept_runs: KeptRuns::default(),
            refusal: None,
            paused: false,
            scrub: None,
            cursors: Cursors::default(),
            reveal: None,
            commands: Vec::new(),
            notices: Vec::new(),
            drive_editor_open: false,
            validation_open: false,
            kept_open: false,
            fitting: Fitting::default(),
            identification: Identification::default(),
            sensing: Sensing::default(),
            diagnosing: Diagnosing::default(),
            exploring: Exploring::default(),
            learning: Learning::default(),
            presenting: None,
            scenes: SavedScenes::default(),
        }
    }

    /// The kept curves that are drawn, with their runs; the one kept last is the last.
    pub fn kept_in_view(&self) -> impl Iterator<Item = (&KeptCurve, &Arc<Snapshot>)> {
        let visible = self.setup.kept.iter().filter(|curve| curve.visible);
        visible.filter_map(|curve| Some((curve, self.kept_runs.drawn(&curve.origin)?)))
    }

    /// Keeps the present device as a curve with this run; `shift` tells its origin from others.
    #[cfg(test)]
    pub fn keep_run(&mut self, name: &str, shift: f64, run: Arc<Snapshot>) {
        use super::setup::kept_curve::RunOrigin;
        use super::simulation::kept::KeptRun;

        let origin = Arc::new(RunOrigin {
            preset: self.setup.preset.clone(),
            drive: self.setup.drive.clone(),
            shift,
            reading: Default::default(),
            duration: self.setup.duration,
            live: None,
        });
        self.setup.kept.push(KeptCurve {
            name: name.to_owned(),
            color: self.setup.kept.len(),
            visible: true,
            origin: Arc::clone(&origin),
        });
        self.kept_runs.put(KeptRun {
            origin,
            run: Ok(run),
            is_complete: true,
        });
    }

    /// Cancels the jobs whose results the state would show.
    pub fn stop_jobs(&self) {
        if let Some(job) = &self.fitting.job {
            job.cancel();
        }
        if let Some((_, job)) = &self.fitting.profile.job {
            job.cancel();
        }
        if let Some((_, job)) = &self.identification.job {
            job.cancel();
        }
        if let Some(running) = &self.diagnosing.running {
            running.job.cancel();
        }
        if let Some(job) = &self.diagnosing.trial.making {
            job.cancel();
        }
        self.exploring.stop();
    }

    /// Asks for a command.
    pub fn ask(&mut self, command: Command) {
        self.commands.push(command);
    }
}
