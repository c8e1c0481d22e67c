//! The state in which a recording begins, where it does not begin at rest.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nalgebra::{DMatrix, DVector};

use super::improve::{Improved, OpenNumber, Search};
use super::{Experiment, ExperimentError};
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::prepare;
use crate::fit::segment::state_units;
use crate::fit::solve::estimate_states::estimate_states;
use crate::fit::solve::levenberg_marquardt::{Clock, Control};
use crate::fit::thresholds::{MAX_CUBIC_CHI2, START_DISTANCE_SHARE, START_VELOCITY_SIGMAS};
use crate::fit::uncertainty::fit_result::misfits;
use crate::model::Model;
use crate::recording::Recording;
use crate::recording::align::set_up::set_up;
use crate::recording::experiment_setup::{DriveSource, InstrumentUnknowns};
use crate::recording::extremes;
use crate::sim::{StartState, StretchSimulator, StretchState};

/// Length of the first stretch in periods of the slowest mode.
const FIRST_STRETCH_PERIODS: f64 = 2.5;
/// The same for a mass without a spring, as a share of the recording.
const FREE_STRETCH_SHARE: f64 = 0.1;
/// Fewest samples of it.
const MIN_FIRST_SAMPLES: usize = 32;
/// Fewest samples that a cubic is laid through.
const MIN_CUBIC_SAMPLES: usize = 8;
/// Shortest time on the ground before the recording that is tried besides none \[s\], and the ratio of
/// each to the one before, up to the longest \[s\]. The ring after the release tells neighbours apart, so
/// that a wider grid would miss the right one.
const SHORTEST_STAY_SECONDS: f64 = 0.2e-3;
/// See [`SHORTEST_STAY_SECONDS`].
const STAY_RATIO: f64 = 1.3;
/// See [`SHORTEST_STAY_SECONDS`].
const LONGEST_STAY_SECONDS: f64 = 0.4;
/// Step of a number of the start for differences, in units of the noise.
const START_STEP_NOISES: f64 = 0.5;

/// A start that the first readings suggest.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundStart {
    /// The state.
    pub start: StartState,
    /// Whether the readings alone say that the recording does not begin as the model does, whatever
    /// its parameters: they move at once, or lie far from there.
    pub is_certain: bool,
    /// What the model leaves of the first stretch from there \[its noise\].
    pub remaining: f64,
}

/// The state in which the experiment's recording begins, from its first stretch; `None` if that is not
/// read.
///
/// # Errors
/// [`FitError`] if the recording cannot be used with `model`.
pub fn estimate_start(
    experiment: &Experiment,
    model: &Model,
) -> Result<Option<FoundStart>, FitError> {
    let (first, _) = experiment.recording.span();
    let alignment = &experiment.alignment;
    let drive = DriveSource::Waveform {
        waveform: experiment.drive.clone(),
        start: first,
    };
    let unknown = experiment.priors.map(|priors| InstrumentUnknowns {
        zeros: priors.zeros,
        scale: priors.scale,
        clock: priors.clock,
        lag: -alignment.time_shift,
    });
    let usable = experiment.recording.usable();
    let recording = Arc::new(set_up(&usable, alignment, drive, unknown));
    let options = FitOptions::for_model(model);
    let simulator = StretchSimulator::new(model, &crate::sim::Options::default())?;
    let slowest = simulator
        .flight_omega2()
        .fold(f64::INFINITY, f64::min)
        .sqrt();
    let period = std::f64::consts::TAU / slowest;
    let stretch = if period.is_finite() {
        FIRST_STRETCH_PERIODS * period
    } else {
        FREE_STRETCH_SHARE * recording.duration()
    };
    let end = recording.time.partition_point(|t| t - first < stretch);
    let end = end.max(MIN_FIRST_SAMPLES).min(recording.len());
    let whole = [Part {
        recording: Arc::clone(&recording),
        samples: 0..recording.len(),
    }];
    let summaries = summarize(model, &whole);
    let part = [Part {
        recording: Arc::clone(&recording),
        samples: 0..end,
    }];
    let space = Space::new(model, &options.free)?;
    let prepared = prepare(model, &space, &part, &summaries, &options)?;
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    let point = estimate_states(&prepared, model, &options, &control, &mut Clock::new(0))?;
    let Some(segment) = point.segments.first().filter(|s| s.samples.start == 0) else {
        return Ok(None);
    };
    let value = |i: usize| segment.value(&segment.locals, i);
    let (misfit, _) = misfits(&prepared, &point)?;
    let remaining = misfit.rms / misfit.noise;
    if segment.starts_held {
        let n = simulator.held_structure().omega2.len();
        let since = segment.since.map_or(0.0, |t| (t - first).min(0.0));
        let state = StretchState {
            q: (0..n).map(value).collect(),
            v: (n..2 * n).map(value).collect(),
            z: Vec::new(),
        };
        return Ok(Some(FoundStart {
            start: StartState {
                state,
                held_since: Some(since),
            },
            is_certain: true,
            remaining,
        }));
    }
    let n = simulator.modes();
    let state = StretchState {
        q: (0..n).map(value).collect(),
        v: (n..2 * n).map(value).collect(),
        z: Vec::new(),
    };
    let far = distance_from_usual(&simulator, model, &state, stretch)?;
    let (low, high) = extremes(&recording.proof_mass[..end]);
    let sigmas = (summaries[0].noise.0, summaries[0].noise.1);
    Ok(Some(FoundStart {
        start: StartState {
            state,
            held_since: None,
        },
        is_certain: far > START_DISTANCE_SHARE * (high - low)
            || moves_at_once(&recording, end / 2, sigmas),
        remaining,
    }))
}

/// How far the proof mass can come from the model's own beginning when it begins in `state` \[m\]; a
/// mode without a spring moves for `stretch` seconds.
fn distance_from_usual(
    simulator: &StretchSimulator,
    model: &Model,
    state: &StretchState,
    stretch: f64,
) -> Result<f64, FitError> {
    let (phi_p, _) = simulator.flight_shapes();
    let usual = StartState::of_model(model)?.state;
    Ok(simulator
        .flight_omega2()
        .enumerate()
        .map(|(k, omega2)| {
            let (q, v) = (state.q[k] - usual.q[k], state.v[k] - usual.v[k]);
            let seconds = if omega2 > 0.0 {
                omega2.powf(-0.5)
            } else {
                stretch
            };
            (phi_p[k] * q.hypot(v * seconds)).abs()
        })
        .sum())
}

/// Whether the first readings have a velocity, whatever the device: noise is `(xp, xc)` \[m\], and no
/// more than `most` samples are looked at.
fn moves_at_once(recording: &Recording, most: usize, noise: (f64, Option<f64>)) -> bool {
    let cantilever = recording.cantilever.as_deref().zip(noise.1);
    let moves = |values: &[f64], sigma: f64| {
        first_velocity(&recording.time, values, most, sigma)
            .is_some_and(|(v, error)| v.abs() > START_VELOCITY_SIGMAS * error)
    };
    moves(&recording.proof_mass, noise.0)
        || cantilever.is_some_and(|(values, sigma)| moves(values, sigma))
}

/// Velocity at the first reading \[m/s\] with its standard error: a cubic through as many samples as
/// are one, up to `most`. `None` if not even the fewest are.
fn first_velocity(time: &[f64], values: &[f64], most: usize, sigma: f64) -> Option<(f64, f64)> {
    let mut found = None;
    let mut count = MIN_CUBIC_SAMPLES;
    while count <= most {
        let unit = time[count - 1] - time[0];
        let used: Vec<usize> = (0..count).filter(|&i| values[i].is_finite()).collect();
        if used.len() >= MIN_CUBIC_SAMPLES {
            let matrix = DMatrix::from_fn(used.len(), 4, |row, k| {
                ((time[used[row]] - time[0]) / unit).powi(k as i32)
            });
            let right = DVector::from_fn(used.len(), |row, _| values[used[row]]);
            let Some(inverse) = (matrix.transpose() * &matrix).try_inverse() else {
                break;
            };
            let solution = &inverse * matrix.transpose() * &right;
            let left = (right - matrix * &solution).norm_squared();
            if left > MAX_CUBIC_CHI2 * (used.len() - 4) as f64 * sigma * sigma {
                break;
            }
            found = Some((solution[1] / unit, sigma * inverse[(1, 1)].sqrt() / unit));
        }
        count += count / 2;
    }
    found
}

/// Improves the start of an experiment that does not begin at rest, by all its readings. `None` if
/// `go_on` said no.
///
/// # Errors
/// [`ExperimentError`] if the device cannot be simulated.
pub fn improve_start(
    experiment: &Experiment,
    start: &StartState,
    model: &Model,
    go_on: &(impl Fn() -> bool + Sync),
) -> Result<Option<Improved>, ExperimentError> {
    let simulator = StretchSimulator::new(model, &crate::sim::Options::default())?;
    let held = start.held_since.is_some();
    let span = experiment.recording.duration();
    let units = state_units(&simulator, held, experiment.noise.0, span);
    let n = start.state.q.len();
    let mut numbers: Vec<OpenNumber> = units
        .iter()
        .map(|unit| OpenNumber {
            step: START_STEP_NOISES * unit,
            sigma: f64::INFINITY,
            most: f64::INFINITY,
            acts_from: f64::NEG_INFINITY,
        })
        .collect();
    let mut values = vec![0.0; numbers.len()];
    let at = |values: &[f64]| {
        let mut start = start.clone();
        for k in 0..n {
            start.state.q[k] += values[k];
            start.state.v[k] += values[n + k];
        }
        start.held_since = values.get(2 * n).map(|stay| -stay.max(0.0));
        Experiment {
            start: Some(start),
            ..experiment.clone()
        }
    };
    if let Some(since) = start.held_since {
        // Adhesion grows with the stay: how long it has lasted decides when it ends.
        let mut best: Option<(f64, f64)> = None;
        let stays = std::iter::successors(Some(SHORTEST_STAY_SECONDS), |s| Some(STAY_RATIO * s));
        let stays = stays.take_while(|s| *s < LONGEST_STAY_SECONDS);
        for stay in stays.chain([0.0, -since]) {
            let tried: Vec<f64> = values.iter().copied().chain([stay]).collect();
            let Some(result) = at(&tried).run(model, go_on)? else {
                return Ok(None);
            };
            if best.is_none_or(|(rms, _)| result.proof_mass.rms < rms) {
                best = Some((result.proof_mass.rms, stay));
            }
        }
        values.push(best.map_or(0.0, |(_, stay)| stay));
        numbers.push(OpenNumber {
            step: experiment.recording.interval(),
            sigma: f64::INFINITY,
            most: f64::INFINITY,
            acts_from: f64::NEG_INFINITY,
        });
    }
    let search = Search {
        at,
        numbers,
        model,
        go_on,
    };
    match search.run(values)? {
        Some(begun) => search.descend(begun),
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::super::start_state::*;

    #[test]
    fn the_first_velocity_is_that_of_the_motion() {
        let time: Vec<f64> = (0..200).map(|i| 2e-5 * f64::from(i)).collect();
        let omega = 3900.0;
        let from = |phase: f64| -> Vec<f64> {
            let value = |t: &f64| 80e-6 * (omega * t + phase).sin();
            time.iter().map(value).collect()
        };
        for phase in [0.0, 0.7, 1.4] {
            let (v, error) = first_velocity(&time, &from(phase), 100, 20e-9).unwrap();
            let true_velocity = 80e-6 * omega * f64::cos(phase);
            assert!(
                (v - true_velocity).abs() < 5.0 * error,
                "{phase}: {v} {true_velocity}"
            );
            assert!(error < 0.02 * 80e-6 * omega);
        }
    }
}
