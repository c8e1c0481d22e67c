//! Small multiples: one panel for each recording, with its own run and its residual below. All panels
//! have the same values in view unless the person chose otherwise, and each its whole recording or
//! all the same time.

use std::collections::BTreeMap;

use eframe::egui::{Frame, Label, Rect, RichText, Role, Stroke, Ui, Vec2, WidgetInfo, vec2};

use super::frame::axes::union;
use super::frame::layout_note::note;
use super::frame::time_plot::{Common, TIME_AXIS_HEIGHT, TimePlot};
use super::frame::{style, time_window};
use super::{residual, trajectory, value_range};
use crate::app::setup::command::Command;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::setup::view::{Picture, RecordingLayout};
use crate::app::state::{Cursors, State};
use crate::model::unit::{format_number, format_quantity};

/// Height of the line with name and misfit \[points\].
const TITLE_HEIGHT: f32 = 22.0;
/// Smallest height of a panel \[points\]: below it neither of its pictures shows a scale.
const MIN_PANEL_HEIGHT: f32 = 200.0;
/// Width for which there is a further panel in a row \[points\].
const COLUMN_WIDTH: f32 = 420.0;
/// A picture wider than this has at least two panels in a row \[points\].
const TWO_COLUMN_WIDTH: f32 = 560.0;
/// Most panels in a row.
const MAX_COLUMNS: usize = 4;
/// Space between panels \[points\].
const PANEL_SPACING: f32 = 6.0;
/// Share of a panel's height that its residual takes, and the smallest height \[points\].
const RESIDUAL_SHARE: f32 = 0.32;
const MIN_RESIDUAL_HEIGHT: f32 = 44.0;

/// One recording's panel.
struct Panel {
    id: OverlayId,
    name: String,
    color: usize,
    misfit: String,
    /// Its pictures from top to bottom.
    plots: Vec<TimePlot>,
    /// Why a picture is empty.
    reasons: Vec<String>,
    /// Time in view \[s\].
    window: (f64, f64),
}

/// All panels.
pub struct Multiples {
    panels: Vec<Panel>,
    /// What is said of pictures that have no panels.
    pub lines: Vec<String>,
}

/// The visible recordings.
fn visible(state: &State) -> Vec<&Overlay> {
    let all = state.setup.overlays.iter();
    all.filter(|overlay| overlay.visible).collect()
}

/// The choice between one picture and small multiples, where there is one.
pub fn header(ui: &mut Ui, state: &mut State) {
    if visible(state).len() < 2 {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.spacing_mut().button_padding.y = 1.0;
        let help = Command::SmallMultiples.with_keys(Command::SmallMultiples.text().1);
        for (layout, text) in [
            (RecordingLayout::Overlay, "Overlay"),
            (RecordingLayout::SmallMultiples, "Small multiples"),
        ] {
            let is_on = state.view.recording_layout == layout;
            let button = ui.selectable_label(is_on, text);
            if button.on_hover_text(&help).clicked() {
                state.view.recording_layout = layout;
            }
        }
        if !is_shown(state) {
            return;
        }
        ui.separator();
        let mut same = !state.view.own_value_scales;
        ui.checkbox(&mut same, "same scale")
            .on_hover_text("All panels have the same values in view.");
        state.view.own_value_scales = !same;
        ui.checkbox(&mut state.view.common_time, "same time")
            .on_hover_text("All panels show the same time, and not each its whole recording.");
        if alone(state).is_some() && ui.button("Show all").clicked() {
            state.view.shown_alone = None;
        }
    });
}

/// Whether there are panels now. A live run is compared with nothing.
fn is_shown(state: &State) -> bool {
    let pictures = &state.view.pictures;
    let is_live = state.snapshot.as_ref().is_some_and(|s| s.live.is_some());
    state.view.recording_layout == RecordingLayout::SmallMultiples
        && !is_live
        && visible(state).len() > 1
        && (pictures.contains(&Picture::Trajectory) || pictures.contains(&Picture::Residual))
}

/// The recording that has all the room, if it is visible.
fn alone(state: &State) -> Option<OverlayId> {
    let id = state.view.shown_alone?;
    visible(state).iter().any(|o| o.id == id).then_some(id)
}

/// The panels; `None` where all recordings are in one picture.
pub fn describe(ui: &Ui, state: &State) -> Option<Multiples> {
    if !is_shown(state) {
        return None;
    }
    let all = visible(state);
    let first = all.iter().map(|o| span(o).0).fold(f64::INFINITY, f64::min);
    let alone = alone(state);
    let shown = all.iter().filter(|o| alone.is_none_or(|id| o.id == id));
    let mut panels: Vec<Panel> = shown.map(|o| panel(ui, state, o, first)).collect();
    same_scale(ui, state, &mut panels);
    let mut lines = residual::left_out(state);
    let unseen = [Picture::Voltage, Picture::Forces];
    let unseen = unseen
        .iter()
        .filter(|picture| state.view.pictures.contains(picture));
    let unseen: Vec<&str> = unseen.map(|picture| picture.name()).collect();
    if !unseen.is_empty() {
        lines.push(format!(
            "{} of the simulation: choose Overlay to see it.",
            unseen.join(" and ")
        ));
    }
    Some(Multiples { panels, lines })
}

/// First and last time of a recording, as aligned \[s\].
fn span(overlay: &Overlay) -> (f64, f64) {
    let (first, last) = overlay.recording.span();
    (overlay.alignment.time(first), overlay.alignment.time(last))
}

fn panel(ui: &Ui, state: &State, overlay: &Overlay, first: f64) -> Panel {
    let own = span(overlay);
    let chosen = time_window::chosen(state);
    // Cursors and zoom of all panels count from the beginning of each recording.
    let (offset, window) = if state.view.common_time {
        let all = chosen.or_else(|| time_window::recorded(state));
        (0.0, all.unwrap_or(own))
    } else {
        let offset = own.0 - first;
        let zoomed = chosen.map(|(from, to)| (from + offset, to + offset));
        (offset, zoomed.unwrap_or(own))
    };
    let (mut plots, mut reasons) = (Vec::new(), Vec::new());
    for picture in [Picture::Trajectory, Picture::Residual] {
        if !state.view.pictures.contains(&picture) {
            continue;
        }
        if picture == Picture::Trajectory {
            plots.push(trajectory::describe_one(ui, state, overlay));
        } else {
            match residual::describe_some(ui, state, &[overlay]) {
                Ok(plot) => plots.push(plot),
                Err(reason) => reasons.push(reason),
            }
        }
    }
    for plot in &mut plots {
        plot.panel = Some((overlay.id, overlay.recording.name.clone()));
        plot.time_offset = offset;
        if state.view.own_value_scales {
            plot.scale = format!("{} #{}", plot.scale, overlay.id);
        }
        value_range::choose(plot, state);
        for i in 0..plot.curves.len() {
            let key = plot.key(&plot.curves[i]);
            plot.curves[i].hidden ^= state.view.switched_curves.contains(&key);
        }
    }
    let compared = residual::comparison(state, overlay);
    let misfit = match compared.map(|c| (c.misfit(), &c.comparison)) {
        Some((Some(misfit), _)) => format!("{} x noise", format_number(misfit, 3)),
        Some((None, Ok(comparison))) => format!("rms {}", format_quantity(comparison.rms, "m", 3)),
        _ => String::new(),
    };
    Panel {
        id: overlay.id,
        name: overlay.recording.name.clone(),
        color: overlay.color,
        misfit,
        plots,
        reasons,
        window,
    }
}

/// Gives all pictures with a scale of the same name the same values in view.
fn same_scale(ui: &Ui, state: &State, panels: &mut [Panel]) {
    type Ranges = ((f64, f64), (f64, f64));
    let mut ranges: BTreeMap<String, Ranges> = BTreeMap::new();
    for panel in panels.iter() {
        for plot in &panel.plots {
            let (window, range) = (panel.window, plot.range(panel.window));
            let all = ranges.entry(plot.scale.clone()).or_insert((window, range));
            for (whole, part) in [(&mut all.0, window), (&mut all.1, range)] {
                *whole = union([*whole, part]).unwrap_or(part);
            }
        }
    }
    for (scale, (window, range)) in &mut ranges {
        if !state.view.value_ranges.contains_key(scale) {
            *range = value_range::held(ui, scale, *window, *range);
        }
    }
    let plots = panels.iter_mut().flat_map(|panel| &mut panel.plots);
    for plot in plots {
        plot.chosen = ranges.get(&plot.scale).map(|(_, range)| *range);
    }
}

impl Multiples {
    /// All their pictures, for the readout.
    pub fn plots(&self) -> Vec<TimePlot> {
        let panels = self.panels.iter();
        panels.flat_map(|panel| panel.plots.clone()).collect()
    }

    /// Values in view of the residual, SI.
    pub fn residual_range(&self) -> Option<(f64, f64)> {
        let mut plots = self.panels.iter().flat_map(|p| &p.plots);
        plots.find(|p| p.picture == Picture::Residual)?.chosen
    }

    /// Draws them over the width, in a place `height` points high; more rows make it higher. Returns
    /// where the first picture is.
    pub fn show(self, ui: &mut Ui, state: &mut State, height: f32) -> Option<Rect> {
        let width = ui.available_width();
        let count = self.panels.len();
        let columns = columns(width, count);
        let rows = count.div_ceil(columns);
        let spaces = PANEL_SPACING * (rows as f32 - 1.0);
        let size = vec2(
            (width - PANEL_SPACING * (columns as f32 - 1.0)) / columns as f32,
            ((height - spaces) / rows as f32).max(MIN_PANEL_HEIGHT),
        );
        let cursors = state.cursors;
        state.cursors.hover = None;
        let mut first = None;
        let mut panels = self.panels.into_iter().peekable();
        while panels.peek().is_some() {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = PANEL_SPACING;
                for panel in panels.by_ref().take(columns) {
                    ui.push_id(("panel", panel.id), |ui| {
                        ui.allocate_ui(size, |ui| {
                            ui.set_min_size(size);
                            ui.set_max_size(size);
                            let shown =
                                ui.vertical(|ui| panel.show(ui, state, cursors, size, count));
                            first = first.or(shown.inner);
                        });
                    });
                }
            });
            ui.add_space(PANEL_SPACING);
        }
        first
    }
}

/// Panels in a row.
fn columns(width: f32, count: usize) -> usize {
    let by_width = (width / COLUMN_WIDTH) as usize;
    let at_least = if width >= TWO_COLUMN_WIDTH { 2 } else { 1 };
    // Four panels are two rows of two and not one of three and one.
    let even = if count == 4 { 2 } else { MAX_COLUMNS };
    by_width.max(at_least).min(even).min(count).max(1)
}

impl Panel {
    fn show(
        self,
        ui: &mut Ui,
        state: &mut State,
        cursors: Cursors,
        size: Vec2,
        count: usize,
    ) -> Option<Rect> {
        let color = style::overlay_color(ui, self.color);
        let is_selected = state.selected == Some(self.id);
        let edge = if is_selected {
            Stroke::new(1.0, color)
        } else {
            Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color)
        };
        let name = self.name.clone();
        let frame = Frame::new().stroke(edge).corner_radius(3).show(ui, |ui| {
            self.title(ui, state, count);
            self.pictures(ui, state, cursors, size.y - TITLE_HEIGHT - 4.0)
        });
        note(ui.ctx(), &format!("panel {name}"), frame.response.rect);
        frame.inner
    }

    fn title(&self, ui: &mut Ui, state: &mut State, count: usize) {
        let size = vec2(ui.available_width(), TITLE_HEIGHT);
        ui.allocate_ui(size, |ui| {
            ui.set_min_size(size);
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 6.0;
                ui.spacing_mut().button_padding.y = 1.0;
                ui.add_space(4.0);
                let is_alone = count == 1;
                let text = if is_alone { "all" } else { "alone" };
                let button = ui.small_button(text);
                let name = if is_alone {
                    "show all recordings".to_owned()
                } else {
                    format!("show {} alone", self.name)
                };
                button.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
                let mut switches = button.on_hover_text(&name).clicked();
                ui.add(Label::new(RichText::new(&self.misfit).strong()).extend());
                let color = style::overlay_color(ui, self.color);
                let letters = (ui.available_width() / 7.0).max(8.0) as usize;
                let short = crate::app::widgets::text::short(&self.name, letters);
                let is_selected = state.selected == Some(self.id);
                let title = ui.selectable_label(is_selected, RichText::new(short).color(color));
                let label = format!("select {}", self.name);
                title.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
                let help = format!(
                    "{}\nClick to select, double-click to show alone.",
                    self.name
                );
                let title = title.on_hover_text(help);
                if title.clicked() {
                    state.selected = Some(self.id);
                }
                switches |= title.double_clicked();
                if switches {
                    state.view.shown_alone = (!is_alone).then_some(self.id);
                }
            });
        });
    }

    /// Draws its pictures. Returns where the first one is.
    fn pictures(
        self,
        ui: &mut Ui,
        state: &mut State,
        cursors: Cursors,
        height: f32,
    ) -> Option<Rect> {
        let mut first = None;
        ui.spacing_mut().item_spacing.y = 2.0;
        for reason in &self.reasons {
            let text = RichText::new(reason).size(12.0).weak();
            ui.add(Label::new(text).truncate());
        }
        let texts = 18.0 * self.reasons.len() as f32;
        let space = height - texts - TIME_AXIS_HEIGHT - 4.0;
        let count = self.plots.len();
        for (i, plot) in self.plots.into_iter().enumerate() {
            let is_lowest = i + 1 == count;
            let residual = (RESIDUAL_SHARE * space).max(MIN_RESIDUAL_HEIGHT);
            let own = match (count, plot.picture) {
                (1, _) => space,
                (_, Picture::Residual) => residual,
                _ => space - residual - 2.0,
            };
            let offset = plot.time_offset;
            let common = Common {
                window: self.window,
                cursors: Cursors {
                    hover: cursors.hover.map(|t| t + offset),
                    first: cursors.first.map(|t| t + offset),
                    second: cursors.second.map(|t| t + offset),
                },
            };
            let axis = if is_lowest { TIME_AXIS_HEIGHT } else { 0.0 };
            let mut reply = plot.show(ui, &common, own + axis, is_lowest);
            first.get_or_insert(reply.response.rect);
            value_range::react(ui, state, &reply);
            // In the time that all panels share.
            reply.window = (self.window.0 - offset, self.window.1 - offset);
            time_window::react(ui, state, &reply);
            if reply.response.clicked() {
                state.selected = Some(self.id);
            }
        }
        first
    }
}
