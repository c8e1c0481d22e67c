//! The end of the guided identification: what was identified, and what was not and why.

use super::guide::{Allowance, Step};
use super::outcome::StepResult;
use crate::model::parameter::ParameterId;
use crate::model::unit::{counted, format_quantity};

/// An identified parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Identified {
    /// Which.
    pub id: ParameterId,
    /// Value, SI.
    pub value: f64,
    /// Standard error, SI; infinite if the step does not determine it.
    pub std_error: f64,
    /// The step that found it.
    pub step: Step,
}

/// A step that told nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Untold {
    /// Which.
    pub step: Step,
    /// Why.
    pub reason: String,
    /// The recording that would tell; `None` if no recording helps, or the reason says what to do.
    pub record: Option<&'static str>,
}

/// What the steps told.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summary {
    /// In the order of the steps.
    pub identified: Vec<Identified>,
    /// Steps whose result is a figure or a sentence, not parameters.
    pub others: Vec<(Step, String)>,
    /// In the order of the steps.
    pub untold: Vec<Untold>,
}

/// The summary of what was `found` (`None` for a step that was not taken), and of what the
/// recordings do not allow.
pub fn summary<'a>(
    allowances: &[Allowance],
    found: impl Fn(Step) -> Option<Result<&'a StepResult, &'a str>>,
) -> Summary {
    let mut summary = Summary::default();
    for step in Step::ALL {
        let untold = |reason: String, record| Untold {
            step,
            reason,
            record,
        };
        let missing = allowances
            .iter()
            .find(|a| a.step == step)
            .and_then(|a| a.by.as_ref().err());
        match (found(step), missing) {
            (Some(Ok(result)), _) if !result.is_reliable() => {
                let reason = "its result is not reliable, as the device does not follow the recordings there; where all of it has been fitted, a diagnosis tells what it lacks";
                summary.untold.push(untold(reason.to_owned(), None));
            }
            (Some(Ok(result)), _) => add(&mut summary, step, result),
            (Some(Err(error)), _) => summary.untold.push(untold(error.to_owned(), None)),
            (None, Some(missing)) => {
                let reason = missing.reason.clone();
                summary.untold.push(untold(reason, missing.record));
            }
            (None, None) => {
                summary
                    .untold
                    .push(untold("not taken yet".to_owned(), None));
            }
        }
    }
    summary
}

fn add(summary: &mut Summary, step: Step, result: &StepResult) {
    let mut identified = |id: ParameterId, value: f64, std_error: f64| {
        summary.identified.push(Identified {
            id,
            value,
            std_error,
            step,
        });
    };
    match result {
        StepResult::Modal(found) => {
            let ids = [
                (ParameterId::F1, ParameterId::Zeta1),
                (ParameterId::F2, ParameterId::Zeta2),
            ];
            for (mode, (frequency, zeta)) in found.identified().zip(ids) {
                identified(frequency, mode.frequency.value, mode.frequency.std_error);
                identified(zeta, mode.zeta.value, mode.zeta.std_error);
            }
            let text = format!(
                "{} with their shapes, from {} to {}",
                counted(found.identified().count(), "mode"),
                format_quantity(found.band.0, "Hz", 3),
                format_quantity(found.band.1, "Hz", 3)
            );
            summary.others.push((step, text));
        }
        StepResult::Restitution(found) => identified(ParameterId::Alpha, found.mean, found.error),
        StepResult::Adhesion(found) => {
            identified(ParameterId::Ca, found.rate.0, found.rate.1);
            identified(ParameterId::Ca0, found.start.0, found.start.1);
        }
        StepResult::Film(found) => {
            for p in &found.fit.parameters {
                if let Some(id) = ParameterId::from_id(&p.id) {
                    identified(id, p.value, p.std_error);
                }
            }
        }
        StepResult::Drive(found) => {
            let text = format!(
                "both branches of gc(V), from {} blocks of slow motion",
                found.points.len()
            );
            summary.others.push((step, text));
        }
        StepResult::Sensitivity(found) => {
            let verdict = found.verdict().unwrap_or_else(|| {
                "the second identification does not fit as well as the first".to_owned()
            });
            summary.others.push((step, verdict));
        }
    }
}

impl Identified {
    /// `alpha = 0.3 +- 0.0004`, or that it is not determined.
    #[must_use]
    pub fn text(&self) -> String {
        let spec = self.id.spec();
        if !self.std_error.is_finite() {
            return format!("{} is not determined", spec.id);
        }
        format!(
            "{} = {} +- {}",
            spec.id,
            format_quantity(self.value, spec.unit, 4),
            format_quantity(self.std_error, spec.unit, 2)
        )
    }
}

impl Untold {
    /// Why, and the recording that would tell.
    #[must_use]
    pub fn text(&self) -> String {
        match self.record {
            Some(record) => format!("{}. Record {record}.", self.reason),
            None => format!("{}.", self.reason.trim_end_matches('.')),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::guide::Missing;
    use super::super::restitution::{ExcludedBounces, Restitution};
    use super::super::summary::*;

    #[test]
    fn what_was_told_and_what_was_not_are_both_in_the_summary() {
        let allowed = |step| Allowance {
            step,
            by: Ok(vec!["a.csv".to_owned()]),
        };
        let missing = Allowance {
            step: Step::Drive,
            by: Err(Missing {
                reason: "0 blocks of slow motion".to_owned(),
                record: Some(Step::Drive.recipe()),
                may_be_the_device: false,
            }),
        };
        let allowances = [missing, allowed(Step::Restitution), allowed(Step::Adhesion)];
        let restitution = StepResult::Restitution(Arc::new(Restitution {
            mean: 0.3,
            error: 4e-4,
            scatter: 1e-3,
            exponent: (0.0, 0.01),
            constant: 0.9,
            bounces: Vec::new(),
            aside: ExcludedBounces::default(),
            off: 1.0,
        }));
        let summary = summary(&allowances, |step| match step {
            Step::Restitution => Some(Ok(&restitution)),
            Step::Adhesion => Some(Err("the releases scatter")),
            _ => None,
        });
        let [alpha] = summary.identified[..] else {
            panic!("{summary:?}");
        };
        assert_eq!(alpha.text(), "alpha = 0.3 +- 0.0004");
        let steps: Vec<Step> = summary.untold.iter().map(|u| u.step).collect();
        let rest = [
            Step::Modal,
            Step::Drive,
            Step::Adhesion,
            Step::Film,
            Step::Sensitivity,
        ];
        assert_eq!(steps, rest);
        assert!(
            summary.untold[1]
                .text()
                .contains("Record whole slow cycles")
        );
        assert_eq!(summary.untold[2].text(), "the releases scatter.");
    }
}
