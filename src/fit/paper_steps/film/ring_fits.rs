//! Fits of the same rings with the film and without, and their starts.

use crate::fit::error::FitError;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::prepare::Prepared;
use crate::fit::solve::levenberg_marquardt::{Clock, Control, Plan, improve};
use crate::fit::solve::point::{Point, settle};
use crate::fit::solve::start_film::{START_GAP_SHARES, weak_film};
use crate::fit::uncertainty::fit_result::{Misfit, misfits};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::SimError;

/// Coordinate of the film's strength at contact.
pub(super) const STRENGTH_COORDINATE: usize = 0;
/// Coordinate of its thickness there.
pub(super) const GAP_COORDINATE: usize = 1;
/// Loss at the start: hardly robust, because everything is far off.
const START_LOSS: Huber = Huber(1e3);
/// Rounds in which each ring's own unknowns are found at first.
const START_SETTLE_ROUNDS: usize = 6;

/// Fits of the same rings, with the film and without.
pub(super) struct RingFits<'a> {
    prepared: &'a Prepared,
    /// Most iterations of each fit.
    iterations: usize,
    control: &'a Control<'a>,
    clock: Clock,
}

impl<'a> RingFits<'a> {
    /// Fits of `prepared` with at most so many iterations each.
    pub(super) fn new(prepared: &'a Prepared, iterations: usize, control: &'a Control<'a>) -> Self {
        let starts = START_GAP_SHARES.len() + 2;
        Self {
            prepared,
            iterations,
            control,
            clock: Clock::new(starts * iterations.min(10)),
        }
    }

    /// The point at unknowns `x`, the rings' initial states fitted from those of `from`.
    pub(super) fn begin(&self, x: &[f64], from: &Point) -> Result<Point, SimError> {
        settle(
            &self.prepared.problem,
            x,
            &from.segments,
            &from.used,
            START_LOSS,
            START_SETTLE_ROUNDS,
        )
    }

    /// The best fit with the film as in `x`, which is to be none.
    pub(super) fn without_film(&mut self, x: &[f64], from: &Point) -> Result<Point, FitError> {
        let bare = Plan {
            stage: "without film",
            iterations: self.iterations,
            locked: &[STRENGTH_COORDINATE, GAP_COORDINATE],
            enough: 1e-6,
        };
        let begun = self.begin(x, from)?;
        let problem = &self.prepared.problem;
        Ok(improve(
            problem,
            begun,
            &bare,
            self.control,
            &mut self.clock,
        )?)
    }

    /// The best of `best` and of the fits from `firsts`, and whether it is one of the latter.
    pub(super) fn best_with_film(
        &mut self,
        firsts: Vec<(Vec<f64>, &Point)>,
        mut best: (Point, Misfit),
    ) -> Result<(Point, Misfit, bool), FitError> {
        let problem = &self.prepared.problem;
        let all = Plan {
            stage: "with film",
            iterations: self.iterations,
            locked: &[],
            enough: 1e-6,
        };
        let mut better = false;
        for (mut there, from) in firsts {
            if self.control.cancelled() {
                break;
            }
            for (x, e) in there.iter_mut().zip(&problem.space.entries) {
                *x = x.clamp(e.low, e.high);
            }
            let begun = self.begin(&there, from)?;
            let point = improve(problem, begun, &all, self.control, &mut self.clock)?;
            let (left, _) = misfits(self.prepared, &point)?;
            if left.rms < best.1.rms {
                best = (point, left);
                better = true;
            }
        }
        Ok((best.0, best.1, better))
    }
}

/// Starts of the fit with film: the model's own film at unknowns `x`, and weak ones of several
/// thicknesses that go on from the fit `without`.
pub(super) fn film_starts<'a>(
    sound: &Model,
    x: &[f64],
    raw: &'a Point,
    without: &'a Point,
) -> Vec<(Vec<f64>, &'a Point)> {
    let mut firsts = vec![(x.to_vec(), raw)];
    let weak = weak_film(sound).ln();
    for share in START_GAP_SHARES {
        let mut there = without.x.clone();
        there[STRENGTH_COORDINATE] = weak;
        there[GAP_COORDINATE] = (share * sound.parameters[ParameterId::Dp]).ln();
        firsts.push((there, without));
    }
    firsts
}
