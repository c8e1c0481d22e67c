//! The guided identification on its own, once the person has asked: the whole device fitted and the
//! recordings examined again, or all steps taken one after the other and applied.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::Identification;
use super::plan::{Course, WholeFit};
use crate::app::analysis::fit::Fitting;
use crate::app::setup::current_setup::Setup;
use crate::fit::paper_steps::guide::{Step, next_to_free};
use eframe::egui::Context;

impl Identification {
    /// The parameters to free in a fit of the whole device, without the locked ones, if one may
    /// help: the device is far from the recordings, or does not follow bounces or releases that were
    /// seen, and not all of it has been fitted.
    pub fn to_free(&self, fitting: &Fitting, setup: &Setup) -> Option<Vec<String>> {
        if !self.needs_fit() {
            return None;
        }
        // What is locked is held as if it were known.
        let mut known = self.fitted(fitting, setup);
        known.extend(setup.locked.iter().cloned());
        let ids = next_to_free(&setup.preset.model, &known)?;
        let free: Vec<String> = ids
            .into_iter()
            .filter(|id| !setup.locked.contains(id))
            .collect();
        (!free.is_empty()).then_some(free)
    }

    /// Whether the device, as it is, keeps a step from being taken.
    pub fn needs_fit(&self) -> bool {
        let may_be_the_device = |a: &crate::fit::paper_steps::guide::Allowance| {
            a.by.as_ref()
                .is_err_and(|missing| missing.may_be_the_device)
        };
        self.first.is_some() || self.allowances.iter().any(may_be_the_device)
    }

    /// The ids that were free in the fit that the device's present values come from.
    fn fitted(&self, fitting: &Fitting, setup: &Setup) -> Vec<String> {
        let model = &setup.preset.model;
        if let Some(whole) = self.whole.as_ref().filter(|w| *w.model == *model) {
            return whole.free.clone();
        }
        match &fitting.result {
            Some(result) if fitting.is_applied(setup) => {
                result.parameters.iter().map(|p| p.id.clone()).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Frees `ids` and fits them; the result is applied when it is there.
    pub fn fit_whole_device(
        &mut self,
        ids: Vec<String>,
        fitting: &mut Fitting,
        setup: &Setup,
        context: &Context,
    ) {
        fitting.free = Some(ids.into_iter().collect::<BTreeSet<_>>());
        fitting.start(setup, context);
        self.course = Course::Fitting;
    }

    /// Begins to take all steps.
    pub fn take_all_steps(&mut self) {
        self.course = Course::Steps {
            running: None,
            taken: Vec::new(),
        };
    }

    /// Applies what a step found.
    pub fn apply(&mut self, step: Step, setup: &mut Setup) {
        let Some(Ok(found)) = self.findings.get(step.id()) else {
            return;
        };
        let before = setup.preset.model.clone();
        found.apply(&mut setup.preset.model);
        // What the steps change is still the device that was fitted.
        if let Some(whole) = self.whole.as_mut().filter(|w| *w.model == before) {
            whole.model = Arc::new(setup.preset.model.clone());
        }
    }

    /// Goes on with what the person asked for. To be called once a frame.
    pub fn proceed(&mut self, fitting: &mut Fitting, setup: &mut Setup, context: &Context) {
        match self.course.clone() {
            Course::ByHand => {}
            Course::Fitting if fitting.job.is_some() => {}
            Course::Fitting => {
                self.course = Course::ByHand;
                let Some(result) = fitting.result.clone().filter(|r| !r.cancelled) else {
                    return;
                };
                fitting.apply(setup);
                self.whole = Some(WholeFit {
                    free: result.parameters.iter().map(|p| p.id.clone()).collect(),
                    model: Arc::new(setup.preset.model.clone()),
                });
                self.findings.clear();
                self.look(setup, context);
            }
            Course::Steps { .. } if self.job.is_some() => {}
            Course::Steps { running, mut taken } => {
                if let Some(step) = running {
                    // A stopped step ends the course.
                    let Some(finding) = self.findings.get(step.id()) else {
                        self.course = Course::ByHand;
                        return;
                    };
                    taken.push(step);
                    if finding.as_ref().is_ok_and(|found| found.is_reliable()) {
                        self.apply(step, setup);
                    }
                }
                let allowed = self.allowances.iter().filter(|a| a.by.is_ok());
                let next = allowed.map(|a| a.step).find(|step| !taken.contains(step));
                self.course = match next {
                    Some(step) => {
                        self.findings.remove(step.id());
                        self.start(step, setup, context);
                        Course::Steps {
                            running: next,
                            taken,
                        }
                    }
                    None => Course::ByHand,
                };
            }
        }
    }

    /// Whether every step that the recordings allow has been taken.
    pub fn is_at_its_end(&self) -> bool {
        let is_taken = |step: Step| self.findings.contains_key(step.id());
        self.course == Course::ByHand
            && self.has_looked()
            && self.job.is_none()
            && self
                .allowances
                .iter()
                .all(|a| a.by.is_err() || is_taken(a.step))
    }
}

#[cfg(test)]
mod tests {
    use super::super::course::*;
    use crate::app::files::built_in;
    use crate::fit::paper_steps::guide::{Allowance, Missing};
    use crate::fit::{default_free, whole_device};

    #[test]
    fn a_fit_is_offered_with_ever_more_free_until_all_is_fitted() {
        let mut setup = built_in::setup();
        let fitting = Fitting::default();
        let mut guide = Identification::default();
        assert_eq!(
            guide.to_free(&fitting, &setup),
            None,
            "nothing is known yet"
        );
        guide.allowances = vec![Allowance {
            step: Step::Adhesion,
            by: Err(Missing {
                reason: "29 releases could not be followed".to_owned(),
                record: None,
                may_be_the_device: true,
            }),
        }];
        let model = setup.preset.model.clone();
        let usual = default_free(&model);
        assert_eq!(guide.to_free(&fitting, &setup), Some(usual.clone()));
        setup.locked.insert("eta".to_owned());
        let free = guide.to_free(&fitting, &setup).expect("the others");
        assert!(!free.contains(&"eta".to_owned()) && free.len() + 1 == usual.len());
        setup.locked.clear();
        let mut whole = |free: Vec<String>| {
            guide.whole = Some(WholeFit {
                free,
                model: Arc::new(model.clone()),
            });
            guide.to_free(&fitting, &setup)
        };
        assert_eq!(whole(usual), Some(whole_device(&model)));
        assert_eq!(whole(whole_device(&model)), None);
        // A slider that has moved since: it is another device.
        let alpha = crate::model::parameter::ParameterId::Alpha;
        setup.preset.model.parameters.set(alpha, 0.2);
        assert!(guide.to_free(&fitting, &setup).is_some());
    }
}
