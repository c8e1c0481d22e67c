//! Heights of the pictures, and the handles between them.

use std::collections::BTreeMap;

use eframe::egui::{
    CursorIcon, EventFilter, Id, Key, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};

use crate::app::setup::view::Picture;

/// How far an arrow key moves a handle \[points\].
const ARROW_KEY_STEP: f32 = 12.0;

/// The smallest height that a handle can give a picture \[points\].
fn min_height(picture: Picture) -> f32 {
    match picture {
        Picture::Device => 110.0,
        _ => 48.0,
    }
}

/// How much the person enlarged each picture, as a factor.
type HeightFactors = BTreeMap<Picture, f32>;

fn id() -> Id {
    Id::unique("plot heights")
}

/// The heights `own` as changed with the handles; their sum stays the same.
pub fn heights(ui: &Ui, own: &[(Picture, f32)]) -> Vec<f32> {
    let factors: HeightFactors = ui.data(|data| data.get_temp(id())).unwrap_or_default();
    let factor = |picture: &Picture| factors.get(picture).copied().unwrap_or(1.0);
    let wanted: Vec<f32> = own
        .iter()
        .map(|(p, h)| (h * factor(p)).max(min_height(*p)))
        .collect();
    let sum = |heights: &[f32]| heights.iter().sum::<f32>().max(1.0);
    let whole: f32 = own.iter().map(|(_, height)| height).sum();
    let scale = whole / sum(&wanted);
    wanted
        .iter()
        .map(|height| (height * scale).floor())
        .collect()
}

/// The handle between two pictures with their heights; `space` points high.
pub fn handle(ui: &mut Ui, above: (Picture, f32), below: (Picture, f32), space: f32) {
    let size = vec2(ui.available_width(), space);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let name = format!("Height of {} and {}", above.0.name(), below.0.name());
    response.widget_info(|| WidgetInfo::labeled(Role::Splitter, true, &name));
    let active = response.hovered() || response.dragged() || response.has_focus();
    if active {
        ui.set_cursor_icon(CursorIcon::ResizeVertical);
        let middle = rect.center();
        let ends = [-24.0, 24.0].map(|x| pos2(middle.x + x, middle.y));
        let color = ui.visuals().widgets.hovered.fg_stroke.color;
        ui.painter().line_segment(ends, Stroke::new(2.0, color));
    }
    let mut step = response.drag_delta().y;
    if response.has_focus() {
        let filter = EventFilter {
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        let pressed = |key| ui.input(|input| input.num_presses(key)) as f32;
        step += ARROW_KEY_STEP * (pressed(Key::ArrowDown) - pressed(Key::ArrowUp));
    }
    if response.double_clicked() {
        ui.data_mut(|data| data.remove_temp::<HeightFactors>(id()));
    } else if step != 0.0 {
        shift(ui, above, below, step);
    }
    response.on_hover_text(
        "Drag, or press the up and down keys, to change the heights; double-click to reset.",
    );
}

/// Moves the handle down by `step` points: the upper picture grows, the lower one shrinks.
fn shift(ui: &Ui, above: (Picture, f32), below: (Picture, f32), step: f32) {
    let room = |(picture, height): (Picture, f32)| (height - min_height(picture)).max(0.0);
    let step = step.clamp(-room(above), room(below));
    ui.data_mut(|data| {
        let factors: &mut HeightFactors = data.get_temp_mut_or_default(id());
        for ((picture, height), step) in [(above, step), (below, -step)] {
            *factors.entry(picture).or_insert(1.0) *= (height + step) / height.max(1.0);
        }
    });
}
