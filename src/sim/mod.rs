//! The hybrid simulator: flight, events, contact.
//!
//! [`simulate`] is a pure function of model, drive and options. [`Runner`] does the
//! same piece by piece, for a device that runs live while its parameters change.

mod crossing;
mod device;
pub(crate) mod error;
mod linear;
mod nodes;
mod output;
pub(crate) mod runner;
mod step;
pub(crate) mod stretch;
pub(crate) mod trace;
mod trace_cursor;

pub use self::error::{Options, SimError};
pub use self::runner::Runner;
pub use self::runner::notes::{Arrival, Integrals, Notes, Turn};
pub use self::runner::strobe::{MotionPhase, MotionState};
pub use self::stretch::prescribed_motion::ActingForces;
pub use self::stretch::propagate::{StepSequence, Stretcher};
pub use self::stretch::{Points, StretchSimulator, StretchState};
pub use self::trace::{Event, EventKind, ForceTraces, Trace};
pub use self::trace_cursor::{Reading, TraceCursor};

use crate::model::Model;
use crate::model::drive::Waveform;

/// Most extra states that the effects can have together.
const MAX_STATES: usize = 32;

/// Device time between two reports of progress, at which a run can be cancelled \[s\].
const PROGRESS_INTERVAL: f64 = 0.01;

/// Most samples of one run: 10 GB of trace.
const MAX_SAMPLES: f64 = 2e8;

/// Simulates from rest at `t = 0` to `duration` \[s\], first sample at 0.
///
/// # Errors
/// [`SimError`], naming the parameter at fault and the time.
///
/// # Examples
/// ```
/// use impactscope::model::{drive::Waveform, preset::Preset};
/// use impactscope::sim::{Options, simulate};
///
/// let model = Preset::default().model;
/// let drive = Waveform::parse("square:50Hz:7V", 0.02)?;
/// let trace = simulate(&model, &drive, 0.02, &Options::default())?;
/// assert_eq!(trace.len(), 1001); // 50 kHz, first and last sample included
/// assert!(trace.proof_mass.iter().all(|x| x.is_finite()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn simulate(
    model: &Model,
    drive: &Waveform,
    duration: f64,
    options: &Options,
) -> Result<Trace, SimError> {
    simulate_while(model, drive, duration, options, || true).map(Option::unwrap_or_default)
}

/// The state in which a run begins, where that is not rest.
#[derive(Debug, Clone, PartialEq)]
pub struct StartState {
    /// Coordinates and velocities: those in flight, or on the ground. Effects begin settled.
    pub state: StretchState,
    /// Since when the mass is on the ground \[s\], at most 0; `None` in flight.
    pub held_since: Option<f64>,
}

impl StartState {
    /// That of the parameters `x0` and `v0`.
    ///
    /// # Errors
    /// [`SimError`] if the model is invalid.
    pub fn of_model(model: &Model) -> Result<Self, SimError> {
        let (q, v) = runner::initial_state(&device::Device::new(model)?);
        let z = Vec::new();
        Ok(Self {
            state: StretchState { q, v, z },
            held_since: None,
        })
    }
}

/// [`simulate`] that can be cancelled: `go_on` is asked every 10 ms of device time, and `None` is
/// returned once it is false. The window uses it when parameters change during a run.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_while(
    model: &Model,
    drive: &Waveform,
    duration: f64,
    options: &Options,
    go_on: impl FnMut() -> bool,
) -> Result<Option<Trace>, SimError> {
    let runner = Runner::new(model, drive, options)?;
    sample_run(runner, duration, options, go_on)
}

/// [`simulate_while`] from a given state at t = 0.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_from(
    model: &Model,
    drive: &Waveform,
    start: &StartState,
    duration: f64,
    options: &Options,
    go_on: impl FnMut() -> bool,
) -> Result<Option<Trace>, SimError> {
    let since = start.held_since;
    let runner = Runner::from_state(model, drive, options, 0.0, &start.state, since)?;
    sample_run(runner, duration, options, go_on)
}

/// The samples of a run from t = 0 to `duration` \[s\]; `None` if `go_on` said no.
fn sample_run(
    mut runner: Runner,
    duration: f64,
    options: &Options,
    mut go_on: impl FnMut() -> bool,
) -> Result<Option<Trace>, SimError> {
    // Rounding must not cost the last sample of a whole number of intervals.
    let intervals = duration * options.rate * (1.0 + 1e-12);
    if !(duration > 0.0 && intervals < MAX_SAMPLES) {
        return Err(SimError::Options {
            what: "duration",
            reason: format!(
                "{duration} s at {} samples per second cannot be held; give a span above 0 with fewer than {MAX_SAMPLES:e} samples",
                options.rate
            ),
        });
    }
    runner.check_span(duration)?;
    let samples = intervals as usize + 1;
    let mut trace = runner.new_trace();
    trace.reserve(samples);
    runner.limit_samples(samples);
    let end = duration.max((samples - 1) as f64 / options.rate);
    // Whole steps are taken: the pieces give the same trace as one run.
    while runner.time() < end {
        runner.advance(end.min(runner.time() + PROGRESS_INTERVAL), &mut trace)?;
        if !go_on() {
            return Ok(None);
        }
    }
    runner.advance(end, &mut trace)?;
    trace.truncate(samples, duration);
    Ok(Some(trace))
}
