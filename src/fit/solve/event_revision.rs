//! Revises the events of segments that do not fit although the others do.
//!
//! Events are found in noisy samples, so some are wrong: a hop too small to be seen, a short
//! stay taken for a bounce, a sharp turn in flight taken for an impact. Other sequences of
//! events are tried, and one is adopted if the segment then fits clearly better.

use rayon::prelude::*;

use super::event_alternatives::alternative_sequences;
use super::event_trial::{EventTrial, SegmentMisfit, segment_misfit};
use super::levenberg_marquardt::{Clock, Control};
use super::point::Point;
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::segment::Segment;
use crate::fit::thresholds::{MAX_REVISED_MISFIT_RATIO, MAX_REVISION_MISFIT};
use crate::recording::quantile_in_place;
use crate::sim::SimError;

/// Changes made to one segment, one after the other.
const MAX_EVENT_CHANGES: usize = 2;
/// Segments with more joints than this are not changed joint by joint.
const MAX_REVISED_JOINTS: usize = 7;
/// Factors on the restitution with which events are predicted.
const RESTITUTION_FACTORS: [f64; 5] = [1.0, 0.8, 1.25, 0.6, 1.6];

/// Sets segments aside that do not fit while the others do. Returns how many; 0 if cancelled.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn set_suspects_aside(
    problem: &Problem,
    point: &mut Point,
    huber: Huber,
    control: &Control<'_>,
) -> Result<usize, SimError> {
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let fitted: Option<Vec<(Vec<f64>, SegmentMisfit)>> = point
        .segments
        .par_iter()
        .enumerate()
        .map(|(i, segment)| {
            if control.cancelled() {
                return None;
            }
            let nuisances = problem.nuisances_of(&point.x, segment.recording);
            let start = segment.locals.clone();
            let refined =
                problem.refine(segment, &states[i], &simulator, &nuisances, start, huber, 5);
            let misfit = segment_misfit(
                problem,
                segment,
                &refined.locals,
                (&simulator, &states[i]),
                (refined.cost, &nuisances),
            );
            Some((refined.locals, misfit))
        })
        .collect();
    let Some(fitted) = fitted else {
        return Ok(0);
    };
    // Relative to the others: where all are off, the events are not the cause.
    let mut costs: Vec<f64> = fitted.iter().map(|f| f.1.mean).collect();
    let usual = quantile_in_place(&mut costs, 0.5);
    let grounded = problem.space.model(&point.x).has_ground;
    let mut aside = 0;
    for (i, (locals, misfit)) in fitted.into_iter().enumerate() {
        point.segments[i].locals = locals;
        // Without a ground there are no events to misread.
        point.used[i] = !grounded || misfit.relative_to(usual) <= 1.0;
        aside += usize::from(!point.used[i]);
    }
    Ok(aside)
}

/// Whether everything is so far off that the events are not the cause.
pub fn is_beyond_revision(point: &Point) -> bool {
    (point.cost / point.rows.max(1) as f64).sqrt() > MAX_REVISION_MISFIT
}

/// Tries other sequences of events in the segments that are set aside, and uses those again
/// that then fit. `first` are the segments as first guessed. Returns how many are used again.
/// If cancelled, the remaining segments stay as they are.
///
/// # Errors
/// [`SimError`] if the model makes no sense at the point.
pub fn revise(
    problem: &Problem,
    point: &mut Point,
    first: &[Segment],
    huber: Huber,
    (control, clock): (&Control<'_>, &Clock),
) -> Result<usize, SimError> {
    if is_beyond_revision(point) {
        return Ok(0);
    }
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let model = problem.space.model(&point.x);
    let revised: Vec<Option<(Segment, f64)>> = point
        .segments
        .par_iter()
        .enumerate()
        .map(|(i, segment)| {
            let trial = EventTrial {
                problem,
                simulator: &simulator,
                model: &model,
                states: &states[i],
                x: &point.x,
                huber,
                control,
            };
            if point.used[i] || control.cancelled() {
                return None;
            }
            // A single segment may take as long as many iterations of the fit.
            clock.report("revising events", problem, point, control);
            Some(trial.revised(segment, &first[i]))
        })
        .collect();
    let mut back = 0;
    for (i, revised) in revised.into_iter().enumerate() {
        if let Some((segment, misfit)) = revised {
            point.segments[i] = segment;
            point.used[i] = misfit < 1.0;
            back += usize::from(point.used[i]);
        }
    }
    Ok(back)
}

impl EventTrial<'_> {
    /// The best sequence of events found, with its misfit.
    fn revised(&self, segment: &Segment, first: &Segment) -> (Segment, f64) {
        let mut best = segment.clone();
        let mut misfit = self.fit(&mut best);
        // The same events from the first guess: the earlier fit may have ended elsewhere.
        let mut others = vec![first.clone()];
        // The bounces determine the restitution, so it may be wrong as long as they are misread.
        others.extend(
            RESTITUTION_FACTORS
                .iter()
                .filter_map(|f| self.predicted(first, *f)),
        );
        others.retain(Segment::is_consistent);
        for mut other in others {
            if misfit < 1.0 || self.control.cancelled() {
                break;
            }
            let now = self.fit(&mut other);
            if now < MAX_REVISED_MISFIT_RATIO * misfit {
                (best, misfit) = (other, now);
            }
        }
        for _ in 0..MAX_EVENT_CHANGES {
            if misfit < 1.0 || best.joints.len() > MAX_REVISED_JOINTS {
                break;
            }
            let mut found: Option<(Segment, f64)> = None;
            let mut others = alternative_sequences(&best);
            others.extend(self.with_missed_impact(&best));
            others.retain(Segment::is_consistent);
            for mut other in others {
                if self.control.cancelled() {
                    break;
                }
                let now = self.fit(&mut other);
                if now
                    < found
                        .as_ref()
                        .map_or(MAX_REVISED_MISFIT_RATIO * misfit, |f| f.1)
                {
                    found = Some((other, now));
                }
            }
            let Some((segment, now)) = found else { break };
            (best, misfit) = (segment, now);
        }
        (best, misfit)
    }
}
