//! The parts of the device.

use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, pos2, vec2,
};

use super::Layout;
use super::look::DeviceLook;
use super::moment::{Extremes, Moment};
use super::paint::{Colors, arrow, block, leader, nice_below, strip, text};
use crate::model::unit::format_quantity;

/// Width of the drawing from which on its parts are named \[points\]: three names in a row.
const MIN_NAMED_WIDTH: f32 = 300.0;

/// Shortest arrow that carries its value \[points\].
const MIN_LABELLED_ARROW: f32 = 4.0;

/// Size of the name and value at an arrow \[points\].
const ARROW_TEXT_SIZE: f32 = 14.0;

/// Number of segments of the drawn beam.
const BEAM_PIECES: usize = 40;
/// Depths of the ground's rough profile below its ridge, from left to right \[points\].
const GROUND_PROFILE: [f32; 16] = [
    9.0, 6.0, 10.0, 8.0, 5.0, 9.0, 11.0, 7.0, 10.0, 6.0, 9.0, 12.0, 7.0, 9.0, 5.0, 10.0,
];

/// Everything needed to draw one instant.
pub(super) struct Scene<'a> {
    pub painter: &'a Painter,
    pub layout: &'a Layout,
    pub colors: &'a Colors,
    pub moment: &'a Moment,
    pub extremes: &'a Extremes,
    pub look: DeviceLook,
}

impl Scene<'_> {
    /// Middle of the mass's base.
    fn base(&self) -> Pos2 {
        pos2(self.layout.mass_x, self.layout.y(self.moment.xp))
    }

    /// Clamp, beam, mass, ground, film and arrows.
    pub fn cantilever(&self) {
        let (l, c) = (self.layout, self.colors);
        let clamp_x = l.area.left() + 20.0;
        let lift = 0.5 * l.mass.y;
        let zero = l.y(0.0) - lift;
        self.rest_line(clamp_x, zero);
        self.ground();

        // Clamped at 0 with zero slope, through xc at half length and xp at the end.
        let xp = self.moment.xp;
        let xc = self.moment.xc.unwrap_or(0.3125 * xp);
        let (a, b) = (8.0 * xc - xp, 2.0 * xp - 8.0 * xc);
        let beam: Vec<Pos2> = (0..=BEAM_PIECES)
            .map(|i| {
                let s = i as f64 / BEAM_PIECES as f64;
                let x = clamp_x + s as f32 * (l.mass_x - clamp_x);
                pos2(x, l.y((a + b * s) * s * s) - lift)
            })
            .collect();
        let edge = c.mass_edge.gamma_multiply(0.5);
        strip(self.painter, &beam, 1.0, 4.5, c.silicon, edge);
        strip(self.painter, &beam, 4.5, 3.5, c.piezo, edge);
        let wall = Rect::from_min_max(
            pos2(l.area.left() + 4.0, zero - 22.0),
            pos2(clamp_x, zero + 22.0),
        );
        self.painter.rect(
            wall,
            2.0,
            c.clamp,
            Stroke::new(1.0, edge),
            StrokeKind::Inside,
        );

        let slope = f64::from(l.mass_x - clamp_x).recip() * l.scale * (2.0 * a + 3.0 * b);
        let angle = (-slope as f32).atan() * 0.35;
        self.film();
        self.mass(angle.clamp(-0.12, 0.12));

        let top = l.area.top() + 2.0;
        let middle = beam[BEAM_PIECES * 3 / 10];
        let at = pos2(clamp_x + 6.0, top);
        if self.has_room_for_names() {
            let label = text(self.painter, at, "lt", "cantilever (piezo)", 12.0, c.weak);
            leader(
                self.painter,
                pos2(middle.x.min(label.right() - 8.0), label.bottom()),
                middle - vec2(0.0, 4.0),
                c.weak,
            );
        }
        self.mass_label("proof mass");

        if let Some(drive) = self.moment.drive {
            let from = beam[BEAM_PIECES / 2];
            let length = self.length(drive, self.extremes.drive);
            // Pulls up from the skin or pushes down onto it: never into the ground.
            let from = from - vec2(0.0, 6.0 + (-length).max(0.0));
            arrow(self.painter, from, length, 3.0, c.drive);
            self.arrow_label("drive", drive, from, (length, -1.0), c.drive);
        }
        self.mass_arrows();
    }

    /// Ceiling, spring and mass; ground and film if there are any.
    pub fn spring(&self) {
        let (l, c) = (self.layout, self.colors);
        let ceiling = l.area.top() + 18.0;
        let x = l.mass_x;
        let rest = l.y(0.0) - 0.5 * l.mass.y;
        self.rest_line(l.area.left() + 12.0, rest);
        let at = pos2(l.area.left() + 12.0, rest - 2.0);
        text(self.painter, at, "lb", "rest", 11.0, c.weak);
        self.ground();
        self.film();
        let plate = Rect::from_min_max(pos2(x - 60.0, ceiling - 8.0), pos2(x + 60.0, ceiling));
        self.painter.rect_filled(plate, 1.0, c.clamp);
        let end = self.base().y - l.mass.y;
        let (turns, lead) = (6, 4.0);
        let body = (end - ceiling - 2.0 * lead).max(1.0);
        let mut line = vec![pos2(x, ceiling), pos2(x, ceiling + lead)];
        line.extend((0..2 * turns).map(|i| {
            let side = if i % 2 == 0 { 9.0 } else { -9.0 };
            let share = (i as f32 + 0.5) / (2 * turns) as f32;
            pos2(x + side, ceiling + lead + share * body)
        }));
        line.extend([pos2(x, end - lead), pos2(x, end)]);
        self.painter.line(line, Stroke::new(1.5, c.silicon));
        self.mass(0.0);
        text(
            self.painter,
            pos2(plate.right() + 8.0, plate.center().y),
            "lc",
            "ceiling and spring",
            12.0,
            c.weak,
        );
        self.label_left_of_mass("mass");
        self.mass_arrows();
    }

    /// A ball in free motion next to a scale of heights.
    pub fn free(&self) {
        let (l, c) = (self.layout, self.colors);
        self.ground();
        let axis_x = l.area.left() + 64.0;
        let (low, high) = (self.extremes.low, self.extremes.high);
        self.painter.line_segment(
            [pos2(axis_x, l.y(low)), pos2(axis_x, l.y(high))],
            Stroke::new(1.0, c.weak),
        );
        let step = 2.0 * nice_below((high - low) / 6.0);
        let first = (low / step).ceil() as i64;
        for i in (first..).take_while(|i| *i as f64 * step <= high).take(12) {
            let y = l.y(i as f64 * step);
            self.painter.line_segment(
                [pos2(axis_x - 4.0, y), pos2(axis_x + 4.0, y)],
                Stroke::new(1.0, c.weak),
            );
            let height = format_quantity(i as f64 * step, "m", 3);
            let y = y.clamp(l.area.top() + 7.0, l.area.bottom() - 7.0);
            text(
                self.painter,
                pos2(axis_x - 8.0, y),
                "rc",
                height,
                11.0,
                c.weak,
            );
        }
        let radius = 0.5 * l.mass.y;
        let centre = self.base() - vec2(0.0, radius);
        self.painter
            .circle(centre, radius, c.mass, Stroke::new(1.5, c.mass_edge));
        let speed = self.length(self.moment.velocity, self.extremes.speed);
        let from = centre - vec2(0.0, radius * speed.signum());
        arrow(self.painter, from, speed, 2.5, c.drive);
        self.label_left_of_mass("mass");
    }

    /// Where the mass is at rest without voltage.
    fn rest_line(&self, from: f32, y: f32) {
        let right = self.layout.area.right() - 8.0;
        self.painter.extend(Shape::dashed_line(
            &[pos2(from, y), pos2(right, y)],
            Stroke::new(1.0, self.colors.weak.gamma_multiply(0.4)),
            4.0,
            5.0,
        ));
    }

    /// The ground with its ridge under the mass.
    fn ground(&self) {
        let (l, c) = (self.layout, self.colors);
        let Some(level) = l.ground else { return };
        let y = l.y(level);
        let (left, right) = (l.area.left(), l.area.right());
        let mut line = vec![];
        let ridge = 0.32 * l.mass.x;
        for (i, bump) in GROUND_PROFILE.iter().enumerate() {
            let x = left + (right - left) * i as f32 / (GROUND_PROFILE.len() - 1) as f32;
            if (x - l.mass_x).abs() > 2.2 * ridge {
                line.push(pos2(x, y + bump));
            }
        }
        let at = line.partition_point(|p| p.x < l.mass_x);
        line.splice(
            at..at,
            [
                pos2(l.mass_x - 1.5 * ridge, y + 7.0),
                pos2(l.mass_x - 0.5 * ridge, y),
                pos2(l.mass_x + 0.5 * ridge, y),
                pos2(l.mass_x + 1.5 * ridge, y + 8.0),
            ],
        );
        // Drawn in vertical slices, because the whole is not convex.
        let mut mesh = eframe::egui::Mesh::default();
        for p in &line {
            mesh.colored_vertex(*p, c.ground);
            mesh.colored_vertex(pos2(p.x, l.area.bottom().max(p.y)), c.ground);
        }
        for i in 0..line.len().saturating_sub(1) as u32 {
            mesh.add_triangle(2 * i, 2 * i + 1, 2 * i + 2);
            mesh.add_triangle(2 * i + 1, 2 * i + 3, 2 * i + 2);
        }
        self.painter.add(Shape::mesh(mesh));
        self.painter.line(line, Stroke::new(1.5, c.ground_edge));
        let at = pos2(left + 26.0, l.area.bottom() - 1.0);
        text(self.painter, at, "lb", "ground", 12.0, c.text);
        if self.moment.contact_since.is_some() {
            let half = 0.5 * ridge;
            self.painter.circle_filled(
                pos2(l.mass_x, y),
                1.3 * ridge,
                c.contact.gamma_multiply(0.28),
            );
            self.painter.line_segment(
                [pos2(l.mass_x - half, y), pos2(l.mass_x + half, y)],
                Stroke::new(3.5, c.contact),
            );
        }
    }

    /// The gas between mass and ground; the colour is stronger for a larger force.
    fn film(&self) {
        let (l, c) = (self.layout, self.colors);
        let Some(level) = l.ground else { return };
        let (top, bottom) = (self.base().y, l.y(level));
        let share = match self.moment.film {
            Some(force) if self.extremes.film > 0.0 => {
                (force.abs() / self.extremes.film).min(1.0).sqrt() as f32
            }
            _ => 0.0,
        };
        if bottom > top + 0.5 {
            let gap = Rect::from_min_max(
                pos2(l.mass_x - 0.5 * l.mass.x, top),
                pos2(l.mass_x + 0.5 * l.mass.x, bottom),
            );
            let fill = c.film.gamma_multiply(0.10 + 0.65 * share);
            self.painter.rect_filled(gap, 0.0, fill);
        }
        if !self.has_room_for_names() {
            return;
        }
        let at = pos2(l.mass_x + 0.5 * l.mass.x + 16.0, bottom - 9.0);
        let label = text(self.painter, at, "lc", "gas film", 12.0, c.film);
        leader(
            self.painter,
            pos2(label.left() - 3.0, at.y),
            pos2(l.mass_x + 0.42 * l.mass.x, bottom - 3.0),
            c.film,
        );
    }

    /// The mass, outlined while it touches the ground.
    fn mass(&self, angle: f32) {
        let (l, c) = (self.layout, self.colors);
        let edge = match self.moment.contact_since {
            Some(_) => Stroke::new(2.5, c.contact),
            None => Stroke::new(1.5, c.mass_edge),
        };
        let corners = block(self.base(), l.mass, angle);
        self.painter
            .add(Shape::convex_polygon(corners, c.mass, edge));
    }

    /// Whether the names of the parts fit beside one another. Without room they would be cut off.
    fn has_room_for_names(&self) -> bool {
        self.layout.area.width() >= MIN_NAMED_WIDTH
    }

    /// The name of the mass at the top edge, with a line to the mass.
    fn mass_label(&self, name: &str) {
        if !self.has_room_for_names() {
            return;
        }
        let (l, c) = (self.layout, self.colors);
        let at = pos2(l.mass_x + 0.5 * l.mass.x, l.area.top() + 2.0);
        let label = text(self.painter, at, "lt", name, 12.0, c.weak);
        leader(
            self.painter,
            pos2(label.left() + 4.0, label.bottom()),
            self.base() + vec2(0.36 * l.mass.x, -l.mass.y + 3.0),
            c.weak,
        );
    }

    /// A name that moves with the mass, on its left.
    fn label_left_of_mass(&self, name: &str) {
        let l = self.layout;
        let at = self.base() - vec2(0.5 * l.mass.x + 8.0, 0.5 * l.mass.y);
        text(self.painter, at, "rc", name, 12.0, self.colors.weak);
    }

    /// Length of an arrow for `force` against the largest of its kind.
    fn length(&self, force: f64, largest: f64) -> f32 {
        if largest > 0.0 && force.is_finite() {
            (force / largest).clamp(-1.0, 1.0) as f32 * self.layout.arrow()
        } else {
            0.0
        }
    }

    /// Film, ground, adhesion, pull and effects where they act on the mass.
    fn mass_arrows(&self) {
        let (l, c, m) = (self.layout, self.colors, self.moment);
        let base = self.base();
        let top = base - vec2(0.0, l.mass.y);
        let at = |share: f32, from: Pos2| pos2(from.x + share * l.mass.x, from.y);
        let largest = self.extremes.film.max(self.extremes.contact);
        let draw = |force: Option<f64>, from: Pos2, width: f32, (name, color): (&str, Color32)| {
            if let Some(force) = force {
                let length = self.length(force, largest);
                arrow(self.painter, from, length, width, color);
                let side = (from.x - base.x).signum();
                let beside = pos2(base.x + 0.5 * side * l.mass.x, from.y);
                self.arrow_label(name, force, beside, (length, side), color);
            }
        };
        match m.contact_since {
            None => {
                let centre = base - vec2(0.0, 0.5 * l.mass.y);
                draw(m.film, at(-0.25, centre), 3.0, ("film", c.film));
            }
            Some(_) => {
                draw(m.pull_off, at(-0.12, top), 3.0, ("pull-off", c.pull));
                let seat = base - vec2(0.0, 0.5 * l.mass.y);
                let adhesion = m.adhesion.map(|f| -f);
                draw(adhesion, at(0.3, seat), 1.5, ("adhesion", c.adhesion));
                draw(m.ground, at(0.12, seat), 3.0, ("ground", c.reaction));
            }
        }
        draw(m.effects, at(0.3, top), 2.5, (m.effects_name, c.weak));
    }

    /// Name and value of a force at the tip of its arrow, on the side that `side` points to. Nothing
    /// for an arrow too short to be seen.
    fn arrow_label(&self, name: &str, force: f64, from: Pos2, arrow: (f32, f32), color: Color32) {
        let (length, side) = arrow;
        if !self.look.has_labels || length.abs() < MIN_LABELLED_ARROW {
            return;
        }
        let words = format!("{name} {}", format_quantity(force.abs(), "N", 2));
        let tip = pos2(from.x + side * 8.0, from.y - length);
        let align = if side < 0.0 {
            Align2::RIGHT_CENTER
        } else {
            Align2::LEFT_CENTER
        };
        let font = FontId::proportional(ARROW_TEXT_SIZE);
        let galley = self.painter.layout_no_wrap(words, font, color);
        let place = align.anchor_size(tip, galley.size());
        let behind = self.colors.behind;
        self.painter.rect_filled(place.expand(2.0), 3.0, behind);
        self.painter.galley(place.min, galley, color);
    }

    /// A bar of a round height at the right edge, which shows the scale.
    pub fn scale_bar(&self) {
        let (l, c) = (self.layout, self.colors);
        let room = f64::from(0.38 * l.area.height());
        let length = nice_below(room / l.scale);
        let height = (length * l.scale) as f32;
        let x = l.area.right() - 12.0;
        let top = l.area.top() + 22.0;
        let stroke = Stroke::new(1.5, c.text);
        let ends = [pos2(x, top), pos2(x, top + height)];
        self.painter.line_segment(ends, stroke);
        for end in ends {
            self.painter
                .line_segment([end - vec2(4.0, 0.0), end + vec2(4.0, 0.0)], stroke);
        }
        text(
            self.painter,
            pos2(x - 6.0, top + 0.5 * height),
            "rc",
            format_quantity(length, "m", 3),
            12.0,
            c.text,
        );
    }
}
