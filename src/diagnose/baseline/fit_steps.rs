//! TODO-doc

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

/// What is not moved at first.
const INITIALLY_LOCKED: [&str; 8] = [
    "Cs", "gp", "f1", "f2", "zeta2", "shape_c2", "shape_p2", "drive_p",
];
/// What shapes the loops of the drive: it runs off where their size is not known yet.
const HYSTERESIS_SHAPE: [&str; 5] = [
    "hysteresis_memory.q",
    "hysteresis_memory.k",
    "hysteresis_memory.b2",
    "hysteresis_memory.b4",
    "hysteresis_memory.v_past",
];
/// Steps of each stretch's own fit from its first guess.
const LOCAL_FIT_STEPS: usize = 3;

/// A problem with where a fit of it stands.
pub(super) type Start = (Problem, Point);

impl Workspace {
    /// The first step of a fit of `start` to the `subset` stretches: sizes, and what damps
    /// the slow motion.
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
            locked.extend(positions(&problem, &HYSTERESIS_SHAPE));
            locked.extend(self.fixed_by_level(&problem));
            point = self.improve(&problem, point, &locked, (7, ROUGH_TOLERANCE), control)?;
            reassign_misread_segments(&problem, &mut point, segments)?;
        }
        Ok((problem, point))
    }

    /// Goes on with all but the film's thickness.
    pub(super) fn release_parameters(
        &self,
        problem: &Problem,
        mut point: Point,
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Point, DiagnoseError> {
        let segments = &self.train.event_free.prepared.segments;
        // What acts most comes first: frequencies and dampings of motions that are far off
        // in size would go astray.
        let late: [&[&str]; 2] = [&["Cs", "gp", "shape_p2"], &["gp"]];
        for ids in late {
            let mut locked = positions(problem, ids);
            if locked.len() == problem.space.len() {
                continue;
            }
            if ids.len() > 2 {
                locked.extend(skew_indices(problem));
            }
            locked.extend(positions(problem, &HYSTERESIS_SHAPE));
            locked.extend(self.fixed_by_level(problem));
            point = self.improve(problem, point, &locked, (7, ROUGH_TOLERANCE), control)?;
            set_clocks(problem, &mut point, segments, subset)?;
            if reassign_misread_segments(problem, &mut point, segments)? {
                // What was set aside must not count any more.
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

    /// Positions of what the recordings say by themselves better than a fit that is far off.
    fn fixed_by_level(&self, problem: &Problem) -> Vec<usize> {
        let ids = self.train.drift.iter().flat_map(|(_, ids)| ids);
        positions(problem, &ids.map(String::as_str).collect::<Vec<_>>())
    }

    /// Goes on with all stretches where a fit was to the `subset` only.
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
        reassign_misread_segments(&problem, &mut point, segments)?;
        point = self.improve(&problem, point, &[], (20, FINE_TOLERANCE), control)?;
        if set_clocks(&problem, &mut point, segments, &vec![true; subset.len()])? {
            point = self.improve(&problem, point, &[], (10, FINE_TOLERANCE), control)?;
        }
        if reassign_misread_segments(&problem, &mut point, segments)? {
            point = self.improve(&problem, point, &[], (10, FINE_TOLERANCE), control)?;
        }
        self.finish(problem, point)
    }
}

/// Cost per value of the segments that are used.
pub(super) fn chi2_per_value(point: &Point) -> f64 {
    point.cost / point.rows.max(1) as f64
}

/// Cost per value of the `subset` stretches, those set aside included.
pub(super) fn subset_chi2(problem: &Problem, point: &Point, subset: &[bool]) -> f64 {
    let subset = point.segments.iter().zip(subset).filter(|(_, f)| **f);
    let rows: usize = subset.map(|(s, _)| problem.rows(s).len()).sum();
    let aside = rows.saturating_sub(point.rows);
    (point.cost + MISREAD_CHI2 * aside as f64) / rows.max(1) as f64
}
