//! Rows of controls that several panels share: a named field for a quantity, the choice of drive.

use eframe::egui::{Id, Label, Ui, vec2};

use crate::app::setup::explore::DriveSource;
use crate::app::widgets::callout;
use crate::app::widgets::quantity_field::QuantityField;
use crate::app::widgets::text::{error_color, small};

/// Width of the names before fields \[points\].
pub const NAME_WIDTH: f32 = 112.0;
/// Width of a field \[points\].
const FIELD_WIDTH: f32 = 92.0;
const NARROW_WIDTH: f32 = 68.0;

/// A named field for a quantity.
pub struct Row<'a> {
    /// Identity; also the name for screen readers.
    pub label: &'a str,
    /// What is written before it.
    pub name: &'a str,
    /// What it is, in plain words.
    pub help: &'a str,
    /// The value, SI.
    pub value: f64,
    /// Its unit.
    pub unit: &'a str,
}

impl Row<'_> {
    /// Draws it; returns a value that `check` accepts, once it was typed.
    pub fn show(&self, ui: &mut Ui, check: impl Fn(f64) -> Option<String>) -> Option<f64> {
        ui.horizontal(|ui| {
            name(ui, self.name, self.help);
            self.field(ui, check)
        })
        .inner
    }

    /// Draws the field alone.
    pub fn field(&self, ui: &mut Ui, check: impl Fn(f64) -> Option<String>) -> Option<f64> {
        self.field_of_width(ui, FIELD_WIDTH, check)
    }

    /// Draws the field alone, where two stand in a row.
    pub fn narrow_field(&self, ui: &mut Ui, check: impl Fn(f64) -> Option<String>) -> Option<f64> {
        self.field_of_width(ui, NARROW_WIDTH, check)
    }

    fn field_of_width(
        &self,
        ui: &mut Ui,
        width: f32,
        check: impl Fn(f64) -> Option<String>,
    ) -> Option<f64> {
        let field = QuantityField {
            id: Id::unique(("explore field", self.label)),
            label: self.label,
            value: self.value,
            unit: self.unit,
            width,
            enabled: true,
        };
        let typed = field.show(ui, check);
        if let Some(error) = &typed.error {
            callout::error(ui, self.label, typed.response.rect, error);
        }
        typed.response.on_hover_text(self.help);
        typed.value
    }
}

/// The name before a control, always as wide.
pub fn name(ui: &mut Ui, text: &str, help: &str) {
    let size = vec2(NAME_WIDTH, ui.spacing().interact_size.y);
    ui.allocate_ui(size, |ui| {
        ui.set_min_width(NAME_WIDTH);
        ui.add(Label::new(text).truncate()).on_hover_text(help);
    });
}

/// Objection to a value outside a range; the ends are allowed.
pub fn within(value: f64, low: f64, high: f64, what: &str) -> Option<String> {
    let inside = value >= low && value <= high;
    (!inside).then(|| format!("{what} must lie between {low} and {high}"))
}

/// Objection to a value that is not positive.
pub fn positive(value: f64, what: &str) -> Option<String> {
    (!(value > 0.0 && value.is_finite())).then(|| format!("{what} must be above 0"))
}

/// Whether the panel takes the drive of Tune or the drawn one; returns another choice.
pub fn source(ui: &mut Ui, source: DriveSource) -> Option<DriveSource> {
    let mut chosen = source;
    ui.horizontal(|ui| {
        name(ui, "Drive", "Which drive the panel takes");
        let choices = [
            (
                DriveSource::Tune,
                "of Tune",
                "The drive of the Tune workspace",
            ),
            (
                DriveSource::Drawn,
                "drawn",
                "The waveform of the Waveform panel",
            ),
        ];
        for (choice, text, help) in choices {
            ui.selectable_value(&mut chosen, choice, text)
                .on_hover_text(help);
        }
    });
    (chosen != source).then_some(chosen)
}

/// A message in the colour of errors, as wide as there is room.
pub fn refusal(ui: &mut Ui, text: &str) {
    let color = error_color(ui);
    ui.add(Label::new(small(text).color(color)).wrap());
}

/// A remark in weak small print.
pub fn remark(ui: &mut Ui, text: &str) {
    ui.add(Label::new(small(text).weak()).wrap());
}
