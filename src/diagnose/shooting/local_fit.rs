//! A model with effects: fitted from a fit near by, and judged by what was kept out.

use super::clock_skew::{set_clocks, shift_skews, usual_skew};
use super::fitted::{Bound, Fitted};
use super::latency::{delay, rest_clocks, share_delay, weigh_delay};
use super::warm_start::{thinned, warm_start};
use super::workspace::{FINE, LOSS, ROUGH, WIDE, Workspace};
use crate::diagnose::data::event_free_segments::prepare_calm;
use crate::diagnose::data::misread_segments::reassign_misread_segments;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::thresholds::SKEW_MIN_COST_DROP;
use crate::fit::problem::Problem;
use crate::fit::problem::parameter_space::Space;
use crate::fit::segment::Segment;
use crate::fit::solve::point::settle;
use crate::model::Model;
use crate::sim::StretchSimulator;

/// Modes that are simulated quickly.
const QUICK_MODES: usize = 2;
/// Unknowns beside those of the baseline with which a step does not take long.
const FEW: usize = 6;

impl Workspace {
    /// A model with effects, fitted to the fitted recordings from `start`, whose values
    /// for the baseline's freedoms and the ids of `free` are moved; those in `bounds` stay
    /// within them. `from` is a fit of a model near by.
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
        if modes(start) != modes(&from.model) {
            let sketch = self.sketch(start, free, bounds, from, control)?;
            return self.complete(sketch, iterations, control);
        }
        let (problem, x) = self.posed(start, free, bounds, from)?;
        let own = &from.point;
        let mut point = if modes(start) > QUICK_MODES || free.len() > FEW {
            // Fast modes make short steps, many unknowns make each step long: the way is gone
            // on a part of the stretches.
            let few = some_of(&own.segments, &own.used);
            let start = settle(&problem, &x, &own.segments, &few, LOSS, 2)?;
            let near = self.improve(&problem, start, &[], (iterations, ROUGH), control)?;
            settle(&problem, &near.x, &own.segments, &own.used, LOSS, 2)?
        } else {
            settle(&problem, &x, &own.segments, &own.used, LOSS, 2)?
        };
        weigh_delay(&problem, &mut point)?;
        point = self.improve(&problem, point, &[], (iterations, FINE), control)?;
        self.finish(problem, point)
    }

    /// The problem of a model with effects, and its unknowns at `start` and beside that as in
    /// `from`.
    pub(crate) fn posed(
        &self,
        start: &Model,
        free: &[String],
        bounds: &[Bound],
        from: &Fitted,
    ) -> Result<(Problem, Vec<f64>), DiagnoseError> {
        let mut ids = self.free.clone();
        ids.extend_from_slice(free);
        let mut problem = self.train.calm.prepared.problem.clone();
        problem.space = Space::new(start, &ids)?;
        for (id, bound) in self.bounds.iter().chain(bounds) {
            problem.space.keep_between(id, *bound);
        }
        let mut x = problem.space.coordinates(start);
        x.extend_from_slice(&from.point.x[from.problem.space.len()..]);
        shift_skews(&problem, &mut x, delay(start)? - delay(&from.model)?);
        share_delay(&problem, &mut x);
        Ok((problem, x))
    }

    /// A model against the recordings kept out, its parameters frozen; `None` if there are
    /// none. `train` is its fit, or a fit near by; `from` is the judgement of a model near
    /// by.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn judge(
        &self,
        model: &Model,
        (train, from): (&Fitted, Option<&Fitted>),
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Fitted>, DiagnoseError> {
        let Some(side) = &self.held_out else {
            return Ok(None);
        };
        let mut problem = side.calm.prepared.problem.clone();
        problem.space = Space::new(model, &self.free)?;
        let mut x = problem.space.coordinates(model);
        let near = from.filter(|f| modes(&f.model) == modes(model));
        // The clocks are those of the fitted recordings.
        let (clocks, late) = match from {
            Some(from) => (0.0, delay(model)? - delay(&from.model)?),
            None => (
                usual_skew(&train.problem, &train.point),
                delay(model)? - delay(&train.model)?,
            ),
        };
        let (segments, point) = match near {
            Some(from) => {
                x.extend_from_slice(&from.point.x[from.problem.space.len()..]);
                shift_skews(&problem, &mut x, clocks + late);
                let own = &from.point;
                let mut point = settle(&problem, &x, &own.segments, &own.used, LOSS, 2)?;
                if late != 0.0 {
                    rest_clocks(&problem, &mut point)?;
                }
                (side.calm.prepared.segments.clone(), point)
            }
            None => {
                match from {
                    Some(from) => x.extend_from_slice(&from.point.x[from.problem.space.len()..]),
                    None => x.resize(problem.unknowns(), 0.0),
                }
                shift_skews(&problem, &mut x, clocks + late);
                let space = &problem.space;
                let (parts, findings) = (&side.parts, &side.findings);
                let segments = prepare_calm(model, space, parts, findings, &self.options)?
                    .prepared
                    .segments;
                let used = match from {
                    Some(from) if from.point.used.len() == segments.len() => {
                        from.point.used.clone()
                    }
                    _ => vec![true; segments.len()],
                };
                let (segments, loss) = match from {
                    Some(from) => {
                        let old = from.problem.simulator(&from.point.x)?;
                        let new = StretchSimulator::new(model, &problem.options)?;
                        let own = &from.point.segments;
                        (warm_start(own, segments, (&old, &new), &problem), LOSS)
                    }
                    None => (segments, WIDE),
                };
                let point = settle(&problem, &x, &segments, &used, loss, 3)?;
                (segments, point)
            }
        };
        let locked: Vec<usize> = (0..problem.space.len()).collect();
        let mut point = self.improve(&problem, point, &locked, (10, FINE), control)?;
        // Jumps that all lie alike between two samples leave a clock a sample off, and what a
        // clock has made up for before may lead it astray.
        let eligible = if from.is_none() {
            vec![true; segments.len()]
        } else {
            point.used.clone()
        };
        let worse = from.is_none_or(|from| point.cost > from.point.cost + SKEW_MIN_COST_DROP);
        if worse && set_clocks(&problem, &mut point, &segments, &eligible)? {
            point = self.improve(&problem, point, &locked, (10, FINE), control)?;
        }
        if from.is_none() && reassign_misread_segments(&problem, &mut point, &segments)? {
            point = self.improve(&problem, point, &locked, (5, FINE), control)?;
        }
        Ok(Some(self.finish(problem, point)?))
    }
}

/// Those of `used` that are used on the way.
pub(crate) fn some_of(segments: &[Segment], used: &[bool]) -> Vec<bool> {
    let few = thinned(segments).into_iter();
    few.zip(used).map(|(few, used)| few && *used).collect()
}

/// Modes of a model with its effects.
pub fn modes(model: &Model) -> usize {
    model.structure_with_effects().modes.len()
}
