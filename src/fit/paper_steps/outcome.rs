//! The result of a step of the identification, shared by window and command line, and how it
//! changes the device for the next steps.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::StepError;
use super::adhesion::{Adhesion, adhesion};
use super::drive::{DriveFit, fit_drive};
use super::film::{Film, film};
use super::guide::Step;
use super::restitution::{Restitution, restitution};
use super::sensitivity::{Sensitivity, sensitivity};
use crate::fit::contact_readings::{ContactReadings, read_contacts};
use crate::fit::error::FitError;
use crate::fit::modal::{ModalFit, ModalOptions, identify};
use crate::fit::options::{FitOptions, Part};
use crate::fit::solve::levenberg_marquardt::Control;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::recording::Recording;

/// The result of a step.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum StepResult {
    /// Modes.
    Modal(Arc<ModalFit>),
    /// Branches of the drive.
    Drive(Arc<DriveFit>),
    /// Restitution.
    Restitution(Arc<Restitution>),
    /// Adhesion.
    Adhesion(Arc<Adhesion>),
    /// The film.
    Film(Arc<Film>),
    /// The sensitivity.
    Sensitivity(Arc<Sensitivity>),
}

/// Takes a step with `model` as identified so far. `known` are contact readings with this model and
/// these recordings, if they have been read already.
///
/// # Errors
/// [`StepError`] with one clear sentence.
pub fn take(
    step: Step,
    model: &Model,
    recordings: &[Arc<Recording>],
    known: Option<&Arc<ContactReadings>>,
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<StepResult, StepError> {
    let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
    let names = names.join(", ");
    let parts: Vec<Part> = recordings.iter().cloned().map(Part::whole).collect();
    let read = || -> Result<Arc<ContactReadings>, StepError> {
        if let Some(known) = known {
            return Ok(Arc::clone(known));
        }
        let read = read_contacts(model, &parts, options, control)?;
        // Cancelled readings are incomplete: a law through them would not show that.
        if control.cancelled() {
            return Err(FitError::Cancelled.into());
        }
        Ok(Arc::new(read))
    };
    Ok(match step {
        Step::Modal => {
            let options = ModalOptions::default();
            StepResult::Modal(Arc::new(identify(model, recordings, &options, control)?))
        }
        Step::Drive => StepResult::Drive(Arc::new(fit_drive(model, recordings)?)),
        Step::Restitution => {
            StepResult::Restitution(Arc::new(restitution(&names, read()?.as_ref())?))
        }
        Step::Adhesion => StepResult::Adhesion(Arc::new(adhesion(&names, read()?.as_ref())?)),
        Step::Film => StepResult::Film(Arc::new(film(model, &parts, options, control)?)),
        Step::Sensitivity => {
            StepResult::Sensitivity(Arc::new(sensitivity(model, &parts, options, control)?))
        }
    })
}

impl StepResult {
    /// Whether its values can be given to a device: the film's cannot where the rings are not
    /// followed, nor modes that do not follow the sweep.
    #[must_use]
    pub fn is_reliable(&self) -> bool {
        match self {
            StepResult::Film(found) => found.follows_rings(),
            StepResult::Modal(found) => found.follows_sweep(),
            StepResult::Drive(_)
            | StepResult::Restitution(_)
            | StepResult::Adhesion(_)
            | StepResult::Sensitivity(_) => true,
        }
    }

    /// Applies the result to the device; the sensitivity is a comparison and changes nothing.
    pub fn apply(&self, model: &mut Model) {
        if let StepResult::Modal(found) = self {
            found.apply(model);
        }
        let p = &mut model.parameters;
        match self {
            StepResult::Drive(found) => model.piezo = Some(found.piezo()),
            StepResult::Restitution(found) => p.set(ParameterId::Alpha, found.mean),
            StepResult::Adhesion(found) => {
                p.set(ParameterId::Ca, found.rate.0.max(0.0));
                p.set(ParameterId::Ca0, found.start.0.max(0.0));
            }
            StepResult::Film(found) => {
                for id in [ParameterId::Cs, ParameterId::Gp] {
                    p.set(id, found.fit.model.parameters[id]);
                }
            }
            StepResult::Modal(_) | StepResult::Sensitivity(_) => {}
        }
    }
}
