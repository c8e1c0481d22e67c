//! The strip over the plots: names and colours of all curves, and their values at the
//! pointer or the cursor.

use eframe::egui::{
    Align, Color32, Id, Label, Layout, Rect, RichText, Role, Sense, Stroke, StrokeKind, Ui,
    WidgetInfo, vec2,
};

use crate::app::state::State;
use crate::model::unit::format_quantity;
use crate::recording::Grid;

use super::layer::{Mark, mark};
use super::style;
use super::time_plot::TimePlot;

/// Width of an entry [points].
const CELL: f32 = 142.0;
/// Height of a row [points].
const ROW: f32 = 18.0;

/// One entry: the curve's colour, its name, its value.
#[derive(Debug, Clone)]
struct Entry {
    color: Option<Color32>,
    name: String,
    value: String,
    switch: Option<Switch>,
    mark: Option<Mark>,
}

/// What a click on an entry shows or hides.
#[derive(Debug, Clone)]
struct Switch {
    key: String,
    hidden: bool,
}

/// What can be read off.
#[derive(Debug, Clone, Default)]
pub struct Readout {
    entries: Vec<Entry>,
}

impl Readout {
    /// Of the described pictures, at the pointer or else the first cursor.
    pub fn of(ui: &Ui, state: &State, plots: &[TimePlot]) -> Self {
        let palette = style::palette(ui);
        let time = time(state);
        let mut entries = Vec::new();
        let mut add = |color, name: &str, value: Option<f64>, base: &str, switch| {
            entries.push(Entry {
                color,
                name: name.to_owned(),
                value: value.map_or_else(String::new, |value| format_quantity(value, base, 4)),
                switch,
                mark: None,
            });
        };
        add(None, "t", time, "s", None);
        for plot in plots {
            for curve in &plot.curves {
                let value = time.and_then(|t| curve.value_at(t));
                let switch = Switch {
                    key: plot.key(curve),
                    hidden: curve.hidden,
                };
                let color = Some(curve.color);
                add(color, &curve.name, value, plot.base, Some(switch));
            }
        }
        if let Some(snapshot) = &state.snapshot {
            let trace = &snapshot.trace;
            let velocity = Grid {
                t0: trace.t0,
                dt: trace.dt,
                values: &trace.proof_mass_velocity,
                slopes: None,
            };
            add(
                None,
                "vp",
                time.and_then(|t| velocity.value_at(t)),
                "m/s",
                None,
            );
        }
        let cursors = state.cursors;
        if let (Some(first), Some(second)) = (cursors.first, cursors.second) {
            let color = Some(palette.cursor[1]);
            let span = second - first;
            add(color, "dt", Some(span), "s", None);
            let rate = (span != 0.0).then(|| 1.0 / span.abs());
            add(color, "1/dt", rate, "Hz", None);
            let xp = |t| {
                let snapshot = state.snapshot.as_ref()?;
                snapshot.proof_mass_pyramid.value_at(t)
            };
            let difference = xp(second).zip(xp(first)).map(|(b, a)| b - a);
            add(color, "dxp", difference, "m", None);
        }
        let has_ground = state.setup.preset.model.has_ground;
        if has_ground && plots.iter().any(|plot| plot.events.is_some()) {
            for (mark, name, color) in [
                (Mark::Impact, "bounces", palette.impact),
                (Mark::Stick, "sticks", palette.stick),
                (Mark::Release, "released", palette.release),
            ] {
                entries.push(Entry {
                    color: Some(color),
                    name: name.to_owned(),
                    value: String::new(),
                    switch: None,
                    mark: Some(mark),
                });
            }
        }
        Self { entries }
    }

    /// Rows that it takes in `width` [points].
    fn rows(&self, width: f32) -> usize {
        self.entries.len().div_ceil(columns(width))
    }

    /// Height of all rows [points].
    pub fn height(&self, width: f32) -> f32 {
        self.rows(width) as f32 * ROW
    }

    /// Draws it over the whole width. Returns the key of a curve that is to be switched.
    pub fn show(&self, ui: &mut Ui) -> Option<String> {
        let mut switched = None;
        let columns = columns(ui.available_width());
        for row in self.entries.chunks(columns) {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing = vec2(4.0, 0.0);
                for entry in row {
                    let layout = Layout::left_to_right(Align::Center);
                    ui.allocate_ui_with_layout(vec2(CELL - 4.0, ROW), layout, |ui| {
                        ui.set_min_size(vec2(CELL - 4.0, ROW));
                        if entry.show(ui) {
                            switched = entry.switch.as_ref().map(|switch| switch.key.clone());
                        }
                    });
                }
            });
        }
        switched
    }
}

/// A name that leaves room for a value.
fn shortened(name: &str) -> String {
    const MOST: usize = 9;
    if name.chars().count() <= MOST {
        return name.to_owned();
    }
    let start: String = name.chars().take(MOST - 1).collect();
    format!("{}\u{2026}", start.trim_end())
}

fn columns(width: f32) -> usize {
    ((width / CELL) as usize).max(1)
}

/// Time that is read off [s].
pub fn time(state: &State) -> Option<f64> {
    state.cursors.hover.or(state.cursors.first)
}

impl Entry {
    /// Draws it; true when its curve is to be switched.
    fn show(&self, ui: &mut Ui) -> bool {
        let hidden = self.switch.as_ref().is_some_and(|switch| switch.hidden);
        let cell = ui.max_rect();
        let (_, rect) = ui.allocate_space(vec2(10.0, ROW));
        if let Some(color) = self.color {
            let y = rect.center().y;
            if let Some(sign) = self.mark {
                ui.painter().add(mark(sign, rect.center(), color));
            } else if hidden {
                let stroke = Stroke::new(1.0, color.gamma_multiply(0.6));
                let swatch = Rect::from_center_size(rect.center(), vec2(9.0, 5.0));
                let painter = ui.painter();
                painter.rect_stroke(swatch, 1.0, stroke, StrokeKind::Inside);
            } else {
                ui.painter()
                    .hline(rect.x_range(), y, Stroke::new(3.0, color));
            }
        }
        let value = RichText::new(&self.value).size(12.0).strong();
        let mut name = RichText::new(shortened(&self.name)).size(12.0);
        if hidden {
            name = name.weak().strikethrough();
        }
        ui.add(Label::new(name).extend().selectable(false));
        ui.add(Label::new(value).truncate().selectable(false));
        let Some(switch) = &self.switch else {
            return false;
        };
        let response = ui.interact(cell, Id::unique(("switch", &switch.key)), Sense::click());
        let label = format!("Show {}", switch.key);
        response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, !switch.hidden, &label));
        if response.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            let painter = ui.painter();
            painter.rect_stroke(cell, 2.0, stroke, StrokeKind::Inside);
        }
        let verb = if hidden { "show" } else { "hide" };
        response
            .on_hover_text(format!("{}\nClick to {verb} it.", self.name))
            .clicked()
    }
}
