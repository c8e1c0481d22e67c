//! Stretches that were set aside as misread: what they cost, and their way back.

use rayon::prelude::*;

use super::{Bench, FINE, Fitted, LOSS, Side};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::stretches::heal;
use crate::fit::robust::Huber;
use crate::fit::segment::Segment;
use crate::fit::solve::settle;

/// A loss that forgives nothing.
const WIDE: Huber = Huber(1e4);
/// Steps of each stretch's own fit, by either loss.
const ROUNDS: usize = 8;

impl Fitted {
    /// Share of the rows that lie in stretches set aside.
    pub fn aside(&self) -> f64 {
        let rows = |used: bool| -> usize {
            let all = self.point.segments.iter().zip(&self.point.used);
            all.filter(|(_, u)| **u == used)
                .map(|(s, _)| self.problem.rows(s).len())
                .sum()
        };
        let (used, aside) = (rows(true), rows(false));
        aside as f64 / (used + aside).max(1) as f64
    }

    /// The cost with that of the stretches set aside, each told as well as it can be from
    /// its guess in `first`: so that fits that set other stretches aside can be compared.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn whole_cost(&self, first: &[Segment]) -> Result<f64, DiagnoseError> {
        let (problem, point) = (&self.problem, &self.point);
        let simulator = problem.simulator(&point.x)?;
        let states = problem.states(&simulator, &point.segments);
        let aside: Vec<f64> = (0..point.segments.len())
            .into_par_iter()
            .filter(|&i| !point.used[i])
            .map(|i| {
                let segment = &point.segments[i];
                let nuisances = problem.nuisances_of(&point.x, segment.recording);
                let fit = |locals: Vec<f64>, loss| {
                    let (near, state) = (&nuisances, &states[i]);
                    problem.refine(segment, state, &simulator, near, locals, loss, ROUNDS)
                };
                let guess = first
                    .get(i)
                    .filter(|f| f.locals.len() == segment.locals.len());
                let guess = guess.map_or_else(|| segment.locals.clone(), |f| f.locals.clone());
                let (near, _) = fit(guess, WIDE);
                fit(near, LOSS).1 + segment.locals.len() as f64
            })
            .collect();
        Ok(self.cost + aside.iter().filter(|c| c.is_finite()).sum::<f64>())
    }
}

impl Bench {
    /// A fit of `side` with all stretches in it, those set aside from their first guess, and
    /// all else as it was.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn with_all(&self, side: &Side, fitted: &Fitted) -> Result<Fitted, DiagnoseError> {
        let point = &fitted.point;
        let first = side.segments();
        let aside: Vec<bool> = point.used.iter().map(|used| !used).collect();
        let guessed = settle(&fitted.problem, &point.x, first, &aside, WIDE, ROUNDS)?;
        let mut segments = point.segments.clone();
        for i in (0..segments.len()).filter(|&i| aside[i]) {
            segments[i] = guessed.segments[i].clone();
        }
        let all = vec![true; segments.len()];
        let point = settle(&fitted.problem, &point.x, &segments, &all, LOSS, 2)?;
        self.finish(fitted.problem.clone(), point)
    }

    /// A fit of `side` without what is misread for its model; its parameters are frozen if it
    /// was `kept_out`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn healed(
        &self,
        side: &Side,
        fitted: Fitted,
        kept_out: bool,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let Fitted {
            problem, mut point, ..
        } = fitted;
        if heal(&problem, &mut point, side.segments())? {
            let frozen = if kept_out { problem.space.len() } else { 0 };
            let locked: Vec<usize> = (0..frozen).collect();
            point = self.improve(&problem, point, &locked, (10, FINE), control)?;
        }
        self.finish(problem, point)
    }
}
