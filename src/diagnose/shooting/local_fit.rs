//! Fits of a model with effects, started from a fit of a similar model, and its test on the
//! held-out recordings.

use super::clock_skew::{median_skew, set_clocks, shift_skews};
use super::fitted::{Bound, Fitted};
use super::latency::{reading_delay, redistribute_delay, reset_clocks, return_delay_from_clocks};
use super::warm_start::{subset_mask, warm_start};
use super::workspace::{FINE_TOLERANCE, ROUGH_TOLERANCE, Workspace};
use crate::diagnose::data::event_free_segments::prepare_event_free;
use crate::diagnose::data::misread_segments::reassign_misread_segments;
use crate::diagnose::data::robust_loss::{LEAST_SQUARES, ROBUST_LOSS};
use crate::diagnose::data::side::Split;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::thresholds::SKEW_MIN_COST_DROP;
use crate::fit::problem::Problem;
use crate::fit::problem::parameter_space::Space;
use crate::fit::segment::Segment;
use crate::fit::solve::point::settle;
use crate::model::Model;
use crate::sim::StretchSimulator;

/// Number of modes up to which a simulation is quick.
const MAX_MODES_WITHOUT_SUBSET: usize = 2;
/// Number of parameters, besides those of the baseline, up to which an iteration is quick.
const MAX_FREE_WITHOUT_SUBSET: usize = 6;

impl Workspace {
    /// Fits a model with effects to the fitted recordings from `start`. The baseline's free
    /// parameters and those of `free` are moved; those in `bounds` stay within them. `from` is
    /// a fit of a similar model.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn fit(
        &self,
        start: &Model,
        free: &[String],
        bounds: &[Bound],
        from: &Fitted,
        iterations: usize,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        if mode_count(start) != mode_count(&from.model) {
            let sketch = self.fit_subset(start, free, bounds, from, control)?;
            return self.fit_all_from(sketch, iterations, control);
        }
        let (problem, x) = self.pose(start, free, bounds, from)?;
        let own = &from.point;
        let mut point = if mode_count(start) > MAX_MODES_WITHOUT_SUBSET
            || free.len() > MAX_FREE_WITHOUT_SUBSET
        {
            // Fast modes need short time steps, and many unknowns make each iteration
            // slow: most iterations use a subset of the segments.
            let few = subset_of_used(&own.segments, &own.used);
            let start = settle(&problem, &x, &own.segments, &few, ROBUST_LOSS, 2)?;
            let near =
                self.improve(&problem, start, &[], (iterations, ROUGH_TOLERANCE), control)?;
            settle(&problem, &near.x, &own.segments, &own.used, ROBUST_LOSS, 2)?
        } else {
            settle(&problem, &x, &own.segments, &own.used, ROBUST_LOSS, 2)?
        };
        redistribute_delay(&problem, &mut point)?;
        point = self.improve(&problem, point, &[], (iterations, FINE_TOLERANCE), control)?;
        self.finish(problem, point)
    }

    /// The problem of a model with effects, and its unknowns: the parameters at `start`, the
    /// others as in `from`.
    pub(crate) fn pose(
        &self,
        start: &Model,
        free: &[String],
        bounds: &[Bound],
        from: &Fitted,
    ) -> Result<(Problem, Vec<f64>), DiagnoseError> {
        let mut ids = self.free.clone();
        ids.extend_from_slice(free);
        let mut problem = self.train.event_free.prepared.problem.clone();
        problem.space = Space::new(start, &ids)?;
        for (id, bound) in self.bounds.iter().chain(bounds) {
            problem.space.keep_between(id, *bound);
        }
        let mut x = problem.space.coordinates(start);
        x.extend_from_slice(&from.point.x[from.problem.space.len()..]);
        shift_skews(
            &problem,
            &mut x,
            reading_delay(start)? - reading_delay(&from.model)?,
        );
        return_delay_from_clocks(&problem, &mut x);
        Ok((problem, x))
    }

    /// Tests a model on the held-out recordings with its parameters frozen; only clocks,
    /// offsets and initial states are fitted. `None` if there are none. `train` is its fit or
    /// that of a similar model; `from` is the same test of a similar model.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn fit_held_out(
        &self,
        model: &Model,
        (train, from): (&Fitted, Option<&Fitted>),
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Fitted>, DiagnoseError> {
        let Some(side) = &self.held_out else {
            return Ok(None);
        };
        let Some(from) = from else {
            // The clocks start from those of the fitted recordings.
            let clocks = median_skew(&train.problem, &train.point);
            let late = reading_delay(model)? - reading_delay(&train.model)?;
            return Ok(Some(self.fit_states(
                side,
                model,
                clocks + late,
                control,
            )?));
        };
        let mut problem = side.event_free.prepared.problem.clone();
        problem.space = Space::new(model, &self.free)?;
        let mut x = problem.space.coordinates(model);
        x.extend_from_slice(&from.point.x[from.problem.space.len()..]);
        let late = reading_delay(model)? - reading_delay(&from.model)?;
        shift_skews(&problem, &mut x, late);
        let (segments, point) = if mode_count(&from.model) == mode_count(model) {
            let own = &from.point;
            let mut point = settle(&problem, &x, &own.segments, &own.used, ROBUST_LOSS, 2)?;
            if late != 0.0 {
                reset_clocks(&problem, &mut point)?;
            }
            (side.event_free.prepared.segments.clone(), point)
        } else {
            let segments = self.segments_of(side, model, &problem.space)?;
            let used = if from.point.used.len() == segments.len() {
                from.point.used.clone()
            } else {
                vec![true; segments.len()]
            };
            let old = from.problem.simulator(&from.point.x)?;
            let new = StretchSimulator::new(model, &problem.options)?;
            let own = &from.point.segments;
            let segments = warm_start(own, segments, (&old, &new), &problem);
            let point = settle(&problem, &x, &segments, &used, ROBUST_LOSS, 3)?;
            (segments, point)
        };
        let locked: Vec<usize> = (0..problem.space.len()).collect();
        let mut point = self.improve(&problem, point, &locked, (10, FINE_TOLERANCE), control)?;
        // If all jumps lie at the same place between two samples, a clock may be off by a
        // sample. What a clock compensated before may also mislead it.
        let eligible = point.used.clone();
        let worse = point.cost > from.point.cost + SKEW_MIN_COST_DROP;
        if worse && set_clocks(&problem, &mut point, (&segments, &eligible), control)? {
            point = self.improve(&problem, point, &locked, (10, FINE_TOLERANCE), control)?;
        }
        Ok(Some(self.finish(problem, point)?))
    }

    /// A model with its parameters frozen on one side, from nothing known of it: only clocks, which
    /// start at `clocks` \[s\], offsets and initial states are fitted.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn fit_states(
        &self,
        side: &Split,
        model: &Model,
        clocks: f64,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let mut problem = side.event_free.prepared.problem.clone();
        problem.space = Space::new(model, &self.free)?;
        let mut x = problem.space.coordinates(model);
        x.resize(problem.unknowns(), 0.0);
        shift_skews(&problem, &mut x, clocks);
        let segments = self.segments_of(side, model, &problem.space)?;
        let all = vec![true; segments.len()];
        let point = settle(&problem, &x, &segments, &all, LEAST_SQUARES, 3)?;
        let locked: Vec<usize> = (0..problem.space.len()).collect();
        let mut point = self.improve(&problem, point, &locked, (10, FINE_TOLERANCE), control)?;
        // If all jumps lie at the same place between two samples, a clock may be off by a sample.
        if set_clocks(&problem, &mut point, (&segments, &all), control)? {
            point = self.improve(&problem, point, &locked, (10, FINE_TOLERANCE), control)?;
        }
        if !control.cancelled() && reassign_misread_segments(&problem, &mut point, &segments)? {
            point = self.improve(&problem, point, &locked, (5, FINE_TOLERANCE), control)?;
        }
        self.finish(problem, point)
    }

    /// The event-free segments of a side with first guesses by `model`.
    fn segments_of(
        &self,
        side: &Split,
        model: &Model,
        space: &Space,
    ) -> Result<Vec<Segment>, DiagnoseError> {
        let (parts, findings) = (&side.parts, &side.findings);
        let cut = prepare_event_free(model, space, parts, findings, &self.options)?;
        Ok(cut.prepared.segments)
    }
}

/// The segments among `used` that a fit on a subset uses.
pub(crate) fn subset_of_used(segments: &[Segment], used: &[bool]) -> Vec<bool> {
    let few = subset_mask(segments).into_iter();
    few.zip(used).map(|(few, used)| few && *used).collect()
}

/// Number of modes of a model with its effects.
pub fn mode_count(model: &Model) -> usize {
    model.structure_with_effects().modes.len()
}
