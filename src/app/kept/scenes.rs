//! What a session keeps of the presenter: the scenes on its keys.

use serde::{Deserialize, Serialize};

use crate::app::analysis::learning::presenting::{SavedScene, SavedScenes, Shows};
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::drive_text::DriveEntry;
use crate::learn::controls::Control;
use crate::learn::lesson::LessonPicture;
use crate::learn::run::Scene;
use crate::model::preset::Preset;

/// A scene on a key. A device is kept as the text of a preset, which checks itself when it is read.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct StoredScene {
    key: u8,
    preset: String,
    drive: DriveEntry,
    duration: f64,
    speed: f64,
    controls: Vec<(String, Option<(f64, f64)>)>,
    pictures: Vec<String>,
    forces: bool,
    energies: bool,
    plots: bool,
    zoom: bool,
}

/// The scenes as they are stored.
pub(super) fn stored(scenes: &SavedScenes) -> Vec<StoredScene> {
    let all = scenes.iter().map(|(key, saved)| {
        let controls = saved.controls.iter().map(|c| (c.id.clone(), c.range));
        let pictures = saved.pictures.iter().map(|p| p.name().to_owned());
        StoredScene {
            key: *key,
            preset: saved.scene.preset.to_toml(),
            drive: DriveEntry::of(&DriveChoice::Waveform(saved.scene.drive.clone())),
            duration: saved.scene.duration,
            speed: saved.speed,
            controls: controls.collect(),
            pictures: pictures.collect(),
            forces: saved.shows.forces,
            energies: saved.shows.energies,
            plots: saved.shows.plots,
            zoom: saved.shows.zoom,
        }
    });
    all.collect()
}

/// The scenes that can be read. One that cannot is left out.
pub(super) fn read(stored: Vec<StoredScene>) -> SavedScenes {
    let read = stored.into_iter().filter_map(|scene| {
        let key = scene.key;
        let saved = one(scene);
        if saved.is_none() {
            log::warn!("scene {key} of the presenter cannot be read");
        }
        Some((key, saved?))
    });
    read.collect()
}

fn one(stored: StoredScene) -> Option<SavedScene> {
    let preset = Preset::parse("scene of the presenter", &stored.preset).ok()?;
    let drive = stored.drive.read(stored.duration).ok()?;
    let DriveChoice::Waveform(drive) = drive else {
        return None;
    };
    let is_sound = |value: f64| value > 0.0 && value.is_finite();
    if !is_sound(stored.duration) || !is_sound(stored.speed) {
        return None;
    }
    let controls = stored.controls.into_iter();
    let picture = |name: String| LessonPicture::ALL.into_iter().find(|p| p.name() == name);
    Some(SavedScene {
        scene: Scene {
            preset,
            drive,
            duration: stored.duration,
        },
        controls: controls.map(|(id, range)| Control { id, range }).collect(),
        pictures: stored.pictures.into_iter().filter_map(picture).collect(),
        speed: stored.speed,
        shows: Shows {
            forces: stored.forces,
            energies: stored.energies,
            plots: stored.plots,
            zoom: stored.zoom,
            keys: false,
        },
    })
}
