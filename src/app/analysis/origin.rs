//! What a result was computed from: the device and the recordings as they were used. A result
//! outlives a change of either, and a session is opened where files have changed; it then
//! says what is different now.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::recording_roles;
use super::recording_roles::with_role;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::{Estimates, Overlay, Role};
use crate::app::setup::own_drive::OwnDrive;
use crate::app::simulation::recorded_drive::RecordedDriveCache;
use crate::model::drive::Waveform;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::align::set_up::set_up;
use crate::recording::csv::ImportSettings;
use crate::recording::experiment_setup::DriveSource;

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
    /// What of its instrument was estimated.
    #[serde(default)]
    pub estimates: Estimates,
    /// What drove it, in words.
    #[serde(default)]
    pub drive: String,
    /// What it was used for.
    pub role: Role,
}

impl Source {
    /// An overlay in its role; `shared` is the drive of the simulation.
    pub fn of(overlay: &Overlay, shared: Option<&Waveform>, role: Role) -> Self {
        let recording = &overlay.recording;
        Self {
            name: recording.name.clone(),
            sha256: recording.sha256.clone(),
            samples: recording.len(),
            import: overlay.import.clone(),
            alignment: overlay.alignment,
            estimates: overlay.estimates,
            drive: drive_text(overlay, shared),
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

    /// Its data, set up as they were used, if it is open under the same drive.
    pub fn recording(&self, setup: &Setup) -> Option<Arc<Recording>> {
        let shared = shared_drive(setup);
        let overlay = Overlay {
            alignment: self.alignment,
            estimates: self.estimates,
            ..self.find(setup)?.clone()
        };
        let same = drive_text(&overlay, shared.as_ref()) == self.drive;
        same.then(|| as_set_up(&overlay, shared.as_ref()))
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
        let shared = shared_drive(setup);
        Self {
            device: setup.preset.model.name.clone(),
            recordings: with(Role::Train)
                .chain(with(Role::HeldOut))
                .map(|(overlay, role)| Source::of(overlay, shared.as_ref(), *role))
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
        let shared = shared_drive(setup);
        let mut changes = Vec::new();
        for source in &self.recordings {
            let name = &source.name;
            match now.iter().find(|(overlay, _)| source.is_of(overlay)) {
                Some((overlay, _)) if overlay.alignment != source.alignment => {
                    changes.push(format!("{name} is shifted or scaled in another way"));
                }
                Some((overlay, _)) if overlay.estimates != source.estimates => {
                    changes.push(format!("other things are estimated of {name}"));
                }
                Some((overlay, _)) if drive_text(overlay, shared.as_ref()) != source.drive => {
                    changes.push(format!("{name} has another drive"));
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

/// The drive of the simulation, if any recording is under it and it can be used. A device without a
/// piezo has none.
pub(crate) fn shared_drive(setup: &Setup) -> Option<Waveform> {
    // Asked for in every frame, and made of a recording it is a copy of thousands of pieces.
    let is_wanted = setup.preset.model.piezo.is_some()
        && setup.overlays.iter().any(Overlay::is_under_shared_drive);
    let resolve = || RecordedDriveCache::default().resolve(setup).ok();
    is_wanted.then(resolve).flatten()
}

/// The recordings of a role as the person has set them up.
pub(crate) fn recordings(setup: &Setup, role: Role) -> Vec<Arc<Recording>> {
    let shared = shared_drive(setup);
    with_role(setup, role)
        .map(|overlay| as_set_up(overlay, shared.as_ref()))
        .collect()
}

/// A recording as the person has set it up: its readings scaled and shifted, its drive, and what of
/// its instrument is unknown. `shared` is the drive of the simulation, which is also that of a recording
/// without voltage; without one, a recording under it keeps its measured voltage.
pub(crate) fn as_set_up(overlay: &Overlay, shared: Option<&Waveform>) -> Arc<Recording> {
    let alignment = &overlay.alignment;
    let drive = source(overlay, shared);
    let is_as_read = *alignment == Alignment::default()
        && drive == DriveSource::default()
        && overlay.estimates == Estimates::default();
    if is_as_read {
        return Arc::clone(&overlay.recording);
    }
    // A shift is that of the readings against the voltage. Without one it is that of all.
    let is_driven =
        overlay.recording.voltage.is_some() || matches!(drive, DriveSource::Waveform { .. });
    let lag = if is_driven {
        -alignment.time_shift
    } else {
        0.0
    };
    let unknown = overlay.estimates.unknowns(lag);
    let mut recording = set_up(&overlay.recording, alignment, drive, Some(unknown));
    if let DriveSource::Waveform { waveform, start } = &recording.drive_source {
        let volts = recording.time.iter().map(|t| waveform.voltage(t - start));
        recording.voltage = Some(volts.collect());
    } else if recording.voltage.is_none() {
        for t in &mut recording.time {
            *t = alignment.time(*t);
        }
    }
    Arc::new(recording)
}

/// What drives a recording, in words.
fn drive_text(overlay: &Overlay, shared: Option<&Waveform>) -> String {
    match source(overlay, shared) {
        DriveSource::Measured(reading) => format!("its voltage: {}", reading.label()),
        DriveSource::Waveform { waveform, .. } => waveform.to_string(),
    }
}

/// What drives a recording.
fn source(overlay: &Overlay, shared: Option<&Waveform>) -> DriveSource {
    let (first, _) = overlay.recording.span();
    let shared = shared.filter(|_| overlay.is_under_shared_drive());
    match (&overlay.drive, shared) {
        // The simulation's t = 0 is that of the recording's times.
        (OwnDrive::Shared | OwnDrive::Measured(_), Some(waveform)) => DriveSource::Waveform {
            waveform: waveform.clone(),
            start: 0.0,
        },
        (OwnDrive::Shared, None) => DriveSource::default(),
        (OwnDrive::Measured(reading), None) => DriveSource::Measured(*reading),
        (OwnDrive::Chosen(waveform), _) => DriveSource::Waveform {
            waveform: waveform.clone(),
            start: first,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::origin::*;
    use crate::app::files::built_in;
    use crate::app::setup::drive_choice::DriveChoice;
    use crate::model::preset::Preset;

    #[test]
    fn what_has_changed_is_said() {
        let mut setup = built_in::setup();
        setup.overlays.truncate(1);
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
        assert!(Arc::ptr_eq(&as_set_up(overlay, None), &overlay.recording));
        overlay.alignment.time_shift = 1e-3;
        overlay.alignment.xp_offset = 2e-6;
        overlay.estimates.scales = true;
        let moved = as_set_up(overlay, None);
        // The shift is that of the readings against the voltage, which keeps its times.
        assert_eq!(moved.time[5], overlay.recording.time[5]);
        let unknown = moved.instrument.unwrap();
        assert_eq!((unknown.lag, unknown.zeros), (-1e-3, true));
        assert!(unknown.scale.is_some() && unknown.clock.is_some());
        let apart = moved.proof_mass[5] - overlay.recording.proof_mass[5];
        assert!((apart - 2e-6).abs() < 1e-15);
    }

    #[test]
    fn a_drive_chosen_for_a_recording_is_that_of_the_fit() {
        let mut setup = built_in::setup();
        let overlay = &mut setup.overlays[0];
        let waveform = Waveform::parse("square:15Hz:6V", 1.0).unwrap();
        overlay.drive = OwnDrive::Chosen(waveform.clone());
        let used = as_set_up(overlay, None);
        let drive = used.own_drive().unwrap().unwrap();
        assert_eq!(drive.text, waveform.to_string());
        assert_eq!(used.voltage.as_ref().unwrap()[0], 6.0);
        overlay.drive = OwnDrive::Shared;
        let shared = as_set_up(overlay, Some(&waveform));
        assert_eq!(
            shared.own_drive().unwrap().unwrap().text,
            waveform.to_string()
        );
    }

    #[test]
    fn a_recording_without_voltage_is_under_the_drive_of_the_simulation() {
        let mut setup = built_in::setup();
        setup.overlays.truncate(1);
        assert_eq!(shared_drive(&setup), None, "it has a drive of its own");
        Arc::make_mut(&mut setup.overlays[0].recording).voltage = None;
        let shared = shared_drive(&setup).unwrap();
        let overlay = &setup.overlays[0];
        let used = as_set_up(overlay, Some(&shared));
        let drive = used.own_drive().unwrap().unwrap();
        assert_eq!(drive.text, shared.to_string());
        assert!(used.has_voltage());
        assert_eq!(drive_text(overlay, Some(&shared)), shared.to_string());
        // Another drive of the simulation is another drive of the recording.
        let origin = Origin::of(&setup);
        let mut changed = setup.clone();
        let other = Waveform::parse("square:21Hz:5V", 1.0).unwrap();
        changed.drive = DriveChoice::Waveform(other);
        let said = origin.differences(&changed).unwrap();
        assert!(said.contains("has another drive"), "{said}");
        // A device without a piezo has no drive.
        setup.preset = Preset::load("oscillator").unwrap();
        assert_eq!(shared_drive(&setup), None);
    }
}
