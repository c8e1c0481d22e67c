//! The readout above the plots: name and colour of each curve, and its value at the pointer
//! or the cursor.

use eframe::egui::{
    Align, Align2, Area, Color32, Frame, Id, Label, Layout, Order, Rect, RichText, Role, Sense,
    Stroke, StrokeKind, Ui, WidgetInfo, vec2,
};

use super::curve::Curve;
use super::layer::{Mark, mark};
use super::style;
use super::time_plot::TimePlot;
use crate::app::state::State;
use crate::model::unit::format_quantity;
use crate::recording::{Channel, Grid};

/// Width of the colour swatch and the space after it \[points\].
const SWATCH_WIDTH: f32 = 14.0;
/// Approximate width of a letter \[points\].
const LETTER_WIDTH: f32 = 6.4;
/// Width reserved for a value, so that a changing one does not move the others \[points\].
const VALUE_WIDTH: f32 = 76.0;
/// Longest name that is written in full \[letters\].
const MAX_NAME_LETTERS: usize = 40;
/// Shortest that a long name becomes in a narrow window \[letters\]: the last ten, by which the
/// names of a series differ, and a few of the first.
const MIN_NAME_LETTERS: usize = 14;
/// Height of a row \[points\].
const ROW_HEIGHT: f32 = 18.0;

/// One entry: the curve's colour, its name, its value.
#[derive(Debug, Clone)]
struct Entry {
    color: Option<Color32>,
    name: String,
    value: String,
    switch: Option<Switch>,
    mark: Option<Mark>,
    /// Lines shown when the pointer is over it.
    details: Vec<String>,
}

/// What a click on an entry shows or hides.
#[derive(Debug, Clone)]
struct Switch {
    /// Its name for screen readers.
    name: String,
    /// Curves that a click switches.
    keys: Vec<String>,
    hidden: bool,
}

/// All entries.
#[derive(Debug, Clone, Default)]
pub struct Readout {
    entries: Vec<Entry>,
    /// Between the two cursors: colour and text.
    differences: Vec<(Color32, String)>,
}

impl Readout {
    /// Reads the pictures at the pointer, else at the first cursor.
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
                details: vec![name.to_owned()],
            });
        };
        add(None, "t", time, "s", None);
        let grouped = is_grouped(state);
        let mut kept = Vec::new();
        for plot in plots {
            for curve in &plot.curves {
                if grouped && curve.owner.is_some() && curve.kept.is_none() {
                    continue;
                }
                let key = plot.key(curve);
                if curve.kept.is_some() {
                    // One entry for all lines of a kept curve.
                    if kept.contains(&key) {
                        continue;
                    }
                    kept.push(key.clone());
                }
                let value = time.and_then(|t| curve.value_at(t + plot.time_offset));
                let switch = Switch {
                    name: key.clone(),
                    keys: vec![key],
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
        if grouped {
            entries.extend(of_recordings(ui, state, plots, time));
        }
        let has_ground = state.setup.preset.model.has_ground;
        if has_ground && plots.iter().any(|plot| plot.events.is_some()) {
            for (mark, name, color) in [
                (Mark::Impact, "bounce", palette.impact),
                (Mark::Stick, "stick", palette.stick),
                (Mark::Release, "release", palette.release),
            ] {
                entries.push(Entry {
                    color: Some(color),
                    name: name.to_owned(),
                    value: String::new(),
                    switch: None,
                    mark: Some(mark),
                    details: Vec::new(),
                });
            }
        }
        let differences = differences(ui, state, plots, grouped);
        Self {
            entries,
            differences,
        }
    }

    /// The same with entries that only tell: where nothing can be shown or hidden.
    #[must_use]
    pub fn without_switches(mut self) -> Self {
        for entry in &mut self.entries {
            entry.switch = None;
        }
        self
    }

    /// Draws the differences between the two cursors in the upper right corner of `plot`. They
    /// take no room of their own, so that a second cursor moves no picture, and no clicks.
    pub fn show_differences(&self, ui: &Ui, plot: Rect) {
        if self.differences.is_empty() || !ui.is_rect_visible(plot) {
            return;
        }
        Area::new(Id::unique("cursor differences"))
            .order(Order::Middle)
            .interactable(false)
            .pivot(Align2::RIGHT_TOP)
            .fixed_pos(plot.right_top() + vec2(-6.0, 4.0))
            .show(ui.ctx(), |ui| {
                let fill = ui.visuals().window_fill.gamma_multiply(0.9);
                let frame = Frame::new().fill(fill).inner_margin(5).corner_radius(3);
                frame.show(ui, |ui| {
                    ui.spacing_mut().item_spacing.y = 1.0;
                    for (color, text) in &self.differences {
                        ui.horizontal(|ui| {
                            let (_, rect) = ui.allocate_space(vec2(10.0, 14.0));
                            let stroke = Stroke::new(3.0, *color);
                            ui.painter().hline(rect.x_range(), rect.center().y, stroke);
                            let text = RichText::new(text).size(12.0);
                            ui.add(Label::new(text).extend().selectable(false));
                        });
                    }
                });
            });
    }

    /// The entries in rows of at most `width` \[points\].
    fn rows(&self, width: f32) -> Vec<&[Entry]> {
        let (mut rows, mut start, mut used) = (Vec::new(), 0, 0.0);
        for (i, entry) in self.entries.iter().enumerate() {
            let wide = entry.width(width);
            if i > start && used + wide > width {
                rows.push(&self.entries[start..i]);
                (start, used) = (i, 0.0);
            }
            used += wide;
        }
        if start < self.entries.len() {
            rows.push(&self.entries[start..]);
        }
        rows
    }

    /// Height of all rows \[points\].
    pub fn height(&self, width: f32) -> f32 {
        self.rows(width).len() as f32 * ROW_HEIGHT
    }

    /// Draws it over the whole width. Returns the keys of curves that were clicked.
    pub fn show(&self, ui: &mut Ui) -> Vec<String> {
        let mut switched = Vec::new();
        let width = ui.available_width();
        for row in self.rows(width) {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing = vec2(4.0, 0.0);
                for entry in row {
                    let layout = Layout::left_to_right(Align::Center);
                    let size = vec2(entry.width(width) - 4.0, ROW_HEIGHT);
                    ui.allocate_ui_with_layout(size, layout, |ui| {
                        ui.set_min_size(size);
                        if entry.show(ui)
                            && let Some(switch) = &entry.switch
                        {
                            switched.clone_from(&switch.keys);
                        }
                    });
                }
            });
        }
        switched
    }
}

/// Time between the two cursors, and the difference of each curve between them.
fn differences(
    ui: &Ui,
    state: &State,
    plots: &[TimePlot],
    grouped: bool,
) -> Vec<(Color32, String)> {
    let (Some(first), Some(second)) = (state.cursors.first, state.cursors.second) else {
        return Vec::new();
    };
    let span = second - first;
    let mut time = format!("dt {}", format_quantity(span, "s", 4));
    if span != 0.0 {
        let rate = format_quantity(1.0 / span.abs(), "Hz", 4);
        time += &format!(",  1/dt {rate}");
    }
    let mut all = vec![(style::palette(ui).cursor[1], time)];
    for plot in plots {
        let is_listed = |curve: &&Curve| match curve.kept {
            // Those of its residuals would fill the picture.
            Some(_) => curve.owner.is_none(),
            None => !grouped || curve.owner.is_none() || curve.owner == state.selected,
        };
        for curve in plot.drawn().filter(is_listed) {
            let at = |t: f64| curve.value_at(t + plot.time_offset);
            let ends = at(second).zip(at(first));
            let difference = ends.map_or_else(
                || "-".to_owned(),
                |(b, a)| format_quantity(b - a, plot.base, 4),
            );
            let name = shortened(&curve.name);
            all.push((curve.color, format!("\u{394} {name} {difference}")));
        }
    }
    all
}

/// Most recordings whose curves each have an entry. With more, each recording has one.
const MAX_SEPARATE_RECORDINGS: usize = 3;

/// Whether there are so many recordings that each has one entry for all its curves.
fn is_grouped(state: &State) -> bool {
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    visible.count() > MAX_SEPARATE_RECORDINGS
}

/// One entry for each visible recording, with the value of its proof mass. Its other values
/// are shown when the pointer is over the entry.
fn of_recordings(ui: &Ui, state: &State, plots: &[TimePlot], time: Option<f64>) -> Vec<Entry> {
    let mut entries = Vec::new();
    for overlay in &state.setup.overlays {
        let (mut keys, mut details) = (Vec::new(), vec![overlay.recording.name.clone()]);
        let mut value = String::new();
        let curves = plots.iter().flat_map(|plot| {
            let own =
                (plot.curves.iter()).filter(|c| c.owner == Some(overlay.id) && c.kept.is_none());
            own.map(move |curve| (plot, curve))
        });
        let all: Vec<_> = curves.collect();
        let hidden = all.iter().all(|(_, curve)| curve.hidden);
        for (plot, curve) in all {
            // All curves of a recording are shown or hidden together.
            if curve.hidden == hidden {
                keys.push(plot.key(curve));
            }
            let Some(now) = time.and_then(|t| curve.value_at(t + plot.time_offset)) else {
                continue;
            };
            let now = format_quantity(now, plot.base, 4);
            let symbol = curve.name.split(' ').next().unwrap_or_default();
            details.push(format!("{symbol} {now}"));
            if symbol == Channel::ProofMass.symbol() {
                value = now;
            }
        }
        if keys.is_empty() {
            continue;
        }
        let name = overlay.recording.name.clone();
        entries.push(Entry {
            color: Some(style::overlay_color(ui, overlay.color)),
            switch: Some(Switch {
                name: name.clone(),
                keys,
                hidden,
            }),
            name,
            value,
            mark: None,
            details,
        });
    }
    entries
}

/// A name without its `.csv`; a long one also without its middle, since the names of a
/// series differ at the end.
pub fn shortened(name: &str) -> String {
    shortened_to(name, MAX_NAME_LETTERS)
}

/// [`shortened`] to at most `most` letters, but never to less than both ends.
fn shortened_to(name: &str, most: usize) -> String {
    let most = most.clamp(MIN_NAME_LETTERS, MAX_NAME_LETTERS);
    let name = name.strip_suffix(".csv").unwrap_or(name);
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let start: String = letters[..most - 11].iter().collect();
    let end: String = letters[letters.len() - 10..].iter().collect();
    format!("{}\u{2026}{}", start.trim_end(), end.trim_start())
}

/// Time at which values are read \[s\].
pub fn time(state: &State) -> Option<f64> {
    state.cursors.hover.or(state.cursors.first)
}

impl Entry {
    /// Its width, whatever its value, in a row of `room` \[points\]. A row that it does not fit
    /// into shortens its name: otherwise it would push the plots below it out of their panel.
    fn width(&self, room: f32) -> f32 {
        let name = LETTER_WIDTH * shortened(&self.name).chars().count() as f32;
        (name + self.width_without_name()).min(room)
    }

    /// Width of all but the name \[points\].
    fn width_without_name(&self) -> f32 {
        let value = if self.mark.is_some() {
            0.0
        } else {
            VALUE_WIDTH
        };
        SWATCH_WIDTH + value + 10.0
    }

    /// Draws it; returns whether it was clicked.
    fn show(&self, ui: &mut Ui) -> bool {
        let hidden = self.switch.as_ref().is_some_and(|switch| switch.hidden);
        let cell = ui.max_rect();
        let (_, rect) = ui.allocate_space(vec2(10.0, ROW_HEIGHT));
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
        let for_name = cell.width() + 4.0 - self.width_without_name();
        let letters = (for_name / LETTER_WIDTH + 0.5) as usize;
        let mut name = RichText::new(shortened_to(&self.name, letters)).size(12.0);
        if hidden {
            name = name.weak().strikethrough();
        }
        ui.add(Label::new(name).extend().selectable(false));
        ui.add(Label::new(value).truncate().selectable(false));
        let Some(switch) = &self.switch else {
            return false;
        };
        let response = ui.interact(cell, Id::unique(("switch", &switch.name)), Sense::click());
        let label = format!("Show {}", switch.name);
        response.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, !switch.hidden, &label));
        if response.has_focus() {
            let stroke = ui.visuals().selection.stroke;
            let painter = ui.painter();
            painter.rect_stroke(cell, 2.0, stroke, StrokeKind::Inside);
        }
        let verb = if hidden { "show" } else { "hide" };
        response
            .on_hover_text(format!("{}\nClick to {verb} it.", self.details.join("\n")))
            .clicked()
    }
}

#[cfg(test)]
mod tests {
    use super::super::readout::*;

    #[test]
    fn shortened_names_of_a_series_stay_distinct() {
        assert_eq!(shortened("xp oscillator-1.csv"), "xp oscillator-1");
        let long = |n| {
            shortened(&format!(
                "xp measurement of the third device on the second day {n}.csv"
            ))
        };
        assert_ne!(long("0001"), long("0002"));
        assert!(long("0001").chars().count() <= MAX_NAME_LETTERS);
    }

    #[test]
    fn an_entry_takes_no_more_than_the_row_that_it_is_in() {
        let entry = Entry {
            color: None,
            name: "xp a-recording-with-a-rather-long-file-name-2024-03-11.csv".to_owned(),
            value: String::new(),
            switch: None,
            mark: None,
            details: Vec::new(),
        };
        assert_eq!(entry.width(243.0), 243.0);
        let wide = entry.width(f32::INFINITY);
        assert!((300.0..400.0).contains(&wide), "{wide}");
        let narrow = shortened_to(&entry.name, 22);
        assert_eq!(narrow, "xp a-record\u{2026}2024-03-11");
        let shortest = shortened_to(&entry.name, 0);
        assert_eq!(
            shortest, "xp\u{2026}2024-03-11",
            "without a space at the cut"
        );
    }
}
