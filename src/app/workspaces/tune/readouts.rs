//! Readouts: error of the simulation on each recording, features side by side, and the
//! kept curves and the differences from the preset.

use eframe::egui::{CollapsingHeader, Label, RichText, Ui};

use super::differences::{differences, table};
use super::kept_curves;
use super::table_a1::features;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::overlay::OverlayId;
use crate::app::simulation::snapshot::{OverlayComparison, Snapshot};
use crate::app::state::State;
use crate::app::widgets::text::{name_of, small};
use crate::diagnose::StretchMisfit;
use crate::model::unit::{counted, format_number, format_quantity};
use crate::sim::{EventKind, StartState};

/// Draws the readouts.
pub fn show(ui: &mut Ui, state: &mut State) {
    section(ui, "Error on the recordings", |ui| match &state.snapshot {
        Some(snapshot) => residuals(ui, state, snapshot),
        None => {
            ui.weak("Nothing has been simulated yet.");
        }
    });
    if let Some(snapshot) = state.snapshot.clone() {
        if snapshot.model.has_ground {
            section(ui, "Features per period", |ui| {
                features::show(ui, state, &snapshot)
            });
        }
        if snapshot.model.has_ground {
            section(ui, "Events", |ui| events(ui, &snapshot));
        }
    }
    section(ui, "Kept curves", |ui| kept_curves::list(ui, state));
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

fn name_label(ui: &mut Ui, state: &State, id: OverlayId) {
    let name = name_of(&state.setup, id);
    let color = state
        .setup
        .overlays
        .iter()
        .find(|o| o.id == id)
        .map(|o| o.color);
    let mut text = RichText::new(&name);
    if let Some(color) = color {
        text = text.color(crate::app::plots::frame::style::overlay_color(ui, color));
    }
    ui.add(Label::new(text).wrap());
}

fn residuals(ui: &mut Ui, state: &State, snapshot: &Snapshot) {
    if snapshot.comparisons.is_empty() {
        let whole_span = Command::SetMode(Mode::WholeSpan);
        ui.weak(if state.setup.overlays.is_empty() {
            "Open a recording to compare with.".to_owned()
        } else if snapshot.live.is_some() {
            whole_span.with_keys("Recordings are compared in whole-span mode") + "."
        } else {
            "All recordings are hidden.".to_owned()
        });
        return;
    }
    // The curve kept last is the one that a person has just changed something against.
    let kept_before = |id: OverlayId| {
        let (curve, run) = state.kept_in_view().last()?;
        let found = run.comparisons.iter().find(|c| c.id == id)?;
        let rms = found.comparison.as_ref().ok()?.rms;
        Some((curve.name.clone(), rms))
    };
    for entry in &snapshot.comparisons {
        name_label(ui, state, entry.id);
        match &entry.comparison {
            Ok(comparison) => {
                ui.horizontal_wrapped(|ui| {
                    ui.spacing_mut().item_spacing.x = 14.0;
                    let rms = format!("rms {}", format_quantity(comparison.rms, "m", 3));
                    ui.label(RichText::new(rms).strong())
                        .on_hover_text("Root mean square of simulation minus recording, xp");
                    if let Some(percent) = comparison.nrmse_percent {
                        ui.label(format!("NRMSE {} %", format_number(percent, 3)))
                            .on_hover_text("rms divided by the range of the recording");
                    }
                    if let Some(misfit) = entry.misfit() {
                        let times = format_number(misfit, 3);
                        ui.label(format!("{times} x noise")).on_hover_text(
                            "rms divided by the estimated noise of the recording: 1 is a perfect model",
                        );
                    }
                });
                if let Some(stretches) = &entry.stretches {
                    let text = between_impacts(stretches);
                    ui.label(small(format!("between impacts: {text}")))
                        .on_hover_text("The recording is cut into stretches at impacts and every few periods; each is started where the readings are. This is the number of Diagnose's proof. It does not add up how an impact that comes a little late spoils the rest of a whole run.");
                }
                instrument(ui, state, entry);
                if let Some((name, kept_rms)) = kept_before(entry.id) {
                    let change = 100.0 * (comparison.rms - kept_rms) / kept_rms;
                    let color = if change > 0.0 {
                        ui.visuals().warn_fg_color
                    } else {
                        ui.visuals().weak_text_color()
                    };
                    let text = compared_with_kept(change, &name, kept_rms);
                    ui.label(small(text).color(color));
                }
            }
            Err(reason) => {
                ui.label(small(reason).color(ui.visuals().warn_fg_color));
            }
        }
    }
}

/// The misfit over the stretches, or why there is none.
fn between_impacts(stretches: &Result<StretchMisfit, String>) -> String {
    match stretches {
        Ok(found) => {
            let rms = format_quantity(found.distance.rms, "m", 3);
            let times = format_number(found.distance.rms / found.noise, 3);
            format!("rms {rms}, {times} x noise")
        }
        Err(reason) => reason.clone(),
    }
}

/// A change of the rms by `percent` from the `rms` of a kept curve \[m\], in words.
fn compared_with_kept(percent: f64, name: &str, rms: f64) -> String {
    let word = if percent > 0.0 { "worse" } else { "better" };
    let rms = format_quantity(rms, "m", 3);
    format!("{:.1} % {word} than {name} ({rms})", percent.abs())
}

/// Under which drive a recording was simulated, and what was estimated of its instrument.
fn instrument(ui: &mut Ui, state: &State, entry: &OverlayComparison) {
    let drive = match (&entry.drive_text, &state.setup.drive) {
        (Some(text), _) => format!("its own drive: {text}"),
        (None, _) if state.setup.preset.model.piezo.is_none() => String::new(),
        (None, _) => "drive of the simulation".to_owned(),
    };
    if !drive.is_empty() {
        ui.label(small(drive).weak());
    }
    let overlay = state.setup.overlays.iter().find(|o| o.id == entry.id);
    let Some(overlay) = overlay else { return };
    let (set, used) = (&overlay.alignment, &entry.alignment);
    let estimates = overlay.estimates;
    let mut parts = Vec::new();
    if estimates.zeros {
        let zero = used.xp_offset - set.xp_offset;
        parts.push(format!("zero {}", format_quantity(-zero, "m", 3)));
    }
    if estimates.clock && entry.own.is_some() {
        let late = used.time_shift - set.time_shift;
        parts.push(format!("clock {}", format_quantity(late, "s", 3)));
    }
    if let Some(start) = entry.own.as_ref().and_then(|own| own.start.as_ref()) {
        parts.push(start_text(start));
    }
    if estimates.scales {
        let scale = used.xp_scale / set.xp_scale;
        parts.push(format!("scale {}", format_number(1.0 / scale, 5)));
    }
    if !parts.is_empty() {
        ui.label(small(format!("estimated: {}", parts.join(", "))).weak())
            .on_hover_text(
                "Zero and scale of its reading of xp, and how late its clock is against that of the voltage. They belong to the instrument and do not count as misfit. Choose in the list of recordings what is estimated.",
            );
    }
}

/// How a recording begins that does not begin at rest.
fn start_text(start: &StartState) -> String {
    match start.held_since {
        None => "begins in motion".to_owned(),
        Some(since) => format!(
            "begins on the ground, there for {}",
            format_quantity(-since, "s", 2)
        ),
    }
}

fn events(ui: &mut Ui, snapshot: &Snapshot) {
    let events = &snapshot.trace.events;
    let count = |kind| events.iter().filter(|event| event.kind == kind).count();
    let kinds = [EventKind::Impact, EventKind::Stick, EventKind::Release];
    let parts = kinds.map(|kind| counted(count(kind), kind.name()));
    ui.label(parts.join(", "))
        .on_hover_text("Events of the simulated run");
}

fn changes(ui: &mut Ui, setup: &Setup) {
    let rows = differences(&setup.original.model, &setup.preset.model);
    if rows.is_empty() {
        ui.weak("Nothing.");
    } else {
        table(ui, "preset differences", ["", "preset", "now"], &rows);
    }
}
