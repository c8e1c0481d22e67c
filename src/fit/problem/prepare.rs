//! From recordings and their summaries to a least-squares problem with its segments.

use std::sync::Arc;

use super::parameter_space::Space;
use super::{Data, FreeNuisance, Nuisance, Problem};
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::options::{FitOptions, Part};
use crate::fit::residual::coloured_noise::Colour;
use crate::fit::residual::residual_rows::Sigmas;
use crate::fit::segment::Segment;
use crate::fit::segment::cut::{Cut, cut};
use crate::fit::segment::event_sequence::Timeline;
use crate::fit::segment::voltage_track::Track;
use crate::fit::thresholds::GROUND_LAW_NOISE_SHARE;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::preset::known_value::KnownValue;
use crate::recording::Recording;
use crate::sim::{Options, SimError, StretchSimulator};

/// A problem with its segments.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// The problem.
    pub problem: Problem,
    /// Its segments, unknowns at their first guess.
    pub segments: Vec<Segment>,
    /// Nuisances at their first guess, one for each free one.
    pub nuisances: Vec<f64>,
}

/// Makes the problem of `parts` for the parameters of `space`, with the first guess of `model`.
///
/// # Errors
/// [`FitError`] if the model makes no sense, a drive is missing or nothing can be used.
pub fn prepare(
    model: &Model,
    space: &Space,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
) -> Result<Prepared, FitError> {
    let simulation = Options {
        tolerance: options.tolerance,
        ..Options::default()
    };
    let simulator = StretchSimulator::new(model, &simulation)?;
    // What is known of a parameter that is held says nothing of the recordings.
    let is_free = |known: &&KnownValue| space.position(&known.id).is_some();
    let mut problem = Problem {
        space: space.clone(),
        data: Vec::with_capacity(parts.len()),
        nuisances: Vec::new(),
        known: options.known.iter().filter(is_free).cloned().collect(),
        options: simulation,
    };
    let mut segments = Vec::new();
    // Drive and events are those of the whole recording: parts of one after the other share
    // them.
    let mut whole: Option<Whole<'_>> = None;
    for (index, (part, summary)) in parts.iter().zip(summaries).enumerate() {
        let lone = summary.noise.1.is_none();
        let sigmas = sigmas(model, &simulator, summary);
        let known = whole.take().filter(|whole| whole.is_of(part, summary));
        let known = match known {
            Some(known) => known,
            None => Whole::new(model, part, summary, options, sigmas.xp)?,
        };
        let Whole {
            recording,
            track,
            timeline,
            ..
        } = &known;
        let longest = options
            .longest
            .unwrap_or_else(|| default_length(&simulator, lone));
        let own = cut(
            &Cut {
                index,
                recording,
                track,
                timeline,
                simulator: &simulator,
                longest,
                lone,
                noise: sigmas.xp,
            },
            part.samples.clone(),
        );
        if own.is_empty() {
            return Err(FitError::NoSegments {
                recording: recording.name.clone(),
                reason: "it is too short, or broken by gaps".to_owned(),
            });
        }
        segments.extend(own);
        free_nuisances(
            model,
            options,
            index,
            recording,
            &sigmas,
            &mut problem.nuisances,
        );
        problem.data.push(Data {
            recording: Arc::clone(recording),
            track: track.clone(),
            sigmas,
            epoch: 0.0,
        });
        whole = Some(known);
    }
    let nuisances = vec![0.0; problem.nuisances.len()];
    Ok(Prepared {
        problem,
        segments,
        nuisances,
    })
}

/// What a part needs of its whole recording.
struct Whole<'a> {
    /// The recording as it was given.
    of: &'a Arc<Recording>,
    summary: &'a RecordingSummary,
    /// The recording without points that the device does not have.
    recording: Arc<Recording>,
    track: Track,
    timeline: Timeline,
}

impl<'a> Whole<'a> {
    /// Drive and events of the recording of `part`, whose proof mass has the noise `noise`
    /// \[m\].
    fn new(
        model: &Model,
        part: &'a Part,
        summary: &'a RecordingSummary,
        options: &FitOptions,
        noise: f64,
    ) -> Result<Self, FitError> {
        let mut recording = Arc::clone(&part.recording);
        if summary.noise.1.is_none() && recording.cantilever.is_some() {
            // The device has no such point.
            let mut without = (*recording).clone();
            without.cantilever = None;
            recording = Arc::new(without);
        }
        let lag = options.nuisances.of(&recording).reading_lag;
        let track = Track::new(model, &recording, lag)?;
        let timeline = summary.timeline(&recording, noise);
        Ok(Self {
            of: &part.recording,
            summary,
            recording,
            track,
            timeline,
        })
    }

    /// Whether it is that of `part`, summarized so.
    fn is_of(&self, part: &Part, summary: &RecordingSummary) -> bool {
        Arc::ptr_eq(self.of, &part.recording) && self.summary == summary
    }
}

/// Default length of segments \[s\]: some periods of the slowest mode if both points were recorded,
/// many if only one was.
pub fn default_length(simulator: &StretchSimulator, lone: bool) -> f64 {
    let slowest = simulator
        .flight_omega2()
        .filter(|w| *w > 0.0)
        .fold(f64::INFINITY, f64::min)
        .sqrt();
    let period = std::f64::consts::TAU / slowest;
    if !period.is_finite() || period <= 0.0 {
        return f64::INFINITY;
    }
    period
        * if simulator.modes() < 2 {
            10.0
        } else if lone {
            6.0
        } else {
            2.5
        }
}

fn sigmas(model: &Model, simulator: &StretchSimulator, summary: &RecordingSummary) -> Sigmas {
    let xp = summary.noise.0;
    let (phi_p, _) = simulator.flight_shapes();
    let springs = simulator
        .flight_omega2()
        .zip(phi_p)
        .filter(|(w, _)| *w > 0.0);
    let compliance: f64 = springs.map(|(w, phi)| phi * phi / w).sum();
    let slowest = simulator
        .flight_omega2()
        .filter(|w| *w > 0.0)
        .fold(f64::INFINITY, f64::min)
        .sqrt();
    let slowest = if slowest.is_finite() { slowest } else { 1.0 };
    let stiffness = if compliance > 0.0 {
        1.0 / compliance
    } else {
        model.proof_mass
    };
    Sigmas {
        xp,
        xc: summary.noise.1.unwrap_or(xp),
        height: GROUND_LAW_NOISE_SHARE * xp,
        velocity: GROUND_LAW_NOISE_SHARE * xp * slowest,
        force: xp * stiffness,
        rest: xp,
        colour: Colour::WHITE,
    }
}

fn free_nuisances(
    model: &Model,
    options: &FitOptions,
    recording: usize,
    data: &Recording,
    sigmas: &Sigmas,
    out: &mut Vec<FreeNuisance>,
) {
    let mut free = |what, unit, (mean, sigma): (f64, f64)| {
        out.push(FreeNuisance {
            recording,
            what,
            unit,
            mean,
            sigma,
        });
    };
    let unknown = (0.0, f64::INFINITY);
    let nuisances = options.nuisances.of(data);
    let both = data.cantilever.is_some();
    // Without spring and drive nothing determines the zero.
    let anchored = model.parameters[ParameterId::F1] > 0.0;
    if nuisances.offsets && anchored {
        free(Nuisance::OffsetP, sigmas.xp, unknown);
        if both {
            free(Nuisance::OffsetC, sigmas.xc, unknown);
        }
    }
    if let Some(sigma) = nuisances.scales {
        free(Nuisance::ScaleP, 1e-4, (0.0, sigma));
        if both {
            free(Nuisance::ScaleC, 1e-4, (0.0, sigma));
        }
    }
    if let Some(sigma) = nuisances.skew
        && model.piezo.is_some()
    {
        let unit = 0.02 * data.interval();
        // The track is late by the recording's own lag, too, which a person has set: only what
        // was assumed for all counts against the prior.
        let assumed = options.nuisances.reading_lag;
        free(Nuisance::Skew, unit, (assumed, sigma));
    }
}

impl From<crate::model::ModelError> for FitError {
    fn from(error: crate::model::ModelError) -> Self {
        FitError::Start(SimError::from(error))
    }
}
