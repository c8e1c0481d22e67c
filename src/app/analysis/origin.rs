//! What a result was computed from: the device and the recordings as they were used. A result
//! outlives a change of either, and a session is opened where files have changed; it then
//! says what is different now.
//!
//! The drive is the measured voltage of each recording, and so part of it.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::recording_roles;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{Overlay, Role};
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;
use crate::recording::{Channel, Recording};

/// A recording that was used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Its name.
    pub name: String,
    /// Hash of its file's bytes; `None` for one that comes from no file.
    pub sha256: Option<String>,
    /// How many samples it has.
    pub samples: usize,
    /// How its columns were read.
    pub import: ImportSettings,
    /// Shift and scale.
    pub alignment: Alignment,
    /// What it was used for.
    pub role: Role,
}

impl Source {
    /// An overlay in its role.
    pub fn of(overlay: &Overlay, role: Role) -> Self {
        let recording = &overlay.recording;
        Self {
            name: recording.name.clone(),
            sha256: recording.sha256.clone(),
            samples: recording.len(),
            import: overlay.import.clone(),
            alignment: overlay.alignment,
            role,
        }
    }

    /// Whether an overlay has the same data. Its number may be another one: a file that is
    /// opened again takes a new number.
    fn is_of(&self, overlay: &Overlay) -> bool {
        let recording = &overlay.recording;
        self.sha256 == recording.sha256
            && (self.sha256.is_some() || self.name == recording.name)
            && self.samples == recording.len()
            && self.import == overlay.import
    }

    /// The overlay with its data, if that is open.
    pub fn find<'a>(&self, setup: &'a Setup) -> Option<&'a Overlay> {
        setup.overlays.iter().find(|overlay| self.is_of(overlay))
    }

    /// Its data, shifted and scaled as it was used, if it is open.
    pub fn recording(&self, setup: &Setup) -> Option<Arc<Recording>> {
        let overlay = self.find(setup)?;
        Some(moved(&overlay.recording, &self.alignment))
    }
}

/// The device and the recordings of a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Name of the device.
    pub device: String,
    /// The recordings; those fitted to come first.
    pub recordings: Vec<Source>,
}

impl Origin {
    /// The device and the used recordings of a setup.
    pub fn of(setup: &Setup) -> Self {
        let all = recording_roles::of(setup);
        let with = |role: Role| all.iter().filter(move |(_, r)| *r == role);
        Self {
            device: setup.preset.model.name.clone(),
            recordings: with(Role::Train)
                .chain(with(Role::HeldOut))
                .map(|(overlay, role)| Source::of(overlay, *role))
                .collect(),
        }
    }

    /// The recordings that were used as `role`, as they were used; `None` unless all are open.
    pub fn recordings(&self, setup: &Setup, role: Role) -> Option<Vec<Arc<Recording>>> {
        let these = self.recordings.iter().filter(|source| source.role == role);
        these.map(|source| source.recording(setup)).collect()
    }

    /// What is different from the setup, as sentences; `None` if the result belongs to it.
    pub fn differences(&self, setup: &Setup) -> Option<String> {
        let mut sentences = Vec::new();
        if self.device != setup.preset.model.name {
            sentences.push(format!("This was computed for the device {}.", self.device));
        }
        let changes = self.changes(setup);
        if !changes.is_empty() {
            sentences.push(format!(
                "The recordings or their roles have changed since: {}.",
                changes.join("; ")
            ));
        }
        (!sentences.is_empty()).then(|| sentences.join(" "))
    }

    /// What is different of the recordings.
    fn changes(&self, setup: &Setup) -> Vec<String> {
        let now = recording_roles::of(setup);
        let mut changes = Vec::new();
        for source in &self.recordings {
            let name = &source.name;
            match now.iter().find(|(overlay, _)| source.is_of(overlay)) {
                Some((overlay, _)) if overlay.alignment != source.alignment => {
                    changes.push(format!("{name} is shifted or scaled in another way"));
                }
                Some((_, role)) if *role != source.role => {
                    changes.push(format!("{name} has another role"));
                }
                Some(_) => {}
                None if now.iter().any(|(o, _)| o.recording.name == *name) => {
                    changes.push(format!("{name} has other data"));
                }
                None => changes.push(format!("{name} is not open")),
            }
        }
        let known = |overlay: &Overlay| {
            let name = &overlay.recording.name;
            let mut sources = self.recordings.iter();
            sources.any(|source| source.is_of(overlay) || source.name == *name)
        };
        for (overlay, role) in &now {
            if *role != Role::Unused && !known(overlay) {
                changes.push(format!("{} is new", overlay.recording.name));
            }
        }
        changes
    }
}

/// The recording as aligned: shifted and scaled.
pub(crate) fn aligned(overlay: &Overlay) -> Arc<Recording> {
    moved(&overlay.recording, &overlay.alignment)
}

/// A recording shifted and scaled.
fn moved(recording: &Arc<Recording>, alignment: &Alignment) -> Arc<Recording> {
    if *alignment == Alignment::default() {
        return Arc::clone(recording);
    }
    let mut recording = recording.as_ref().clone();
    for t in &mut recording.time {
        *t = alignment.time(*t);
    }
    let scale = |values: &mut [f64], channel| {
        for x in values {
            *x = alignment.value(channel, *x);
        }
    };
    scale(&mut recording.proof_mass, Channel::ProofMass);
    if let Some(values) = &mut recording.cantilever {
        scale(values, Channel::Cantilever);
    }
    Arc::new(recording)
}

#[cfg(test)]
mod tests {
    use super::super::origin::*;
    use crate::app::files::built_in;
    use crate::model::preset::Preset;

    #[test]
    fn what_has_changed_is_said() {
        let mut setup = built_in::setup();
        let mut second = setup.overlays[0].clone();
        second.id = 2;
        let data = Arc::make_mut(&mut second.recording);
        (data.name, data.sha256) = ("b.csv".to_owned(), Some("00".to_owned()));
        setup.overlays.push(second);
        setup.overlays[0].role = Some(Role::Train);
        setup.overlays[1].role = Some(Role::HeldOut);
        let origin = Origin::of(&setup);
        assert_eq!(origin.differences(&setup), None);
        // A file that is opened again has a new number and the same data.
        setup.overlays[1].id = 7;
        assert_eq!(origin.differences(&setup), None);
        let says = |setup: &Setup, part: &str| {
            let said = origin.differences(setup).unwrap_or_default();
            assert!(said.contains(part), "{said}");
        };
        let mut changed = setup.clone();
        changed.overlays[1].alignment.time_shift = 1e-3;
        says(&changed, "b.csv is shifted or scaled");
        let mut changed = setup.clone();
        changed.overlays[1].role = Some(Role::Train);
        says(&changed, "b.csv has another role");
        let mut changed = setup.clone();
        let data = Arc::make_mut(&mut changed.overlays[1].recording);
        data.sha256 = Some("01".to_owned());
        says(&changed, "b.csv has other data");
        assert!(origin.recordings(&changed, Role::HeldOut).is_none());
        assert!(origin.recordings(&changed, Role::Train).is_some());
        let mut changed = setup.clone();
        changed.overlays.pop();
        says(&changed, "b.csv is not open");
        let mut changed = setup.clone();
        let mut third = changed.overlays[1].clone();
        (third.id, third.role) = (9, Some(Role::Train));
        let data = Arc::make_mut(&mut third.recording);
        (data.name, data.sha256) = ("c.csv".to_owned(), Some("02".to_owned()));
        changed.overlays.push(third);
        says(&changed, "c.csv is new");
        changed.preset = Preset::load("oscillator").unwrap();
        says(&changed, "computed for the device paper");
    }

    #[test]
    fn a_shift_and_a_scale_reach_what_is_computed() {
        let mut setup = built_in::setup();
        let overlay = &mut setup.overlays[0];
        assert!(Arc::ptr_eq(&aligned(overlay), &overlay.recording));
        overlay.alignment.time_shift = 1e-3;
        overlay.alignment.xp_offset = 2e-6;
        let moved = aligned(overlay);
        assert_eq!(moved.time[5], overlay.recording.time[5] + 1e-3);
        let apart = moved.proof_mass[5] - overlay.recording.proof_mass[5];
        assert!((apart - 2e-6).abs() < 1e-15);
    }
}
