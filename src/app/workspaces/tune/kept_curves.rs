//! Kept curves: a short list among the readouts, and a table with the numbers of each next to
//! those of the present run.

use eframe::egui::{
    Button, Grid, Id, Key, Label, RichText, Role, Sense, StrokeKind, TextEdit, Ui, WidgetInfo, vec2,
};

use super::differences::differences;
use super::table_a1::features::{FEATURE_ROWS, latest};
use crate::app::plots::frame::style::{kept_color, overlay_color};
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::restore_parameters;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::kept_curve::{KeptCurve, MAX_NAME_LETTERS, rename};
use crate::app::setup::overlay::Overlay;
use crate::app::simulation::kept::KeptRun;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::text::{name_of, short, small};
use crate::fit::table_a1::measurements::Figures;
use crate::model::unit::{format_number, format_quantity};

/// Digits of a misfit.
const MISFIT_DIGITS: usize = 3;
/// Most differences that are written in a row; all are shown under the pointer.
const MAX_WRITTEN_DIFFERENCES: usize = 3;
/// Width of the field for a name \[points\].
const NAME_WIDTH: f32 = 150.0;
/// Longest name in the list \[letters\].
const MAX_LISTED_LETTERS: usize = 26;
/// Longest name of a recording over its column \[letters\].
const MAX_TITLE_LETTERS: usize = 14;

/// What a person does with a curve. It is done after all are drawn, because drawing borrows them.
/// A click on a button also ends the typing of a name: then there are two in a frame.
enum KeptEdit {
    Rename(usize, String),
    Restore(usize),
    Remove(usize),
}

/// The curves among the readouts: visible or not, name and misfit.
pub(super) fn list(ui: &mut Ui, state: &mut State) {
    buttons(ui, state);
    let mut switched = None;
    for (i, curve) in state.setup.kept.iter().enumerate() {
        ui.horizontal(|ui| {
            if tick(ui, curve, "show") {
                switched = Some(i);
            }
            let name = RichText::new(short(&curve.name, MAX_LISTED_LETTERS))
                .color(kept_color(ui, curve.color));
            let run = state.kept_runs.of(&curve.origin);
            let misfit = match run.map(|run| &run.run) {
                None => "computing".to_owned(),
                Some(Err(_)) => "not shown".to_owned(),
                Some(Ok(run)) => misfit_text(run),
            };
            ui.label(name).on_hover_text(about(curve, run));
            ui.label(small(misfit));
        });
    }
    toggle(state, switched);
}

/// The table: a row for the present run and one for each kept curve.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    buttons(ui, state);
    if state.setup.kept.is_empty() {
        let text = "No curve is kept. Keep the present one, change a parameter, and compare.";
        ui.label(text);
        return;
    }
    let (mut switched, mut edits) = (None, Vec::new());
    let overlays: Vec<&Overlay> = state.setup.overlays.iter().filter(|o| o.visible).collect();
    let columns = 6 + overlays.len() + FEATURE_ROWS.len();
    Grid::new("kept curves")
        .num_columns(columns)
        .striped(true)
        .spacing([9.0, 4.0])
        .show(ui, |ui| {
            titles(ui, &overlays);
            present_row(ui, state, &overlays);
            for (i, curve) in state.setup.kept.iter().enumerate() {
                if tick(ui, curve, "draw") {
                    switched = Some(i);
                }
                if let Some(name) = name_field(ui, i, curve) {
                    edits.push(KeptEdit::Rename(i, name));
                }
                curve_buttons(ui, i, curve, &mut edits);
                let run = state.kept_runs.of(&curve.origin);
                numbers(ui, run, &overlays);
                difference_text(ui, state, curve);
                ui.end_row();
            }
        });
    ui.add_space(6.0);
    for curve in &state.setup.kept {
        remark(ui, curve, state.kept_runs.of(&curve.origin));
    }
    toggle(state, switched);
    for edit in edits {
        apply(state, edit);
    }
}

fn apply(state: &mut State, edit: KeptEdit) {
    let setup = &mut state.setup;
    match edit {
        KeptEdit::Rename(i, name) => rename(&mut setup.kept, i, &name),
        KeptEdit::Restore(i) => {
            if let Some(curve) = setup.kept.get(i).cloned() {
                restore_parameters(setup, &curve);
            }
        }
        KeptEdit::Remove(i) if i < setup.kept.len() => {
            setup.kept.remove(i);
        }
        KeptEdit::Remove(_) => {}
    }
}

fn toggle(state: &mut State, switched: Option<usize>) {
    if let Some(curve) = switched.and_then(|i| state.setup.kept.get_mut(i)) {
        curve.visible = !curve.visible;
    }
}

/// Keeps the present curve, and shows the table.
fn buttons(ui: &mut Ui, state: &mut State) {
    ui.horizontal_wrapped(|ui| {
        let keep = ui.add_enabled(state.snapshot.is_some(), Button::new("Keep the curve"));
        let hint = Command::KeepCurve.with_keys(Command::KeepCurve.text().1);
        if keep.on_hover_text(hint).clicked() {
            state.ask(Command::KeepCurve);
        }
        if !state.kept_open && !state.setup.kept.is_empty() {
            let table = ui.button("Table of kept curves");
            if table.on_hover_text(Command::KeptCurves.text().1).clicked() {
                state.ask(Command::KeptCurves);
            }
        }
    });
}

/// The curve's colour, filled if it is drawn. Returns whether it was clicked.
fn tick(ui: &mut Ui, curve: &KeptCurve, verb: &str) -> bool {
    let mut visible = curve.visible;
    ui.horizontal(|ui| {
        let color = kept_color(ui, curve.color);
        let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
        if visible {
            ui.painter().rect_filled(rect, 2.0, color);
        } else {
            let painter = ui.painter();
            painter.rect_stroke(rect, 2.0, (1.5, color), StrokeKind::Inside);
        }
        ui.spacing_mut().icon_spacing = 0.0;
        let check = ui.checkbox(&mut visible, "");
        check.widget_info(|| {
            let label = format!("{verb} {}", curve.name);
            WidgetInfo::selected(Role::CheckBox, true, visible, label)
        });
        check.on_hover_text("Draw it over the plots").clicked()
    })
    .inner
}

/// The name, which is changed by typing. Returns the new one on Enter, Tab or a click elsewhere;
/// Escape keeps the old one.
fn name_field(ui: &mut Ui, i: usize, curve: &KeptCurve) -> Option<String> {
    let id = Id::unique(("name of a kept curve", i));
    let key = id.with("draft");
    let draft: Option<String> = ui.data(|data| data.get_temp(key));
    let mut text = draft.unwrap_or_else(|| curve.name.clone());
    let edit = TextEdit::singleline(&mut text)
        .id(id)
        .char_limit(MAX_NAME_LETTERS)
        .min_size(eframe::egui::vec2(NAME_WIDTH, 0.0))
        .desired_width(NAME_WIDTH)
        .text_color(kept_color(ui, curve.color));
    let field = ui.add(edit);
    ui.ctx().accesskit_node_builder(field.id, |node| {
        node.set_label(format!("name of {}", curve.name));
    });
    if field.has_focus() {
        ui.data_mut(|data| data.insert_temp(key, text));
        return None;
    }
    ui.data_mut(|data| data.remove::<String>(key));
    let is_cancelled = ui.input(|input| input.key_pressed(Key::Escape));
    let ended = field.lost_focus() && !is_cancelled && text != curve.name;
    field.on_hover_text(format!("{}\nType to rename it.", curve.name));
    ended.then_some(text)
}

fn curve_buttons(ui: &mut Ui, i: usize, curve: &KeptCurve, edits: &mut Vec<KeptEdit>) {
    let name = &curve.name;
    let restore = ui.button("Restore");
    let label = format!("restore {name}");
    restore.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
    let hint = "Set the device to its values and effects, locked ones too; the drive stays. Can be undone.";
    if restore.on_hover_text(hint).clicked() {
        edits.push(KeptEdit::Restore(i));
    }
    let remove = icon_button(ui, Icon::Remove, &format!("remove {name}"));
    if remove
        .on_hover_text("Remove the curve (can be undone)")
        .clicked()
    {
        edits.push(KeptEdit::Remove(i));
    }
}

fn titles(ui: &mut Ui, overlays: &[&Overlay]) {
    ui.label("");
    ui.label(small("name").strong());
    ui.label("");
    ui.label("");
    ui.label(small("misfit").strong())
        .on_hover_text("Over all recordings shown, in units of their noise. 1 is a perfect model.");
    for overlay in overlays {
        let name = &overlay.recording.name;
        let title = small(short(name, MAX_TITLE_LETTERS));
        let title = title.color(overlay_color(ui, overlay.color));
        ui.label(title)
            .on_hover_text(format!("{name}: misfit in units of its noise"));
    }
    for row in FEATURE_ROWS {
        ui.label(small(row.title()).strong())
            .on_hover_text(row.help());
    }
    ui.label(small("differs from now").strong());
    ui.end_row();
}

fn present_row(ui: &mut Ui, state: &State, overlays: &[&Overlay]) {
    ui.label("");
    ui.label("now");
    ui.label("");
    ui.label("");
    match &state.snapshot {
        Some(snapshot) => {
            let figures = latest(ui, None, &snapshot.features);
            let figures = figures.as_deref().map(Figures::of).unwrap_or_default();
            cells(ui, snapshot, figures, overlays);
        }
        None => empty_cells(ui, overlays),
    }
    ui.end_row();
}

/// Misfits and features of a kept curve.
fn numbers(ui: &mut Ui, run: Option<&KeptRun>, overlays: &[&Overlay]) {
    match run.map(|run| &run.run) {
        Some(Ok(snapshot)) => {
            let figures = snapshot.features.as_deref().map(Figures::of);
            cells(ui, snapshot, figures.unwrap_or_default(), overlays);
        }
        Some(Err(_)) | None => empty_cells(ui, overlays),
    }
}

fn cells(ui: &mut Ui, snapshot: &Snapshot, figures: Figures, overlays: &[&Overlay]) {
    number(ui, &misfit_text(snapshot));
    for overlay in overlays {
        let found = snapshot.comparisons.iter().find(|c| c.id == overlay.id);
        match found.map(|c| (c.misfit(), &c.comparison)) {
            Some((Some(misfit), _)) => number(ui, &format_number(misfit, MISFIT_DIGITS)),
            // Without noise there is no unit but the length.
            Some((None, Ok(comparison))) => number(ui, &format_quantity(comparison.rms, "m", 2)),
            Some((None, Err(reason))) => {
                ui.label("none").on_hover_text(reason);
            }
            None => number(ui, "-"),
        }
    }
    for row in FEATURE_ROWS {
        let value = row.value(&figures);
        let text = value.map_or_else(|| "-".to_owned(), |value| format_number(value, 3));
        number(ui, &text);
    }
}

fn empty_cells(ui: &mut Ui, overlays: &[&Overlay]) {
    for _ in 0..=overlays.len() + FEATURE_ROWS.len() {
        number(ui, "-");
    }
}

fn number(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).monospace().size(11.5));
}

/// `1.02`, or that there is none.
fn misfit_text(snapshot: &Snapshot) -> String {
    let total = snapshot.total_misfit();
    total.map_or_else(
        || "-".to_owned(),
        |total| format_number(total, MISFIT_DIGITS),
    )
}

/// The parameters in which a curve differs from the present device, and its drive if that differs:
/// name, the curve's value, the present value.
fn all_differences(state: &State, curve: &KeptCurve) -> Vec<[String; 3]> {
    let origin = &curve.origin;
    let (kept, now) = (&origin.preset.model, &state.setup.preset.model);
    let mut rows = Vec::new();
    if kept.name != now.name {
        let name = |name: &str| name.to_owned();
        rows.push([name("device"), name(&kept.name), name(&now.name)]);
    }
    rows.extend(differences(kept, now));
    if kept.piezo.is_some() && origin.drive != state.setup.drive {
        let text = |drive: &DriveChoice| match drive {
            DriveChoice::Waveform(waveform) => waveform.to_string(),
            DriveChoice::Recorded(id) => format!("voltage of {}", name_of(&state.setup, *id)),
        };
        let (kept, now) = (text(&origin.drive), text(&state.setup.drive));
        rows.push(["drive".to_owned(), kept, now]);
    }
    rows
}

fn difference_text(ui: &mut Ui, state: &State, curve: &KeptCurve) {
    let rows = all_differences(state, curve);
    let written = rows.iter().take(MAX_WRITTEN_DIFFERENCES);
    let parts: Vec<String> = written
        .map(|[name, kept, _]| format!("{name} {kept}"))
        .collect();
    let mut text = parts.join(", ");
    if rows.is_empty() {
        text = "nothing".to_owned();
    } else if rows.len() > MAX_WRITTEN_DIFFERENCES {
        text += &format!(" and {} more", rows.len() - MAX_WRITTEN_DIFFERENCES);
    }
    let lines: Vec<String> = rows
        .iter()
        .map(|[name, kept, now]| format!("{name}: {kept}, now {now}"))
        .collect();
    let label = ui.add(Label::new(small(text)).extend());
    if !lines.is_empty() {
        label.on_hover_text(lines.join("\n"));
    }
}

/// What there is to know of a curve besides its numbers.
fn about(curve: &KeptCurve, run: Option<&KeptRun>) -> String {
    match run.map(|run| &run.run) {
        _ if curve.origin.live.is_some() => format!(
            "{}: from a live run. It is compared with no recording and lost when the window is closed.",
            curve.name
        ),
        Some(Err(reason)) => format!("{} cannot be shown: {reason}", curve.name),
        Some(Ok(_)) => curve.name.clone(),
        None => format!("{}: being computed", curve.name),
    }
}

/// The same below the table, where it says more than the name.
fn remark(ui: &mut Ui, curve: &KeptCurve, run: Option<&KeptRun>) {
    let text = about(curve, run);
    if text != curve.name {
        ui.label(small(text).weak());
    }
}
