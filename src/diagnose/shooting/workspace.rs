//! Recordings made ready for a diagnosis, and what all fits to them share.
//!
//! All fits here are over event-free segments (`data::event_free_segments`). What happens at the
//! ground is analysed separately (`contact`).

use std::sync::Arc;

use super::clock_skew::fitted_skews;
use super::fitted::{Bound, Fitted, RequiredEffect};
use super::free_parameters::{free_parameters, known_bounds, structure_bounds};
use crate::diagnose::data::event_free_segments::prepare_event_free;
use crate::diagnose::data::noise_model;
use crate::diagnose::data::noise_model::{ContactRecording, Noise};
use crate::diagnose::data::reading_assumptions::{HOVERS_REASON, ReadingAssumptions};
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::data::side::{Drift, Split, level_drift_of};
use crate::diagnose::data::walking_zero::with_walk;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::score_test::reading_scales::{self, EQUAL_SCALE_SIGMA, OWN_SCALE_SIGMA};
use crate::fit::inspect::recording_summary::{RecordingSummary, summarize_with_lag};
use crate::fit::problem::Problem;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::{Prepared, default_length, prepare};
use crate::fit::residual::residual_rows::Sigmas;
use crate::fit::solve::levenberg_marquardt::{Clock, Plan, improve};
use crate::fit::solve::point::{Point, settle};
use crate::fit::{FitError, FitOptions, FreeNuisances, ParameterChoices, Part};
use crate::model::Model;
use crate::sim::StretchSimulator;

/// Prior standard deviation of the skew between the clocks of voltage and readings \[s\].
const CLOCK_SKEW_SIGMA: f64 = 5e-6;
/// Noise of readings that show none, as a share of their largest.
const EXACT_NOISE_SHARE: f64 = 1e-3;
/// Tolerance of a simulation of whole runs, in that of one of segments.
const WHOLE_RUN_TOLERANCE_SHARE: f64 = 0.04;
/// Relative fall of the cost that an iteration must reach to be followed by another, in final
/// fits.
pub(crate) const FINE_TOLERANCE: f64 = 2e-6;
/// The same on the way.
pub(crate) const ROUGH_TOLERANCE: f64 = 2e-3;

/// Everything that stays fixed while hypotheses are compared.
#[derive(Debug, Clone)]
pub struct Workspace {
    /// Recordings to fit.
    pub train: Split,
    /// Held-out recordings; `None` if there are none.
    pub held_out: Option<Split>,
    /// Noise of the readings.
    pub noise: Noise,
    /// Relative standard error of the size of the noise.
    pub noise_error: f64,
    /// Ids of the baseline's free parameters.
    pub free: Vec<String>,
    /// What was chosen about parameters.
    pub choices: ParameterChoices,
    /// The model that the re-tuning started from.
    pub initial_model: Model,
    /// The effect found by the re-tuning without which the baseline is lost.
    pub required_effect: Option<Arc<RequiredEffect>>,
    /// Fits with other effects in its place.
    pub rival_effects: Arc<Vec<RequiredEffect>>,
    pub(crate) bounds: Vec<Bound>,
    pub(crate) options: FitOptions,
}

impl Workspace {
    /// Makes recordings ready.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a recording or the model cannot be used.
    pub fn new(
        model: &Model,
        train: &[Part],
        held_out: &[Part],
        options: &DiagnoseOptions,
    ) -> Result<Self, DiagnoseError> {
        let assumptions = ReadingAssumptions::default();
        Self::with_assumptions(model, (train, held_out), options, &assumptions)
    }

    /// The same under assumptions on the readings.
    pub(crate) fn with_assumptions(
        model: &Model,
        (train, held_out): (&[Part], &[Part]),
        options: &DiagnoseOptions,
        assumptions: &ReadingAssumptions,
    ) -> Result<Self, DiagnoseError> {
        if train.is_empty() {
            return Err(DiagnoseError::NoRecording);
        }
        let lone = train.iter().all(|p| p.recording.cantilever.is_none()) || !model.has_cantilever;
        let free = options.choices.free_ids(free_parameters(model, lone));
        let found = |parts: &[Part], hovers: &[usize]| {
            let mut findings = summarize_with_lag(model, parts, assumptions.lag);
            for &k in hovers {
                findings[k].level = Err(HOVERS_REASON.to_owned());
                findings[k].change = None;
            }
            findings
        };
        let findings = found(train, &assumptions.hovering.0);
        let mut tolerance = options.tolerance * noise_scale(train, &findings);
        if !model.has_ground {
            // Errors of the steps add up over a whole run.
            tolerance *= WHOLE_RUN_TOLERANCE_SHARE;
        }
        // One length for all models, so that all are compared on the same segments.
        let simulation = crate::sim::Options {
            tolerance,
            ..crate::sim::Options::default()
        };
        // Without a ground nothing ends a flight: what a law does to the whole run counts.
        let longest = if model.has_ground {
            default_length(&StretchSimulator::new(model, &simulation)?, lone)
        } else {
            f64::INFINITY
        };
        // Where nothing drives the device a scale is a force, such as its weight.
        let has_scales = model.piezo.is_some() && train.len() > 1;
        let scale_sigma = if assumptions.own_scales {
            OWN_SCALE_SIGMA
        } else {
            EQUAL_SCALE_SIGMA
        };
        let fit = FitOptions {
            free: free.clone(),
            known: options.choices.known.clone(),
            longest: Some(longest),
            nuisances: FreeNuisances {
                offsets: true,
                scales: has_scales.then_some(scale_sigma),
                skew: Some(CLOCK_SKEW_SIGMA),
                reading_lag: assumptions.latency,
            },
            tolerance,
            ..FitOptions::for_model(model)
        };
        let space = Space::new(model, &free)?;
        let side = |parts: &[Part], findings: Vec<RecordingSummary>| -> Result<Split, FitError> {
            let event_free = prepare_event_free(model, &space, parts, &findings, &fit)?;
            Ok(Split {
                parts: parts.to_vec(),
                drift: level_drift_of(&findings),
                findings,
                event_free,
            })
        };
        let mut train = side(train, findings)?;
        let mut held_out = if held_out.is_empty() {
            None
        } else {
            let findings = found(held_out, &assumptions.hovering.1);
            Some(with_frozen_parameters(side(held_out, findings)?))
        };
        let (noise, noise_error) = share_noise(&mut train, &mut held_out);
        Ok(Self {
            train,
            held_out,
            noise,
            noise_error,
            free,
            choices: options.choices.clone(),
            initial_model: model.clone(),
            required_effect: None,
            rival_effects: Arc::default(),
            bounds: structure_bounds(model)
                .into_iter()
                .chain(known_bounds(&options.choices.known))
                .collect(),
            options: fit,
        })
    }

    /// The same with a scale of its own for each reading of each recording.
    pub fn with_own_scales(&self) -> Self {
        let mut freed = self.clone();
        for side in std::iter::once(&mut freed.train).chain(&mut freed.held_out) {
            reading_scales::set_free(&mut side.event_free.prepared.problem);
        }
        freed
    }

    /// Effects that were fitted from a cold start, the required one first.
    pub fn cold_fits(&self) -> impl Iterator<Item = &RequiredEffect> {
        let required = self.required_effect.as_deref();
        required.into_iter().chain(self.rival_effects.iter())
    }

    /// Start times of the fitted recordings if all are placed one after the other, in the
    /// order given \[s\].
    pub fn epochs(&self) -> Vec<f64> {
        let mut at = 0.0;
        let parts = self.train.parts.iter();
        parts
            .map(|part| {
                let (begin, end) = part.recording.span();
                let epoch = at - begin;
                at += end - begin;
                epoch
            })
            .collect()
    }

    /// Total duration of the fitted recordings \[s\].
    pub fn fitted_duration(&self) -> f64 {
        let spans = self.train.parts.iter().map(|p| p.recording.span());
        spans.map(|(begin, end)| end - begin).sum()
    }

    /// The same recordings placed one after the other in time, the held-out ones last: what
    /// happens to the ground once affects all later recordings.
    pub fn as_sequence(&self) -> Self {
        let mut series = self.clone();
        let mut epochs = self.epochs();
        let mut at = self.fitted_duration();
        for (data, epoch) in series
            .train
            .event_free
            .prepared
            .problem
            .data
            .iter_mut()
            .zip(&epochs)
        {
            data.epoch = *epoch;
        }
        epochs.clear();
        if let Some(held_out) = &mut series.held_out {
            for (data, part) in held_out
                .event_free
                .prepared
                .problem
                .data
                .iter_mut()
                .zip(&held_out.parts)
            {
                let (begin, end) = part.recording.span();
                data.epoch = at - begin;
                at += end - begin;
            }
        }
        series
    }

    /// The drift that the level in the fitted recordings shows, if `model` has none yet.
    pub fn unmodelled_drift(&self, model: &Model) -> Option<&Drift> {
        let known = |spec| model.effects.iter().any(|e| e.spec == spec);
        let drift = self.train.drift.as_ref();
        drift.filter(|(effect, _)| !known(effect.spec))
    }

    /// Recordings of a split cut with their events into segments of at most `longest` \[s\],
    /// for `model`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn with_events(
        &self,
        side: &Split,
        model: &Model,
        longest: f64,
    ) -> Result<Prepared, DiagnoseError> {
        let space = Space::new(model, &self.free)?;
        let options = FitOptions {
            longest: Some(longest),
            ..self.options.clone()
        };
        Ok(prepare(
            model,
            &space,
            &side.parts,
            &side.findings,
            &options,
        )?)
    }

    pub(crate) fn improve(
        &self,
        problem: &Problem,
        point: Point,
        locked: &[usize],
        (iterations, enough): (usize, f64),
        control: &DiagnoseControl<'_>,
    ) -> Result<Point, DiagnoseError> {
        let control = control.quiet();
        let plan = Plan {
            stage: "event-free segments",
            iterations,
            locked,
            enough,
        };
        let mut clock = Clock::new(iterations);
        let point = improve(problem, point, &plan, &control, &mut clock)?;
        log::debug!(
            "chi2 {:.1} of {} rows in {} steps with {:?}",
            point.cost,
            point.rows,
            clock.done(),
            FitSummary(problem, &point)
        );
        Ok(point)
    }

    pub(crate) fn finish(&self, problem: Problem, point: Point) -> Result<Fitted, DiagnoseError> {
        let point = settle(
            &problem,
            &point.x,
            &point.segments,
            &point.used,
            ROBUST_LOSS,
            2,
        )?;
        Ok(Fitted::at(problem, point)?)
    }
}

/// Noise of the quietest of `parts` \[m\]; a share of their largest reading where they show none.
fn noise_scale(parts: &[Part], findings: &[RecordingSummary]) -> f64 {
    let noises = findings.iter().map(|f| f.noise.0).filter(|n| *n > 0.0);
    let noise = noises.fold(f64::INFINITY, f64::min);
    let all = parts.iter().flat_map(|p| &p.recording.proof_mass);
    let finite = all.filter(|x| x.is_finite());
    let reach = finite.fold(0.0f64, |a, x| a.max(x.abs()));
    noise.clamp(EXACT_NOISE_SHARE.powi(2) * reach, EXACT_NOISE_SHARE * reach)
}

/// A side on which parameters are frozen: what is known of them counts where they are fitted.
fn with_frozen_parameters(mut side: Split) -> Split {
    side.event_free.prepared.problem.known.clear();
    side
}

/// Gives all recordings the noise of one instrument; returns it with the relative standard error of its
/// size.
fn share_noise(train: &mut Split, held_out: &mut Option<Split>) -> (Noise, f64) {
    let picks: [fn(&mut Sigmas) -> &mut f64; 2] = [|s| &mut s.xp, |s| &mut s.xc];
    let mut information = 0.0;
    for pick in picks {
        let mut all: Vec<(usize, &mut f64)> = std::iter::once(&mut *train)
            .chain(held_out.as_mut())
            .flat_map(|s| &mut s.event_free.prepared.problem.data)
            .map(|d| (d.recording.len(), pick(&mut d.sigmas)))
            .collect();
        information += noise_model::pool_noise(&mut all).powi(-2);
    }
    let sides = || std::iter::once(&*train).chain(held_out.as_ref());
    let stays: Vec<ContactRecording<'_>> = sides()
        .flat_map(|s| {
            s.event_free
                .prepared
                .problem
                .data
                .iter()
                .zip(&s.event_free.timelines)
        })
        .map(|(d, timeline)| ContactRecording {
            recording: &d.recording,
            timeline,
            sigma: d.sigmas.xp,
        })
        .collect();
    let mut noise = noise_model::estimate_noise(&stays);
    let stays: Vec<ContactRecording<'_>> = stays
        .iter()
        .map(|stay| ContactRecording {
            sigma: noise.factor * stay.sigma,
            ..*stay
        })
        .collect();
    noise.colour = with_walk(&stays, noise.colour);
    for side in std::iter::once(train).chain(held_out) {
        side.set_noise(&noise);
        for data in &side.event_free.prepared.problem.data {
            log::debug!("{}: {:?}", data.recording.name, data.sigmas);
        }
    }
    (noise, information.max(1.0).powf(-0.5))
}

pub(crate) fn positions(problem: &Problem, ids: &[&str]) -> Vec<usize> {
    ids.iter()
        .filter_map(|id| problem.space.position(id))
        .collect()
}

/// Parameters, clocks and segments of a fit in one line, for the log.
struct FitSummary<'a>(&'a Problem, &'a Point);

impl std::fmt::Debug for FitSummary<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(problem, point) = self;
        let values = problem.space.values(&point.x);
        for (entry, value) in problem.space.entries.iter().zip(values) {
            write!(f, "{} {value:.4e}, ", entry.id)?;
        }
        for skew in fitted_skews(problem, point) {
            write!(f, "{:.1} us, ", skew * 1e6)?;
        }
        let used = point.used.iter().filter(|used| **used).count();
        write!(f, "{used} of {} event-free segments", point.segments.len())
    }
}
