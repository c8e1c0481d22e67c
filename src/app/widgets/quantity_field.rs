//! A field for a quantity with its unit: "58 um", "2e-21". Text that cannot be read stays in
//! the field with the reason, and the value stays as it was.

use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::text_edit::TextEditOutput;
use eframe::egui::{Align2, FontSelection, Id, Key, Margin, Response, StrokeKind, TextEdit, Ui};

use crate::model::unit::{format_quantity, parse_quantity, prefix_for};

/// A quantity to be shown and typed.
pub struct QuantityField<'a> {
    /// Identity, stable over frames.
    pub id: Id,
    /// Name for screen readers and tests.
    pub label: &'a str,
    /// The value \[SI\].
    pub value: f64,
    /// Its SI unit, empty for a plain number.
    pub unit: &'a str,
    /// Width of the field \[points\].
    pub width: f32,
    /// A locked field is shown but cannot be changed.
    pub enabled: bool,
}

/// What a person did with a [`QuantityField`].
pub struct QuantityOutput {
    /// The field.
    pub response: Response,
    /// A new value \[SI\], typed and accepted.
    pub value: Option<f64>,
    /// Why the text in the field cannot be read.
    pub error: Option<String>,
}

/// What is being typed.
#[derive(Debug, Clone)]
struct Draft {
    text: String,
    /// Text when typing began. If it is unchanged, so is the value.
    start: String,
    /// Value when typing began \[SI\].
    value: f64,
    error: Option<String>,
}

/// The value of a number typed without a unit. It may be in SI or in the unit that the field
/// shows; the reading nearer to the current value `now` is taken. In a field of 70 um, both
/// `72` and `7e-5` are read as expected.
fn interpret(text: &str, value: f64, now: f64, unit: &str) -> f64 {
    let has_no_unit = text.trim().parse::<f64>().is_ok();
    let (_, factor) = prefix_for(now, unit);
    if !has_no_unit || factor == 1.0 || now == 0.0 || value == 0.0 {
        return value;
    }
    let log_distance = |value: f64| (value / now).abs().ln().abs();
    let shown = value * factor;
    if log_distance(shown) < log_distance(value) {
        shown
    } else {
        value
    }
}

impl QuantityField<'_> {
    /// Draws the field. A typed value is accepted on Enter, Tab or a click elsewhere if
    /// `check` returns no objection; Escape discards it.
    pub fn show(self, ui: &mut Ui, check: impl Fn(f64) -> Option<String>) -> QuantityOutput {
        let key = self.id.with("draft");
        let mut draft = self.current_draft(ui, key);
        let mut text = match &draft {
            Some(draft) => draft.text.clone(),
            None => format_quantity(self.value, self.unit, 4),
        };
        let read = |text: &str| match parse_quantity(text, self.unit) {
            Ok(value) => {
                let value = interpret(text, value, self.value, self.unit);
                check(value).map_or(Ok(value), Err)
            }
            Err(error) => Err(error.to_string()),
        };
        let is_wrong = draft
            .as_ref()
            .is_some_and(|d| d.text != d.start && read(&d.text).is_err());
        let mut shown = self.edit(ui, &mut text, is_wrong);
        let response = shown.response.response.clone();
        if response.gained_focus() {
            self.begin(ui, &mut draft, &mut shown);
        }
        if response.changed()
            && let Some(draft) = &mut draft
        {
            draft.text = text;
            draft.error = None;
        }
        let mut value = None;
        if response.lost_focus() {
            value = finish(ui, &mut draft, read);
        }
        let error = draft.as_ref().and_then(|d| d.error.clone());
        if error.is_some() {
            let stroke = (1.0, super::text::error_color(ui));
            ui.painter()
                .rect_stroke(response.rect, 2.0, stroke, StrokeKind::Outside);
        }
        store(ui, key, draft);
        QuantityOutput {
            response,
            value,
            error,
        }
    }

    /// The draft of the last frame, unless it has ended.
    fn current_draft(&self, ui: &Ui, key: Id) -> Option<Draft> {
        let draft: Option<Draft> = ui.data(|data| data.get_temp(key));
        let focused = ui.memory(|memory| memory.has_focus(self.id));
        // A value that was changed elsewhere ends a failed attempt, and so does Escape.
        let ended = |d: &Draft| {
            !focused && (d.value != self.value || ui.input(|i| i.key_pressed(Key::Escape)))
        };
        draft.filter(|d| !ended(d))
    }

    /// Draws the text field.
    fn edit(&self, ui: &mut Ui, text: &mut String, is_wrong: bool) -> TextEditOutput {
        let color = if is_wrong {
            super::text::error_color(ui)
        } else {
            ui.visuals().text_color()
        };
        let edit = TextEdit::singleline(text)
            .id(self.id)
            .margin(Margin::symmetric(4, 2))
            .desired_width(self.width - 8.0)
            .align(Align2::RIGHT_CENTER)
            .font(FontSelection::Default)
            .text_color(color)
            .interactive(self.enabled);
        let shown = edit.show(ui);
        ui.ctx()
            .accesskit_node_builder(shown.response.response.id, |node| {
                node.set_label(self.label);
                // It takes no keys: a screen reader must not offer it as a field to type in.
                if !self.enabled {
                    node.set_disabled();
                }
            });
        shown
    }

    /// Begins to type: the text gets all its digits and is selected.
    fn begin(&self, ui: &Ui, draft: &mut Option<Draft>, shown: &mut TextEditOutput) {
        let full = format_quantity(self.value, self.unit, 9);
        // A failed attempt is kept, so that it can be corrected.
        let draft = draft.get_or_insert_with(|| Draft {
            text: full.clone(),
            start: full,
            value: self.value,
            error: None,
        });
        let length = draft.text.chars().count();
        let all = CCursorRange::two(CCursor::new(0), CCursor::new(length));
        shown.state.cursor.set_char_range(Some(all));
        let id = shown.response.response.id;
        shown.state.clone().store(ui.ctx(), id);
    }
}

/// Ends typing: returns the value that was read, or keeps the draft with the reason why not.
fn finish(
    ui: &Ui,
    draft: &mut Option<Draft>,
    read: impl Fn(&str) -> Result<f64, String>,
) -> Option<f64> {
    let mut finished = draft.take()?;
    if ui.input(|i| i.key_pressed(Key::Escape)) || finished.text == finished.start {
        return None;
    }
    match read(&finished.text) {
        Ok(typed) => Some(typed),
        Err(reason) => {
            finished.error = Some(reason);
            *draft = Some(finished);
            None
        }
    }
}

/// Keeps the draft for the next frame, or forgets it.
fn store(ui: &Ui, key: Id, draft: Option<Draft>) {
    ui.data_mut(|data| match draft {
        Some(draft) => {
            data.insert_temp(key, draft);
        }
        None => {
            data.remove::<Draft>(key);
        }
    });
}
