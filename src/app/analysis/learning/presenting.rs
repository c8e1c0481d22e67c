//! The presenter: one or two scenes that fill the screen, and scenes saved on keys.

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::Context;

use super::runs::{SceneQuestion, SceneResult, SceneRuns};
use crate::app::analysis::explore::latest::Latest;
use crate::learn::controls::Control;
use crate::learn::lesson::LessonPicture;
use crate::learn::playback::{Playback, SlowMoments};
use crate::learn::run::Scene;

/// What is shown besides the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shows {
    /// Names and values at the arrows of forces.
    pub forces: bool,
    /// Bars of energies.
    pub energies: bool,
    /// The plots.
    pub plots: bool,
    /// The picture goes near at impacts.
    pub zoom: bool,
    /// The keys.
    pub keys: bool,
}

impl Default for Shows {
    fn default() -> Self {
        Self {
            forces: true,
            energies: true,
            plots: true,
            zoom: true,
            keys: false,
        }
    }
}

/// A scene on the screen.
#[derive(Debug, Clone)]
pub struct Side {
    /// Device, drive and span.
    pub scene: Scene,
    /// The same as it was when the presenter began; a reset goes back to it.
    pub original: Scene,
    runs: Latest<SceneRuns>,
    newest: Option<SceneResult>,
    /// Why no run is shown.
    pub problem: Option<String>,
}

impl Side {
    fn new(scene: Scene) -> Self {
        Self {
            original: scene.clone(),
            scene,
            runs: Latest::default(),
            newest: None,
            problem: None,
        }
    }

    /// The run that is shown.
    pub fn result(&self) -> Option<&SceneResult> {
        self.newest.as_ref()
    }

    fn update(&mut self, context: &Context) {
        let question = SceneQuestion {
            scene: self.scene.clone(),
            step: None,
            round: None,
        };
        self.runs.ask(question, context);
        if let Some(answered) = self.runs.newest() {
            match &answered.answer {
                Ok(result) => {
                    self.problem = None;
                    self.newest = Some(result.clone());
                }
                Err(error) if !self.runs.is_waiting() => self.problem = Some(error.clone()),
                Err(_) => {}
            }
        }
    }
}

/// A saved scene: everything that is needed to show it again.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedScene {
    /// Device, drive and span.
    pub scene: Scene,
    /// Its sliders.
    pub controls: Vec<Control>,
    /// Its pictures.
    pub pictures: Vec<LessonPicture>,
    /// Simulated seconds per second.
    pub speed: f64,
    /// What was shown.
    pub shows: Shows,
}

/// Scenes by key, 1 to 9.
pub type SavedScenes = BTreeMap<u8, SavedScene>;

/// The presenter while it fills the screen.
#[derive(Debug, Clone)]
pub struct Presenting {
    /// A, and B beside it.
    pub sides: Vec<Side>,
    /// The side that sliders and pointer act on.
    pub active: usize,
    /// The sliders.
    pub controls: Vec<Control>,
    /// The slider that keys move.
    pub control: usize,
    /// The plots.
    pub pictures: Vec<LessonPicture>,
    /// The moment shown.
    pub playback: Playback,
    /// What is shown.
    pub shows: Shows,
    /// Whether the next digit saves the scene instead of showing one.
    pub is_saving: bool,
    /// The last thing that was done, in words.
    pub remark: String,
    /// Reading to which the pointer holds the mass \[m\].
    pub pulled: Option<f64>,
    /// Reading from which the mass was let go \[m\].
    pub let_go_at: Option<f64>,
    /// Beginning and end of a film \[s\]; all of the run if `None`.
    pub film: (Option<f64>, Option<f64>),
    /// Zoom factor of the window before.
    pub zoom_before: f32,
    /// Whether scenes begin whole instead of running.
    is_still: bool,
}

impl Presenting {
    /// Begins with a scene, running.
    /// One that is `still` begins at the end of the run and without zoom; keys can change both.
    pub fn new(saved: SavedScene, zoom_before: f32, is_still: bool) -> Self {
        let mut playback = Playback::new(saved.speed);
        playback.loops = true;
        playback.slows_at_impacts = true;
        let mut saved = saved;
        if is_still {
            playback.time = saved.scene.duration;
            saved.shows.zoom = false;
        } else {
            playback.start();
        }
        Self {
            sides: vec![Side::new(saved.scene)],
            active: 0,
            controls: saved.controls,
            control: 0,
            pictures: saved.pictures,
            playback,
            shows: saved.shows,
            is_saving: false,
            remark: String::new(),
            pulled: None,
            let_go_at: None,
            film: (None, None),
            zoom_before,
            is_still,
        }
    }

    /// Shows a saved scene.
    pub fn show_saved(&mut self, saved: SavedScene) {
        let before = (self.zoom_before, self.playback);
        *self = Self::new(saved, before.0, self.is_still);
        self.playback.slows_at_impacts = before.1.slows_at_impacts;
    }

    /// What is on the active side now, to be saved.
    pub fn saved(&self) -> Option<SavedScene> {
        Some(SavedScene {
            scene: self.side()?.scene.clone(),
            controls: self.controls.clone(),
            pictures: self.pictures.clone(),
            speed: self.playback.speed,
            shows: Shows {
                keys: false,
                ..self.shows
            },
        })
    }

    /// The side that sliders act on.
    pub fn side(&self) -> Option<&Side> {
        self.sides.get(self.active)
    }

    /// The side that sliders act on.
    pub fn side_mut(&mut self) -> Option<&mut Side> {
        self.sides.get_mut(self.active)
    }

    /// Shows B beside A, or A alone.
    pub fn toggle_second(&mut self) {
        if self.sides.len() > 1 {
            self.sides.truncate(1);
            self.active = 0;
            return;
        }
        if let Some(first) = self.sides.first() {
            let second = Side::new(first.scene.clone());
            self.sides.push(second);
            self.active = 1;
        }
    }

    /// Sliders act on the other side.
    pub fn switch_side(&mut self) {
        self.active = (self.active + 1) % self.sides.len().max(1);
    }

    /// The longest span of the sides \[s\].
    pub fn duration(&self) -> f64 {
        let spans = self.sides.iter().map(|side| side.scene.duration);
        spans.fold(0.0, f64::max)
    }

    /// Holds the mass at a reading \[m\].
    pub fn hold(&mut self, reading: f64) {
        self.pulled = Some(reading);
        if let Some(side) = self.side_mut() {
            side.scene.pull_to(reading);
        }
        self.playback.time = 0.0;
        self.playback.is_playing = false;
    }

    /// Lets go of the mass at a reading \[m\]: the run begins there.
    pub fn let_go(&mut self, reading: f64) {
        self.pulled = None;
        self.let_go_at = Some(reading);
        if let Some(side) = self.side_mut() {
            side.scene.pull_to(reading);
        }
        self.playback.start();
    }

    /// Asks for runs, takes them, and advances the moment by `wall` \[s\].
    pub fn update(&mut self, context: &Context, wall: f64) {
        for side in &mut self.sides {
            side.update(context);
        }
        let duration = self.duration();
        // It is slow where any of the sides has an impact.
        let sides = self.sides.iter().filter_map(Side::result);
        let at = self.playback.time;
        let nearest = sides.max_by(|a, b| {
            let nearness = |side: &SceneResult| side.slow.nearness(at);
            nearness(a).total_cmp(&nearness(b))
        });
        let slow =
            nearest.map_or_else(|| Arc::new(SlowMoments::default()), |r| Arc::clone(&r.slow));
        if self.pulled.is_none() {
            self.playback.advance(wall, duration, &slow);
        }
        if self.playback.is_playing {
            context.request_repaint();
        }
    }
}
