//! The column of text next to the device.

use eframe::egui::{Color32, Painter, pos2, vec2};

use super::moment::{Extremes, Moment};
use super::paint::{Colors, arrow, text};
use super::{Kind, Layout};
use crate::model::unit::{format_number, format_quantity};

/// Points per metre on a screen with 96 points per inch.
const POINTS_PER_METRE: f64 = 96.0 / 0.0254;

/// Draws regime, time, voltage, displacement and forces, one line each, and the scale.
pub(super) fn show(
    painter: &Painter,
    layout: &Layout,
    colors: &Colors,
    moment: &Moment,
    extremes: &Extremes,
    kind: Kind,
) {
    let c = colors;
    let mut at = layout.column;
    let bottom = layout.area.bottom();
    let regime_color = match moment.contact_since {
        Some(_) => c.contact,
        None => c.text,
    };
    let has_ground = layout.ground.is_some();
    if has_ground {
        text(painter, at, "lt", moment.regime(), 13.0, regime_color);
        at.y += 19.0;
    }
    let mut line = |marker: Option<(Color32, f64)>, words: String, color: Color32| {
        // The last line is reserved for the scale.
        if at.y + 30.0 > bottom {
            return;
        }
        if let Some((color, value)) = marker {
            let half = if value < 0.0 { -5.5 } else { 5.5 };
            let foot = at + vec2(5.0, 7.0 + half);
            arrow(painter, foot, 2.0 * half, 2.0, color);
        }
        let indent = if marker.is_some() { 14.0 } else { 0.0 };
        text(painter, at + vec2(indent, 0.0), "lt", words, 12.0, color);
        at.y += 15.0;
    };
    let quantity = |value: f64, unit| format_quantity(value, unit, 3);
    let mut first = format!("t = {}", format_quantity(moment.time, "s", 5));
    if let Some(voltage) = moment.voltage.filter(|_| kind == Kind::Cantilever) {
        first = format!("V = {},  {first}", quantity(voltage, "V"));
    }
    line(None, first, c.text);
    let name = if kind == Kind::Free { "height" } else { "x" };
    let name = if kind == Kind::Cantilever { "xp" } else { name };
    line(
        None,
        format!("{name} = {}", quantity(moment.reading, "m")),
        c.text,
    );
    if kind == Kind::Free {
        // Rounding errors of the simulator are shown as zero.
        let rounding = moment.velocity.abs() < 1e-9 * extremes.speed;
        let velocity = if rounding { 0.0 } else { moment.velocity };
        let marker = (velocity != 0.0).then_some((c.drive, velocity));
        line(
            marker,
            format!("velocity {}", quantity(velocity, "m/s")),
            c.text,
        );
    }
    let shown = |value: Option<f64>| value.filter(|f| f.abs() >= 5e-13);
    let forces = [
        ("piezo drive", shown(moment.drive), c.drive),
        ("gas film", shown(moment.film), c.film),
        ("restoring force", shown(moment.pull_off), c.pull),
        ("ground", shown(moment.ground), c.reaction),
        (
            "adhesion limit",
            shown(moment.adhesion.map(|f| -f)),
            c.adhesion,
        ),
        (moment.effects_name, shown(moment.effects), c.weak),
    ];
    for (name, force, color) in forces {
        let Some(force) = force.filter(|_| kind != Kind::Free || name == moment.effects_name)
        else {
            continue;
        };
        let words = format!("{name} {}", quantity(force.abs(), "N"));
        line(Some((color, force)), words, c.text);
    }
    let times = layout.scale / POINTS_PER_METRE;
    let scale = if times >= 1.0 {
        format!("vertical scale \u{d7} {}", format_number(times, 2))
    } else {
        format!("vertical scale 1 : {}", format_number(1.0 / times, 2))
    };
    let foot = pos2(layout.column.x, bottom - 14.0);
    text(painter, foot, "lt", scale, 11.0, c.weak);
}
