//! What a session keeps of the sealed trial: the draw, the seal, the person's guess and the
//! marks. What is concealed is not in the file; the draw gives it again.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::app::analysis::sealed_trial::{Draw, Guess, Level, Suspended, Tally, Trial};
use crate::app::files::built_in;
use crate::app::setup::current_setup::{DiagnosisChoices, Setup};
use crate::app::setup::drive_text::{DriveEntry, OwnDriveEntry};
use crate::app::setup::explore::ExploreChoices;
use crate::app::setup::kept_curve::KeptCurve;
use crate::app::setup::overlay::{Estimates, Overlay, OverlayId, Role};
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::trial::score::Mark;

/// The window of the sealed trial, and the running trial.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TrialPanel {
    open: bool,
    seed: String,
    level: Level,
    beam: bool,
    noise: f64,
    tally: Tally,
    running: Option<Running>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Running {
    draw: Draw,
    seal: String,
    guess: Option<Guess>,
    marks: Option<(Option<Mark>, Option<Mark>)>,
}

impl TrialPanel {
    pub(super) fn of(trial: &Trial, suspended: Option<&Suspended>) -> Self {
        Self {
            open: trial.open,
            seed: trial.seed.clone(),
            level: trial.level,
            beam: trial.beam,
            noise: trial.noise,
            tally: trial.tally,
            running: suspended.map(|suspended| Running {
                draw: suspended.draw,
                seal: suspended.seal.clone(),
                guess: suspended.guess.clone(),
                marks: suspended.marks,
            }),
        }
    }

    /// Gives it to a window of the sealed trial. A tally that was begun in this run of the
    /// program stays. Returns the trial to go on with, without its setup and answers.
    pub(super) fn restore(self, trial: &mut Trial) -> Option<Suspended> {
        trial.open = self.open;
        trial.seed = self.seed;
        trial.level = self.level;
        trial.beam = self.beam;
        trial.noise = self.noise;
        if trial.tally == Tally::default() {
            trial.tally = self.tally;
        }
        let running = self.running?;
        Some(Suspended {
            draw: running.draw,
            seal: running.seal,
            guess: running.guess,
            marks: running.marks,
            setup: None,
            automatic: None,
            by_hand: None,
        })
    }
}

/// The setup of a trial, without the data of its recordings.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct StoredSetup {
    preset: String,
    original: String,
    drive: DriveEntry,
    duration: f64,
    locked: BTreeSet<String>,
    recordings: Vec<StoredOverlay>,
    #[serde(default)]
    kept: Vec<KeptCurve>,
    #[serde(default)]
    diagnosis: DiagnosisChoices,
    #[serde(default)]
    explore: ExploreChoices,
}

#[derive(Debug, Serialize, Deserialize)]
struct StoredOverlay {
    id: OverlayId,
    name: String,
    alignment: Alignment,
    drive: Option<OwnDriveEntry>,
    estimates: Estimates,
    visible: bool,
    color: usize,
    role: Option<Role>,
}

impl StoredSetup {
    pub(super) fn of(setup: &Setup) -> Self {
        let overlay = |overlay: &Overlay| StoredOverlay {
            id: overlay.id,
            name: overlay.recording.name.clone(),
            alignment: overlay.alignment,
            drive: OwnDriveEntry::of(&overlay.drive),
            estimates: overlay.estimates,
            visible: overlay.visible,
            color: overlay.color,
            role: overlay.role,
        };
        Self {
            preset: setup.preset.to_toml(),
            original: setup.original.to_toml(),
            drive: DriveEntry::of(&setup.drive),
            duration: setup.duration,
            locked: setup.locked.clone(),
            recordings: setup.overlays.iter().map(overlay).collect(),
            kept: setup.kept.clone(),
            diagnosis: setup.diagnosis.clone(),
            explore: setup.explore.clone(),
        }
    }

    /// The setup; its recordings have names and no data. `None` if it makes no sense.
    pub(super) fn read(self) -> Option<Setup> {
        let duration = self.duration;
        if !(duration > 0.0 && duration.is_finite()) {
            return None;
        }
        let overlay = |stored: StoredOverlay| {
            let (times, values) = (vec![0.0, 1.0], vec![0.0, 0.0]);
            let empty = Recording::new(&stored.name, times, None, values, None).ok()?;
            let drive = stored.drive.map(|drive| drive.read(duration)).transpose();
            Some(Overlay {
                alignment: stored.alignment,
                drive: drive.ok()?.unwrap_or_default(),
                estimates: stored.estimates,
                visible: stored.visible,
                made_up: false,
                color: stored.color,
                role: stored.role,
                ..built_in::unread(stored.id, Arc::new(empty))
            })
        };
        let recordings = self.recordings.into_iter().map(overlay);
        Some(Setup {
            preset: Preset::parse("device of the sealed trial", &self.preset).ok()?,
            original: Arc::new(Preset::parse("device of the sealed trial", &self.original).ok()?),
            drive: self.drive.read(duration).ok()?,
            duration,
            locked: self.locked,
            overlays: recordings.collect::<Option<_>>()?,
            kept: self.kept,
            diagnosis: self.diagnosis,
            explore: self.explore,
        })
    }
}
