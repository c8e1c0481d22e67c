//! A scene up to a moment: the device, bars of its energies, and plots with a dot that runs along
//! them. Lessons, the presenter and films draw it. Scales stay while it plays.

mod energies;
mod overlay;

use std::sync::Arc;

use eframe::egui::{Id, Ui, Vec2, vec2};

pub use self::overlay::{Overlay, Predicted};

use super::device::{DeviceLook, DevicePlace, show_as};
use super::frame::readout::Readout;
use super::frame::time_plot::{Common, Reply, TIME_AXIS_HEIGHT, TimePlot};
use super::{describe, plane};
use crate::app::analysis::learning::runs::SceneResult;
use crate::app::files::built_in;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::view::{Picture, View};
use crate::app::state::State;
use crate::learn::lesson::LessonPicture;
use crate::learn::run::Scene;

/// Share of the height for the device where plots follow.
const DEVICE_SHARE: f32 = 0.44;
/// The same where pictures in a plane follow too.
const SMALL_DEVICE_SHARE: f32 = 0.36;
/// Share of the height for pictures in a plane.
const PLANE_SHARE: f32 = 0.34;
/// Width of the bars of energies \[points\].
const ENERGY_WIDTH: f32 = 236.0;
/// Smallest width of the device next to them \[points\].
const MIN_DEVICE_WIDTH: f32 = 300.0;
/// Space between pictures \[points\].
const PICTURE_SPACING: f32 = 6.0;

/// What is drawn.
pub struct Stage<'a> {
    /// Device, drive and span.
    pub scene: &'a Scene,
    /// Its run.
    pub result: &'a SceneResult,
    /// The moment \[s\].
    pub time: f64,
    /// The pictures.
    pub pictures: &'a [LessonPicture],
    /// How the device looks.
    pub look: DeviceLook,
    /// What is laid over the trajectory.
    pub overlay: Overlay<'a>,
    /// Whether scales only grow while the scene is changed, so that runs can be compared.
    pub holds_scale: bool,
    /// Distinguishes stages that are drawn at once.
    pub name: &'static str,
}

/// Where things were drawn.
#[derive(Default)]
pub struct StageOutput {
    /// The device.
    pub device: Option<DevicePlace>,
    /// The plot of the trajectory.
    pub trajectory: Option<Reply>,
}

impl Stage<'_> {
    fn has(&self, picture: LessonPicture) -> bool {
        self.pictures.contains(&picture)
    }

    /// Draws it in the room that `ui` has.
    pub fn show(&self, ui: &mut Ui) -> StageOutput {
        ui.push_id(("stage", self.name), |ui| self.draw(ui)).inner
    }

    fn draw(&self, ui: &mut Ui) -> StageOutput {
        let mut output = StageOutput::default();
        let state = self.state();
        let plots = self.plots(ui, &state);
        let planes = self.planes();
        let space = ui.available_size();
        ui.spacing_mut().item_spacing.y = 0.0;
        let has_device = self.has(LessonPicture::Device) || self.has(LessonPicture::Energy);
        let mut rest = space.y;
        if has_device {
            let height = match (plots.is_empty(), planes.is_empty()) {
                (true, true) => rest,
                (_, true) => DEVICE_SHARE * rest,
                (_, false) => SMALL_DEVICE_SHARE * rest,
            };
            output.device = self.device_row(ui, &state, vec2(space.x, height));
            ui.add_space(PICTURE_SPACING);
            rest -= height + PICTURE_SPACING;
        }
        let plane_height = match plots.is_empty() {
            _ if planes.is_empty() => 0.0,
            true => rest,
            false => PLANE_SHARE * space.y,
        };
        if !plots.is_empty() {
            output.trajectory = self.time_plots(ui, &state, plots, rest - plane_height);
        }
        if !planes.is_empty() {
            ui.add_space(PICTURE_SPACING);
            let mut up_to_now = state;
            up_to_now.view.time_range = Some((0.0, self.time.max(1e-3 * self.scene.duration)));
            let width = ui.available_width() / planes.len() as f32 - 14.0;
            let height = (plane_height - 2.0 * PICTURE_SPACING).max(60.0);
            ui.horizontal(|ui| {
                for picture in planes {
                    plane(ui, &up_to_now, picture, [width, height]).show(ui);
                }
            });
        }
        output
    }

    /// What the pictures are drawn from.
    fn state(&self) -> State {
        let mut setup = built_in::from_preset(self.scene.preset.clone());
        setup.drive = DriveChoice::Waveform(self.scene.drive.clone());
        setup.duration = self.scene.duration;
        let shown = |picture: &LessonPicture| match picture {
            LessonPicture::Voltage => Some(Picture::Voltage),
            LessonPicture::Trajectory => Some(Picture::Trajectory),
            LessonPicture::Forces => Some(Picture::Forces),
            _ => None,
        };
        let view = View {
            pictures: self.pictures.iter().filter_map(shown).collect(),
            time_range: Some((0.0, self.scene.duration)),
            ..View::default()
        };
        let mut state = State::new(setup, view);
        state.snapshot = Some(Arc::clone(&self.result.snapshot));
        state.cursors.hover = Some(self.time);
        state
    }

    fn planes(&self) -> Vec<Picture> {
        let pictures = self.pictures.iter();
        let planes = pictures.filter_map(|picture| match picture {
            LessonPicture::PhasePortrait => Some(Picture::PhasePortrait),
            LessonPicture::DriveLoop if self.scene.preset.model.piezo.is_some() => {
                Some(Picture::DriveLoop)
            }
            _ => None,
        });
        planes.collect()
    }

    /// The plots against time, with the moment and what is laid over.
    fn plots(&self, ui: &Ui, state: &State) -> Vec<TimePlot> {
        let (mut plots, _) = describe(ui, state);
        for plot in &mut plots {
            plot.playhead = Some(self.time);
            if plot.picture == Picture::Trajectory {
                overlay::lay_over(ui, plot, self);
            }
            if self.holds_scale {
                self.hold_scale(ui, plot);
            }
        }
        if let Some(residual) = overlay::residual(ui, self) {
            plots.push(residual);
        }
        plots
    }

    /// Gives a plot the largest scale that it has had for this device and span, on any side.
    fn hold_scale(&self, ui: &Ui, plot: &mut TimePlot) {
        let device = &self.scene.preset.model.name;
        let span = self.scene.duration.to_bits();
        let id = Id::unique(("held scale", plot.picture.name(), device, span));
        let (low, high) = plot.range((0.0, self.scene.duration));
        let held = ui.data(|data| data.get_temp::<(f64, f64)>(id));
        let range = held.map_or((low, high), |held| (held.0.min(low), held.1.max(high)));
        ui.data_mut(|data| data.insert_temp(id, range));
        plot.chosen = Some(range);
    }

    fn device_row(&self, ui: &mut Ui, state: &State, size: Vec2) -> Option<DevicePlace> {
        let mut place = None;
        ui.allocate_ui(size, |ui| {
            ui.set_min_size(size);
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = 8.0;
                let has_device = self.has(LessonPicture::Device);
                let has_room = !has_device || size.x > ENERGY_WIDTH + MIN_DEVICE_WIDTH;
                let has_bars = self.has(LessonPicture::Energy) && has_room;
                let bars = if has_bars { ENERGY_WIDTH } else { 0.0 };
                if has_device {
                    let own = vec2((size.x - bars - 8.0).max(60.0), size.y);
                    ui.allocate_ui(own, |ui| {
                        place = show_as(ui, state, Some(self.time), self.look);
                    });
                }
                if has_bars {
                    let width = if has_device { bars } else { size.x };
                    energies::show(ui, self, vec2(width, size.y));
                }
            });
        });
        place
    }

    /// Draws the plots against time; returns where the trajectory is.
    fn time_plots(
        &self,
        ui: &mut Ui,
        state: &State,
        plots: Vec<TimePlot>,
        space: f32,
    ) -> Option<Reply> {
        // The picture is that of the lesson: nothing is switched.
        let readout = Readout::of(ui, state, &plots).without_switches();
        let _ = readout.show(ui);
        let common = Common {
            window: (0.0, self.scene.duration),
            cursors: state.cursors,
        };
        let room = space - readout.height(ui.available_width()) - TIME_AXIS_HEIGHT;
        let room = room - PICTURE_SPACING * plots.len() as f32;
        let weight = |plot: &TimePlot| match plot.picture {
            Picture::Trajectory => 2.0,
            Picture::Forces => 1.6,
            _ => 1.0,
        };
        let total: f32 = plots.iter().map(weight).sum();
        let last = plots.len().saturating_sub(1);
        let mut trajectory = None;
        for (i, plot) in plots.into_iter().enumerate() {
            let lowest = i == last;
            let own = (room * weight(&plot) / total).floor().max(40.0);
            let height = own + if lowest { TIME_AXIS_HEIGHT } else { 0.0 };
            let is_trajectory = plot.picture == Picture::Trajectory;
            let reply = plot.show(ui, &common, height, lowest);
            if is_trajectory {
                overlay::paint(ui, self, &reply);
                trajectory = Some(reply);
            }
            ui.add_space(PICTURE_SPACING);
        }
        trajectory
    }
}
