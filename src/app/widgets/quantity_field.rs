//! A field for a quantity with its unit: "58 um", "2e-21". Nonsense stays in the field
//! with the reason; the value stays what it was.

use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::{Align2, FontSelection, Id, Key, Margin, Response, StrokeKind, TextEdit, Ui};

use crate::model::unit::{format_quantity, parse_quantity, prefix_for};

/// A quantity to be shown and typed.
pub struct QuantityField<'a> {
    /// Identity, stable over frames.
    pub id: Id,
    /// Name for screen readers and tests.
    pub label: &'a str,
    /// The value [SI].
    pub value: f64,
    /// Its SI unit, empty for a plain number.
    pub unit: &'a str,
    /// Width of the field [points].
    pub width: f32,
    /// A locked field is shown but cannot be changed.
    pub enabled: bool,
}

/// What a person did with a [`QuantityField`].
pub struct QuantityOutput {
    /// The field.
    pub response: Response,
    /// A new value [SI], typed and accepted.
    pub value: Option<f64>,
    /// Why what stands in the field is no value.
    pub error: Option<String>,
}

/// What is being typed.
#[derive(Debug, Clone)]
struct Draft {
    text: String,
    /// Text and value when typing began: left unchanged they change nothing.
    start: String,
    value: f64,
    error: Option<String>,
}

/// What a number without a unit means: SI, or the unit that the field shows, whichever is
/// nearer to the value that stands there. `72` in a field of 70 um is 72 um, `7e-5` too.
fn meant(text: &str, value: f64, now: f64, unit: &str) -> f64 {
    let bare = text.trim().parse::<f64>().is_ok();
    let (_, factor) = prefix_for(now, unit);
    if !bare || factor == 1.0 || now == 0.0 || value == 0.0 {
        return value;
    }
    let far = |value: f64| (value / now).abs().ln().abs();
    let shown = value * factor;
    if far(shown) < far(value) {
        shown
    } else {
        value
    }
}

impl QuantityField<'_> {
    /// Draws the field. A typed value is taken on Enter, Tab or a click elsewhere if
    /// `check` has nothing against it; Escape gives up.
    pub fn show(self, ui: &mut Ui, check: impl Fn(f64) -> Option<String>) -> QuantityOutput {
        let key = self.id.with("draft");
        let mut draft: Option<Draft> = ui.data(|data| data.get_temp(key));
        // A value that changed elsewhere ends a failed attempt.
        let focused = ui.memory(|memory| memory.has_focus(self.id));
        if draft
            .as_ref()
            .is_some_and(|d| d.value != self.value && !focused)
        {
            draft = None;
        }
        // A failed attempt that stands in the field is given up by Escape from anywhere.
        if !focused && ui.input(|i| i.key_pressed(Key::Escape)) {
            draft = None;
        }
        let mut text = match &draft {
            Some(draft) => draft.text.clone(),
            None => format_quantity(self.value, self.unit, 4),
        };
        let read = |text: &str| match parse_quantity(text, self.unit) {
            Ok(value) => {
                let value = meant(text, value, self.value, self.unit);
                check(value).map_or(Ok(value), Err)
            }
            Err(error) => Err(error.to_string()),
        };
        let wrong = draft
            .as_ref()
            .is_some_and(|d| d.text != d.start && read(&d.text).is_err());
        let color = if wrong {
            super::text::error_color(ui)
        } else {
            ui.visuals().text_color()
        };
        let edit = TextEdit::singleline(&mut text)
            .id(self.id)
            .margin(Margin::symmetric(4, 2))
            .desired_width(self.width - 8.0)
            .align(Align2::RIGHT_CENTER)
            .font(FontSelection::Default)
            .text_color(color)
            .interactive(self.enabled);
        let mut shown = edit.show(ui);
        let response = shown.response.response.clone();
        ui.ctx()
            .accesskit_node_builder(response.id, |node| node.set_label(self.label));

        let mut value = None;
        if response.gained_focus() {
            let full = format_quantity(self.value, self.unit, 9);
            // A failed attempt is mended, not thrown away.
            if draft.is_none() {
                draft = Some(Draft {
                    text: full.clone(),
                    start: full,
                    value: self.value,
                    error: None,
                });
            }
            let length = draft.as_ref().map_or(0, |d| d.text.chars().count());
            let all = CCursorRange::two(CCursor::new(0), CCursor::new(length));
            shown.state.cursor.set_char_range(Some(all));
            shown.state.store(ui.ctx(), response.id);
        }
        if response.changed()
            && let Some(draft) = &mut draft
        {
            draft.text = text;
            draft.error = None;
        }
        if response.lost_focus()
            && let Some(mut finished) = draft.take()
            && !ui.input(|i| i.key_pressed(Key::Escape))
            && finished.text != finished.start
        {
            match read(&finished.text) {
                Ok(typed) => value = Some(typed),
                Err(reason) => {
                    finished.error = Some(reason);
                    draft = Some(finished);
                }
            }
        }
        let error = draft.as_ref().and_then(|d| d.error.clone());
        if error.is_some() {
            let stroke = (1.0, super::text::error_color(ui));
            ui.painter()
                .rect_stroke(response.rect, 2.0, stroke, StrokeKind::Outside);
        }
        ui.data_mut(|data| match draft {
            Some(draft) => {
                data.insert_temp(key, draft);
            }
            None => {
                data.remove::<Draft>(key);
            }
        });
        QuantityOutput {
            response,
            value,
            error,
        }
    }
}
