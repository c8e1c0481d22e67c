//! A device that runs in slow motion, with a history to scrub through.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::request::SimulationRequest;
use super::snapshot::{LiveState, Snapshot};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{Runner, SimError, Trace};

/// Samples kept for scrubbing: 40 s of device time at 50 kHz.
const HISTORY_SAMPLES: usize = 2_000_000;
/// Most samples in one snapshot; copying and decimating more would take too long.
const MAX_VIEW_SAMPLES: usize = 200_000;
/// Longest time of computing before new requests are taken.
const MAX_SLICE: Duration = Duration::from_millis(20);
/// Wall time between two pictures \[s\]. No step of the run is longer, so that slow motion
/// moves in every picture.
const FRAME_TIME: f64 = 1.0 / 60.0;
/// Device time of a single step \[s\].
const SINGLE_STEP_TIME: f64 = 1e-4;

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
    /// Start of the present pace: wall time, device time \[s\], and slow-down.
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
    /// [`SimError`] if the request cannot be simulated.
    pub fn start(request: &SimulationRequest) -> Result<Self, SimError> {
        let mut options = request.options();
        // A live run has no end; its slices are bounded by wall time instead.
        options.max_steps = u64::MAX;
        options.max_events = usize::MAX;
        options.forces = true;
        let mut runner = Runner::new(&request.model, &request.drive, &options)?;
        runner.limit_step(FRAME_TIME * request.slow_down);
        let now = Instant::now();
        Ok(Self {
            history: runner.new_trace(),
            runner,
            model: Arc::clone(&request.model),
            drive: request.drive.clone(),
            restarts: request.restarts,
            steps: request.steps,
            pace: (now, 0.0, request.slow_down),
            measured: (now, 0.0),
            speed: 0.0,
            shown: None,
            changed: false,
            stopped: false,
        })
    }

    /// Applies changed parameters and a changed drive to the running device.
    ///
    /// # Errors
    /// [`SimError`] if they cannot be simulated; the device runs on with the old ones.
    pub fn adopt(&mut self, request: &SimulationRequest) -> Result<(), SimError> {
        let other_device = request.model.modes.len() != self.model.modes.len()
            || request.model.name != self.model.name;
        if other_device || request.restarts != self.restarts {
            *self = Self::start(request)?;
            return Ok(());
        }
        if request.model != self.model {
            self.runner.set_model(&request.model)?;
            self.model = Arc::clone(&request.model);
            self.stopped = false;
            self.restart_pace(request);
        }
        if request.drive != self.drive {
            self.runner.set_drive(&request.drive)?;
            self.drive = request.drive.clone();
            self.stopped = false;
        }
        Ok(())
    }

    fn restart_pace(&mut self, request: &SimulationRequest) {
        self.pace = (Instant::now(), self.runner.time(), request.slow_down);
    }

    /// Whether the device stands still.
    pub fn is_still(&self, request: &SimulationRequest) -> bool {
        request.paused || self.stopped
    }

    /// Whether there is something new to show since the last snapshot.
    pub fn has_changed(&self) -> bool {
        self.changed
    }

    /// Advances until simulated time has reached wall time times the slow-down, or the slice
    /// of computing time is used up.
    ///
    /// # Errors
    /// [`SimError`] if the device cannot be simulated any further; it then stands still.
    pub fn slice(&mut self, request: &SimulationRequest) -> Result<(), SimError> {
        let started = Instant::now();
        if request.steps != self.steps {
            self.steps = request.steps;
            self.run(self.runner.time() + SINGLE_STEP_TIME)?;
        }
        if request.paused || self.stopped {
            self.restart_pace(request);
            self.measured = (started, self.runner.time());
            self.speed = 0.0;
            return Ok(());
        }
        if self.pace.2 != request.slow_down {
            self.runner.limit_step(FRAME_TIME * request.slow_down);
            self.restart_pace(request);
        }
        let target = self.pace.1 + self.pace.0.elapsed().as_secs_f64() * request.slow_down;
        while self.runner.time() < target {
            // Short pieces, so that the clock is checked often.
            let piece = (self.runner.time() + 1e-3).min(target);
            self.run(piece)?;
            if started.elapsed() > MAX_SLICE {
                break;
            }
        }
        if self.runner.time() < target {
            // The wanted speed is not reached: the run must not try to catch up.
            self.restart_pace(request);
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
        if self.history.len() > HISTORY_SAMPLES + HISTORY_SAMPLES / 4 {
            self.history.forget(self.history.len() - HISTORY_SAMPLES);
        }
        result
    }

    /// The part of the history that ends at the present time, or at the scrubbed one.
    pub fn snapshot(&mut self, generation: u64, request: &SimulationRequest) -> Snapshot {
        let time = self.history.end().min(self.runner.time());
        let end = request.scrub.unwrap_or(time).clamp(self.history.t0, time);
        let still = self.is_still(request);
        let shown = Shown {
            time,
            scrub: request.scrub,
            duration: request.duration,
            still,
            model: Arc::clone(&self.model),
        };
        self.changed = self.shown.as_ref() != Some(&shown);
        self.shown = Some(shown);
        let samples = ((request.duration / self.history.dt) as usize).clamp(2, MAX_VIEW_SAMPLES);
        let last = ((end - self.history.t0) / self.history.dt).round() as usize + 1;
        let view = self
            .history
            .piece(last.saturating_sub(samples), last.min(self.history.len()));
        let mut snapshot = Snapshot::new(
            generation,
            &self.model,
            Arc::new(view),
            Vec::new(),
            Duration::ZERO,
        );
        snapshot.live = Some(LiveState {
            time,
            history_start: self.history.t0,
            speed: self.speed,
            paused: still,
        });
        snapshot
    }
}
