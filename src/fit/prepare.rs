//! From recordings to a problem: noise, drive, contact level, events, segments.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use super::chain::Sigmas;
use super::colour::Colour;
use super::error::FitError;
use super::noise::noise_of;
use super::options::FitOptions;
use super::problem::{Data, FreeNuisance, Nuisance, Problem};
use super::segment::{Cut, Segment, cut};
use super::space::Space;
use super::timeline::Timeline;
use super::track::Track;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::recording::events::{EventOptions, HOP, find_events};
use crate::recording::level::estimate_contact_level;
use crate::recording::level_step::{LevelStep, find_level_step};
use crate::recording::{Channel, Recording, quantile_in_place};
use crate::sim::{Options, SimError, StretchSimulator};

/// The laws of the ground hold to this share of the noise.
const LAW: f64 = 0.1;
/// Levels this close are the same ground with the same zero \[m\].
const SAME_LEVEL: f64 = 2e-6;
/// A noise below this share of the motion is taken to be this: the simulation and the
/// recorder's digits are no better.
const LEAST_NOISE: f64 = 1e-5;

/// A stretch of a recording to be used.
#[derive(Debug, Clone)]
pub struct Part {
    /// The recording.
    pub recording: Arc<Recording>,
    /// Which samples of it.
    pub samples: Range<usize>,
}

impl Part {
    /// All of a recording.
    pub fn whole(recording: Arc<Recording>) -> Self {
        let samples = 0..recording.len();
        Self { recording, samples }
    }

    /// A recording cut in two: its first two thirds and the rest.
    pub fn split(recording: Arc<Recording>) -> (Self, Self) {
        let at = 2 * recording.len() / 3;
        let first = Self {
            samples: 0..at,
            recording: Arc::clone(&recording),
        };
        let rest = Self {
            samples: at..recording.len(),
            recording,
        };
        (first, rest)
    }
}

/// What the data alone say about each part.
#[derive(Debug, Clone)]
pub struct Findings {
    /// Noise of the proof mass and of the cantilever \[m\].
    pub noise: (f64, Option<f64>),
    /// Contact level in the reading \[m\], or why there is none.
    pub level: Result<f64, String>,
    /// How that level changes in the course of the recording, if it does; `level` is that
    /// before.
    pub step: Option<LevelStep>,
}

impl Findings {
    /// What happens at the ground in `recording`, whose noise is `noise` \[m\].
    pub fn timeline(&self, recording: &Recording, noise: f64) -> Timeline {
        match self.level {
            Ok(level) => {
                let xp = self.levelled(recording);
                Timeline::new(&recording.time, &xp, level, noise)
            }
            Err(_) => Timeline::default(),
        }
    }

    /// Reading of the proof mass with changes of the ground's level taken out \[m\].
    pub fn levelled<'a>(&self, recording: &'a Recording) -> Cow<'a, [f64]> {
        let xp = &recording.proof_mass;
        match self.step {
            Some(step) => Cow::Owned(step.taken_out(&recording.time, xp)),
            None => Cow::Borrowed(xp),
        }
    }
}

/// Looks at parts without a model of the motion.
pub fn look(model: &Model, parts: &[Part]) -> Vec<Findings> {
    let mut findings: Vec<Findings> = parts.iter().map(|p| look_at(model, p)).collect();
    if !model.has_ground {
        return findings;
    }
    let mut known: Vec<f64> = findings
        .iter()
        .filter_map(|f| f.level.clone().ok())
        .collect();
    let common = quantile_in_place(&mut known, 0.5);
    for (finding, part) in findings.iter_mut().zip(parts) {
        if finding.level.is_err()
            && let Some(level) = level_of_impacts(&part.recording, finding.noise.0, common)
        {
            finding.level = Ok(level);
        }
    }
    findings
}

fn look_at(model: &Model, part: &Part) -> Findings {
    let r = &part.recording;
    let noise = |channel: Channel| {
        // A part whose noise cannot be told is refused by the check.
        let sigma = noise_of(r, channel).map_or(0.0, |n| n.sigma);
        let values = r.channel(channel).unwrap_or_default();
        let mut finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
        let low = quantile_in_place(&mut finite, 0.01);
        let span = quantile_in_place(&mut finite, 0.99) - low;
        sigma.max(LEAST_NOISE * span).max(f64::MIN_POSITIVE)
    };
    let estimate = noise_of(r, Channel::ProofMass).ok();
    let step = model
        .has_ground
        .then(|| find_level_step(r, estimate))
        .flatten();
    let level = if model.has_ground {
        let xp = step.map_or(Cow::Borrowed(&r.proof_mass), |step| {
            Cow::Owned(step.taken_out(&r.time, &r.proof_mass))
        });
        estimate_contact_level(r.axis(), r.voltage.as_deref(), &xp, estimate)
            .map_err(|missing| missing.to_string())
    } else {
        Err("the device has no ground".to_owned())
    };
    let xc = model.has_cantilever && r.cantilever.is_some();
    log::debug!("{}: ground at {level:?}, {step:?}", r.name);
    Findings {
        noise: (
            noise(Channel::ProofMass),
            xc.then(|| noise(Channel::Cantilever)),
        ),
        level,
        step,
    }
}

/// Level of a ground on which the mass never rests: where it turns suddenly, again and
/// again. A level known from another recording is taken if it is the same.
fn level_of_impacts(recording: &Recording, noise: f64, common: f64) -> Option<f64> {
    let xp = &recording.proof_mass;
    let mut finite: Vec<f64> = xp.iter().copied().filter(|x| x.is_finite()).collect();
    let bottom = quantile_in_place(&mut finite, 0.0);
    let level = if (bottom - common).abs() < SAME_LEVEL {
        common
    } else {
        bottom
    };
    let options = EventOptions {
        contact_level: level,
        noise,
        hop: HOP,
    };
    let impacts = find_events(recording.axis(), xp, &options).impacts;
    let sudden = impacts
        .iter()
        .filter(|i| i.v_after - i.v_before > 2.0 * i.v_error);
    (sudden.count() >= 2).then_some(level)
}

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

/// Makes a problem of `parts` for the parameters of `space`, guessed as in `model`.
///
/// # Errors
/// [`FitError`] if the model makes no sense, a drive is missing or nothing can be used.
pub fn prepare(
    model: &Model,
    space: &Space,
    parts: &[Part],
    findings: &[Findings],
    options: &FitOptions,
) -> Result<Prepared, FitError> {
    let simulation = Options {
        tolerance: options.tolerance,
        ..Options::default()
    };
    let simulator = StretchSimulator::new(model, &simulation)?;
    let mut problem = Problem {
        space: space.clone(),
        data: Vec::with_capacity(parts.len()),
        nuisances: Vec::new(),
        options: simulation,
    };
    let mut segments = Vec::new();
    for (index, (part, finding)) in parts.iter().zip(findings).enumerate() {
        let mut recording = Arc::clone(&part.recording);
        if finding.noise.1.is_none() && recording.cantilever.is_some() {
            // The device has no such point.
            let mut without = (*recording).clone();
            without.cantilever = None;
            recording = Arc::new(without);
        }
        let track = Track::new(model, &recording, options.nuisances.late)?;
        let lone = finding.noise.1.is_none();
        let sigmas = sigmas(model, &simulator, finding);
        let timeline = finding.timeline(&recording, sigmas.xp);
        let longest = options
            .longest
            .unwrap_or_else(|| default_length(&simulator, lone));
        let own = cut(
            &Cut {
                index,
                recording: &recording,
                track: &track,
                timeline: &timeline,
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
            &recording,
            &sigmas,
            &mut problem.nuisances,
        );
        problem.data.push(Data {
            recording,
            track,
            sigmas,
            epoch: 0.0,
        });
    }
    let nuisances = vec![0.0; problem.nuisances.len()];
    Ok(Prepared {
        problem,
        segments,
        nuisances,
    })
}

/// Longest segment \[s\]: some periods of the slowest mode where both points were
/// recorded, many where only one was.
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

fn sigmas(model: &Model, simulator: &StretchSimulator, finding: &Findings) -> Sigmas {
    let xp = finding.noise.0;
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
        xc: finding.noise.1.unwrap_or(xp),
        height: LAW * xp,
        velocity: LAW * xp * slowest,
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
    let nuisances = &options.nuisances;
    let both = data.cantilever.is_some();
    // Without spring and drive nothing tells where zero is.
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
        free(Nuisance::Skew, unit, (nuisances.late, sigma));
    }
}

impl From<crate::model::ModelError> for FitError {
    fn from(error: crate::model::ModelError) -> Self {
        FitError::Start(SimError::from(error))
    }
}
