//! The error before and after on each recording, all on one scale. Held-out recordings come
//! first.

use eframe::egui::{
    Align2, FontId, Rect, Response, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};

use crate::app::analysis::diagnosis_view::Look;
use crate::app::widgets::text::{heading, small};
use crate::app::workspaces::diagnose::colors;
use crate::app::workspaces::diagnose::words::{after_text, role_text};
use crate::diagnose::Diagnosis;
use crate::diagnose::diagnosis::ProofOf;
use crate::diagnose::report::words::{capitalised, chi2, in_noise, metres, share, two_digits};

/// Height of a bar \[points\].
const BAR_HEIGHT: f32 = 13.0;
/// Width of the numbers after a bar \[points\].
const NUMBERS_WIDTH: f32 = 118.0;

/// Draws the bars.
pub fn show(ui: &mut Ui, look: &mut Look, d: &Diagnosis) {
    let longest = d
        .proof
        .iter()
        .flat_map(|p| [p.distance.before.rms, p.distance.after.rms, 1.2 * p.noise])
        .filter(|v| v.is_finite())
        .fold(1e-12, f64::max);
    for held_out in [true, false] {
        let these: Vec<&ProofOf> = (d.proof.iter())
            .filter(|p| p.held_out == held_out)
            .collect();
        if these.is_empty() {
            continue;
        }
        heading(ui, &capitalised(role_text(held_out)));
        for p in these {
            let response = recording(ui, d, p, longest);
            let response = response.on_hover_text(about(d, p));
            if response.clicked() {
                look.whole(&p.recording, p.held_out);
            }
        }
    }
    ui.label(
        small("Autocorrelation of the residuals at lag 1: near 0 if they are white noise.").weak(),
    );
}

fn about(d: &Diagnosis, p: &ProofOf) -> String {
    let mut text = format!(
        "{}: {} of its samples are compared; noise {}.\nRe-tuned model: {}, chi2 {}.",
        p.recording,
        share(p.covered),
        metres(p.noise),
        metres(p.distance.before.rms),
        chi2(p.distance.before.chi2)
    );
    if !d.named.is_empty() {
        text += &format!(
            "\n{}: {}, chi2 {}.",
            capitalised(after_text(d)),
            metres(p.distance.after.rms),
            chi2(p.distance.after.chi2)
        );
    }
    text + "\nClick to see its residual over time, before and after."
}

fn recording(ui: &mut Ui, d: &Diagnosis, p: &ProofOf, longest: f64) -> Response {
    let named = !d.named.is_empty();
    let bars = if named { 2.0 } else { 1.0 };
    let size = vec2(ui.available_width(), 30.0 + bars * (BAR_HEIGHT + 1.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| {
        let text = format!(
            "proof on {}: {} to {}",
            p.recording,
            metres(p.distance.before.rms),
            metres(p.distance.after.rms)
        );
        WidgetInfo::labeled(Role::Button, true, text)
    });
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    if response.hovered() {
        painter.rect_filled(rect, 2.0, visuals.faint_bg_color);
    }
    let font = FontId::proportional(11.5);
    painter.text(
        rect.min,
        Align2::LEFT_TOP,
        &p.recording,
        font.clone(),
        visuals.text_color(),
    );
    let room = rect.width() - NUMBERS_WIDTH;
    let x = |v: f64| rect.left() + (v / longest).clamp(0.0, 1.0) as f32 * room;
    let noise = x(p.noise);
    let pairs = [
        (p.distance.before.rms, colors::before(ui), true),
        (p.distance.after.rms, colors::after(ui), named),
    ];
    let mut top = rect.top() + 14.0;
    for (rms, color, _) in pairs.into_iter().filter(|(_, _, shown)| *shown) {
        let end = if rms.is_finite() { x(rms) } else { rect.left() };
        let bar = Rect::from_min_max(pos2(rect.left(), top), pos2(end, top + BAR_HEIGHT));
        painter.rect_filled(bar, 1.0, color);
        let words = if rms.is_finite() {
            format!("{}, {}", metres(rms), in_noise(rms, p.noise))
        } else {
            "not compared".to_owned()
        };
        painter.text(
            pos2(end.max(noise) + 5.0, top + 0.5 * BAR_HEIGHT),
            Align2::LEFT_CENTER,
            words,
            font.clone(),
            visuals.text_color(),
        );
        top += BAR_HEIGHT + 1.0;
    }
    painter.extend(Shape::dashed_line(
        &[pos2(noise, rect.top() + 13.0), pos2(noise, top)],
        Stroke::new(1.0, colors::noise(ui)),
        3.0,
        2.0,
    ));
    painter.text(
        pos2(rect.left(), top),
        Align2::LEFT_TOP,
        details(p, named),
        FontId::proportional(11.0),
        visuals.weak_text_color(),
    );
    response
}

fn details(p: &ProofOf, named: bool) -> String {
    let (before, after) = p.correlation;
    if named {
        format!(
            "chi2 {} to {}, lag-1 autocorr. {} to {}",
            chi2(p.distance.before.chi2),
            chi2(p.distance.after.chi2),
            two_digits(before),
            two_digits(after)
        )
    } else {
        format!(
            "chi2 {}, lag-1 autocorrelation {}",
            chi2(p.distance.before.chi2),
            two_digits(before)
        )
    }
}
