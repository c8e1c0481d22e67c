//! The residual of one recording over time: the motion above, the residual below, coloured
//! by motion regime. All recordings share one logarithmic scale.

use eframe::egui::{
    Align2, Color32, FontId, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo,
    pos2, vec2,
};

use crate::app::workspaces::diagnose::colors;
use crate::app::workspaces::diagnose::words::{after_text, role_text};
use crate::diagnose::Diagnosis;
use crate::diagnose::diagnosis::{Mismatch, Strip};
use crate::diagnose::report::words::{in_noise, metres};

/// Height of the name above the strip \[points\].
const NAME_HEIGHT: f32 = 15.0;
/// Height of the motion \[points\].
const MOTION_HEIGHT: f32 = 15.0;
/// Height of the residual \[points\].
const RESIDUAL_HEIGHT: f32 = 30.0;

/// The scales that all strips share.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Natural logarithms of the smallest and largest residual, which is in metres.
    residual: (f64, f64),
    /// Lowest and highest position \[m\].
    motion: (f64, f64),
}

impl Scale {
    /// Scales that hold all strips.
    pub fn of(d: &Diagnosis) -> Self {
        let all = d
            .strips
            .iter()
            .flat_map(|s| s.before.iter().chain(&s.after));
        let greatest = all
            .copied()
            .filter(|v| v.is_finite())
            .fold(4.0 * d.noise, f64::max);
        let least = (0.5 * d.noise).max(1e-6 * greatest).max(1e-15);
        let motion = d
            .strips
            .iter()
            .flat_map(|s| s.xp.iter().copied())
            .filter(|v| v.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                (a.min(v), b.max(v))
            });
        Self {
            residual: (least.ln(), greatest.max(2.0 * least).ln()),
            motion,
        }
    }

    fn height(&self, rms: f64) -> f32 {
        let (low, high) = self.residual;
        (((rms.max(1e-300).ln() - low) / (high - low)) as f32).clamp(0.02, 1.0)
    }
}

/// What a person did on a strip.
pub enum StripAction {
    /// A click at a time \[s\].
    Click(f64),
    /// An interval was selected by dragging, start and end \[s\].
    SelectInterval(f64, f64),
}

/// Draws a strip. `marked` are its intervals of mismatch with their numbers.
pub fn show(
    ui: &mut Ui,
    d: &Diagnosis,
    strip: &Strip,
    scale: &Scale,
    marked: &[(usize, &Mismatch)],
    selected: bool,
) -> Option<StripAction> {
    let size = vec2(
        ui.available_width(),
        NAME_HEIGHT + MOTION_HEIGHT + RESIDUAL_HEIGHT,
    );
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let kind = role_text(strip.held_out);
    response.widget_info(|| {
        let text = format!("residuals along {}, {kind}", strip.recording);
        WidgetInfo::labeled(Role::Button, true, text)
    });
    let span = span(strip)?;
    let part = |x: f32| f64::from(((x - rect.left()) / rect.width()).clamp(0.0, 1.0));
    let time = |x: f32| span.0 + part(x) * (span.1 - span.0);
    if ui.is_rect_visible(rect) {
        paint(ui, d, strip, scale, marked, (rect, selected, span, kind));
        if let Some(from) = drag_start(ui, &response) {
            let to = ui.input(|i| i.pointer.hover_pos()).unwrap_or(from);
            let body = Rect::from_x_y_ranges(
                from.x.min(to.x)..=from.x.max(to.x),
                rect.top() + NAME_HEIGHT..=rect.bottom(),
            );
            let color = ui.visuals().selection.bg_fill.gamma_multiply(0.5);
            ui.painter().rect_filled(body.intersect(rect), 0.0, color);
        }
    }
    let action = strip_action(ui, &response, time);
    if let Some(at) = response.hover_pos() {
        let text = about(d, strip, time(at.x));
        response.on_hover_text_at_pointer(text);
    }
    action
}

fn drag_start(ui: &Ui, response: &Response) -> Option<Pos2> {
    response
        .dragged()
        .then(|| ui.input(|input| input.pointer.press_origin()))?
}

fn strip_action(ui: &Ui, response: &Response, time: impl Fn(f32) -> f64) -> Option<StripAction> {
    if response.clicked() {
        let at = response.interact_pointer_pos()?;
        return Some(StripAction::Click(time(at.x)));
    }
    if response.drag_stopped() {
        let from = ui.input(|i| i.pointer.press_origin());
        let to = response.interact_pointer_pos()?;
        // egui forgets the press when the button comes up, but not the total drag.
        let from = from.map_or(to.x - response.total_drag_delta()?.x, |p| p.x);
        let (a, b) = (time(from.min(to.x)), time(from.max(to.x)));
        return Some(if (from - to.x).abs() < 4.0 {
            StripAction::Click(a)
        } else {
            StripAction::SelectInterval(a, b)
        });
    }
    None
}

/// First and last time of the bins \[s\].
pub fn span(strip: &Strip) -> Option<(f64, f64)> {
    let (first, last) = (*strip.time.first()?, *strip.time.last()?);
    let half = 0.5 * (last - first) / (strip.time.len().max(2) - 1) as f64;
    (last > first).then_some((first - half, last + half))
}

fn about(d: &Diagnosis, strip: &Strip, t: f64) -> String {
    let bin = strip
        .time
        .partition_point(|&at| at < t)
        .min(strip.time.len().saturating_sub(1));
    let regime = strip.regime.get(bin).map_or("", |r| r.text());
    let at = |values: &[f64]| values.get(bin).copied().unwrap_or(f64::NAN);
    let (before, after) = (at(&strip.before), at(&strip.after));
    let mut text = format!("{:.2} ms, {regime}\n", 1e3 * t);
    if before.is_finite() {
        text += &format!(
            "re-tuned model {}, {}",
            metres(before),
            in_noise(before, d.noise)
        );
        if !d.named.is_empty() {
            text += &format!(
                "\n{} {}, {}",
                after_text(d),
                metres(after),
                in_noise(after, d.noise)
            );
        }
    } else {
        text += "not compared here";
    }
    text + "\nClick to show it, drag to select an interval."
}

/// Rectangle, whether it is selected, first and last time \[s\], and role in words.
type StripPlace<'a> = (Rect, bool, (f64, f64), &'a str);

fn paint(
    ui: &Ui,
    d: &Diagnosis,
    strip: &Strip,
    scale: &Scale,
    marked: &[(usize, &Mismatch)],
    (rect, selected, span, kind): StripPlace<'_>,
) {
    let painter = ui.painter_at(rect.expand(1.0));
    let visuals = ui.visuals();
    let body = Rect::from_min_max(pos2(rect.left(), rect.top() + NAME_HEIGHT), rect.max);
    painter.rect_filled(body, 2.0, visuals.extreme_bg_color);
    let x = |t: f64| body.left() + (((t - span.0) / (span.1 - span.0)) as f32) * body.width();
    title(ui, strip, rect, span, (selected, kind));
    for (_, m) in marked {
        let shade = visuals.selection.bg_fill.gamma_multiply(0.28);
        let (a, b) = (x(m.start), x(m.end));
        let spot = Rect::from_x_y_ranges(a..=b.max(a + 2.0), body.y_range());
        painter.rect_filled(spot.intersect(body), 0.0, shade);
    }
    let width = body.width() / strip.time.len().max(1) as f32;
    let height = |rms: f64| body.bottom() - scale.height(rms) * RESIDUAL_HEIGHT;
    for (i, (t, rms)) in strip.time.iter().zip(&strip.before).enumerate() {
        if !rms.is_finite() {
            continue;
        }
        let left = x(*t) - 0.5 * width;
        let bar = Rect::from_min_max(pos2(left, height(*rms)), pos2(left + width, body.bottom()));
        let color = strip
            .regime
            .get(i)
            .map_or(Color32::GRAY, |r| colors::regime(ui, *r));
        painter.rect_filled(bar, 0.0, color);
    }
    let (low, high) = scale.motion;
    let rise = |v: f64| {
        let share = ((v - low) / (high - low).max(1e-15)) as f32;
        body.top() + 1.0 + (1.0 - share) * (MOTION_HEIGHT - 2.0)
    };
    let motion = strip
        .time
        .iter()
        .zip(&strip.xp)
        .map(|(t, v)| (x(*t), *v, rise(*v)));
    lines(
        &painter,
        motion,
        Stroke::new(1.0, visuals.weak_text_color()),
    );
    if !d.named.is_empty() {
        let after = strip.time.iter().zip(&strip.after);
        let after = after.map(|(t, v)| (x(*t), *v, height(*v)));
        lines(
            &painter,
            after,
            Stroke::new(1.0, visuals.strong_text_color()),
        );
    }
    let noise = Stroke::new(1.0, colors::noise(ui));
    let y = height(d.noise);
    painter.extend(Shape::dashed_line(
        &[pos2(body.left(), y), pos2(body.right(), y)],
        noise,
        3.0,
        3.0,
    ));
    numbers(ui, &painter, marked, body, x);
    if selected {
        let stroke = Stroke::new(1.0, visuals.selection.stroke.color);
        painter.rect_stroke(body, 2.0, stroke, eframe::egui::StrokeKind::Inside);
    }
}

/// Name on the left, role and time span on the right.
fn title(ui: &Ui, strip: &Strip, rect: Rect, span: (f64, f64), (selected, kind): (bool, &str)) {
    let visuals = ui.visuals();
    let font = FontId::proportional(11.5);
    // Rounded first, and no minus before a zero.
    let ms = |t: f64| (1e3 * t).round() + 0.0;
    let length = format!("{kind}, {} to {} ms", ms(span.0), ms(span.1));
    let right = ui.painter().text(
        rect.right_top(),
        Align2::RIGHT_TOP,
        length,
        font.clone(),
        visuals.weak_text_color(),
    );
    let color = if selected {
        visuals.strong_text_color()
    } else {
        visuals.text_color()
    };
    let room = Rect::from_min_max(rect.min, pos2(right.left() - 6.0, rect.top() + NAME_HEIGHT));
    ui.painter_at(room)
        .text(rect.min, Align2::LEFT_TOP, &strip.recording, font, color);
}

/// Lines through finite points; other points break the line.
fn lines(
    painter: &eframe::egui::Painter,
    points: impl Iterator<Item = (f32, f64, f32)>,
    stroke: Stroke,
) {
    let mut piece: Vec<Pos2> = Vec::new();
    for (x, value, y) in points {
        if value.is_finite() {
            piece.push(pos2(x, y));
        } else if !piece.is_empty() {
            painter.line(std::mem::take(&mut piece), stroke);
        }
    }
    if piece.len() > 1 {
        painter.line(piece, stroke);
    }
}

/// The numbers of the intervals. A number that would overlap another is skipped.
fn numbers(
    ui: &Ui,
    painter: &eframe::egui::Painter,
    marked: &[(usize, &Mismatch)],
    body: Rect,
    x: impl Fn(f64) -> f32,
) {
    let mut taken: Vec<f32> = Vec::new();
    for (number, m) in marked {
        let at = x(0.5 * (m.start + m.end)).clamp(body.left() + 6.0, body.right() - 6.0);
        if taken.iter().any(|t| (t - at).abs() < 15.0) {
            continue;
        }
        taken.push(at);
        painter.text(
            pos2(at, body.top() + 1.0),
            Align2::CENTER_TOP,
            (number + 1).to_string(),
            FontId::proportional(11.0),
            ui.visuals().strong_text_color(),
        );
    }
}
