//! The first part of a fit with other modes than before: it settles on a subset of the segments
//! before all of them are taken in.

use super::clock_skew::set_clocks;
use super::fitted::{Bound, Fitted};
use super::local_fit::subset_of_used;
use super::warm_start::warm_start;
use super::workspace::{FINE_TOLERANCE, ROUGH_TOLERANCE, Workspace};
use crate::diagnose::data::event_free_segments::prepare_event_free;
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::thresholds::SUBSET_ABORT_RATIO;
use crate::fit::problem::Problem;
use crate::fit::segment::Segment;
use crate::fit::solve::point::{Point, settle};
use crate::model::Model;
use crate::sim::StretchSimulator;

/// A fit to a subset of the segments.
#[derive(Debug)]
pub struct SubsetFit {
    problem: Problem,
    point: Point,
    /// All segments; those of the subset as they were.
    segments: Vec<Segment>,
    used: Vec<bool>,
    subset: Vec<bool>,
}

impl SubsetFit {
    /// Chi2 on the subset, which is the same for all fits begun from one.
    pub fn cost(&self) -> f64 {
        self.point.cost
    }

    /// Chi2 per value on the subset.
    pub fn per_value(&self) -> f64 {
        self.point.cost / self.point.rows.max(1) as f64
    }

    /// Whether the subset is so far off compared to `fitted` that a fit to all segments is
    /// pointless.
    pub fn is_lost_compared_to(&self, fitted: &Fitted) -> bool {
        let lost = self.per_value() > SUBSET_ABORT_RATIO * fitted.per_value();
        if lost {
            log::debug!("{:.1} per value on a part", self.per_value());
        }
        lost
    }
}

impl Workspace {
    /// Begins a fit of a model that may have other modes than `from`; see [`Workspace::fit`].
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn fit_subset(
        &self,
        start: &Model,
        free: &[String],
        bounds: &[Bound],
        from: &Fitted,
        control: &DiagnoseControl<'_>,
    ) -> Result<SubsetFit, DiagnoseError> {
        let (problem, x) = self.pose(start, free, bounds, from)?;
        let (side, space) = (&self.train, &problem.space);
        let event_free =
            prepare_event_free(start, space, &side.parts, &side.findings, &self.options)?;
        let segments = event_free.prepared.segments;
        // The same segments with more unknowns each: misread ones stay set aside.
        let used = if segments.len() == from.point.used.len() {
            from.point.used.clone()
        } else {
            vec![true; segments.len()]
        };
        let (old, new) = (
            from.problem.simulator(&from.point.x)?,
            StretchSimulator::new(start, &problem.options)?,
        );
        let segments = warm_start(&from.point.segments, segments, (&old, &new), &problem);
        let subset = subset_of_used(&segments, &used);
        let begun = settle(&problem, &x, &segments, &subset, ROBUST_LOSS, 3)?;
        let known: Vec<usize> = (0..self.free.len()).collect();
        let near = self.improve(&problem, begun, &known, (12, ROUGH_TOLERANCE), control)?;
        let near = self.improve(&problem, near, &[], (6, ROUGH_TOLERANCE), control)?;
        Ok(SubsetFit {
            problem,
            point: near,
            segments,
            used,
            subset,
        })
    }

    /// Goes on with all segments.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn fit_all_from(
        &self,
        subset_fit: SubsetFit,
        iterations: usize,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let (problem, near) = (subset_fit.problem, subset_fit.point);
        let mut all = subset_fit.segments;
        for i in (0..all.len()).filter(|&i| subset_fit.subset[i]) {
            all[i] = near.segments[i].clone();
        }
        let mut point = settle(&problem, &near.x, &all, &subset_fit.used, ROBUST_LOSS, 3)?;
        // A missing or superfluous mode may have shifted a clock by samples.
        set_clocks(&problem, &mut point, (&all, &subset_fit.used), control)?;
        let point = self.improve(&problem, point, &[], (iterations, FINE_TOLERANCE), control)?;
        self.finish(problem, point)
    }
}
