//! The Diagnose workspace. Four steps stand side by side: the recordings, where they differ
//! from the model, which effect is missing, and the proof. The verdict bar above them states
//! the result in one sentence.

mod candidate;
mod colors;
pub mod figures;
mod options;
mod sealed_trial;
mod sealed_truth;
mod step1_recordings;
mod step2_where;
mod step3_what;
mod step4_proof;
#[cfg(test)]
mod tests;
mod verdict_bar;
pub(super) mod words;

use eframe::egui::{
    Align, Align2, CentralPanel, FontId, Layout, Panel, Rect, RichText, Sense, Ui, UiBuilder, pos2,
    vec2,
};

use crate::app::state::State;

/// One column of the workspace.
struct Step {
    title: &'static str,
    /// Share of the width, 0..1.
    share: f32,
    show: fn(&mut Ui, &mut State),
}

const STEPS: [Step; 4] = [
    Step {
        title: "Recordings",
        share: 0.175,
        show: step1_recordings::show,
    },
    Step {
        title: "Where",
        share: 0.325,
        show: step2_where::show,
    },
    Step {
        title: "What",
        share: 0.26,
        show: step3_what::show,
    },
    Step {
        title: "Proof",
        share: 0.24,
        show: step4_proof::show,
    },
];

/// Space between two steps \[points\].
const STEP_GAP: f32 = 17.0;

/// Draws the workspace.
pub fn show(ui: &mut Ui, state: &mut State) {
    Panel::top("diagnose verdict bar").show(ui, |ui| verdict_bar::show(ui, state));
    CentralPanel::default().show(ui, |ui| steps(ui, state));
    sealed_trial::show(ui, state);
}

fn steps(ui: &mut Ui, state: &mut State) {
    let all = ui.available_rect_before_wrap();
    let width = all.width() - STEP_GAP * (STEPS.len() - 1) as f32;
    let mut left = all.left();
    for (i, step) in STEPS.iter().enumerate() {
        let size = vec2((step.share * width).floor(), all.height());
        let rect = Rect::from_min_size(pos2(left, all.top()), size);
        if i > 0 {
            let stroke = ui.visuals().widgets.noninteractive.bg_stroke;
            ui.painter()
                .vline(left - 0.5 * STEP_GAP, all.y_range(), stroke);
        }
        let child = UiBuilder::new()
            .id_salt(step.title)
            .max_rect(rect)
            .layout(Layout::top_down(Align::Min));
        ui.scope_builder(child, |ui| {
            ui.set_clip_rect(rect.expand2(vec2(2.0, 0.0)).intersect(ui.clip_rect()));
            title(ui, i + 1, step.title);
            (step.show)(ui, state);
        });
        left += size.x + STEP_GAP;
    }
    ui.advance_cursor_after_rect(all);
}

/// The number of a step in a circle, and its name.
fn title(ui: &mut Ui, number: usize, name: &str) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(20.0, 20.0), Sense::hover());
        let visuals = ui.visuals();
        ui.painter()
            .circle_filled(rect.center(), 9.5, visuals.selection.bg_fill);
        ui.painter().text(
            rect.center(),
            Align2::CENTER_CENTER,
            number.to_string(),
            FontId::proportional(12.5),
            visuals.strong_text_color(),
        );
        ui.label(RichText::new(name).strong().size(15.5));
    });
    ui.add_space(2.0);
}
