//! The recordings as measured, shown until there is an answer: enough to recognise them and
//! to make a guess in a sealed trial.

use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Role as Kind, Sense, Stroke, Ui, WidgetInfo,
    pos2, vec2,
};

use crate::app::analysis::recording_roles;
use crate::app::plots::frame::cache;
use crate::app::plots::frame::style::{overlay_color, palette};
use crate::app::setup::overlay::{Overlay, Role};
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::state::State;
use crate::model::unit::format_quantity;
use crate::recording::Channel;

/// Height of the name \[points\].
const NAME_HEIGHT: f32 = 15.0;
/// Height of the curves \[points\].
const CURVES_HEIGHT: f32 = 62.0;

/// Draws all recordings that are used.
pub fn show(ui: &mut Ui, state: &State) {
    for (overlay, role) in recording_roles::of(&state.setup) {
        if role != Role::Unused {
            ui.push_id(overlay.id, |ui| preview(ui, overlay, role));
        }
    }
}

fn preview(ui: &mut Ui, overlay: &Overlay, role: Role) {
    let recording = &overlay.recording;
    let size = vec2(ui.available_width(), NAME_HEIGHT + CURVES_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let name = format!("{} as measured", recording.name);
    response.widget_info(|| WidgetInfo::labeled(Kind::Image, true, &name));
    if !ui.is_rect_visible(rect) {
        return;
    }
    let span = recording.span();
    let body = Rect::from_min_max(pos2(rect.left(), rect.top() + NAME_HEIGHT), rect.max);
    let painter = ui.painter_at(rect);
    painter.rect_filled(body, 2.0, ui.visuals().extreme_bg_color);
    let mut reach = String::new();
    // The drive is drawn first, behind the motion.
    for (channel, color) in [
        (Channel::Voltage, palette(ui).voltage.gamma_multiply(0.5)),
        (Channel::ProofMass, overlay_color(ui, overlay.color)),
    ] {
        let Some(pyramid) = cache::channel(ui, overlay, channel) else {
            continue;
        };
        let Some(range) = pyramid.extremes() else {
            continue;
        };
        curve(&painter, body, &pyramid, (span, range), color);
        if channel == Channel::ProofMass {
            reach = format!(", xp over {}", format_quantity(range.1 - range.0, "m", 3));
        }
    }
    let kind = if role == Role::HeldOut {
        "held out"
    } else {
        "for fitting"
    };
    let font = FontId::proportional(11.5);
    let text = format!(
        "{kind}, {}{reach}",
        format_quantity(span.1 - span.0, "s", 3)
    );
    let weak = ui.visuals().weak_text_color();
    let right = painter.text(
        rect.right_top(),
        Align2::RIGHT_TOP,
        text,
        font.clone(),
        weak,
    );
    let room = Rect::from_min_max(rect.min, pos2(right.left() - 6.0, body.top()));
    let ink = ui.visuals().text_color();
    ui.painter_at(room)
        .text(rect.min, Align2::LEFT_TOP, &recording.name, font, ink);
}

/// A curve that fills `body`: its time span and its range of values.
fn curve(
    painter: &Painter,
    body: Rect,
    pyramid: &Pyramid,
    ((from, to), (low, high)): ((f64, f64), (f64, f64)),
    color: Color32,
) {
    let inside = body.shrink2(vec2(0.0, 3.0));
    let place = |[t, v]: [f64; 2]| {
        let x = ((t - from) / (to - from).max(1e-12)) as f32;
        let y = ((v - low) / (high - low).max(1e-30)) as f32;
        pos2(
            inside.left() + x * inside.width(),
            inside.bottom() - y * inside.height(),
        )
    };
    let points = pyramid.draw(from, to, inside.width().max(1.0) as usize);
    for piece in points.split(|point| point[0].is_nan()) {
        let line: Vec<Pos2> = piece.iter().map(|p| place(*p)).collect();
        painter.line(line, Stroke::new(1.1, color));
    }
}
