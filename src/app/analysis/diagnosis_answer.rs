//! A finished diagnosis together with its input, so that the answer stays readable after the
//! recordings have changed.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::fit::{as_set_up, shared_drive};
use super::recording_roles::with_role;
use crate::app::setup::current_setup::Setup;
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
#[derive(Debug, Clone)]
pub struct Asked {
    /// The recordings used; those fitted to come first.
    pub recordings: Vec<Used>,
    /// Whether the last third of each recording was held out, because no recording was.
    pub split: bool,
    /// Effects chosen by hand; `None` for a search.
    pub by_hand: Option<BTreeSet<String>>,
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
                    let mut renamed = recording.as_ref().clone();
                    renamed.name = name.unwrap_or_default();
                    recording = Arc::new(renamed);
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
            recordings,
            split,
            by_hand,
        }
    }

    pub(crate) fn side(&self, role: Role) -> Vec<Arc<Recording>> {
        let these = self.recordings.iter().filter(|used| used.role == role);
        these.map(|used| Arc::clone(&used.recording)).collect()
    }

    /// The recording of that name.
    pub fn find(&self, name: &str) -> Option<&Used> {
        self.recordings.iter().find(|u| u.recording.name == name)
    }
}

/// A diagnosis with its input.
#[derive(Debug, Clone)]
pub struct Answer {
    /// The result.
    pub diagnosis: Diagnosis,
    /// The input.
    pub asked: Asked,
}
