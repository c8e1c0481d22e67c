//! Forward selection by held-out recordings: the effect with the largest gain is added, its
//! parameters are refined together with all that is known, and the search goes on.

use super::least_squares::gram::Solution;
use super::regression::{
    FittedEffect, Knowledge, Regression, Runs, clock_skews, regression, weigh_rows,
};
use crate::diagnose::score_test::forms::CatalogueDirection;
use crate::diagnose::thresholds::{FORCE_BALANCE_HELD_GAIN, FORCE_BALANCE_TRAIN_GAIN};
use crate::model::effects::ActiveEffect;
use crate::sim::SimError;

/// Most steps in which the parameters of an effect are refined.
const MAX_REFINEMENTS: usize = 8;
/// Largest factor by which a step of the refinement may change a parameter.
const MAX_STEP_FACTOR: f64 = 2.5;
/// Relative fall of chi2 below which a refinement has come to its end.
const REFINED_SHARE: f64 = 1e-4;
/// Times that the structure and the noise that follows from it are brought up to date.
const STRUCTURE_UPDATES: usize = 2;

/// Times that the clocks of the recordings are brought up to date: how a jump acts is linear in its
/// instant for small steps of that only.
const CLOCK_UPDATES: usize = 2;

/// Limits of the misfits of rows in turn, in typical ones: the first ones bring the fit near most rows,
/// the last one decides what is far off.
const ROW_LIMITS: [f64; 5] = [1.5, 1.5, 1.5, 3.0, 8.0];

/// Chi2 of both splits at a state of knowledge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BalanceChi2 {
    /// Of the fitted recordings.
    pub train: f64,
    /// Equations of them, less their own unknowns.
    pub train_freedom: f64,
    /// Of the held-out ones; 0 without any.
    pub held_out: f64,
    /// See `train_freedom`.
    pub held_out_freedom: f64,
}

impl BalanceChi2 {
    /// Chi2 per equation of the fitted recordings.
    pub fn train_per_row(&self) -> f64 {
        self.train / self.train_freedom.max(1.0)
    }

    /// Chi2 per equation of the held-out recordings; not a number without any.
    pub fn held_out_per_row(&self) -> f64 {
        if self.held_out_freedom > 0.0 {
            self.held_out / self.held_out_freedom
        } else {
            f64::NAN
        }
    }
}

/// What an effect would bring at one choice of its constants.
#[derive(Debug, Clone, PartialEq)]
pub struct BalanceGain {
    /// Which form.
    pub form: usize,
    /// Its strength, in units of the form's.
    pub theta: f64,
    /// Falls of chi2 on fitted and held-out recordings.
    pub gain: (f64, f64),
    /// Chi2 per equation of the held-out recordings with it.
    pub held_out_per_row: f64,
}

/// The balance over both splits.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Fitted recordings.
    pub train: Runs,
    /// Held-out ones; may be empty.
    pub held_out: Runs,
}

/// A regression of both splits, with the solution of the known columns.
pub struct Solved {
    /// Fitted recordings.
    pub train: Regression,
    /// Held-out ones.
    pub held_out: Regression,
    /// The known columns' coefficients.
    pub solution: Solution,
}

impl Solved {
    /// Chi2 of both splits.
    pub fn chi2(&self) -> BalanceChi2 {
        BalanceChi2 {
            train: self.solution.chi2,
            train_freedom: self.train.total.freedom - self.solution.rank as f64,
            held_out: self.held_out.total.chi2_at(&self.solution),
            held_out_freedom: self.held_out.total.freedom,
        }
    }
}

impl Balance {
    /// The regression with `asked`, and the solution without.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn solve(&self, known: &Knowledge, asked: &[ActiveEffect]) -> Result<Solved, SimError> {
        let train = regression(&self.train, known, asked)?;
        let held_out = regression(&self.held_out, known, asked)?;
        let columns: Vec<usize> = (0..train.known).collect();
        let solution = train.total.solve(&columns);
        let mut held_out = held_out;
        if self.held_out.runs.is_empty() {
            held_out.total = super::least_squares::gram::Gram::new(train.total.slopes.len());
        }
        Ok(Solved {
            train,
            held_out,
            solution,
        })
    }

    /// Brings structure and noise up to date.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn settle(&self, known: &mut Knowledge) -> Result<Solved, SimError> {
        for _ in 0..STRUCTURE_UPDATES {
            let solved = self.solve(known, &[])?;
            known.adopt(&solved.solution);
        }
        self.solve(known, &[])
    }

    /// Brings the clocks of all recordings up to date, too.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn settle_clocks(&mut self, known: &mut Knowledge) -> Result<Solved, SimError> {
        let first = known.clone();
        for (k, limit) in ROW_LIMITS.into_iter().enumerate() {
            let limit = (limit, k + 1 == ROW_LIMITS.len());
            let solved = self.settle(known)?;
            for side in [&mut self.train, &mut self.held_out] {
                weigh_rows(side, known, &solved.solution, limit)?;
            }
            known.clone_from(&first);
        }
        for _ in 0..CLOCK_UPDATES {
            let solved = self.settle(known)?;
            for side in [&mut self.train, &mut self.held_out] {
                let later = clock_skews(side, known, &solved.solution)?;
                side.delay_drives(&later);
            }
        }
        self.settle(known)
    }

    /// What each of `forms` would bring, best first.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn gains(
        &self,
        known: &Knowledge,
        forms: &[CatalogueDirection],
    ) -> Result<Vec<BalanceGain>, SimError> {
        let asked: Vec<ActiveEffect> = forms.iter().map(|f| f.effect(1.0)).collect();
        let solved = self.solve(known, &asked)?;
        let before = solved.chi2();
        let mut out = Vec::new();
        for (k, form) in forms.iter().enumerate() {
            let mut columns: Vec<usize> = (0..solved.train.known).collect();
            columns.push(solved.train.known + k);
            let with = solved.train.total.solve(&columns);
            let theta = with.values[solved.train.known];
            let fits_sign = form.signed || theta > 0.0;
            if !fits_sign || theta == 0.0 {
                continue;
            }
            let held = solved.held_out.total.chi2_at(&with);
            out.push(BalanceGain {
                form: k,
                theta,
                gain: (before.train - with.chi2, before.held_out - held),
                held_out_per_row: held / before.held_out_freedom,
            });
        }
        out.sort_by(|a, b| b.total().total_cmp(&a.total()));
        Ok(out)
    }

    /// Refines the parameters of the known effects together with everything else.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn refine(&self, known: &mut Knowledge) -> Result<Solved, SimError> {
        let mut solved = self.settle(known)?;
        for _ in 0..MAX_REFINEMENTS {
            let Some(step) = parameter_steps(known, &solved) else {
                break;
            };
            let mut share = 1.0;
            let mut better = None;
            while share > 0.05 {
                let mut trial = known.clone();
                move_parameters(&mut trial, &step, share);
                let next = self.solve(&trial, &[]);
                if let Ok(next) = next
                    && next.solution.chi2 < solved.solution.chi2
                {
                    better = Some((trial, next));
                    break;
                }
                share *= 0.3;
            }
            let Some((trial, next)) = better else {
                break;
            };
            let fall = 1.0 - next.solution.chi2 / solved.solution.chi2;
            *known = trial;
            known.adopt(&next.solution);
            solved = self.solve(known, &[])?;
            if fall < REFINED_SHARE {
                break;
            }
        }
        Ok(solved)
    }
}

impl BalanceGain {
    /// Gain by which effects are ranked: both splits count.
    pub fn total(&self) -> f64 {
        self.gain.0 + self.gain.1
    }
}

/// Whether falls of chi2 are beyond chance on both splits, where `excess` remains a row: what is off by
/// more than its noise in each row is off by chance as much more.
pub fn is_significant(gain: (f64, f64), excess: (f64, f64), has_held_out: bool) -> bool {
    let train = gain.0 / excess.0.max(1.0) > FORCE_BALANCE_TRAIN_GAIN;
    let held = gain.1 / excess.1.max(1.0) > FORCE_BALANCE_HELD_GAIN;
    train && (held || !has_held_out)
}

/// Changes of all fitted parameters that the solution calls for; `None` if there are none.
fn parameter_steps(known: &Knowledge, solved: &Solved) -> Option<Vec<f64>> {
    let count: usize = known.effects.iter().map(|e| e.free.len()).sum();
    let first = known.first_parameter();
    let steps = solved.solution.values.rows(first, count);
    (count > 0).then(|| steps.iter().copied().collect())
}

/// Standard errors of the fitted parameters, in the order of effects and of their parameters.
pub fn parameter_errors(known: &Knowledge, solved: &Solved) -> Vec<Vec<f64>> {
    let mut at = known.first_parameter();
    let effects = known.effects.iter().map(|e| {
        let own = e.free.iter().map(|_| {
            let error = solved.solution.covariance[(at, at)].sqrt();
            at += 1;
            error
        });
        own.collect()
    });
    effects.collect()
}

fn move_parameters(known: &mut Knowledge, steps: &[f64], share: f64) {
    let mut steps = steps.iter();
    for FittedEffect {
        effect,
        free,
        bounds,
    } in &mut known.effects
    {
        for (&i, (low, high)) in free.iter().zip(bounds.iter()) {
            let Some(step) = steps.next() else {
                return;
            };
            let spec = &effect.spec.parameters[i];
            let old = effect.values[i];
            let mut new = old + share * step;
            if old > 0.0 && spec.limits.0 >= 0.0 {
                new = new.clamp(old / MAX_STEP_FACTOR, old * MAX_STEP_FACTOR);
            }
            effect.values[i] = new.clamp(*low, *high);
        }
    }
}
