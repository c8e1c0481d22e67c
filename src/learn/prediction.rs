//! What a pupil predicts, and how near it comes.

use serde::{Deserialize, Serialize};

use super::expression::ExpressionError;
use super::lesson::{Claim, Mark, Relation, Task};
use super::run::Run;
use crate::model::unit::{format_number, format_quantity};

/// A drawn curve whose error is at most this share of the motion's range is fully right: about the
/// width of a hand's line.
const CURVE_TOLERANCE: f64 = 0.05;
/// A drawn curve whose error is this share of the range says nothing: a level line through the
/// middle of a swing has it.
const CURVE_WORTHLESS: f64 = 0.35;
/// A mark this many tolerances off says nothing.
const MARK_WORTHLESS: f64 = 5.0;
/// Two sides of a claim are near if they differ by less than this share of the larger.
const NEAR_SHARE: f64 = 0.05;
/// Times at which a drawn curve is compared with the run.
const COMPARED_TIMES: usize = 1000;

/// A prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Prediction {
    /// The option with this number, from 0.
    Choice(usize),
    /// The value of a mark \[SI\].
    Mark(f64),
    /// Readings at even times over the run, from its beginning to its end \[m\].
    Curve(Vec<f64>),
}

/// A prediction that was compared with the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    /// From 0 to 1.
    pub score: f64,
    /// What was predicted, in words or as a number with its unit.
    pub predicted: String,
    /// What the simulation gave, likewise.
    pub simulated: String,
    /// How far apart they are, with a unit; empty for a choice.
    pub difference: String,
}

impl Scored {
    /// From 0 to 3.
    pub fn stars(&self) -> usize {
        (self.score.clamp(0.0, 1.0) * 3.0).round() as usize
    }
}

impl Claim {
    /// Whether it holds of a run.
    ///
    /// # Errors
    /// [`ExpressionError`].
    pub fn holds(&self, run: &Run) -> Result<bool, ExpressionError> {
        let of = |id: &str, nth| run.value(id, nth);
        let (left, right) = (self.left.value(&of)?, self.right.value(&of)?);
        Ok(match self.relation {
            Relation::Less => left < right,
            Relation::Greater => left > right,
            Relation::Near => (left - right).abs() <= NEAR_SHARE * left.abs().max(right.abs()),
        })
    }
}

impl Mark {
    /// The simulated value \[SI\].
    ///
    /// # Errors
    /// [`ExpressionError`].
    pub fn simulated(&self, run: &Run) -> Result<f64, ExpressionError> {
        self.of.value(&|id, nth| run.value(id, nth))
    }

    /// A value as it is shown.
    pub fn text(&self, value: f64) -> String {
        let (unit, factor) = &self.unit;
        let number = format_number(value / factor, 3);
        format!("{number} {}", unit.replace('u', "\u{b5}"))
    }

    /// The step of a key, a hundredth of the range \[SI\].
    pub fn step(&self) -> f64 {
        0.01 * (self.range.1 - self.range.0)
    }
}

/// The drawn reading at `t` \[s\] of a run of `duration`: straight between the points.
pub fn drawn_value(points: &[f64], duration: f64, t: f64) -> Option<f64> {
    let last = points.len().checked_sub(1)?;
    let at = (t / duration).clamp(0.0, 1.0) * last as f64;
    let i = (at.floor() as usize).min(last);
    let from = *points.get(i)?;
    let to = *points.get((i + 1).min(last))?;
    Some(from + (to - from) * (at - i as f64))
}

/// Rms of drawn less simulated reading over a run, and the range of the simulated one \[m\].
pub fn curve_error(points: &[f64], run: &Run) -> Option<(f64, f64)> {
    let trace = &run.trace;
    let (mut sum, mut count) = (0.0, 0);
    for k in 0..COMPARED_TIMES {
        let t = run.duration * k as f64 / (COMPARED_TIMES - 1) as f64;
        let i = ((t - trace.t0) / trace.dt).round().max(0.0) as usize;
        let Some(simulated) = trace.proof_mass.get(i) else {
            continue;
        };
        sum += (drawn_value(points, run.duration, t)? - simulated).powi(2);
        count += 1;
    }
    let (low, high) = crate::recording::extremes(&trace.proof_mass);
    (count > 0).then(|| ((sum / f64::from(count)).sqrt(), high - low))
}

/// Falls from 1 at `right` to 0 at `worthless`.
fn falling(error: f64, right: f64, worthless: f64) -> f64 {
    (1.0 - (error - right) / (worthless - right)).clamp(0.0, 1.0)
}

/// Compares a prediction with a run; `options` are the answers of a choice as shown.
///
/// # Errors
/// A measure that the run does not have, or a prediction of another kind than the task.
pub fn score(
    task: &Task,
    prediction: &Prediction,
    run: &Run,
    options: &[String],
) -> Result<Scored, String> {
    match (task, prediction) {
        (Task::Choice(choice), Prediction::Choice(chosen)) => {
            let text = |i: usize| options.get(i).cloned().unwrap_or_default();
            Ok(Scored {
                score: f64::from(u8::from(*chosen == choice.right)),
                predicted: text(*chosen),
                simulated: text(choice.right),
                difference: String::new(),
            })
        }
        (Task::Mark(mark), Prediction::Mark(value)) => {
            let simulated = mark.simulated(run).map_err(|error| error.to_string())?;
            let off = (value - simulated).abs();
            let worthless = MARK_WORTHLESS * mark.tolerance;
            Ok(Scored {
                score: falling(off, mark.tolerance, worthless),
                predicted: mark.text(*value),
                simulated: mark.text(simulated),
                difference: mark.text(off),
            })
        }
        (Task::Curve(_), Prediction::Curve(points)) => {
            let (rms, range) = curve_error(points, run).ok_or("there is no curve to compare")?;
            let share = if range > 0.0 { rms / range } else { 1.0 };
            let unit = run.model.coordinate.base_unit();
            Ok(Scored {
                score: falling(share, CURVE_TOLERANCE, CURVE_WORTHLESS),
                predicted: "a drawn curve".to_owned(),
                simulated: format!("a motion over {}", format_quantity(range, unit, 3)),
                difference: format!(
                    "{} rms, {:.0} % of the motion",
                    format_quantity(rms, unit, 3),
                    100.0 * share
                ),
            })
        }
        _ => Err("this prediction does not belong to the step; predict again".to_owned()),
    }
}
