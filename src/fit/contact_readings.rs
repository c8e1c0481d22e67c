//! Speeds at each bounce and the pull-off force at each release (eq. 13), with standard errors.
//!
//! They are read with the laws of restitution and adhesion switched off: each segment is fitted
//! with free velocities and forces. Structure, drive and film are those of the model.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::contact_sample::{Sampled, count_events, pick};
use super::error::FitError;
use super::inspect::plausible_units::check_level;
use super::inspect::preconditions::{check_each, check_summaries, one_device};
use super::inspect::recording_summary::{RecordingSummary, summarize};
use super::options::{FitOptions, Part};
use super::problem::parameter_space::Space;
use super::problem::prepare::{Prepared, prepare};
use super::residual::residual_rows::{Encounter, Nuisances, SegmentContext, SegmentRun};
use super::residual::residuals::residuals;
use super::residual::simulate_segment::simulate_segment;
use super::segment::Segment;
use super::segment::event_sequence::GroundEvent;
use super::solve::estimate_states::estimate_states;
use super::solve::levenberg_marquardt::{Clock, Control};
use super::solve::point::Point;
use crate::fit::thresholds::MAX_SEGMENT_NOISE_RATIO;
use crate::model::Model;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, Stretcher};

/// Factor on the standard deviations of the laws of the ground, which switches them off.
pub(crate) const GROUND_LAW_RELAXATION: f64 = 1e5;
/// Step of a segment's unknowns for differences, in their own units.
const DIFFERENCE_STEP: f64 = 1e-3;

/// A bounce.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounce {
    /// Index of the recording.
    pub recording: usize,
    /// When \[s\].
    pub time: f64,
    /// Speed of approach \[m/s\].
    pub approach: f64,
    /// Velocity after \[m/s\].
    pub departure: f64,
    /// `departure / approach`.
    pub ratio: f64,
    /// Its standard error.
    pub error: f64,
    /// How far above the ground's level the approach is when the departure leaves it \[m\].
    pub miss: f64,
    /// Its standard error \[m\].
    pub miss_error: f64,
    /// Covariance of `ratio` and `miss` \[m\].
    pub shared: f64,
    /// Samples from then to the next event, or as far as is known.
    pub flight: f64,
}

impl Bounce {
    /// Ratio and its standard error if approach and departure are at one instant, to within
    /// `about` \[s\], at a `level` \[m\] relative to the model's, with its variance. A misread
    /// instant shows in the height between approach and departure, which corrects the ratio.
    pub fn at_once(&self, about: f64, level: (f64, f64)) -> (f64, f64) {
        let variance = self.off_by(about) + level.1;
        let per_miss = self.shared / variance.max(f64::MIN_POSITIVE);
        let left = self.error.powi(2) - per_miss * self.shared;
        // Rounding may leave less than nothing.
        let error = left.max(0.0).sqrt();
        (self.ratio - per_miss * (self.miss - level.0), error)
    }

    /// Variance of that height \[m^2\] if approach and departure are within `about` \[s\].
    pub fn off_by(&self, about: f64) -> f64 {
        self.miss_error.powi(2) + (about * self.approach).powi(2)
    }
}

/// A release.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Release {
    /// Index of the recording.
    pub recording: usize,
    /// When \[s\].
    pub time: f64,
    /// Time on the ground before \[s\].
    pub contact: f64,
    /// The same in samples.
    pub samples: f64,
    /// Pull-off force \[N\].
    pub force: f64,
    /// Its standard error \[N\].
    pub error: f64,
    /// By how much the drive makes it jump at about that instant \[N\].
    pub jump: f64,
}

/// Everything read at the ground, in order of recording and time.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactReadings {
    /// Bounces.
    pub bounces: Vec<Bounce>,
    /// Releases after stays long enough to determine the force.
    pub releases: Vec<Release>,
    /// Bounces in segments too far from the model to be read.
    pub unread: usize,
    /// Releases without a force: in such segments, after a contact of too few samples, or after
    /// one that began before the recording.
    pub unread_releases: usize,
    /// Median distance of the model from the segments that were read, and from all those with at
    /// most one event, in units of the noise; 0 if there are none.
    pub off: ModelDistance,
}

/// How far a model is from the recordings, in units of the noise.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelDistance {
    /// In the segments in which bounces or releases were read.
    pub read: f64,
    /// In segments with at most one event, where a misread event is not the cause.
    pub eventless: f64,
}

/// Reads bounces and releases in `parts`, the parameters of `model` held.
///
/// # Errors
/// [`FitError`] if a part cannot be used.
pub fn read_contacts(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<ContactReadings, FitError> {
    Space::new(model, &options.free)?;
    let summaries = summarize(model, parts);
    check_readable(model, parts, &summaries, options)?;
    let read = read_picked(model, (parts, &summaries), options, control, |_| None);
    read.map(|(readings, _)| readings)
}

/// The same in an even pick of the segments, where there are very many: enough to see what the
/// recordings allow. Says how many were picked, if not all. The parts are readable, and their
/// summaries known.
///
/// # Errors
/// [`FitError`] if a part cannot be used.
pub fn sample_contacts(
    model: &Model,
    (parts, summaries): (&[Part], &[RecordingSummary]),
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<(ContactReadings, Option<Sampled>), FitError> {
    let picked = |segments: &mut Vec<Segment>| pick(segments, parts.len());
    read_picked(model, (parts, summaries), options, control, picked)
}

fn read_picked(
    model: &Model,
    (parts, summaries): (&[Part], &[RecordingSummary]),
    options: &FitOptions,
    control: &Control<'_>,
    pick: impl FnOnce(&mut Vec<Segment>) -> Option<Sampled>,
) -> Result<(ContactReadings, Option<Sampled>), FitError> {
    let space = Space::new(model, &options.free)?;
    let mut prepared = prepare(model, &space, parts, summaries, options)?;
    let sampled = pick(&mut prepared.segments);
    for data in &mut prepared.problem.data {
        data.sigmas.velocity *= GROUND_LAW_RELAXATION;
        data.sigmas.force *= GROUND_LAW_RELAXATION;
    }
    let mut clock = Clock::new(options.iterations.min(10));
    let point = estimate_states(&prepared, model, options, control, &mut clock)?;
    Ok((read_contacts_at(&prepared, &point)?, sampled))
}

/// Refuses what no step can use: recordings that are too short, constant, saturated, in another
/// unit, or of different devices. Recordings without contact pass, because not every step needs
/// one.
///
/// # Errors
/// [`FitError`] with one clear sentence.
pub(crate) fn check_readable(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
) -> Result<(), FitError> {
    Space::new(model, &options.free)?;
    check_each(model, parts)?;
    check_readable_together(model, parts, summaries, options)
}

/// What [`check_readable`] asks of all parts together.
fn check_readable_together(
    model: &Model,
    parts: &[Part],
    summaries: &[RecordingSummary],
    options: &FitOptions,
) -> Result<(), FitError> {
    match check_summaries(model, parts, summaries, options) {
        Ok(()) | Err(FitError::NoContact { .. }) => {}
        Err(error) => return Err(error),
    }
    if model.has_ground {
        check_level(model, parts, summaries)?;
    }
    one_device(model, parts, summaries).map(|_| ())
}

/// Summaries of parts, and whether they are readable, both at once.
pub(crate) fn inspect(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
) -> (Vec<RecordingSummary>, Result<(), FitError>) {
    let (summaries, each) = rayon::join(
        || summarize(model, parts),
        || Space::new(model, &options.free).and_then(|_| check_each(model, parts)),
    );
    let readable = each.and_then(|()| check_readable_together(model, parts, &summaries, options));
    (summaries, readable)
}

/// Reads bounces and releases at a point that was fitted without the laws of the ground.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub(crate) fn read_contacts_at(
    prepared: &Prepared,
    point: &Point,
) -> Result<ContactReadings, SimError> {
    let problem = &prepared.problem;
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let own: Vec<(ContactReadings, f64)> = point
        .segments
        .par_iter()
        .enumerate()
        .map(|(i, segment)| {
            let mut stretcher = Stretcher::new(&simulator);
            let context = problem.context(segment, &states[i]);
            let nuisances = problem.nuisances_of(&point.x, segment.recording);
            let chi2 = segment_chi2(segment, &context, &mut stretcher, &nuisances);
            let read = (point.used[i] && chi2 < MAX_SEGMENT_NOISE_RATIO * MAX_SEGMENT_NOISE_RATIO)
                .then(|| read_segment(prepared, point, segment, &states[i], &mut stretcher, chi2))
                .flatten();
            let mut read = read.unwrap_or_else(|| ContactReadings {
                unread: count_events(segment, |kind| matches!(kind, GroundEvent::Bounce { .. })),
                ..ContactReadings::default()
            });
            let releases =
                count_events(segment, |kind| matches!(kind, GroundEvent::Release { .. }));
            read.unread_releases = releases - read.releases.len();
            (read, chi2.sqrt())
        })
        .collect();
    let has_readings = |r: &ContactReadings| !(r.bounces.is_empty() && r.releases.is_empty());
    let read = own.iter().filter(|(r, _)| has_readings(r));
    let eventless = own.iter().zip(&point.segments);
    let eventless = eventless.filter(|(_, s)| count_events(s, |_| true) <= 1);
    let median = |mut off: Vec<f64>| match off.as_mut_slice() {
        [] => 0.0,
        off => quantile_in_place(off, 0.5),
    };
    let mut all = ContactReadings {
        off: ModelDistance {
            read: median(read.map(|(_, off)| *off).collect()),
            eventless: median(eventless.map(|((_, off), _)| *off).collect()),
        },
        ..ContactReadings::default()
    };
    for (readings, _) in own {
        all.bounces.extend(readings.bounces);
        all.releases.extend(readings.releases);
        all.unread += readings.unread;
        all.unread_releases += readings.unread_releases;
    }
    let key = |recording: usize, time: f64| (recording, time);
    all.bounces.sort_by(|a, b| {
        let (a, b) = (key(a.recording, a.time), key(b.recording, b.time));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    all.releases.sort_by(|a, b| {
        let (a, b) = (key(a.recording, a.time), key(b.recording, b.time));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    Ok(all)
}

/// Chi2 per degree of freedom of a segment; infinite where it cannot be simulated.
fn segment_chi2(
    segment: &Segment,
    context: &SegmentContext<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
) -> f64 {
    let (locals, mut r) = (&segment.locals, Vec::new());
    if residuals(segment, context, stretcher, nuisances, locals, &mut r).is_err() {
        return f64::INFINITY;
    }
    let freedom = r.len().saturating_sub(locals.len()).max(1);
    let chi2 = r.iter().map(|r| r * r).sum::<f64>() / freedom as f64;
    if chi2.is_finite() {
        chi2
    } else {
        f64::INFINITY
    }
}

/// Quantities of interest of a run: ratios and height differences of the bounces, forces of the
/// releases.
fn quantities(run: &SegmentRun) -> Vec<f64> {
    let mut out = Vec::new();
    for encounter in &run.encounters {
        match *encounter {
            Encounter::Meeting {
                miss,
                speed,
                after: Some(after),
                ..
            } => out.extend([after / speed, miss]),
            Encounter::PullOff(Some(pull)) if pull.informative => out.push(pull.force),
            _ => {}
        }
    }
    out
}

/// Readings of one segment with misfit `chi2`; `None` if it cannot be simulated. Errors by linear
/// propagation of the covariance of the segment's unknowns.
fn read_segment(
    prepared: &Prepared,
    point: &Point,
    segment: &Segment,
    states: &[f64],
    stretcher: &mut Stretcher<'_>,
    chi2: f64,
) -> Option<ContactReadings> {
    let problem = &prepared.problem;
    let context = problem.context(segment, states);
    let nuisances = problem.nuisances_of(&point.x, segment.recording);
    let locals = &segment.locals;
    let base = simulate_segment(segment, &context, stretcher, &nuisances, locals).ok()?;
    let values = quantities(&base);
    if values.is_empty() {
        return Some(ContactReadings::default());
    }
    let mut r0 = Vec::new();
    residuals(segment, &context, stretcher, &nuisances, locals, &mut r0).ok()?;
    // How residuals and quantities move with each unknown.
    let mut of_residuals = DMatrix::zeros(r0.len(), locals.len());
    let mut of_values = DMatrix::zeros(values.len(), locals.len());
    let mut r = Vec::new();
    for j in 0..locals.len() {
        let mut there = locals.clone();
        there[j] += DIFFERENCE_STEP;
        residuals(segment, &context, stretcher, &nuisances, &there, &mut r).ok()?;
        let moved =
            quantities(&simulate_segment(segment, &context, stretcher, &nuisances, &there).ok()?);
        if r.len() != r0.len() || moved.len() != values.len() {
            return None;
        }
        for (i, (a, b)) in r.iter().zip(&r0).enumerate() {
            of_residuals[(i, j)] = (a - b) / DIFFERENCE_STEP;
        }
        for (i, (a, b)) in moved.iter().zip(&values).enumerate() {
            of_values[(i, j)] = (a - b) / DIFFERENCE_STEP;
        }
    }
    let normal = of_residuals.transpose() * &of_residuals;
    let ridge = 1e-12 * normal.diagonal().max();
    let normal = normal + DMatrix::from_diagonal(&DVector::from_element(locals.len(), ridge));
    let covariance = normal.try_inverse()? * chi2.max(1.0);
    let spread = &of_values * covariance * of_values.transpose();
    let error = |i: usize| spread[(i, i)].max(0.0).sqrt();
    let mut quantity = 0..values.len();
    let skew = nuisances.skew;
    let mut readings = ContactReadings::default();
    let end = problem.data[segment.recording].recording.time[segment.samples.end - 1] + skew;
    for (i, encounter) in base.encounters.iter().enumerate() {
        let next = base.encounters[i + 1..].iter().find_map(Encounter::time);
        match *encounter {
            Encounter::Meeting {
                time,
                miss,
                speed,
                after: Some(after),
            } => {
                let (ratio, height) = (quantity.next()?, quantity.next()?);
                readings.bounces.push(Bounce {
                    recording: segment.recording,
                    time: time - skew,
                    approach: speed,
                    departure: after,
                    ratio: after / speed,
                    error: error(ratio),
                    miss,
                    miss_error: error(height),
                    shared: spread[(ratio, height)],
                    flight: (next.unwrap_or(end) - time) / segment.interval,
                });
            }
            Encounter::PullOff(Some(pull)) if pull.informative => readings.releases.push(Release {
                recording: segment.recording,
                time: pull.time - skew,
                contact: pull.contact,
                samples: pull.contact / segment.interval,
                force: pull.force,
                jump: pull.jump,
                error: error(quantity.next()?),
            }),
            _ => {}
        }
    }
    readings.bounces.retain(|b| {
        [b.ratio, b.error, b.miss_error, b.shared]
            .iter()
            .all(|x| x.is_finite())
    });
    readings
        .releases
        .retain(|r| r.force.is_finite() && r.error.is_finite());
    Some(readings)
}

#[cfg(test)]
#[path = "contact_readings_tests.rs"]
mod tests;
