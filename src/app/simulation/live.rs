//! A device that runs against wall time, with a history to scrub through.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::request::SimulationRequest;
use super::snapshot::{LiveState, Snapshot};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{Runner, SimError, Trace};

/// Samples kept for scrubbing: 40 s of device time at 50 kHz.
const HISTORY: usize = 2_000_000;
/// Samples handed to the window at once.
const VIEW: usize = 200_000;
/// Longest stretch of computing before commands are looked at again.
const SLICE: Duration = Duration::from_millis(20);
/// Wall time between two pictures [s]: no step of the run is longer, so that slow motion
/// moves in each.
const FRAME: f64 = 1.0 / 60.0;
/// Device time of one single step [s].
const SINGLE_STEP: f64 = 1e-4;

/// What a snapshot depends on.
#[derive(Debug, PartialEq)]
struct Shown {
    time: f64,
    scrub: Option<f64>,
    duration: f64,
    still: bool,
    model: Arc<Model>,
}

/// The running device.
pub struct Live {
    runner: Runner,
    history: Trace,
    model: Arc<Model>,
    drive: Waveform,
    restarts: u64,
    steps: u64,
    /// Wall and device time from which the present pace counts.
    pace: (Instant, f64, f64),
    /// Wall and device time at the last measurement of speed.
    measured: (Instant, f64),
    speed: f64,
    shown: Option<Shown>,
    changed: bool,
    stopped: bool,
}

impl Live {
    /// A device at rest at t = 0.
    ///
    /// # Errors
    /// [`SimError`] if the wish cannot be simulated.
    pub fn start(wish: &SimulationRequest) -> Result<Self, SimError> {
        let mut options = wish.options();
        // A run has no end; its slices are bounded by time instead.
        options.max_steps = u64::MAX;
        options.max_events = usize::MAX;
        options.forces = true;
        let mut runner = Runner::new(&wish.model, &wish.drive, &options)?;
        runner.limit_step(FRAME * wish.slow_down);
        let now = Instant::now();
        Ok(Self {
            history: runner.new_trace(),
            runner,
            model: Arc::clone(&wish.model),
            drive: wish.drive.clone(),
            restarts: wish.restarts,
            steps: wish.steps,
            pace: (now, 0.0, wish.slow_down),
            measured: (now, 0.0),
            speed: 0.0,
            shown: None,
            changed: false,
            stopped: false,
        })
    }

    /// Takes over changed parameters and drive on the running device.
    ///
    /// # Errors
    /// [`SimError`] if they cannot be simulated; the device runs on with the old ones.
    pub fn adopt(&mut self, wish: &SimulationRequest) -> Result<(), SimError> {
        let other_device =
            wish.model.modes.len() != self.model.modes.len() || wish.model.name != self.model.name;
        if other_device || wish.restarts != self.restarts {
            *self = Self::start(wish)?;
            return Ok(());
        }
        if wish.model != self.model {
            self.runner.set_model(&wish.model)?;
            self.model = Arc::clone(&wish.model);
            self.stopped = false;
            self.restart_pace(wish);
        }
        if wish.drive != self.drive {
            self.runner.set_drive(&wish.drive)?;
            self.drive = wish.drive.clone();
            self.stopped = false;
        }
        Ok(())
    }

    fn restart_pace(&mut self, wish: &SimulationRequest) {
        self.pace = (Instant::now(), self.runner.time(), wish.slow_down);
    }

    /// Whether nothing moves.
    pub fn is_still(&self, wish: &SimulationRequest) -> bool {
        wish.paused || self.stopped
    }

    /// Whether there is something new to show since the last snapshot.
    pub fn has_changed(&self) -> bool {
        self.changed
    }

    /// Advances until simulated time has met wall time times the slow-down, or the
    /// slice of computing is used up.
    ///
    /// # Errors
    /// [`SimError`] if the device cannot go on; it stands still then.
    pub fn slice(&mut self, wish: &SimulationRequest) -> Result<(), SimError> {
        let started = Instant::now();
        if wish.steps != self.steps {
            self.steps = wish.steps;
            self.run(self.runner.time() + SINGLE_STEP)?;
        }
        if wish.paused || self.stopped {
            self.restart_pace(wish);
            self.measured = (started, self.runner.time());
            self.speed = 0.0;
            return Ok(());
        }
        if self.pace.2 != wish.slow_down {
            self.runner.limit_step(FRAME * wish.slow_down);
            self.restart_pace(wish);
        }
        let target = self.pace.1 + self.pace.0.elapsed().as_secs_f64() * wish.slow_down;
        while self.runner.time() < target {
            // Pieces short enough that the clock is looked at in time.
            let piece = (self.runner.time() + 1e-3).min(target);
            self.run(piece)?;
            if started.elapsed() > SLICE {
                break;
            }
        }
        if self.runner.time() < target {
            // Wall time cannot be met: do not chase it.
            self.restart_pace(wish);
        }
        let since = self.measured.0.elapsed().as_secs_f64();
        if since > 0.5 {
            self.speed = (self.runner.time() - self.measured.1) / since;
            self.measured = (Instant::now(), self.runner.time());
        }
        Ok(())
    }

    fn run(&mut self, until: f64) -> Result<(), SimError> {
        let result = self.runner.advance(until, &mut self.history);
        self.stopped = result.is_err();
        if self.history.len() > HISTORY + HISTORY / 4 {
            self.history.forget(self.history.len() - HISTORY);
        }
        result
    }

    /// What is to be seen now: the stretch of the history that ends at the time looked at.
    pub fn snapshot(&mut self, generation: u64, wish: &SimulationRequest) -> Snapshot {
        let time = self.history.end().min(self.runner.time());
        let end = wish.scrub.unwrap_or(time).clamp(self.history.t0, time);
        let still = self.is_still(wish);
        let shown = Shown {
            time,
            scrub: wish.scrub,
            duration: wish.duration,
            still,
            model: Arc::clone(&self.model),
        };
        self.changed = self.shown.as_ref() != Some(&shown);
        self.shown = Some(shown);
        let samples = ((wish.duration / self.history.dt) as usize).clamp(2, VIEW);
        let last = ((end - self.history.t0) / self.history.dt).round() as usize + 1;
        let view = self
            .history
            .piece(last.saturating_sub(samples), last.min(self.history.len()));
        let mut snapshot =
            Snapshot::new(generation, &self.model, Arc::new(view), &[], Duration::ZERO);
        snapshot.live = Some(LiveState {
            time,
            history_start: self.history.t0,
            speed: self.speed,
            paused: still,
        });
        snapshot
    }
}
