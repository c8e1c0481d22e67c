//! A finished diagnosis together with its input, so that the answer stays readable after the
//! recordings have changed.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::origin::{Origin, as_set_up, shared_drive};
use super::recording_roles::with_role;
use crate::app::setup::current_setup::{DiagnosisChoices, Setup};
use crate::app::setup::overlay::{OverlayId, Role};
use crate::diagnose::Diagnosis;
use crate::recording::Recording;

/// A recording as the diagnosis used it.
#[derive(Debug, Clone)]
pub struct Used {
    /// Its number in the window.
    pub id: OverlayId,
    /// Its data, shifted and scaled, with a unique name.
    pub recording: Arc<Recording>,
    /// What it was used for.
    pub role: Role,
}

/// The input of a diagnosis.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Asked {
    /// The recordings used; those fitted to come first. After a session was opened, those that
    /// are still there.
    #[serde(skip)]
    pub recordings: Vec<Used>,
    /// The device and all recordings used.
    pub origin: Origin,
    /// The unique names of all recordings used, in the same order.
    names: Vec<String>,
    /// Whether the last third of each recording was held out, because no recording was.
    pub split: bool,
    /// Effects chosen by hand; `None` for a search.
    pub by_hand: Option<BTreeSet<String>>,
    /// What was chosen besides.
    #[serde(default)]
    pub choices: DiagnosisChoices,
}

impl Asked {
    /// The recordings of a setup, by their roles.
    pub fn of(setup: &Setup, by_hand: Option<BTreeSet<String>>) -> Self {
        let mut recordings: Vec<Used> = Vec::new();
        let shared = shared_drive(setup);
        for role in [Role::Train, Role::HeldOut] {
            for overlay in with_role(setup, role) {
                let mut recording = as_set_up(overlay, shared.as_ref());
                let known = |name: &str| recordings.iter().any(|u| u.recording.name == name);
                if known(&recording.name) {
                    // Results name recordings, so names must be unique.
                    let name = (2..)
                        .map(|n| format!("{} ({n})", recording.name))
                        .find(|name| !known(name));
                    recording = named(recording, &name.unwrap_or_default());
                }
                recordings.push(Used {
                    id: overlay.id,
                    recording,
                    role,
                });
            }
        }
        let split = recordings.iter().all(|u| u.role == Role::Train);
        Self {
            origin: Origin::of(setup),
            names: recordings
                .iter()
                .map(|u| u.recording.name.clone())
                .collect(),
            recordings,
            split,
            by_hand,
            choices: setup.diagnosis.clone(),
        }
    }

    pub(crate) fn side(&self, role: Role) -> Vec<Arc<Recording>> {
        let these = self.recordings.iter().filter(|used| used.role == role);
        these.map(|used| Arc::clone(&used.recording)).collect()
    }

    /// Whether recordings can be found again in the setup: after a session was opened they
    /// are read one by one.
    pub fn can_complete(&self, setup: &Setup) -> bool {
        let mut all = self.origin.recordings.iter().zip(&self.names);
        self.recordings.len() < self.names.len()
            && all.any(|(source, name)| self.find(name).is_none() && source.find(setup).is_some())
    }

    /// Finds recordings again in the setup, as they were used.
    pub fn complete(&mut self, setup: &Setup) {
        let all = self.origin.recordings.iter().zip(&self.names);
        self.recordings = all
            .filter_map(|(source, name)| {
                Some(Used {
                    id: source.find(setup)?.id,
                    recording: named(source.recording(setup)?, name),
                    role: source.role,
                })
            })
            .collect();
    }

    /// The recording of that name.
    pub fn find(&self, name: &str) -> Option<&Used> {
        self.recordings.iter().find(|u| u.recording.name == name)
    }
}

/// The recording under a name.
fn named(recording: Arc<Recording>, name: &str) -> Arc<Recording> {
    if recording.name == name {
        return recording;
    }
    let mut renamed = recording.as_ref().clone();
    name.clone_into(&mut renamed.name);
    Arc::new(renamed)
}

/// A diagnosis with its input.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Answer {
    /// The result.
    pub diagnosis: Diagnosis,
    /// The input.
    pub asked: Asked,
    /// Whether its residuals were thinned when it was saved: not every sample is there.
    pub is_thinned: bool,
}

impl Answer {
    /// An answer as it was just computed.
    pub fn new(diagnosis: Diagnosis, asked: Asked) -> Self {
        Self {
            diagnosis,
            asked,
            is_thinned: false,
        }
    }
}
