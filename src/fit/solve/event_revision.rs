//! Second thoughts on events. Where a segment does not come down to the noise although
//! the others have, the data may have been misread there: a hop too small to be seen, a
//! quick stay taken for a bounce, a sharp turn in the air taken for an impact. Each
//! such reading is tried, and kept if the segment then fits clearly better.

use rayon::prelude::*;

use super::event_alternatives::alternative_sequences;
use super::levenberg_marquardt::{Clock, Control};
use super::point::Point;
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::residual::residual_rows::{Nuisances, Row, rows};
use crate::fit::residual::residuals::residuals;
use crate::fit::segment::Segment;
use crate::model::Model;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, StretchSimulator, Stretcher};

/// Misfit, in units of the noise, beyond which events are not read again.
const MAX_REVISION_MISFIT: f64 = 10.0;
/// Another reading must bring what is suspect below this share.
const MAX_REVISED_MISFIT_RATIO: f64 = 0.8;
/// Changes made to one segment, one after the other.
const MAX_EVENT_CHANGES: usize = 2;
/// Segments with more joints than this are not changed joint by joint.
const MAX_REVISED_JOINTS: usize = 7;
/// Factors on the restitution with which events are predicted.
const RESTITUTION_FACTORS: [f64; 5] = [1.0, 0.8, 1.25, 0.6, 1.6];

/// Takes the say from segments that do not fit while the others do; returns how many,
/// none if it was cancelled.
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
            let told = problem.refine(segment, &states[i], &simulator, &nuisances, start, huber, 5);
            let strain = segment_misfit(
                problem,
                segment,
                &told.locals,
                (&simulator, &states[i]),
                (told.cost, &nuisances),
            );
            Some((told.locals, strain))
        })
        .collect();
    let Some(fitted) = fitted else {
        return Ok(0);
    };
    // Measured by the others: where all are off, it is not the reading of events.
    let mut costs: Vec<f64> = fitted.iter().map(|f| f.1.mean).collect();
    let usual = quantile_in_place(&mut costs, 0.5);
    let grounded = problem.space.model(&point.x).has_ground;
    let mut aside = 0;
    for (i, (locals, strain)) in fitted.into_iter().enumerate() {
        point.segments[i].locals = locals;
        // Without a ground there are no events to misread.
        point.used[i] = !grounded || strain.relative_to(usual) <= 1.0;
        aside += usize::from(!point.used[i]);
    }
    Ok(aside)
}

/// Whether all is so far off that the reading of events is not to blame.
pub fn is_beyond_revision(point: &Point) -> bool {
    (point.cost / point.rows.max(1) as f64).sqrt() > MAX_REVISION_MISFIT
}

/// Tries other readings of the events in the segments set aside, and takes those back
/// that then fit. `first` are the segments as first guessed. Returns how many came back.
/// Cancelled, it leaves the segments it has not come to as they are.
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
            // A single segment may take as long as many iterations.
            clock.tell("events read again", problem, point, control);
            Some(trial.revised(segment, &first[i]))
        })
        .collect();
    let mut back = 0;
    for (i, revised) in revised.into_iter().enumerate() {
        if let Some((segment, strain)) = revised {
            point.segments[i] = segment;
            point.used[i] = strain < 1.0;
            back += usize::from(point.used[i]);
        }
    }
    Ok(back)
}

impl EventTrial<'_> {
    /// The best reading found, with its strain.
    fn revised(&self, segment: &Segment, first: &Segment) -> (Segment, f64) {
        let mut best = segment.clone();
        let mut strain = self.fit(&mut best);
        // The same reading from the first guess: the fit may have gone astray before.
        let mut others = vec![first.clone()];
        // Restitution is told by the bounces, so that it may be off as long as they are
        // misread.
        others.extend(
            RESTITUTION_FACTORS
                .iter()
                .filter_map(|f| self.predicted(first, *f)),
        );
        others.retain(Segment::is_consistent);
        for mut other in others {
            if strain < 1.0 || self.control.cancelled() {
                break;
            }
            let now = self.fit(&mut other);
            if now < MAX_REVISED_MISFIT_RATIO * strain {
                (best, strain) = (other, now);
            }
        }
        for _ in 0..MAX_EVENT_CHANGES {
            if strain < 1.0 || best.joints.len() > MAX_REVISED_JOINTS {
                break;
            }
            let mut found: Option<(Segment, f64)> = None;
            let mut others = alternative_sequences(&best);
            others.extend(self.overlooked(&best));
            others.retain(Segment::is_consistent);
            for mut other in others {
                if self.control.cancelled() {
                    break;
                }
                let now = self.fit(&mut other);
                if now
                    < found
                        .as_ref()
                        .map_or(MAX_REVISED_MISFIT_RATIO * strain, |f| f.1)
                {
                    found = Some((other, now));
                }
            }
            let Some((segment, now)) = found else { break };
            (best, strain) = (segment, now);
        }
        (best, strain)
    }
}
