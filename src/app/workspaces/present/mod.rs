//! The presenter: one device, or two beside each other, that fill the screen, with few large
//! sliders. All is done by keys; the pointer can pull the mass and let it go.

mod keys;
mod sliders;

use eframe::egui::{
    Align2, CentralPanel, Color32, Frame, Grid, Label, Panel, Rect, RichText, Stroke, Ui,
    UiBuilder, Window, vec2,
};

pub use self::keys::PRESENTER_KEYS;

use crate::app::analysis::learning::presenting::{Presenting, SavedScenes};
use crate::app::plots::device::{DeviceLook, DevicePlace};
use crate::app::plots::stage::{Overlay, Stage};
use crate::app::setup::command::Command;
use crate::app::state::State;
use crate::app::workspaces::tune::speed_text;
use crate::learn::lesson::LessonPicture;
use crate::model::unit::format_quantity;

/// How much larger everything is than in the window: type of 13 points is then read from the last
/// row.
pub const PRESENTER_ZOOM: f32 = 1.9;
/// Size of the head line \[points\].
const HEAD_SIZE: f32 = 15.0;

/// Draws the presenter over the whole window.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(mut presenting) = state.presenting.take() else {
        return;
    };
    let asked = keys::handle(ui, &mut presenting, &mut state.scenes);
    let wall = ui.input(|input| f64::from(input.unstable_dt));
    presenting.update(ui.ctx(), wall);
    Panel::bottom("presenter sliders").show(ui, |ui| {
        sliders::show(ui, &mut presenting);
    });
    CentralPanel::default().show(ui, |ui| {
        head(ui, &presenting, &state.scenes);
        sides(ui, &mut presenting);
    });
    if presenting.shows.keys {
        key_list(ui, &mut presenting);
    }
    state.presenting = Some(presenting);
    if let Some(command) = asked {
        state.ask(command);
    }
}

/// Time, speed, what was done last, and which keys hold scenes.
fn head(ui: &mut Ui, presenting: &Presenting, scenes: &SavedScenes) {
    let playback = &presenting.playback;
    let mut text = format!("t = {}", format_quantity(playback.time, "s", 4));
    let state = match (presenting.pulled, playback.is_playing) {
        (Some(_), _) => "held".to_owned(),
        (None, true) => format!("speed {}", speed_text(playback.speed)),
        (None, false) => "paused".to_owned(),
    };
    text += &format!("   {state}");
    if let Some(reading) = presenting.pulled {
        text += &format!("   pulled to {}", format_quantity(reading, "m", 3));
    } else if let Some(reading) = presenting.let_go_at {
        text += &format!("   let go at {}", format_quantity(reading, "m", 3));
    }
    if !scenes.is_empty() {
        let keys: Vec<String> = scenes.keys().map(u8::to_string).collect();
        text += &format!("   scenes {}", keys.join(" "));
    }
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).size(HEAD_SIZE).strong());
        let remark = if presenting.is_saving {
            "Save this scene on which key, 1 to 9?"
        } else {
            presenting.remark.as_str()
        };
        ui.add(Label::new(RichText::new(remark).size(HEAD_SIZE)).truncate());
    });
}

/// A, and B beside it.
fn sides(ui: &mut Ui, presenting: &mut Presenting) {
    let count = presenting.sides.len().max(1);
    let space = ui.available_size();
    let width = space.x / count as f32 - 4.0;
    let origin = ui.cursor().min;
    for i in 0..count {
        let corner = origin + vec2(i as f32 * (width + 8.0), 0.0);
        let rect = Rect::from_min_size(corner, vec2(width, space.y));
        let mut child = ui.new_child(UiBuilder::new().max_rect(rect).id_salt(("side", i)));
        if count > 1 {
            let is_active = presenting.active == i;
            let name = ["A", "B"].get(i).copied().unwrap_or_default();
            let text = RichText::new(name).size(22.0).strong();
            let selection = child.visuals().selection.stroke.color;
            // Both take the same room, so that the pictures stand at one height.
            let frame = if is_active {
                selection
            } else {
                Color32::TRANSPARENT
            };
            Frame::new()
                .stroke(Stroke::new(2.0, frame))
                .inner_margin(2.0)
                .show(&mut child, |ui| ui.label(text));
        }
        side(&mut child, presenting, i);
    }
}

fn side(ui: &mut Ui, presenting: &mut Presenting, index: usize) {
    let Some(side) = presenting.sides.get(index) else {
        return;
    };
    if let Some(problem) = &side.problem {
        let color = crate::app::widgets::text::error_color(ui);
        ui.colored_label(color, format!("This cannot be simulated: {problem}"));
    }
    let Some(result) = side.result().cloned() else {
        ui.label("The run is being computed.");
        return;
    };
    let shows = presenting.shows;
    let time = presenting.playback.time.min(side.scene.duration);
    let zoom = if shows.zoom && presenting.pulled.is_none() {
        result.slow.nearness(time)
    } else {
        0.0
    };
    let mut pictures = vec![LessonPicture::Device];
    if shows.energies {
        pictures.push(LessonPicture::Energy);
    }
    if shows.plots {
        let plots = presenting.pictures.iter().copied();
        pictures
            .extend(plots.filter(|p| !matches!(p, LessonPicture::Device | LessonPicture::Energy)));
    }
    let stage = Stage {
        scene: &side.scene,
        result: &result,
        time,
        pictures: &pictures,
        look: DeviceLook {
            zoom,
            has_labels: shows.forces,
            is_movable: true,
        },
        overlay: Overlay::default(),
        holds_scale: true,
        name: ["A", "B"].get(index).copied().unwrap_or("A"),
    };
    let output = stage.show(ui);
    if let Some(place) = output.device {
        pull(ui, presenting, index, &place);
    }
}

/// The mass taken by the pointer, and let go.
fn pull(ui: &Ui, presenting: &mut Presenting, index: usize, place: &DevicePlace) {
    let response = &place.response;
    if response.dragged()
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let reading = place.reading_at(pointer.y);
        presenting.active = index;
        presenting.hold(reading);
        ui.ctx().request_repaint();
    }
    if response.drag_stopped()
        && let Some(reading) = presenting.pulled
    {
        presenting.let_go(reading);
    }
}

/// The list of keys over the picture.
fn key_list(ui: &mut Ui, presenting: &mut Presenting) {
    let mut is_open = true;
    Window::new("Keys of the presenter")
        .open(&mut is_open)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .resizable(false)
        .show(ui, |ui| {
            Grid::new("presenter keys")
                .num_columns(2)
                .spacing([14.0, 2.0])
                .show(ui, |ui| {
                    for (key, what) in PRESENTER_KEYS {
                        ui.label(RichText::new(key).strong());
                        ui.label(what);
                        ui.end_row();
                    }
                });
        });
    presenting.shows.keys &= is_open;
}

/// Says how to leave, for a moment after the start.
#[must_use]
pub fn welcome() -> String {
    format!(
        "H shows the keys, {} leaves",
        Command::Present.keys().unwrap_or_default()
    )
}
