//! The slider of a parameter: name, track with the default marked, typed value, reset and
//! lock.

use eframe::egui::{
    Align, FontId, Grid, Id, Label, Layout, Rect, RichText, Sense, Ui, UiBuilder, vec2,
};

use super::callout;
use super::default_value::differs;
use super::icon::{ICON_SIZE, Icon, icon_button, icon_toggle};
use super::quantity_field::QuantityField;
use super::slider_track::SliderTrack;
use crate::model::parameter::{ParameterSpec, Scale};
use crate::model::unit::format_quantity;

/// Space between the parts of a row \[points\].
const PART_GAP: f32 = 4.0;

/// Size of a symbol in a small row, and width that its column has at least \[points\].
const SMALL_SYMBOL_SIZE: f32 = 14.0;
const MIN_SYMBOL_WIDTH: f32 = 54.0;

/// A part of the range for which the model was not measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extrapolation {
    /// Greatest measured size of the value \[SI\].
    pub above: f64,
    /// What was measured: the beginning of a sentence.
    pub what: &'static str,
}

/// How much room a slider takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Two rows, with the name written out.
    Large,
    /// One row, with the symbol.
    Small,
}

/// A parameter to be shown.
pub struct ParameterSlider<'a> {
    /// Distinguishes the same slider in two places.
    pub scope: &'a str,
    /// Id as typed by a person: `Cs`, or `quadratic_drag.cd`.
    pub id: &'a str,
    /// The parameter, with the slider range of this device.
    pub spec: ParameterSpec,
    /// Current value \[SI\].
    pub value: f64,
    /// Value of the preset \[SI\], marked on the track; reset goes back to it.
    pub original: f64,
    /// A locked slider does not move; `None` for one that cannot be locked.
    pub locked: Option<bool>,
    /// How much room it takes.
    pub size: Size,
    /// Why the model refuses the current value.
    pub problem: Option<&'a str>,
    /// From which value on the model is extrapolated: shaded on the track, and said below it.
    pub extrapolation: Option<Extrapolation>,
}

/// What a person did with a [`ParameterSlider`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SliderOutput {
    /// New value \[SI\].
    pub value: Option<f64>,
    /// The lock was clicked.
    pub toggle_lock: bool,
}

/// Sizes of a name that takes two lines, the first that fits.
const NAME_SIZES: [f32; 4] = [10.5, 9.5, 8.5, 7.5];

impl ParameterSlider<'_> {
    /// Draws the slider over the available width.
    pub fn show(self, ui: &mut Ui) -> SliderOutput {
        let mut output = SliderOutput::default();
        let (error, row);
        let width = ui.available_width();
        let long_unit = self.spec.unit.len() > 6;
        // Every part has a fixed place, so that a long text does not move the others.
        match self.size {
            Size::Large => {
                let (rect, _) = ui.allocate_exact_size(vec2(width, 48.0), Sense::hover());
                row = rect;
                let (top, bottom) = rect.split_top_bottom_at_fraction(0.5);
                let field = if long_unit { 132.0 } else { 104.0 };
                let (rest, lock) = split_right(top, ICON_SIZE + PART_GAP);
                let (name, value) = split_right(rest, field + PART_GAP);
                self.place(ui, name, "name", |ui| self.name(ui));
                error = self.place(ui, value, "value", |ui| self.field(ui, field, &mut output));
                self.place(ui, lock, "lock", |ui| self.lock(ui, &mut output));
                let (track, reset) = split_right(bottom, ICON_SIZE + PART_GAP);
                self.place(ui, track, "track", |ui| {
                    self.track(ui, track.width(), 24.0, &mut output);
                });
                self.place(ui, reset, "reset", |ui| self.reset(ui, &mut output));
            }
            Size::Small => {
                let (rect, _) = ui.allocate_exact_size(vec2(width, 22.0), Sense::hover());
                let field = match self.spec.unit.len() {
                    0..=4 => 84.0,
                    5..=6 => 100.0,
                    _ => 118.0,
                };
                row = rect;
                let name_width = self.symbol_width(ui);
                let (name, rest) = rect.split_left_right_at_x(rect.left() + name_width);
                let (rest, lock) = split_right(rest, ICON_SIZE + PART_GAP);
                let (rest, reset) = split_right(rest, ICON_SIZE + PART_GAP);
                let (track, value) = split_right(rest, field + PART_GAP);
                self.place(ui, name, "name", |ui| self.symbol(ui, SMALL_SYMBOL_SIZE));
                self.place(ui, track, "track", |ui| {
                    self.track(ui, track.width(), 18.0, &mut output);
                });
                error = self.place(ui, value, "value", |ui| self.field(ui, field, &mut output));
                self.place(ui, reset, "reset", |ui| self.reset(ui, &mut output));
                self.place(ui, lock, "lock", |ui| self.lock(ui, &mut output));
            }
        }
        if let Some(reason) = error.as_deref().or(self.problem) {
            callout::error(ui, ("slider", self.scope, self.id), row, reason);
        }
        if let Some(beyond) = self.extrapolation
            && self.value.abs() > beyond.above
        {
            let color = ui.visuals().warn_fg_color;
            let limit = format_quantity(beyond.above, self.spec.unit, 3);
            let text = format!("{} up to {limit}: this is extrapolated.", beyond.what);
            ui.label(super::text::small(text).color(color));
        }
        if self.is_locked() {
            output.value = None;
        }
        output
    }

    /// Width of the column of the symbol in a small row: as wide as the symbol, which is the only
    /// name there \[points\].
    fn symbol_width(&self, ui: &Ui) -> f32 {
        let font = FontId::proportional(SMALL_SYMBOL_SIZE);
        let color = ui.visuals().text_color();
        let text = self.spec.symbol.to_owned();
        let needed = ui.painter().layout_no_wrap(text, font, color).size().x;
        (needed + 2.0 * PART_GAP).max(MIN_SYMBOL_WIDTH)
    }

    /// Shows `content` in a part of the row, with its own widget id.
    fn place<R>(
        &self,
        ui: &mut Ui,
        rect: Rect,
        part: &str,
        content: impl FnOnce(&mut Ui) -> R,
    ) -> R {
        let builder = UiBuilder::new()
            .id_salt((self.scope, self.id, part))
            .max_rect(rect)
            .layout(Layout::left_to_right(Align::Center));
        let mut child = ui.new_child(builder);
        child.spacing_mut().item_spacing.x = PART_GAP;
        if part != "track" && part != "name" {
            child.add_space(PART_GAP);
        }
        content(&mut child)
    }

    fn name(&self, ui: &mut Ui) {
        self.symbol(ui, 16.0);
        // A long name in a narrow panel takes two small lines, which have the height of the row.
        let font = eframe::egui::TextStyle::Body.resolve(ui.style());
        let color = ui.visuals().text_color();
        let text = self.spec.name;
        let whole = ui
            .painter()
            .layout_no_wrap(text.to_owned(), font.clone(), color);
        let label = if whole.size().x <= ui.available_width() {
            Label::new(text).extend()
        } else {
            let width = ui.available_width();
            let fits = |size: &f32| {
                let small = FontId::new(*size, font.family.clone());
                let layout = |text: &str, width: f32| {
                    ui.painter()
                        .layout(text.to_owned(), small.clone(), color, width)
                };
                let longest = text
                    .split(' ')
                    .map(|word| layout(word, f32::INFINITY).size().x);
                layout(text, width).rows.len() <= 2 && longest.fold(0.0, f32::max) <= width
            };
            let size = NAME_SIZES.into_iter().find(fits);
            let size = size.unwrap_or(NAME_SIZES[NAME_SIZES.len() - 1]);
            Label::new(RichText::new(text).size(size)).wrap()
        };
        let label = ui.add(label.selectable(false));
        label.on_hover_ui(|ui| self.tooltip(ui));
    }

    fn is_locked(&self) -> bool {
        self.locked == Some(true)
    }

    fn symbol(&self, ui: &mut Ui, size: f32) {
        let mut text = RichText::new(self.spec.symbol).size(size).strong();
        if self.problem.is_some() {
            text = text.color(super::text::error_color(ui));
        }
        let label = ui.add(Label::new(text).extend().selectable(false));
        label.on_hover_ui(|ui| self.tooltip(ui));
    }

    fn track(&self, ui: &mut Ui, width: f32, height: f32, output: &mut SliderOutput) {
        let label = format!("{}, {}", self.id, self.spec.name);
        let text = self.write(self.value);
        let shown = SliderTrack {
            id: Id::unique(("slider", self.scope, self.id)),
            label: &label,
            text: &text,
            numeric: (self.value, self.spec.range.0, self.spec.range.1),
            fraction: fraction(&self.spec, self.value),
            mark: Some(fraction(&self.spec, self.original)),
            extrapolated_from: self
                .extrapolation
                .map_or(1.0, |beyond| fraction(&self.spec, beyond.above)),
            enabled: !self.is_locked(),
            error: self.problem.is_some(),
            size: vec2(width, height),
        }
        .show(ui);
        super::slider_search::arrive(ui, self.id, &shown.response);
        if self.scope.is_empty() {
            let name = format!("slider {}", self.id);
            crate::app::plots::frame::layout_note::note(ui.ctx(), &name, shown.response.rect);
        }
        if let Some(fraction) = shown.fraction {
            let pixel = 1.0 / f64::from(width.max(1.0)) * if shown.fine { 0.1 } else { 1.0 };
            output.value = Some(round_to_pixel(&self.spec, fraction, pixel));
        }
        if let Some(value) = shown.value.filter(|v| self.spec.refusal(*v).is_none()) {
            output.value = Some(value);
        }
        if shown.reset {
            output.value = Some(self.original);
        }
    }

    fn field(&self, ui: &mut Ui, width: f32, output: &mut SliderOutput) -> Option<String> {
        let label = format!("{} value", self.id);
        let field = QuantityField {
            id: Id::unique(("value", self.scope, self.id)),
            label: &label,
            value: self.value,
            unit: self.spec.unit,
            width,
            enabled: !self.is_locked(),
        };
        let typed = field.show(ui, |value| self.spec.refusal(value));
        if let Some(value) = typed.value {
            output.value = Some(value);
        }
        typed.error
    }

    fn reset(&self, ui: &mut Ui, output: &mut SliderOutput) {
        if differs(self.value, self.original) && !self.is_locked() {
            let button = icon_button(ui, Icon::Reset, &format!("reset {}", self.id));
            if button.clicked() {
                output.value = Some(self.original);
            }
            button.on_hover_text(format!(
                "Changed from {}.\nClick to go back, or double-click the track.",
                self.write(self.original)
            ));
        }
    }

    fn lock(&self, ui: &mut Ui, output: &mut SliderOutput) {
        let Some(locked) = self.locked else {
            return;
        };
        let icon = if locked { Icon::Locked } else { Icon::Unlocked };
        let button = icon_toggle(ui, icon, &format!("lock {}", self.id), locked);
        output.toggle_lock |= button.clicked();
        button.on_hover_text(if locked {
            "Locked: sliders and fits do not change it. Click to unlock."
        } else {
            "Lock this value against change."
        });
    }

    fn write(&self, value: f64) -> String {
        format_quantity(value, self.spec.unit, 5)
    }

    fn tooltip(&self, ui: &mut Ui) {
        let spec = &self.spec;
        ui.set_max_width(330.0);
        ui.label(RichText::new(format!("{} ({})", spec.name, spec.symbol)).strong());
        ui.label(spec.meaning);
        if !spec.equation.is_empty() {
            ui.label(RichText::new(spec.equation).monospace());
        }
        Grid::new("parameter facts")
            .num_columns(2)
            .spacing([10.0, 2.0])
            .show(ui, |ui| {
                let mut fact = |name: &str, text: String| {
                    ui.weak(name);
                    ui.label(text);
                    ui.end_row();
                };
                let unit = if spec.unit.is_empty() {
                    "none (dimensionless)"
                } else {
                    spec.unit
                };
                fact("unit", unit.to_owned());
                fact("default", self.write(self.original));
                let scale = match spec.scale {
                    Scale::Log => "logarithmic",
                    Scale::Linear => "linear",
                };
                fact(
                    "slider",
                    format!(
                        "{} to {}, {scale}",
                        self.write(spec.range.0),
                        self.write(spec.range.1)
                    ),
                );
            });
        ui.weak("Shift: fine steps. Arrow keys when focused. Double-click: default. Values outside the range can be typed.");
    }
}

/// Cuts `width` off the right of `rect`.
fn split_right(rect: Rect, width: f32) -> (Rect, Rect) {
    rect.split_left_right_at_x((rect.right() - width).max(rect.left()))
}

/// Position of a value on the track. Zero on a logarithmic track lies to the left of it.
fn fraction(spec: &ParameterSpec, value: f64) -> f64 {
    let fraction = spec.fraction(value);
    if fraction.is_nan() {
        -1.0
    } else {
        fraction.clamp(-1.0, 2.0)
    }
}

/// Value at a position, rounded to what one `pixel` (share of the track) resolves, so that
/// dragged values have few digits.
fn round_to_pixel(spec: &ParameterSpec, fraction: f64, pixel: f64) -> f64 {
    let value = spec.value_at(fraction);
    let (low, high) = spec.range;
    if fraction <= 0.0 {
        return low;
    }
    if fraction >= 1.0 {
        return high;
    }
    let step =
        (spec.value_at(fraction + 0.5 * pixel) - spec.value_at(fraction - 0.5 * pixel)).abs();
    if !(step > 0.0 && step.is_finite()) {
        return value;
    }
    // Via text, which gives the nearest decimal number: 0.3, not 0.30000000000000004.
    let exponent = step.log10().floor() as i32;
    let scaled = (value / 10f64.powi(exponent)).round();
    format!("{scaled}e{exponent}")
        .parse::<f64>()
        .unwrap_or(value)
        .clamp(low, high)
}

#[cfg(test)]
mod tests {
    use super::super::parameter_slider::*;
    use crate::model::parameter::ParameterId;

    #[test]
    fn dragged_values_are_short_and_in_range() {
        let gp = *ParameterId::Gp.spec();
        let text = format!("{}", round_to_pixel(&gp, 0.277_777, 1.0 / 250.0));
        assert!(text.len() < 10, "{text}");
        let cs = *ParameterId::Cs.spec();
        let value = round_to_pixel(&cs, 0.5, 1.0 / 250.0);
        assert!((cs.fraction(value) - 0.5).abs() < 1.0 / 250.0);
        assert_eq!(round_to_pixel(&cs, 0.0, 0.01), cs.range.0);
        assert_eq!(round_to_pixel(&cs, 1.0, 0.01), cs.range.1);
        // Fine steps resolve more than coarse ones.
        let coarse = round_to_pixel(&gp, 0.33333, 0.004);
        let fine = round_to_pixel(&gp, 0.33333, 0.0004);
        assert!((gp.fraction(fine) - 0.33333).abs() <= (gp.fraction(coarse) - 0.33333).abs());
    }

    #[test]
    fn values_outside_the_track_are_shown_at_its_end() {
        let cs = *ParameterId::Cs.spec();
        assert_eq!(fraction(&cs, 0.0), -1.0);
        assert!(fraction(&cs, 1e-10) > 1.0);
    }
}
