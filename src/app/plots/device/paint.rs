//! Strokes, arrows and text of the picture of the device.

use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, Vec2, Visuals, pos2, vec2,
};

/// Colours of the parts. Colours with a meaning are from the palette of Okabe and Ito.
#[derive(Debug, Clone, Copy)]
pub(super) struct Colors {
    pub text: Color32,
    /// Behind a text that lies over the device.
    pub behind: Color32,
    pub weak: Color32,
    pub silicon: Color32,
    pub piezo: Color32,
    pub mass: Color32,
    pub mass_edge: Color32,
    pub clamp: Color32,
    pub ground: Color32,
    pub ground_edge: Color32,
    pub film: Color32,
    pub contact: Color32,
    pub drive: Color32,
    pub reaction: Color32,
    pub adhesion: Color32,
    pub pull: Color32,
}

impl Colors {
    /// For the dark or the light theme.
    pub fn of(visuals: &Visuals) -> Self {
        let dark = visuals.dark_mode;
        let pick = |on_dark: (u8, u8, u8), on_light: (u8, u8, u8)| {
            let (r, g, b) = if dark { on_dark } else { on_light };
            Color32::from_rgb(r, g, b)
        };
        Self {
            text: visuals.strong_text_color(),
            behind: visuals.panel_fill.gamma_multiply(0.85),
            weak: pick((165, 165, 165), (90, 90, 90)),
            silicon: pick((120, 132, 150), (130, 142, 160)),
            piezo: pick((230, 159, 0), (222, 150, 0)),
            mass: pick((86, 110, 145), (150, 172, 205)),
            mass_edge: pick((190, 208, 235), (60, 80, 115)),
            clamp: pick((95, 95, 100), (150, 150, 155)),
            ground: pick((74, 64, 54), (196, 180, 160)),
            ground_edge: pick((176, 152, 122), (112, 92, 68)),
            film: pick((86, 180, 233), (0, 114, 178)),
            contact: pick((255, 120, 60), (184, 69, 0)),
            drive: pick((240, 190, 60), (176, 112, 0)),
            reaction: pick((255, 120, 60), (213, 74, 0)),
            adhesion: pick((214, 140, 186), (170, 80, 135)),
            pull: pick((60, 190, 140), (0, 130, 95)),
        }
    }
}

/// Draws text. `place` is two letters, for horizontal (`l`, `c`, `r`) and vertical (`t`, `c`,
/// `b`) alignment.
pub(super) fn text(
    painter: &Painter,
    at: Pos2,
    place: &str,
    text: impl ToString,
    size: f32,
    color: Color32,
) -> Rect {
    let align = match place {
        "lt" => Align2::LEFT_TOP,
        "lc" => Align2::LEFT_CENTER,
        "lb" => Align2::LEFT_BOTTOM,
        "ct" => Align2::CENTER_TOP,
        "rc" => Align2::RIGHT_CENTER,
        "rt" => Align2::RIGHT_TOP,
        _ => Align2::CENTER_CENTER,
    };
    painter.text(at, align, text, FontId::proportional(size), color)
}

/// A thin line from a label to its part, with a dot at the part.
pub(super) fn leader(painter: &Painter, from: Pos2, to: Pos2, color: Color32) {
    let color = color.gamma_multiply(0.6);
    painter.line_segment([from, to], Stroke::new(1.0, color));
    painter.circle_filled(to, 1.8, color);
}

/// A vertical arrow from `from`, upwards for a positive `length` \[points\]. Arrows shorter
/// than 2 points are not drawn.
pub(super) fn arrow(painter: &Painter, from: Pos2, length: f32, width: f32, color: Color32) {
    if !length.is_finite() || length.abs() < 2.0 {
        return;
    }
    let up = -length.signum();
    let tip = pos2(from.x, from.y - length);
    let head = (length.abs() * 0.5).min(2.0 + 2.2 * width);
    let neck = pos2(tip.x, tip.y - up * head);
    painter.line_segment([from, neck], Stroke::new(width, color));
    let side = 0.55 * head + 0.6;
    painter.add(Shape::convex_polygon(
        vec![
            tip,
            pos2(neck.x - side, neck.y),
            pos2(neck.x + side, neck.y),
        ],
        color,
        Stroke::NONE,
    ));
}

/// A strip of `thickness` along `line`, from `offset` above it downwards.
pub(super) fn strip(
    painter: &Painter,
    line: &[Pos2],
    offset: f32,
    thickness: f32,
    fill: Color32,
    edge: Color32,
) {
    // Straight quadrilaterals: a bent strip is not convex.
    let normal = |i: usize| -> Vec2 {
        let a = line[i.saturating_sub(1)];
        let b = line[(i + 1).min(line.len() - 1)];
        let along = (b - a).normalized();
        vec2(along.y, -along.x)
    };
    let above: Vec<Pos2> = (0..line.len())
        .map(|i| line[i] + normal(i) * offset)
        .collect();
    let below: Vec<Pos2> = (0..line.len())
        .map(|i| line[i] + normal(i) * (offset - thickness))
        .collect();
    let mut mesh = eframe::egui::Mesh::default();
    for (a, b) in above.iter().zip(&below) {
        mesh.colored_vertex(*a, fill);
        mesh.colored_vertex(*b, fill);
    }
    for i in 0..line.len().saturating_sub(1) as u32 {
        mesh.add_triangle(2 * i, 2 * i + 1, 2 * i + 2);
        mesh.add_triangle(2 * i + 1, 2 * i + 3, 2 * i + 2);
    }
    painter.add(Shape::mesh(mesh));
    painter.line(above, Stroke::new(1.0, edge));
    painter.line(below, Stroke::new(1.0, edge));
}

/// Rectangle of `size` with the middle of its base at `base`, rotated by `angle`.
pub(super) fn block(base: Pos2, size: Vec2, angle: f32) -> Vec<Pos2> {
    let (sin, cos) = angle.sin_cos();
    let turn = |x: f32, y: f32| pos2(base.x + x * cos - y * sin, base.y + x * sin + y * cos);
    let half = 0.5 * size.x;
    vec![
        turn(-half, -size.y),
        turn(half, -size.y),
        turn(half, 0.0),
        turn(-half, 0.0),
    ]
}

/// Largest of 1, 2, 5 times a power of ten that is not above `x`.
pub(super) fn nice_below(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let decade = 10f64.powf(x.log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|step| *step <= x * (1.0 + 1e-9))
        .unwrap_or(decade)
}
