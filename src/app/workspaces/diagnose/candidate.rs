//! One effect that was compared: its probability and, once opened, the evidence for and
//! against it.

use eframe::egui::{
    Align2, Button, Color32, FontId, Grid, Rect, RichText, Role, Sense, Ui, WidgetInfo, vec2,
};

use super::colors;
use crate::app::analysis::diagnosis::Diagnosing;
use crate::app::analysis::diagnosis_view::support;
use crate::app::widgets::text::{error_color, small};
use crate::diagnose::Diagnosis;
use crate::diagnose::diagnosis::{Candidate, NamedEffect};
use crate::diagnose::report::words::{
    alike, capitalised, chi2, gain, gain_where_fitted, size, with_error,
};
use crate::diagnose::report::{probability, sentences};
use crate::model::effects::{EffectSpec, find};

/// Width of the bar of a probability \[points\].
const BAR_WIDTH: f32 = 74.0;

/// Draws a row, with its details if it is opened. Effects chosen by hand are not `compared`
/// with others, so they have no probability.
pub fn show(
    ui: &mut Ui,
    diagnosing: &mut Diagnosing,
    d: &Diagnosis,
    c: &Candidate,
    compared: bool,
) {
    let named = d.named.iter().find(|n| n.id == c.id);
    ui.push_id(&c.id, |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            tick(ui, diagnosing, c);
            let (rect, name) = bar_and_name(ui, &c.name, named.is_some());
            let mark = if named.is_some() {
                colors::verdict(ui, d.verdict)
            } else {
                ui.visuals().widgets.active.bg_fill
            };
            if compared {
                bar(ui, rect, c.probability, &probability(c.probability), mark);
            } else if named.is_some() {
                bar(ui, rect, 1.0, "by hand", mark);
            } else {
                bar(ui, rect, 0.0, "-", mark);
            }
            let opened = diagnosing.look.opened.contains(&c.id);
            if name.on_hover_text(hint(c, opened)).clicked() {
                if opened {
                    diagnosing.look.opened.remove(&c.id);
                } else {
                    diagnosing.look.opened.insert(c.id.clone());
                }
            }
        });
        if diagnosing.look.opened.contains(&c.id) {
            ui.indent("details", |ui| {
                details(ui, diagnosing, c, named, compared);
            });
        }
    });
}

/// Room for the bar, and the button with the name after it.
fn bar_and_name(ui: &mut Ui, name: &str, strong: bool) -> (Rect, eframe::egui::Response) {
    let (rect, _) = ui.allocate_exact_size(vec2(BAR_WIDTH, 17.0), Sense::hover());
    let text = RichText::new(capitalised(name));
    let text = if strong { text.strong() } else { text };
    let width = ui.available_width();
    let button = Button::new(text).frame(false).truncate();
    (rect, ui.add_sized(vec2(width, 18.0), LeftButton(button)))
}

/// A button with left-aligned text.
struct LeftButton<'a>(Button<'a>);

impl eframe::egui::Widget for LeftButton<'_> {
    fn ui(self, ui: &mut Ui) -> eframe::egui::Response {
        let layout = eframe::egui::Layout::left_to_right(eframe::egui::Align::Center);
        ui.with_layout(layout, |ui| ui.add(self.0)).inner
    }
}

fn tick(ui: &mut Ui, diagnosing: &mut Diagnosing, c: &Candidate) {
    let mut on = diagnosing.picked().contains(&c.id);
    let busy = diagnosing.running.is_some();
    ui.spacing_mut().icon_spacing = 0.0;
    let check = ui.add_enabled(!busy, eframe::egui::Checkbox::new(&mut on, ""));
    check.widget_info(|| {
        let label = format!("include {}", c.name);
        WidgetInfo::selected(Role::CheckBox, !busy, on, label)
    });
    let check = check.on_hover_text(
        "Tick or untick effects, then press \"Test ticked effects\" to fit and check exactly those ticked",
    );
    if check.changed() {
        diagnosing.pick(&c.id, on);
    }
}

fn hint(c: &Candidate, opened: bool) -> String {
    let law = find(&c.id).map_or("", |spec| spec.sentence);
    let what = if opened {
        "Click to close."
    } else {
        "Click for the evidence for and against it."
    };
    format!("{}\n{law}\n{what}", c.id)
}

/// A probability as a bar with its number.
pub fn bar(ui: &Ui, rect: Rect, share: f64, text: &str, color: Color32) {
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    if share.is_finite() && share > 0.0 {
        let mut part = rect;
        part.set_width(rect.width() * (share as f32).clamp(0.015, 1.0));
        painter.rect_filled(part, 2.0, color.gamma_multiply(0.75));
    }
    painter.text(
        rect.left_center() + vec2(4.0, 0.0),
        Align2::LEFT_CENTER,
        text,
        FontId::proportional(11.5),
        ui.visuals().strong_text_color(),
    );
}

fn details(
    ui: &mut Ui,
    diagnosing: &mut Diagnosing,
    c: &Candidate,
    named: Option<&NamedEffect>,
    compared: bool,
) {
    ui.spacing_mut().item_spacing.y = 2.0;
    let spec = find(&c.id);
    if let Some(spec) = spec {
        ui.label(small(spec.law).monospace());
        ui.label(small(spec.sentence).weak());
    }
    if let Some(effect) = named {
        parameters(ui, effect, spec);
        for evidence in &effect.evidence {
            bullet(ui, "+", &sentences::evidence(evidence));
        }
        if let Some(text) = alike(&effect.alike) {
            bullet(ui, "?", &text);
        }
    }
    for remark in c.remarks.iter().filter(|_| compared) {
        bullet(ui, "-", &sentences::candidate(remark));
    }
    if named.is_none() && compared {
        numbers(ui, c);
    }
    let opens = support(&c.id);
    let button = ui.button(small(opens.text()));
    if button
        .on_hover_text(format!("Open the plot that shows {} best", c.name))
        .clicked()
    {
        diagnosing.look.support(&c.id);
    }
    ui.add_space(4.0);
}

fn parameters(ui: &mut Ui, effect: &NamedEffect, spec: Option<&'static EffectSpec>) {
    Grid::new("parameters")
        .num_columns(2)
        .spacing([10.0, 1.0])
        .show(ui, |ui| {
            for p in &effect.parameters {
                let known = spec.and_then(|s| s.parameters.iter().find(|q| q.id == p.id));
                ui.label(small(&p.id))
                    .on_hover_text(known.map_or("", |q| q.name));
                ui.label(small(with_error(p)).strong());
                ui.end_row();
            }
            ui.label(small("largest force"))
                .on_hover_text("Over the recordings, on the proof mass");
            ui.label(small(size(effect.size)).strong());
            ui.end_row();
        });
}

fn numbers(ui: &mut Ui, c: &Candidate) {
    let fitted = gain_where_fitted(c);
    let text = format!(
        "chi2 falls by {fitted} on fitted and {} on held-out recordings, to {} per sample",
        gain(c.held_out_gain),
        chi2(c.held_out_chi2)
    );
    ui.label(small(text).weak())
        .on_hover_text("A dash: the effect was not fitted on its own");
}

/// A sentence of evidence for (`+`), against (`-`) or undecided (`?`).
fn bullet(ui: &mut Ui, sign: &str, text: &str) {
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let color = match sign {
            "+" => crate::app::plots::frame::style::palette(ui).release,
            "-" => error_color(ui),
            _ => ui.visuals().warn_fg_color,
        };
        ui.label(small(sign).strong().color(color));
        ui.add(eframe::egui::Label::new(small(sentence(text))).wrap());
    });
}

/// A remark with a capital letter and a full stop.
pub fn sentence(text: &str) -> String {
    let text = capitalised(text.trim());
    if text.ends_with(['.', '!', '?']) {
        text
    } else {
        text + "."
    }
}
