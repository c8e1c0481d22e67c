//! The steps of a cold start of the baseline: parameters are released in stages on a subset of the
//! segments, then all segments are fitted.

use crate::diagnose::data::misread_segments::reassign_misread_segments;
use crate::diagnose::data::robust_loss::{LEAST_SQUARES, MISREAD_CHI2, ROBUST_LOSS};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::clock_skew::{set_clocks, skew_indices};
use crate::diagnose::shooting::fitted::{Bound, Fitted};
use crate::diagnose::shooting::set_aside::include_segments;
use crate::diagnose::shooting::workspace::{FINE_TOLERANCE, ROUGH_TOLERANCE, Workspace, positions};
use crate::fit::problem::Problem;
use crate::fit::problem::parameter_space::Space;
use crate::fit::solve::point::{Point, settle};
use crate::model::Model;
use crate::model::effects::CATALOGUE;

/// Ids of parameters that the first step does not move.
const INITIALLY_LOCKED: [&str; 8] = [
    "Cs", "gp", "f1", "f2", "zeta2", "shape_c2", "shape_p2", "drive_p",
];
/// Iterations of each segment's own fit from its first guess.
const LOCAL_FIT_STEPS: usize = 3;

/// A problem and the point that a fit of it has reached.
pub(super) type Start = (Problem, Point);

impl Workspace {
    /// The first step of a fit of `start` to the `subset` of segments: sizes, and the damping
    /// of the slow motion.
    pub(super) fn first_step(
        &self,
        start: &Model,
        (free, bounds): (&[String], &[Bound]),
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<(Problem, Point), DiagnoseError> {
        let segments = &self.train.event_free.prepared.segments;
        let mut problem = self.train.event_free.prepared.problem.clone();
        let mut ids = self.free.clone();
        ids.extend_from_slice(free);
        problem.space = Space::new(start, &ids)?;
        for (id, range) in self.bounds.iter().chain(bounds) {
            problem.space.keep_between(id, *range);
        }
        let mut x = problem.space.coordinates(start);
        x.resize(problem.unknowns(), 0.0);
        let mut point = settle(&problem, &x, segments, subset, LEAST_SQUARES, 3)?;
        let mut locked = positions(&problem, &INITIALLY_LOCKED);
        if locked.len() < problem.space.len() {
            locked.extend(skew_indices(&problem));
            locked.extend(deferred_indices(&problem));
            locked.extend(self.fixed_by_level(&problem));
            point = self.improve(&problem, point, &locked, (7, ROUGH_TOLERANCE), control)?;
            if !control.cancelled() {
                reassign_misread_segments(&problem, &mut point, segments)?;
            }
        }
        Ok((problem, point))
    }

    /// Releases all parameters but the film's thickness.
    pub(super) fn release_parameters(
        &self,
        problem: &Problem,
        mut point: Point,
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Point, DiagnoseError> {
        let segments = &self.train.event_free.prepared.segments;
        // The strongest influences come first: frequencies and dampings of motions whose
        // size is far off would go astray.
        let late: [&[&str]; 2] = [&["Cs", "gp", "shape_p2"], &["gp"]];
        for ids in late {
            let mut locked = positions(problem, ids);
            if locked.len() == problem.space.len() || control.cancelled() {
                continue;
            }
            if ids.len() > 2 {
                locked.extend(skew_indices(problem));
            }
            locked.extend(deferred_indices(problem));
            locked.extend(self.fixed_by_level(problem));
            point = self.improve(problem, point, &locked, (7, ROUGH_TOLERANCE), control)?;
            set_clocks(problem, &mut point, (segments, subset), control)?;
            if !control.cancelled() && reassign_misread_segments(problem, &mut point, segments)? {
                // Segments set aside no longer count.
                point = settle(
                    problem,
                    &point.x,
                    &point.segments,
                    &point.used,
                    ROBUST_LOSS,
                    1,
                )?;
            }
        }
        Ok(point)
    }

    /// Positions of the parameters that the level of the ground determines better than a fit
    /// that is far off.
    fn fixed_by_level(&self, problem: &Problem) -> Vec<usize> {
        let ids = self.train.drift.iter().flat_map(|(_, ids)| ids);
        positions(problem, &ids.map(String::as_str).collect::<Vec<_>>())
    }

    /// Goes on with all segments after a fit to the `subset`.
    pub(super) fn fit_all_segments(
        &self,
        problem: Problem,
        point: Point,
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let segments = &self.train.event_free.prepared.segments;
        let others: Vec<bool> = subset.iter().map(|f| !f).collect();
        let mut point = include_segments(&problem, point, segments, &others, LOCAL_FIT_STEPS)?;
        if control.cancelled() {
            return self.finish(problem, point);
        }
        reassign_misread_segments(&problem, &mut point, segments)?;
        point = self.improve(&problem, point, &[], (20, FINE_TOLERANCE), control)?;
        let all = vec![true; subset.len()];
        if set_clocks(&problem, &mut point, (segments, &all), control)? {
            point = self.improve(&problem, point, &[], (10, FINE_TOLERANCE), control)?;
        }
        if !control.cancelled() && reassign_misread_segments(&problem, &mut point, segments)? {
            point = self.improve(&problem, point, &[], (10, FINE_TOLERANCE), control)?;
        }
        self.finish(problem, point)
    }
}

/// Indices of the parameters of effects that run away while the size of their effect is unknown,
/// such as those that shape the loops of the drive.
fn deferred_indices(problem: &Problem) -> Vec<usize> {
    let ids = CATALOGUE.iter().flat_map(|effect| {
        let own = effect.search.deferred.iter();
        own.map(move |parameter| format!("{}.{parameter}", effect.id))
    });
    ids.filter_map(|id| problem.space.position(&id)).collect()
}

/// Cost per value of the segments that are used.
pub(super) fn chi2_per_value(point: &Point) -> f64 {
    point.cost / point.rows.max(1) as f64
}

/// Cost per value of the `subset` of segments, those set aside included at [`MISREAD_CHI2`] per
/// row.
pub(super) fn subset_chi2(problem: &Problem, point: &Point, subset: &[bool]) -> f64 {
    let subset = point.segments.iter().zip(subset).filter(|(_, f)| **f);
    let rows: usize = subset.map(|(s, _)| problem.rows(s).len()).sum();
    let aside = rows.saturating_sub(point.rows);
    (point.cost + MISREAD_CHI2 * aside as f64) / rows.max(1) as f64
}
