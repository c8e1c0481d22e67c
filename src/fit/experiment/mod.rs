//! A recording as an experiment of its own: simulated as a whole under its own drive from its own
//! start, and compared with its readings.
//!
//! What belongs to the instrument and not to the device is estimated with every comparison, within
//! stated priors: the zero of each reading, the clock of the readings against that of the voltage,
//! and, where asked for, their scales. All of it follows from one run: a shift in time moves the
//! readings along the simulated motion, whose velocity is known.

mod instrument;
#[cfg(test)]
mod tests;

use std::sync::Arc;

pub use self::instrument::{InstrumentPriors, estimate_instrument};

use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::align::Alignment;
use crate::recording::noise::recording_noise;
use crate::recording::{Channel, Recording};
use crate::sim::{Options, SimError, Trace, TraceCursor, simulate_while};

/// Lowest sampling rate of a run \[Hz\]: what lies between samples is interpolated.
const MIN_RATE: f64 = 50e3;
/// Most samples of a run.
const MAX_RUN_SAMPLES: f64 = 4e6;

/// A recording and what drove it.
#[derive(Debug, Clone)]
pub struct Experiment {
    /// The measurement.
    pub recording: Arc<Recording>,
    /// The drive; its t = 0 is the recording's first time.
    pub drive: Waveform,
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
    /// Simulation minus recording of the proof mass \[m\] at each sample of the recording; NaN
    /// where either says nothing.
    pub residual_p: Vec<f64>,
    /// The same of the cantilever; empty if it was not recorded.
    pub residual_c: Vec<f64>,
    /// Root mean square of `residual_p` \[m\].
    pub rms: f64,
    /// Samples compared.
    pub count: usize,
}

impl ExperimentResult {
    /// `rms` in units of the noise of the proof mass.
    #[must_use]
    pub fn misfit(&self, experiment: &Experiment) -> f64 {
        self.rms / (experiment.noise.0 * self.alignment.xp_scale.abs())
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
        let sigma = |channel| recording_noise(&recording, channel).ok().map(|n| n.sigma);
        let noise = (
            sigma(Channel::ProofMass).unwrap_or(0.0),
            sigma(Channel::Cantilever),
        );
        Self {
            recording,
            drive,
            alignment,
            priors: Some(InstrumentPriors::default()),
            noise,
        }
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
    /// [`SimError`] if the device cannot be simulated.
    pub fn run(
        &self,
        model: &Model,
        go_on: impl Fn() -> bool,
    ) -> Result<Option<ExperimentResult>, SimError> {
        let (first, _) = self.recording.span();
        let options = Options {
            rate: self.rate(),
            ..Options::default()
        };
        let duration = self.recording.duration() + 1.0 / options.rate;
        let Some(mut trace) = simulate_while(model, &self.drive, duration, &options, go_on)? else {
            return Ok(None);
        };
        trace.shift(first);
        Ok(Some(self.compare(Arc::new(trace))))
    }

    /// Compares a run of this experiment with its recording.
    #[must_use]
    pub fn compare(&self, trace: Arc<Trace>) -> ExperimentResult {
        let alignment = match &self.priors {
            Some(priors) => estimate_instrument(self, &trace, priors),
            None => self.alignment,
        };
        let recording = &self.recording;
        let mut cursor = TraceCursor::new(&trace);
        let mut residual_p = Vec::with_capacity(recording.len());
        let mut residual_c = Vec::new();
        for (i, &t) in recording.time.iter().enumerate() {
            let reading = cursor.at(alignment.time(t));
            let at = |x: fn(&crate::sim::Reading) -> f64| reading.as_ref().map_or(f64::NAN, x);
            let measured = alignment.value(Channel::ProofMass, recording.proof_mass[i]);
            residual_p.push(at(|r| r.xp) - measured);
            if let Some(values) = &recording.cantilever {
                residual_c.push(at(|r| r.xc) - alignment.value(Channel::Cantilever, values[i]));
            }
        }
        let (rms, count) = root_mean_square(&residual_p);
        ExperimentResult {
            trace,
            alignment,
            residual_p,
            residual_c,
            rms,
            count,
        }
    }
}

/// Root mean square of the finite values, and their number.
fn root_mean_square(values: &[f64]) -> (f64, usize) {
    let finite = || values.iter().filter(|v| v.is_finite());
    let count = finite().count();
    let squares: f64 = finite().map(|v| v * v).sum();
    ((squares / count.max(1) as f64).sqrt(), count)
}
