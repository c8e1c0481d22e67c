//! Segments that were set aside as misread: what they cost, and how they are taken in again.

use std::sync::Arc;

use rayon::prelude::*;

use super::fitted::Fitted;
use super::workspace::{FINE_TOLERANCE, Workspace};
use crate::diagnose::data::misread_segments::{initial_guess, reassign_misread_segments};
use crate::diagnose::data::robust_loss::{LEAST_SQUARES, MAX_RESIDUAL, ROBUST_LOSS};
use crate::diagnose::data::side::Split;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::thresholds::LOST_TRACK_CHI2;
use crate::fit::problem::Problem;
use crate::fit::segment::Segment;
use crate::fit::solve::point::{Point, residuals_at, settle};
use crate::sim::SimError;

/// Iterations of each segment's own fit, by either loss.
const LOCAL_FIT_STEPS: usize = 8;

impl Fitted {
    /// Share of the rows that lie in segments set aside.
    pub fn set_aside_share(&self) -> f64 {
        let rows = |used: bool| -> usize {
            let all = self.point.segments.iter().zip(&self.point.used);
            all.filter(|(_, u)| **u == used)
                .map(|(s, _)| self.problem.rows(s).len())
                .sum()
        };
        let (used, aside) = (rows(true), rows(false));
        aside as f64 / (used + aside).max(1) as f64
    }

    /// Number of values and chi2 per value of each segment that is used, residuals clipped at
    /// [`MAX_RESIDUAL`]; `None` for the others.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub(crate) fn segment_chi2(&self) -> Result<Vec<Option<(usize, f64)>>, SimError> {
        let used = &self.point.used;
        let all = residuals_at(&self.problem, &self.point, |i, _| used[i])?;
        let mean = |r: Vec<f64>| {
            let squares = r
                .iter()
                .map(|r| r.clamp(-MAX_RESIDUAL, MAX_RESIDUAL).powi(2));
            (r.len(), squares.sum::<f64>() / r.len().max(1) as f64)
        };
        Ok(all.into_iter().map(|r| r.map(mean)).collect())
    }

    /// The cost including segments set aside, each fitted as well as possible from its guess
    /// in `first`, so that fits that set other segments aside can be compared.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn cost_with_set_aside(&self, first: &[Segment]) -> Result<f64, DiagnoseError> {
        let (problem, point) = (&self.problem, &self.point);
        let simulator = problem.simulator(&point.x)?;
        let states = problem.states(&point.x, &simulator, &point.segments);
        let aside: Vec<f64> = (0..point.segments.len())
            .into_par_iter()
            .filter(|&i| !point.used[i])
            .map(|i| {
                let segment = &point.segments[i];
                let nuisances = problem.nuisances_of(&point.x, segment.recording);
                let fit = |locals: Vec<f64>, loss| {
                    let (near, state) = (&nuisances, &states[i]);
                    problem.refine(
                        segment,
                        state,
                        &simulator,
                        near,
                        locals,
                        loss,
                        LOCAL_FIT_STEPS,
                    )
                };
                let near = fit(initial_guess(&first[i], segment).to_vec(), LEAST_SQUARES);
                fit(near.locals, ROBUST_LOSS).cost + segment.locals.len() as f64
            })
            .collect();
        Ok(self.cost + aside.iter().filter(|c| c.is_finite()).sum::<f64>())
    }
}

/// `point` with the `others` among its segments taken in too, each from its guess in `first`.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub(crate) fn include_segments(
    problem: &Problem,
    point: Point,
    first: &[Segment],
    others: &[bool],
    rounds: usize,
) -> Result<Point, SimError> {
    let guessed = settle(problem, &point.x, first, others, LEAST_SQUARES, rounds)?;
    let (mut segments, mut used) = (point.segments, point.used);
    for i in (0..others.len()).filter(|&i| others[i]) {
        segments[i] = guessed.segments[i].clone();
        used[i] = true;
    }
    settle(problem, &point.x, &segments, &used, ROBUST_LOSS, 2)
}

impl Workspace {
    /// A fit of `side` with all segments taken in, those set aside from their first guess,
    /// everything else unchanged.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn with_all_segments(
        &self,
        side: &Split,
        fitted: &Fitted,
    ) -> Result<Fitted, DiagnoseError> {
        let aside: Vec<bool> = fitted.point.used.iter().map(|used| !used).collect();
        self.with_segments(side, fitted, &aside)
    }

    /// A fit of `side` with the segments `more` taken in too, each from its first guess.
    fn with_segments(
        &self,
        side: &Split,
        fitted: &Fitted,
        more: &[bool],
    ) -> Result<Fitted, DiagnoseError> {
        let (problem, point) = (&fitted.problem, fitted.point.clone());
        let point = include_segments(problem, point, side.segments(), more, LOCAL_FIT_STEPS)?;
        self.finish(problem.clone(), point)
    }

    /// Two fits of `side` on the segments that either describes well or both use, so that
    /// their residuals can be compared. Segments that one set aside and the other is far from
    /// were misread for both.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub fn on_common_segments(
        &self,
        side: &Split,
        fits: [&Fitted; 2],
    ) -> Result<[Fitted; 2], DiagnoseError> {
        let [a, b] = fits.map(|fitted| &fitted.point.used);
        if a == b || a.len() != b.len() || a.len() != side.segments().len() {
            return Ok(fits.map(Fitted::clone));
        }
        let means = [fits[0].segment_chi2()?, fits[1].segment_chi2()?];
        let is_described = |i: usize| {
            means
                .iter()
                .any(|m| m[i].is_some_and(|(_, m)| m < LOST_TRACK_CHI2))
        };
        let shown: Vec<bool> = (0..a.len())
            .map(|i| is_described(i) || a[i] && b[i])
            .collect();
        let of = |fitted: &Fitted| {
            let own = fitted.point.used.iter().zip(&shown);
            let more: Vec<bool> = own.map(|(own, shown)| *shown && !own).collect();
            let mut fewer = fitted.clone();
            fewer.jacobians = Arc::default();
            for (used, shown) in fewer.point.used.iter_mut().zip(&shown) {
                *used &= shown;
            }
            self.with_segments(side, &fewer, &more)
        };
        Ok([of(fits[0])?, of(fits[1])?])
    }

    /// A fit of `side` without the segments misread for its model. Parameters are frozen if
    /// the side `is_held_out`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn without_misread(
        &self,
        side: &Split,
        fitted: Fitted,
        is_held_out: bool,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let Fitted {
            problem, mut point, ..
        } = fitted;
        let may_go_on = !control.cancelled();
        if may_go_on && reassign_misread_segments(&problem, &mut point, side.segments())? {
            let frozen = if is_held_out { problem.space.len() } else { 0 };
            let locked: Vec<usize> = (0..frozen).collect();
            point = self.improve(&problem, point, &locked, (10, FINE_TOLERANCE), control)?;
        }
        self.finish(problem, point)
    }
}
