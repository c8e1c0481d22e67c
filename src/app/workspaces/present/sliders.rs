//! The large sliders of the presenter.

use eframe::egui::{Frame, RichText, Stroke, Ui, vec2};

use crate::app::analysis::learning::presenting::Presenting;
use crate::app::widgets::parameter_slider::{ParameterSlider, Size};

/// Most sliders in a row.
const ROW_COUNT: usize = 4;

/// Draws the sliders that the scene names; the one that the keys move is framed.
pub(super) fn show(ui: &mut Ui, presenting: &mut Presenting) {
    let controls = presenting.controls.clone();
    if controls.is_empty() {
        return;
    }
    let columns = controls.len().min(ROW_COUNT);
    let width = ui.available_width() / columns as f32 - 16.0;
    let selected = presenting.control;
    ui.horizontal_wrapped(|ui| {
        for (i, control) in controls.iter().enumerate() {
            let Some(side) = presenting.side() else {
                return;
            };
            let (Some(spec), Some(value)) = (
                control.spec(&side.scene),
                side.scene.control_value(&control.id),
            ) else {
                continue;
            };
            let original = side.original.control_value(&control.id).unwrap_or(value);
            let refused = side.scene.preset.model.check().err();
            let problem = refused.filter(|error| error.parameter == control.id);
            let slider = ParameterSlider {
                scope: "presenter",
                id: &control.id,
                spec,
                value,
                original,
                locked: None,
                size: Size::Large,
                problem: problem.as_ref().map(|error| error.reason.as_str()),
                extrapolation: None,
            };
            let color = ui.visuals().selection.stroke.color;
            let stroke = Stroke::new(if i == selected { 1.5 } else { 0.0 }, color);
            let moved = Frame::new()
                .stroke(stroke)
                .inner_margin(3.0)
                .show(ui, |ui| {
                    ui.allocate_ui(vec2(width, 52.0), |ui| {
                        ui.set_width(width);
                        slider.show(ui).value
                    })
                    .inner
                });
            if let Some(value) = moved.inner
                && let Some(side) = presenting.side_mut()
            {
                side.scene.set_control(&control.id, value);
                presenting.control = i;
            }
        }
    });
    let is_two = presenting.sides.len() > 1;
    if is_two {
        let name = if presenting.active == 0 { "A" } else { "B" };
        ui.label(RichText::new(format!("The sliders move {name}; X switches.")).size(12.0));
    }
}
