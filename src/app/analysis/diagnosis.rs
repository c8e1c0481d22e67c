//! Running a diagnosis, and its results. A diagnosis changes nothing by itself: the person
//! accepts its model.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use eframe::egui::Context;

use super::diagnosis_answer::{Answer, Asked};
use super::diagnosis_view::Look;
use super::job::Job;
use super::sealed_trial::Trial;
use crate::app::setup::current_setup::{ParameterChoice, Setup};
use crate::app::setup::overlay::Role;
use crate::app::simulation::recorded_drive::RecordedDriveCache;
use crate::diagnose::findings::Remark;
use crate::diagnose::{DiagnoseControl, DiagnoseOptions, DiagnoseProgress, Diagnosis, diagnose};
use crate::fit::{FixedParameter, ParameterChoices, Part};
use crate::model::Model;
use crate::model::effects::CATALOGUE;
use crate::model::preset::known_value::{KnownValue, device_ids};

/// A running diagnosis.
#[derive(Debug, Clone)]
pub struct Running {
    /// Its thread.
    pub job: Job<DiagnoseProgress, Diagnosis>,
    /// Its input.
    pub asked: Asked,
}

/// State of the Diagnose workspace.
#[derive(Debug, Clone, Default)]
pub struct Diagnosing {
    /// The running diagnosis.
    pub running: Option<Running>,
    /// Result of the last search.
    pub automatic: Option<Arc<Answer>>,
    /// Result with effects chosen by hand.
    pub by_hand: Option<Arc<Answer>>,
    /// Whether the result by hand is shown if there are both.
    pub hand_shown: bool,
    /// Why the last diagnosis failed.
    pub error: Option<String>,
    /// Effects ticked by hand; `None` for those named by the search.
    pub picked: Option<BTreeSet<String>>,
    /// What is shown of the answer.
    pub look: Look,
    /// The sealed trial.
    pub trial: Trial,
}

impl Diagnosing {
    /// The answer that is shown.
    pub fn shown(&self) -> Option<&Arc<Answer>> {
        if self.hand_shown {
            self.by_hand.as_ref().or(self.automatic.as_ref())
        } else {
            self.automatic.as_ref().or(self.by_hand.as_ref())
        }
    }

    /// Effects that are ticked: by hand, or those named by the search.
    pub fn picked(&self) -> BTreeSet<String> {
        match (&self.picked, &self.automatic) {
            (Some(picked), _) => picked.clone(),
            (None, Some(answer)) => named(&answer.diagnosis),
            (None, None) => BTreeSet::new(),
        }
    }

    /// Ticks or unticks an effect.
    pub fn pick(&mut self, id: &str, on: bool) {
        let mut picked = self.picked();
        if on {
            picked.insert(id.to_owned());
        } else {
            picked.remove(id);
        }
        self.picked = Some(picked);
    }

    /// Starts a diagnosis of the present device: a search, or with the given effects.
    pub fn start(&mut self, setup: &Setup, by_hand: Option<BTreeSet<String>>, context: &Context) {
        self.error = None;
        let asked = Asked::of(setup, by_hand);
        let options = match options(setup, asked.by_hand.as_ref()) {
            Ok(options) => options,
            Err(reason) => {
                self.error = Some(reason);
                return;
            }
        };
        let model = setup.preset.model.clone();
        let of_job = asked.clone();
        let job = Job::start("diagnosis", context, move |control| {
            let report = |progress: &DiagnoseProgress| control.report(progress.clone());
            let control = DiagnoseControl {
                cancel: control.cancel(),
                progress: &report,
            };
            ask(&model, &of_job, &options, &control)
        });
        self.running = Some(Running { job, asked });
    }

    /// Takes the result of the running diagnosis. Returns whether it has just ended.
    pub(crate) fn take(&mut self) -> bool {
        let Some(result) = self.running.as_ref().and_then(|running| running.job.take()) else {
            return false;
        };
        let Some(Running { asked, .. }) = self.running.take() else {
            return false;
        };
        match result {
            Ok(diagnosis) => self.adopt(diagnosis, asked),
            Err(error) => self.error = Some(error),
        }
        true
    }

    /// Shows an answer.
    pub fn adopt(&mut self, diagnosis: Diagnosis, asked: Asked) {
        self.hand_shown = asked.by_hand.is_some();
        let answer = Arc::new(Answer::new(diagnosis, asked));
        self.look.begin(&answer);
        if self.hand_shown {
            self.by_hand = Some(answer);
        } else {
            // A new search replaces earlier results by hand.
            self.by_hand = None;
            self.picked = None;
            self.automatic = Some(answer);
        }
    }

    /// Why the answer cannot be applied to the device, if so.
    pub fn why_not_applied(&self, setup: &Setup) -> Option<&'static str> {
        if self.trial.sealed.is_some() {
            return Some("This is the device of a sealed trial, not yours");
        }
        let other = |answer: &Arc<Answer>| answer.diagnosis.model.name != setup.preset.model.name;
        self.shown()
            .is_some_and(other)
            .then_some("The open device is not the one that was diagnosed")
    }

    /// In what the setup differs from that of the answer.
    pub fn differences(&self, setup: &Setup) -> Option<String> {
        let asked = &self.shown()?.asked;
        let origin = asked.origin.differences(setup);
        let others = (asked.choices != setup.diagnosis)
            .then(|| "The options have changed since.".to_owned());
        match (origin, others) {
            (Some(origin), Some(others)) => Some(format!("{origin} {others}")),
            (origin, others) => origin.or(others),
        }
    }

    /// Whether the recordings or their roles have changed since the answer.
    pub fn is_stale(&self, setup: &Setup) -> bool {
        self.differences(setup).is_some()
    }

    /// Finds the recordings of answers again that come from a session.
    pub(crate) fn complete(&mut self, setup: &Setup) {
        for answer in [&mut self.automatic, &mut self.by_hand] {
            if let Some(answer) = answer
                && answer.asked.can_complete(setup)
            {
                Arc::make_mut(answer).asked.complete(setup);
            }
        }
    }
}

/// Ids of the effects that a diagnosis names.
pub fn named(diagnosis: &Diagnosis) -> BTreeSet<String> {
    diagnosis.named.iter().map(|n| n.id.clone()).collect()
}

/// Why no diagnosis can be started, and what to do.
pub fn obstacle(setup: &Setup) -> Option<String> {
    if setup.overlays.is_empty() {
        return Some("There are no recordings. Drop CSV files on the window.".to_owned());
    }
    let used = super::recording_roles::of(setup);
    if !used.iter().any(|(_, role)| *role == Role::Train) {
        return Some(
            "No recording is used for fitting. Choose \"fit\" for at least one.".to_owned(),
        );
    }
    // A recording without voltage is under the drive of the simulation, if there is one.
    let driven = setup.preset.model.piezo.is_some();
    let silent = used.iter().find(|(o, role)| {
        let is_used = driven && *role != Role::Unused;
        is_used && o.is_under_shared_drive() && !o.recording.has_voltage()
    });
    if let Some((overlay, _)) = silent
        && let Err(reason) = RecordedDriveCache::default().resolve(setup)
    {
        return Some(format!(
            "{} has no voltage, and the drive of the simulation cannot be used in its place: \
             {reason}. Choose \"ignore\" for it, or open a file with a column V.",
            overlay.recording.name
        ));
    }
    let problem = setup.preset.model.check().err()?;
    Some(format!("The device cannot be simulated: {problem}"))
}

/// What a diagnosis of a setup is asked, with the effects chosen `by_hand` or in a search.
///
/// # Errors
/// What is wrong with the choices, and what to do.
pub(crate) fn options(
    setup: &Setup,
    by_hand: Option<&BTreeSet<String>>,
) -> Result<DiagnoseOptions, String> {
    let asked = &setup.diagnosis;
    let compared = CATALOGUE.iter().map(|effect| effect.id.to_owned());
    let compared: Vec<String> = compared.filter(|id| !asked.skipped.contains(id)).collect();
    let candidates = match compared.len() {
        0 => return Err("No effect is ticked to be compared. Tick one under Options.".to_owned()),
        all if all == CATALOGUE.len() => Vec::new(),
        _ => compared,
    };
    let mut choices = ParameterChoices::default();
    // What was chosen for another device, or is no parameter of a device, does not count here.
    for id in device_ids(&setup.preset.model) {
        match asked.parameters.get(&id) {
            Some(ParameterChoice::Free) => choices.also_free.push(id),
            Some(ParameterChoice::Held) => choices.fixed.push(FixedParameter { id, value: None }),
            Some(&ParameterChoice::Known { value, std_error }) => choices.known.push(KnownValue {
                id,
                value,
                std_error,
            }),
            None if setup.locked.contains(&id) => {
                choices.fixed.push(FixedParameter { id, value: None });
            }
            None => {}
        }
    }
    let resolved = choices.resolve(&setup.preset);
    let longest = asked.longest.map(Duration::try_from_secs_f64);
    Ok(DiagnoseOptions {
        candidates,
        by_hand: by_hand.map(|ids| ids.iter().cloned().collect()),
        choices: resolved.map_err(|error| error.to_string())?,
        budget: longest.transpose().map_err(|error| error.to_string())?,
        ..DiagnoseOptions::default()
    })
}

fn ask(
    model: &Model,
    asked: &Asked,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Diagnosis, String> {
    let (train, held_out) = Part::sides(asked.side(Role::Train), asked.side(Role::HeldOut));
    let answer = diagnose(model, &train, &held_out, options, control);
    let mut diagnosis = answer.map_err(|error| error.to_string())?;
    if asked.split {
        diagnosis.remarks.insert(0, Remark::LastThirdHeldOut);
    }
    Ok(diagnosis)
}

#[cfg(test)]
#[path = "proof_tests.rs"]
mod tests;
