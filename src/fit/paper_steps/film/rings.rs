//! The rings after break-offs: which can be fitted to, and each simulated at a point of the fit.

use crate::fit::contact_readings::inspect;
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::options::{FitOptions, Part};
use crate::fit::paper_steps::StepError;
use crate::fit::paper_steps::break_off::{break_offs, ring_problem};
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::Prepared;
use crate::fit::residual::residual_rows::Encounter;
use crate::fit::residual::simulate_segment::simulate_segment;
use crate::fit::solve::point::Point;
use crate::fit::thresholds::MIN_STAY_TIME;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::{SimError, Stretcher};

/// Free parameters, in the order of the coordinates of the fits.
const FREE_PARAMETERS: [&str; 2] = ["Cs", "gp"];

/// The prepared problem of the step.
pub(crate) struct Rings {
    /// The model with a film that has a thickness.
    pub(super) sound: Model,
    /// What the fit may do.
    pub(super) options: FitOptions,
    /// One segment for each ring.
    pub(super) prepared: Prepared,
}

impl Rings {
    /// Names of the recordings that show one.
    pub(crate) fn recordings(&self) -> Vec<String> {
        let problem = &self.prepared.problem;
        let segments = self.prepared.segments.iter();
        let mut names: Vec<String> = segments
            .map(|s| problem.data[s.recording].recording.name.clone())
            .collect();
        names.dedup();
        names
    }
}

/// The rings that can be fitted to.
///
/// # Errors
/// Those of the step, except for what only the fit can show.
pub(crate) fn rings_of(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
) -> Result<Rings, StepError> {
    let own = own_options(options);
    rings_in(model, parts, options, || inspect(model, parts, &own))
}

/// The options, for the parameters of the step.
fn own_options(options: &FitOptions) -> FitOptions {
    FitOptions {
        free: FREE_PARAMETERS.map(str::to_owned).to_vec(),
        ..options.clone()
    }
}

/// [`rings_of`] parts that `inspected` summarizes, and refuses if they are not readable.
///
/// # Errors
/// As [`rings_of`].
pub(crate) fn rings_in(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    inspected: impl FnOnce() -> (Vec<RecordingSummary>, Result<(), FitError>),
) -> Result<Rings, StepError> {
    check(model)?;
    let mut sound = model.clone();
    let dp = sound.parameters[ParameterId::Dp];
    if sound.parameters[ParameterId::Gp] <= dp {
        // The film's thickness is searched from its own starts, so a bad one does not matter.
        sound.parameters.set(ParameterId::Gp, 1.2 * dp);
    }
    sound.check().map_err(FitError::from)?;
    let options = own_options(options);
    let (summaries, readable) = inspected();
    readable?;
    let none = || {
        let names: Vec<&str> = parts.iter().map(|p| p.recording.name.as_str()).collect();
        StepError::Unsuited {
            recording: names.join(", "),
            reason: format!(
                "no break-off found: no stay on the ground of {:.1} ms or more is followed by half a period of free ringing",
                1e3 * MIN_STAY_TIME
            ),
            remedy: "record a 5 Hz ramped square of 8 V, with touch, break-off and the ring after it",
        }
    };
    let found = break_offs(&sound, parts, &summaries);
    if found.is_empty() {
        return Err(none());
    }
    let space = Space::new(&sound, &options.free)?;
    let prepared = ring_problem(&sound, &space, &found, &summaries, &options)?;
    if prepared.segments.is_empty() {
        return Err(none());
    }
    Ok(Rings {
        sound,
        options,
        prepared,
    })
}

/// Times after the release, the reading without the instrument's offset and scale, and the simulation.
pub(super) type Ring = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Each segment at a point; `None` where it cannot be simulated.
pub(super) fn simulated_rings(
    prepared: &Prepared,
    point: &Point,
) -> Result<Vec<Option<Ring>>, SimError> {
    let problem = &prepared.problem;
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let mut stretcher = Stretcher::new(&simulator);
    let each = point.segments.iter().zip(&states);
    let ring = each.map(|(segment, states)| {
        let context = problem.context(segment, states);
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let locals = &segment.locals;
        let done = simulate_segment(segment, &context, &mut stretcher, &nuisances, locals).ok()?;
        let release = done.encounters.iter().find_map(|e| match e {
            Encounter::PullOff(Some(pull)) => Some(pull.time - nuisances.skew),
            _ => None,
        })?;
        let recording = context.recording;
        let samples = segment.samples.clone();
        let time = recording.time[samples.clone()].iter();
        let read = recording.proof_mass[samples].iter();
        Some((
            time.map(|t| t - release).collect(),
            read.map(|x| (x - nuisances.offset_p) / nuisances.scale_p)
                .collect(),
            done.xp,
        ))
    });
    Ok(ring.collect())
}

/// Whether a model has what the step is about.
///
/// # Errors
/// [`StepError::Device`] if it has no ground.
fn check(model: &Model) -> Result<(), StepError> {
    if model.has_ground {
        return Ok(());
    }
    Err(StepError::Device {
        device: model.name.clone(),
        what: "ground",
        step: "the film",
    })
}
