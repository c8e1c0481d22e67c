//! The strip over the plots: names and colours of all curves, and their values at the
//! pointer or the cursor.

use eframe::egui::{Align, Color32, Label, Layout, RichText, Stroke, Ui, vec2};

use crate::app::state::State;
use crate::model::unit::format_quantity;
use crate::recording::Grid;

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
        let mut add = |color, name: &str, value: Option<f64>, base: &str| {
            entries.push(Entry {
                color,
                name: shortened(name),
                value: value.map_or_else(String::new, |value| format_quantity(value, base, 4)),
            });
        };
        add(None, "t", time, "s");
        for plot in plots {
            for curve in &plot.curves {
                let value = time.and_then(|t| curve.value_at(t));
                add(Some(curve.color), &curve.name, value, plot.base);
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
            add(None, "vp", time.and_then(|t| velocity.value_at(t)), "m/s");
        }
        let cursors = state.cursors;
        if let (Some(first), Some(second)) = (cursors.first, cursors.second) {
            let color = Some(palette.cursor[1]);
            let span = second - first;
            add(color, "dt", Some(span), "s");
            let rate = (span != 0.0).then(|| 1.0 / span.abs());
            add(color, "1/dt", rate, "Hz");
            let xp = |t| {
                let snapshot = state.snapshot.as_ref()?;
                snapshot.proof_mass_pyramid.value_at(t)
            };
            let difference = xp(second).zip(xp(first)).map(|(b, a)| b - a);
            add(color, "dxp", difference, "m");
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

    /// Draws it over the whole width.
    pub fn show(&self, ui: &mut Ui) {
        let columns = columns(ui.available_width());
        for row in self.entries.chunks(columns) {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing = vec2(4.0, 0.0);
                for entry in row {
                    let layout = Layout::left_to_right(Align::Center);
                    ui.allocate_ui_with_layout(vec2(CELL - 4.0, ROW), layout, |ui| {
                        ui.set_min_size(vec2(CELL - 4.0, ROW));
                        entry.show(ui);
                    });
                }
            });
        }
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
    fn show(&self, ui: &mut Ui) {
        let (_, rect) = ui.allocate_space(vec2(10.0, ROW));
        if let Some(color) = self.color {
            let stroke = Stroke::new(3.0, color);
            ui.painter().hline(rect.x_range(), rect.center().y, stroke);
        }
        let value = RichText::new(&self.value).size(12.0).strong();
        let name = RichText::new(&self.name).size(12.0);
        ui.add(Label::new(name).extend().selectable(false));
        ui.add(Label::new(value).truncate().selectable(false));
    }
}
