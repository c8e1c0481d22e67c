//! Numbers: how far recording and simulation are apart, features side by side, what
//! differs from the kept curve and from the preset.

use std::sync::Arc;

use eframe::egui::{CollapsingHeader, Grid, RichText, ScrollArea, Ui};

use super::{original, small};
use crate::app::command::Command;
use crate::app::setup::{OverlayId, Setup};
use crate::app::snapshot::{OverlayComparison, Snapshot};
use crate::app::state::State;
use crate::model::Model;
use crate::model::parameter::ParameterSpec;
use crate::model::unit::{format_number, format_quantity};
use crate::recording::features::Features;
use crate::sim::EventKind;

/// The features of Table A.1, per period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// Bounces before the sustained contact.
    pub bounces: Option<f64>,
    /// Peak oscillation amplitude [m].
    pub peak: Option<f64>,
    /// Time in contact [s].
    pub contact: Option<f64>,
}

/// The figures of a run or a recording in its periodic steady state; empty while they
/// are still computed.
pub fn figures(features: &Option<Arc<Features>>) -> Figures {
    let Some(steady) = features.as_ref().and_then(|f| f.steady.as_ref().ok()) else {
        return Figures::default();
    };
    Figures {
        bounces: steady.bounces.map(|spread| spread.mean),
        peak: steady.peak_amplitude.map(|spread| spread.mean),
        contact: steady.contact_duration.map(|spread| spread.mean),
    }
}

/// A row of the features' table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Row {
    /// Bounces.
    Bounces,
    /// Peak.
    Peak,
    /// Contact.
    Contact,
}

/// All rows in order.
pub const ROWS: [Row; 3] = [Row::Bounces, Row::Peak, Row::Contact];

impl Row {
    /// Name with the unit of [`Self::value`].
    pub fn title(self) -> &'static str {
        match self {
            Row::Bounces => "bounces",
            Row::Peak => "peak [µm]",
            Row::Contact => "contact [ms]",
        }
    }

    /// What it means.
    pub fn help(self) -> &'static str {
        match self {
            Row::Bounces => {
                "Departures of more than 5 µm before the sustained contact, per period; 0 where contact is not sustained"
            }
            Row::Peak => {
                "Highest xp after break-off while the voltage falls or is held, minus the lowest xp, per period"
            }
            Row::Contact => "Total time in contact per period; hops under 5 µm are merged",
        }
    }

    /// The number in the unit of [`Self::title`].
    pub fn value(self, figures: &Figures) -> Option<f64> {
        match self {
            Row::Bounces => figures.bounces,
            Row::Peak => figures.peak.map(|v| 1e6 * v),
            Row::Contact => figures.contact.map(|v| 1e3 * v),
        }
    }
}

/// Draws the readouts.
pub fn show(ui: &mut Ui, state: &mut State) {
    section(ui, "Fit to the recordings", |ui| match &state.snapshot {
        Some(snapshot) => residuals(ui, state, snapshot),
        None => {
            ui.weak("Nothing has been simulated yet.");
        }
    });
    if let Some(snapshot) = state.snapshot.clone() {
        section(ui, "Features per period", |ui| {
            features(ui, state, &snapshot)
        });
        section(ui, "Events", |ui| events(ui, &snapshot));
    }
    section(ui, "Kept curve (A/B)", |ui| ghost(ui, state));
    section(ui, "Changed from the preset", |ui| {
        changes(ui, &state.setup)
    });
}

pub(super) fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong())
        .id_salt(title)
        .default_open(true)
        .show_unindented(ui, content);
}

fn number(ui: &mut Ui, text: String) -> eframe::egui::Response {
    ui.label(RichText::new(text).monospace())
}

fn name_of(setup: &Setup, id: OverlayId) -> String {
    let overlay = setup.overlays.iter().find(|overlay| overlay.id == id);
    overlay.map_or_else(
        || format!("#{id}"),
        |overlay| overlay.recording.name.clone(),
    )
}

fn name_label(ui: &mut Ui, state: &State, id: OverlayId) {
    let name = name_of(&state.setup, id);
    let color = state
        .setup
        .overlays
        .iter()
        .find(|o| o.id == id)
        .map(|o| o.color);
    let mut text = RichText::new(short(&name, 22));
    if let Some(color) = color {
        text = text.color(crate::app::plots::style::overlay_color(ui, color));
    }
    ui.label(text).on_hover_text(name);
}

/// The first `limit` characters of a name.
fn short(name: &str, limit: usize) -> String {
    if name.chars().count() <= limit {
        name.to_owned()
    } else {
        format!("{}...", name.chars().take(limit - 3).collect::<String>())
    }
}

fn residuals(ui: &mut Ui, state: &State, snapshot: &Snapshot) {
    if snapshot.comparisons.is_empty() {
        ui.weak("No visible recording to compare with.");
        return;
    }
    let ghost = |id: OverlayId| {
        let ghost = state.ghost.as_ref()?;
        let found = ghost.comparisons.iter().find(|c| c.id == id)?;
        found.comparison.as_ref().ok().map(|c| c.rms)
    };
    for entry in &snapshot.comparisons {
        name_label(ui, state, entry.id);
        match &entry.comparison {
            Ok(comparison) => {
                ui.horizontal_wrapped(|ui| {
                    number(
                        ui,
                        format!("rms {}", format_quantity(comparison.rms, "m", 3)),
                    )
                    .on_hover_text("Root mean square of simulation minus recording, xp");
                    if let Some(percent) = comparison.nrmse_percent {
                        number(ui, format!("NRMSE {} %", format_number(percent, 3)))
                            .on_hover_text("rms over the range of the recording");
                    }
                    if let Some(noise) = noise_of(ui, state, entry) {
                        let times = format_number(comparison.rms / noise, 2);
                        number(ui, format!("{times} x noise")).on_hover_text(
                            "rms over the estimated noise of the recording: 1 is a perfect model",
                        );
                    }
                });
                if let Some(kept) = ghost(entry.id) {
                    let change = 100.0 * (comparison.rms - kept) / kept;
                    let color = if change > 0.0 {
                        ui.visuals().warn_fg_color
                    } else {
                        ui.visuals().weak_text_color()
                    };
                    let text = format!("kept {} ({change:+.1} %)", format_quantity(kept, "m", 3));
                    ui.label(small(text).color(color));
                }
            }
            Err(reason) => {
                ui.label(small(reason).color(ui.visuals().warn_fg_color));
            }
        }
    }
}

/// A difference with its sign, to two digits.
fn signed(value: f64) -> String {
    let sign = if value < 0.0 { "" } else { "+" };
    format!("{sign}{}", format_number(value, 2))
}

fn noise_of(ui: &Ui, state: &State, entry: &OverlayComparison) -> Option<f64> {
    let overlay = state.setup.overlays.iter().find(|o| o.id == entry.id)?;
    crate::app::noise::sigma(ui, overlay)
        .filter(|noise| *noise > 0.0)
        .map(|noise| noise * overlay.alignment.xp_scale.abs())
}

fn features(ui: &mut Ui, state: &State, snapshot: &Snapshot) {
    let own = figures(&snapshot.features);
    if own == Figures::default() && snapshot.comparisons.is_empty() {
        ui.weak("None: the drive does not repeat within the span, or there is no ground.");
        return;
    }
    let mut columns = vec![(None, own)];
    for entry in &snapshot.comparisons {
        columns.push((Some(entry.id), figures(&entry.features)));
    }
    ScrollArea::horizontal().id_salt("features").show(ui, |ui| {
        Grid::new("features")
            .num_columns(1 + columns.len())
            .striped(true)
            .spacing([10.0, 3.0])
            .show(ui, |ui| {
                ui.label("");
                for (id, _) in &columns {
                    match id {
                        None => {
                            ui.label(small("now").strong());
                        }
                        Some(id) => {
                            let name = name_of(&state.setup, *id);
                            ui.label(small(short(&name, 14)).strong())
                                .on_hover_text(name);
                        }
                    }
                }
                ui.end_row();
                for row in ROWS {
                    ui.label(row.title()).on_hover_text(row.help());
                    let simulated = row.value(&own);
                    for (id, column) in &columns {
                        let text = match (id, row.value(column), simulated) {
                            (_, None, _) => "-".to_owned(),
                            (None, Some(value), _) | (Some(_), Some(value), None) => {
                                format_number(value, 3)
                            }
                            (Some(_), Some(value), Some(simulated)) => {
                                format!("{} ({})", format_number(value, 3), simulated - value)
                            }
                        };
                        let label = number(ui, text);
                        if id.is_some() {
                            label.on_hover_text("Recording (simulation minus recording)");
                        }
                    }
                    ui.end_row();
                }
            });
    });
}

fn events(ui: &mut Ui, snapshot: &Snapshot) {
    let events = &snapshot.trace.events;
    let count = |kind| events.iter().filter(|event| event.kind == kind).count();
    let kinds = [EventKind::Impact, EventKind::Stick, EventKind::Release];
    let parts = kinds.map(|kind| format!("{} {}", count(kind), plural(kind, count(kind))));
    ui.label(parts.join(", "))
        .on_hover_text("Events of the simulated run");
}

fn plural(kind: EventKind, count: usize) -> String {
    format!("{}{}", kind.name(), if count == 1 { "" } else { "s" })
}

fn ghost(ui: &mut Ui, state: &mut State) {
    let kept = state.ghost.clone();
    let name = if kept.is_some() {
        "Drop the kept curve"
    } else {
        "Keep this curve"
    };
    let button = ui.add_enabled(state.snapshot.is_some(), eframe::egui::Button::new(name));
    if button
        .on_hover_text("Keep the present curve to compare with (G)")
        .clicked()
    {
        state.ask(Command::ToggleGhost);
    }
    let Some(kept) = kept else {
        return;
    };
    let rows = differences(&kept.model, &state.setup.preset.model);
    if rows.is_empty() {
        ui.weak("Same parameters as now.");
    } else {
        table(ui, "ghost differences", ["", "kept", "now"], &rows);
    }
}

fn changes(ui: &mut Ui, setup: &Setup) {
    let mut before = setup.preset.model.clone();
    for (id, _) in setup.preset.model.parameters.iter() {
        before.parameters.set(id, original::value(setup, id));
    }
    before.effects = original::preset(setup)
        .map(|p| p.model.effects.clone())
        .unwrap_or_default();
    let rows = differences(&before, &setup.preset.model);
    if rows.is_empty() {
        ui.weak("Nothing.");
    } else {
        table(ui, "preset differences", ["", "preset", "now"], &rows);
    }
}

/// Symbol, value before and value after.
type Difference = [String; 3];

/// Parameters and effects in which two devices differ.
pub fn differences(before: &Model, after: &Model) -> Vec<Difference> {
    let mut rows = Vec::new();
    let write = |spec: &ParameterSpec, value: f64| format_quantity(value, spec.unit, 4);
    for (id, value) in after.parameters.iter() {
        let (spec, old) = (id.spec(), before.parameters[id]);
        if after.uses(id) && original::differs(value, old) {
            rows.push([spec.symbol.to_owned(), write(spec, old), write(spec, value)]);
        }
    }
    let find = |model: &Model, id: &str| {
        model
            .effects
            .iter()
            .find(|e| e.spec.id == id)
            .map(|e| e.values.clone())
    };
    for effect in crate::model::effects::CATALOGUE {
        let (old, new) = (find(before, effect.id), find(after, effect.id));
        if old.is_none() && new.is_none() {
            continue;
        }
        for (i, spec) in effect.parameters.iter().enumerate() {
            let at = |values: &Option<Vec<f64>>| values.as_ref().map(|v| v[i]);
            if at(&old) == at(&new) {
                continue;
            }
            let text = |value: Option<f64>| value.map_or("off".to_owned(), |v| write(spec, v));
            let name = format!("{} {}", effect.name, spec.symbol);
            rows.push([name, text(at(&old)), text(at(&new))]);
        }
    }
    rows
}

fn table(ui: &mut Ui, id: &str, titles: [&str; 3], rows: &[Difference]) {
    Grid::new(id)
        .num_columns(3)
        .striped(true)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            for title in titles {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for [name, old, new] in rows {
                ui.label(short(name, 18)).on_hover_text(name);
                number(ui, old.clone());
                number(ui, new.clone());
                ui.end_row();
            }
        });
}
