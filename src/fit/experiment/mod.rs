//! A recording as an experiment of its own: simulated as a whole under its own drive from its own
//! start, and compared with its readings.
//!
//! What belongs to the instrument and not to the device is estimated with every comparison, within
//! stated priors: the zero of each reading, the clock of the readings against that of the voltage,
//! and, where asked for, their scales. All of it follows from one run: a shift in time moves the
//! readings along the simulated motion, whose velocity is known.
//!
//! How the recording begins and what its voltage leaves open takes further runs: see [`decide()`].

mod decide;
mod drive_freedom;
mod improve;
mod instrument;
mod sensitivity;
mod start_state;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use thiserror::Error;

pub use self::decide::{Decision, Questions, decide, whole_run};
pub use self::drive_freedom::improve_drive;
pub use self::improve::Improved;
pub use self::instrument::{InstrumentPriors, estimate_instrument};
pub use self::sensitivity::{Influence, Probe, Sensitivity, Suggestion, sensitivity};
pub use self::start_state::{FoundStart, estimate_start, improve_start};

use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::align::Alignment;
use crate::recording::compare::{CompareError, Comparison, compare};
use crate::recording::{Channel, Recording};
use crate::sim::{Options, SimError, StartState, Trace, simulate_from, simulate_while};

/// Lowest sampling rate of a run \[Hz\]: what lies between samples is interpolated.
const MIN_RATE: f64 = 50e3;
/// Most samples of a run.
const MAX_RUN_SAMPLES: f64 = 4e6;

/// Why there is no comparison.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExperimentError {
    /// The device cannot be simulated under this drive.
    #[error(transparent)]
    Simulation(#[from] SimError),
    /// Run and recording have nothing in common.
    #[error(transparent)]
    Compare(#[from] CompareError),
}

/// A recording and what drove it.
#[derive(Debug, Clone)]
pub struct Experiment {
    /// The measurement.
    pub recording: Arc<Recording>,
    /// The drive; its t = 0 is the recording's first time.
    pub drive: Waveform,
    /// The state in which it begins; `None` for rest.
    pub start: Option<StartState>,
    /// Shift, scales and zeros set by hand; what is estimated comes on top of them.
    pub alignment: Alignment,
    /// What is estimated; `None` for nothing.
    pub priors: Option<InstrumentPriors>,
    /// Noise of the readings \[m\], `(xp, xc)`.
    pub noise: (f64, Option<f64>),
}

/// A run compared with its recording.
#[derive(Debug, Clone)]
pub struct ExperimentResult {
    /// The run, by the recording's clock: its first sample is at the recording's first time.
    pub trace: Arc<Trace>,
    /// Shift, scales and zeros used, those estimated included.
    pub alignment: Alignment,
    /// Simulation minus recording of the proof mass.
    pub proof_mass: Comparison,
    /// The same of the cantilever, if it was recorded.
    pub cantilever: Option<Comparison>,
}

impl ExperimentResult {
    /// Residual of the proof mass in units of its noise; `None` if it has none.
    #[must_use]
    pub fn misfit(&self, experiment: &Experiment) -> Option<f64> {
        let (noise, _) = experiment.aligned_noise(&self.alignment);
        (noise > 0.0).then(|| self.proof_mass.rms / noise)
    }

    /// Sum of squares of all residuals in units of their noise.
    #[must_use]
    pub fn sum_of_squares(&self, experiment: &Experiment) -> f64 {
        let (xp, xc) = experiment.aligned_noise(&self.alignment);
        let unit = |sigma: f64| if sigma > 0.0 { sigma } else { 1.0 };
        let readings = |c: &Comparison, sigma: f64| c.count as f64 * (c.rms / unit(sigma)).powi(2);
        let cantilever = self.cantilever.as_ref().zip(xc);
        readings(&self.proof_mass, xp) + cantilever.map_or(0.0, |(c, sigma)| readings(c, sigma))
    }
}

/// Total of several misfits, each with its number of samples: the root of the mean square.
#[must_use]
pub fn total_misfit(parts: &[(f64, usize)]) -> Option<f64> {
    let count: usize = parts.iter().map(|p| p.1).sum();
    let squares: f64 = parts.iter().map(|(m, n)| m * m * *n as f64).sum();
    (count > 0).then(|| (squares / count as f64).sqrt())
}

impl Experiment {
    /// Of a recording under `drive`, its noise estimated.
    #[must_use]
    pub fn new(recording: Arc<Recording>, drive: Waveform, alignment: Alignment) -> Self {
        let sigma = |channel| recording.noise(channel).map(|n| n.sigma);
        let noise = (
            sigma(Channel::ProofMass).unwrap_or(0.0),
            sigma(Channel::Cantilever),
        );
        Self {
            recording,
            drive,
            start: None,
            alignment,
            priors: Some(InstrumentPriors::default()),
            noise,
        }
    }

    /// Noise of the readings as they are compared, scaled \[m\], `(xp, xc)`.
    #[must_use]
    pub fn aligned_noise(&self, alignment: &Alignment) -> (f64, Option<f64>) {
        let (xp, xc) = self.noise;
        (
            xp * alignment.xp_scale.abs(),
            xc.map(|sigma| sigma * alignment.xc_scale.abs()),
        )
    }

    /// Samples per second of the run: a whole multiple of the recording's, so that no reading
    /// between samples is needed where the clocks agree.
    #[must_use]
    pub fn rate(&self) -> f64 {
        let own = self.recording.sampling_rate();
        let multiple = (MIN_RATE / own).ceil().max(1.0);
        (own * multiple).min(MAX_RUN_SAMPLES / self.recording.duration())
    }

    /// Simulates the experiment and compares; `None` if `go_on` said no.
    ///
    /// # Errors
    /// [`ExperimentError`] if the device cannot be simulated or there is nothing to compare.
    pub fn run(
        &self,
        model: &Model,
        go_on: impl Fn() -> bool,
    ) -> Result<Option<ExperimentResult>, ExperimentError> {
        let (first, _) = self.recording.span();
        let options = Options {
            rate: self.rate(),
            ..Options::default()
        };
        let duration = self.recording.duration() + 1.0 / options.rate;
        let drive = &self.drive;
        let run = match &self.start {
            Some(start) => simulate_from(model, drive, start, duration, &options, go_on)?,
            None => simulate_while(model, drive, duration, &options, go_on)?,
        };
        let Some(mut trace) = run else {
            return Ok(None);
        };
        trace.shift(first);
        Ok(Some(self.compare(Arc::new(trace))?))
    }

    /// Compares a run of this experiment with its recording.
    ///
    /// # Errors
    /// [`ExperimentError::Compare`] if they have nothing in common.
    pub fn compare(&self, trace: Arc<Trace>) -> Result<ExperimentResult, ExperimentError> {
        let alignment = match &self.priors {
            Some(priors) => estimate_instrument(self, &trace, priors),
            None => self.alignment,
        };
        let recording = &self.recording;
        let proof_mass = compare(recording, Channel::ProofMass, &alignment, &trace)?;
        let cantilever = compare(recording, Channel::Cantilever, &alignment, &trace).ok();
        Ok(ExperimentResult {
            trace,
            alignment,
            proof_mass,
            cantilever,
        })
    }
}
