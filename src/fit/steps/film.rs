//! Step 4, film (fig. 9): the decay of the ring after break-off, with the gas film and
//! without, and `Cs` and `gp` by which the two agree with the data.

use std::sync::Arc;

use super::StepError;
use crate::fit::readings::Readings;
use crate::fit::{Control, FitError, FitOptions, FitResult, Misfit, Part, fit, judge};
use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::ParameterId;
use crate::recording::Recording;
use crate::sim::{Options, StretchSimulator, Stretcher};

/// Part of the ring after a release that the figure shows [s].
const SHOWN: f64 = 8e-3;
/// What `Cs` is where there is no film [N m^2 s]: its force is far below any noise.
const NO_FILM: f64 = 1e-30;

/// One curve of the figure, after one release.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Decay {
    /// Times after the release [s].
    pub time: Vec<f64>,
    /// The recording [m].
    pub measured: Vec<f64>,
    /// Simulated with the film [m].
    pub with_film: Vec<f64>,
    /// And without [m].
    pub without_film: Vec<f64>,
}

/// The film.
#[derive(Debug, Clone)]
pub struct Film {
    /// The fit of `Cs` and `gp`.
    pub fit: FitResult,
    /// What is left of the same recordings with the film, and without.
    pub with_film: Misfit,
    /// See [`Self::with_film`].
    pub without_film: Misfit,
    /// Film coefficient at the contact gap, `Cs / (gp - dp)^3` [N s/m].
    pub at_contact: f64,
    /// The ring after one release, if one was read.
    pub decay: Option<Decay>,
}

/// Fits `Cs` and `gp` with the rest of the device as in `model`, and leaves the film out
/// for comparison.
///
/// # Errors
/// [`FitError`] if the recordings do not allow it.
pub fn film(
    model: &Model,
    parts: &[Part],
    readings: &Readings,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Film, FitError> {
    let options = FitOptions {
        free: vec!["Cs".to_owned(), "gp".to_owned()],
        ..options.clone()
    };
    let fit = fit(model, parts, &[], &options, control)?;
    let mut without = fit.model.clone();
    without.parameters.set(ParameterId::Cs, NO_FILM);
    let (without_film, _) = judge(&without, parts, &options, control)?;
    let p = &fit.model.parameters;
    let gap = p[ParameterId::Gp] - p[ParameterId::Dp];
    let decay = readings
        .releases
        .iter()
        .max_by(|a, b| a.force.total_cmp(&b.force))
        .and_then(|release| {
            let recording = &parts.get(release.recording)?.recording;
            decay(&fit.model, &without, recording, release.time)
        });
    Ok(Film {
        at_contact: p[ParameterId::Cs] / gap.powi(3),
        with_film: fit.train.0.clone(),
        without_film,
        decay,
        fit,
    })
}

/// Both simulations of the ring after the release at `start`, from the static state of
/// the held mass; the recording's zero taken from the ground before.
fn decay(with: &Model, without: &Model, recording: &Recording, start: f64) -> Option<Decay> {
    let (times, volts) = recording.drive_table()?;
    let table = VoltageTable::from_recording(&recording.name, times, volts).ok()?;
    let drive = Waveform::Table(Arc::new(table));
    let first = recording.time.partition_point(|&t| t < start);
    let last = recording.time.partition_point(|&t| t < start + SHOWN);
    let samples = first..last;
    let time: Vec<f64> = recording.time[samples.clone()].to_vec();
    let pieces: Vec<_> = (drive.index_at(start)..=drive.index_at(*time.last()?))
        .map(|i| drive.segment(i))
        .collect();
    let level = -with.parameters[ParameterId::Dp];
    let ring = |model: &Model| -> Option<Vec<f64>> {
        let simulator = StretchSimulator::new(model, &Options::default()).ok()?;
        let mut state = simulator.rest_state(&pieces, start, Some(level));
        simulator.lift(level, &mut state);
        let mut out = vec![f64::NAN; time.len()];
        let mut stretcher = Stretcher::new(&simulator);
        let end = *time.last()?;
        let note = |i: usize, xp: f64, _: f64| out[i] = xp;
        stretcher
            .carry(&pieces, None, start, end, &mut state, &time, note)
            .ok()?;
        Some(out)
    };
    let ground: Vec<f64> = recording.proof_mass[first.saturating_sub(10)..first]
        .iter()
        .copied()
        .filter(|x| x.is_finite())
        .collect();
    let zero = ground.iter().sum::<f64>() / ground.len().max(1) as f64 - level;
    Some(Decay {
        measured: recording.proof_mass[samples]
            .iter()
            .map(|x| x - zero)
            .collect(),
        with_film: ring(with)?,
        without_film: ring(without)?,
        time: time.iter().map(|t| t - start).collect(),
    })
}

/// Whether a model has what the step is about.
///
/// # Errors
/// [`StepError::Device`] if it has no ground.
pub fn check(model: &Model) -> Result<(), StepError> {
    if model.has_ground {
        return Ok(());
    }
    Err(StepError::Device {
        device: model.name.clone(),
        what: "ground",
        step: "the film",
    })
}
