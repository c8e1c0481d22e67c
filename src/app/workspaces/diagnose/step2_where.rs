//! Step 2: where simulation and recordings differ. Residual strips and the worst intervals
//! stand above, the figure with the evidence below.

use eframe::egui::{Button, Label, Panel, Sense, Ui, UiBuilder, vec2};

use super::colors;
use super::figures::{evidence, frame, recording_preview, residual_strip};
use super::words::{after_text, placeholder, scrolled};
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::analysis::diagnosis_view::Look;
use crate::app::state::State;
use crate::app::widgets::text::{heading, small};
use crate::diagnose::diagnosis::{Mismatch, Regime};
use crate::diagnose::report::words::{share, time_span};

/// Intervals of mismatch that are numbered and listed at most.
const MAX_LISTED_INTERVALS: usize = 12;

/// Draws the step.
pub fn show(ui: &mut Ui, state: &mut State) {
    let Some(answer) = state.diagnosing.shown().cloned() else {
        placeholder(
            ui,
            "Where the re-tuned model and the recordings differ by more than the noise: at which \
             times, in which regime, in which channel. Click an interval to see its curves.",
        );
        ui.add_space(4.0);
        scrolled(ui, "diagnose preview", |ui| {
            recording_preview::show(ui, state)
        });
        return;
    };
    let room = ui.available_height();
    Panel::bottom("diagnose evidence")
        .resizable(true)
        .default_size((0.5 * room).max(300.0))
        .size_range(200.0..=(room - 120.0).max(210.0))
        .frame(eframe::egui::Frame::NONE)
        .show(ui, |ui| {
            // The panel keeps the height that was chosen, whatever is drawn in it.
            let rect = ui.available_rect_before_wrap();
            let mut inside = ui.new_child(UiBuilder::new().max_rect(rect));
            evidence::show(&mut inside, state, &answer);
            ui.advance_cursor_after_rect(rect);
        });
    scrolled(ui, "diagnose where", |ui| {
        let look = &mut state.diagnosing.look;
        strips(ui, look, &answer);
        ui.add_space(4.0);
        worst(ui, look, &answer);
    });
}

fn strips(ui: &mut Ui, look: &mut Look, answer: &Answer) {
    let d = &answer.diagnosis;
    if d.strips.is_empty() {
        ui.weak("No residuals over time are available.");
        return;
    }
    let entries = Regime::ALL.map(|r| (short(r), colors::regime(ui, r)));
    frame::legend(ui, &entries);
    let after = if d.named.is_empty() {
        String::new()
    } else {
        format!("; line: {}", after_text(d))
    };
    let line = format!("Bars: residual of the re-tuned model (log scale){after}; dashes: noise.");
    ui.label(small(line).weak());
    let scale = residual_strip::Scale::of(d);
    for s in &d.strips {
        let numbered = d.mismatch.iter().take(MAX_LISTED_INTERVALS).enumerate();
        let marked: Vec<(usize, &Mismatch)> = numbered
            .filter(|(_, m)| m.recording == s.recording && lies_in(m, s))
            .collect();
        let selected = look.recording == Some((s.recording.clone(), s.held_out));
        match residual_strip::show(ui, d, s, &scale, &marked, selected) {
            None => {}
            Some(residual_strip::StripAction::SelectInterval(a, b)) => {
                look.whole(&s.recording, s.held_out);
                look.window = Some((a, b));
            }
            Some(residual_strip::StripAction::Click(t)) => {
                let hit = marked.iter().find(|(_, m)| (m.start..=m.end).contains(&t));
                match hit {
                    Some((_, m)) => look.zoom(&s.recording, s.held_out, (m.start, m.end)),
                    None => look.whole(&s.recording, s.held_out),
                }
            }
        }
    }
}

/// Whether an interval lies in the part of a recording that a strip shows.
fn lies_in(m: &Mismatch, s: &crate::diagnose::diagnosis::Strip) -> bool {
    residual_strip::span(s).is_some_and(|(a, b)| (a..=b).contains(&(0.5 * (m.start + m.end))))
}

/// A regime in a word or two.
fn short(regime: Regime) -> &'static str {
    match regime {
        Regime::FarFlight => "far flight",
        Regime::NearGroundApproach => "approach",
        Regime::Impact => "impact",
        Regime::Contact => "contact",
        Regime::Release => "release",
        Regime::NearGroundDeparture => "departure",
    }
}

fn worst(ui: &mut Ui, look: &mut Look, answer: &Answer) {
    let d = &answer.diagnosis;
    heading(ui, "Intervals with the largest excess residual");
    if d.mismatch.is_empty() {
        ui.label(small(
            "None: the re-tuned model agrees with the recordings within the noise.",
        ));
        return;
    }
    for (i, m) in d.mismatch.iter().take(MAX_LISTED_INTERVALS).enumerate() {
        row(ui, look, answer, (i, m));
    }
    let more = d.mismatch.len().saturating_sub(MAX_LISTED_INTERVALS);
    if more > 0 {
        ui.label(small(format!("Not listed: {more} weaker.")).weak());
    }
}

fn row(ui: &mut Ui, look: &mut Look, answer: &Answer, (i, m): (usize, &Mismatch)) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let (rect, _) = ui.allocate_exact_size(vec2(46.0, 14.0), Sense::hover());
        let color = colors::regime(ui, m.regime);
        let mut bar = rect;
        bar.set_width(rect.width() * (m.share as f32).clamp(0.02, 1.0));
        ui.painter()
            .rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        ui.painter()
            .rect_filled(bar, 2.0, color.gamma_multiply(0.6));
        ui.painter().text(
            rect.left_center() + vec2(3.0, 0.0),
            eframe::egui::Align2::LEFT_CENTER,
            share(m.share),
            eframe::egui::FontId::proportional(11.0),
            ui.visuals().strong_text_color(),
        );
        let title = format!("{}: {}", i + 1, time_span(m));
        let button = ui.add(Button::new(small(title)).min_size(vec2(116.0, 0.0)));
        let button = button.on_hover_text(format!(
            "{} of the excess: {}, {}, {}. Click to show it.",
            share(m.share),
            m.recording,
            m.channel,
            m.regime.text()
        ));
        if button.clicked() {
            let strips = &answer.diagnosis.strips;
            let held_out = strips
                .iter()
                .find(|s| s.recording == m.recording && lies_in(m, s))
                .is_some_and(|s| s.held_out);
            look.zoom(&m.recording, held_out, (m.start, m.end));
        }
        let text = format!("{}, {}, {}", m.channel, m.regime.text(), m.recording);
        ui.add(Label::new(small(text)).truncate());
    });
}
