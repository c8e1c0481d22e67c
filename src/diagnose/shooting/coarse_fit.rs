//! The first part of a fit with other modes than before: its own constants find their place on
//! a part of the stretches, before all of them are taken up.

use super::clock_skew::set_clocks;
use super::fitted::{Bound, Fitted};
use super::local_fit::some_of;
use super::warm_start::warm_start;
use super::workspace::{FINE, LOSS, ROUGH, Workspace};
use crate::diagnose::data::event_free_segments::prepare_calm;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::thresholds::SUBSET_ABORT_RATIO;
use crate::fit::problem::Problem;
use crate::fit::segment::Segment;
use crate::fit::solve::point::{Point, settle};
use crate::model::Model;
use crate::sim::StretchSimulator;

/// A fit on a part of the stretches.
#[derive(Debug)]
pub struct SubsetFit {
    problem: Problem,
    near: Point,
    /// All stretches, those of the part as they were.
    segments: Vec<Segment>,
    used: Vec<bool>,
    few: Vec<bool>,
}

impl SubsetFit {
    /// Chi2 on that part, the same for all fits that begin from one.
    pub fn cost(&self) -> f64 {
        self.near.cost
    }

    /// Chi2 per value on that part.
    pub fn per_value(&self) -> f64 {
        self.near.cost / self.near.rows.max(1) as f64
    }

    /// Whether that part is so far off beside `fitted` that all stretches need not be asked.
    pub fn is_lost_beside(&self, fitted: &Fitted) -> bool {
        let lost = self.per_value() > SUBSET_ABORT_RATIO * fitted.per_value();
        if lost {
            log::debug!("{:.1} per value on a part", self.per_value());
        }
        lost
    }
}

impl Workspace {
    /// Begins a fit of a model whose modes need not be those of `from`; see [`Workspace::fit`].
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn sketch(
        &self,
        start: &Model,
        free: &[String],
        bounds: &[Bound],
        from: &Fitted,
        control: &DiagnoseControl<'_>,
    ) -> Result<SubsetFit, DiagnoseError> {
        let (problem, x) = self.posed(start, free, bounds, from)?;
        let (side, space) = (&self.train, &problem.space);
        let calm = prepare_calm(start, space, &side.parts, &side.findings, &self.options)?;
        let segments = calm.prepared.segments;
        // The same stretches, with more unknowns each: what was misread stays aside.
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
        let few = some_of(&segments, &used);
        let begun = settle(&problem, &x, &segments, &few, LOSS, 3)?;
        let known: Vec<usize> = (0..self.free.len()).collect();
        let near = self.improve(&problem, begun, &known, (12, ROUGH), control)?;
        let near = self.improve(&problem, near, &[], (6, ROUGH), control)?;
        Ok(SubsetFit {
            problem,
            near,
            segments,
            used,
            few,
        })
    }

    /// Goes on with all stretches.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn complete(
        &self,
        sketch: SubsetFit,
        iterations: usize,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let (problem, near) = (sketch.problem, sketch.near);
        let mut all = sketch.segments;
        for i in (0..all.len()).filter(|&i| sketch.few[i]) {
            all[i] = near.segments[i].clone();
        }
        let mut point = settle(&problem, &near.x, &all, &sketch.used, LOSS, 3)?;
        // A mode that was missing, or one too many, may have led a clock astray by samples.
        set_clocks(&problem, &mut point, &all, &sketch.used)?;
        let point = self.improve(&problem, point, &[], (iterations, FINE), control)?;
        self.finish(problem, point)
    }
}
