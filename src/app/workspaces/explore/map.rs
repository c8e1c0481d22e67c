//! The map panel: axes and measure on the left, the map in the middle, the case under the pointer on
//! the right.

use eframe::egui::{
    Button, CentralPanel, ComboBox, EventFilter, Key, Label, Panel, ScrollArea, Ui, vec2,
};

use super::axis_picker::AxisPicker;
use super::case;
use super::fields::{Row, name, refusal, remark, source, within};
use super::progress;
use super::readout::READOUT_WIDTH;
use crate::app::analysis::explore::mapping::{Mapping, measure_of, request_of};
use crate::app::analysis::explore::source::drive_of;
use crate::app::flows::open_case;
use crate::app::plots::explore::colors::regime_color;
use crate::app::plots::explore::legend;
use crate::app::plots::explore::map::{CaseMark, MapPicture, case_at, value_axis};
use crate::app::plots::explore::plane::PlaneOutput;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::explore::MapChoices;
use crate::app::state::State;
use crate::app::widgets::text::heading;
use crate::explore::map::{Axis, MapResult, PointState};
use crate::explore::measures::{Drawn, MEASURES, MeasureId, Regime};
use crate::fit::table_a1::measurements::cases;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::unit::counted;

/// Width of the controls and of the case under the pointer \[points\].
const CONTROLS_WIDTH: f32 = 286.0;
/// Points along an axis that can be asked for.
const POINT_COUNTS: (f64, f64) = (2.0, 1000.0);
/// A path has a new point when the pointer has moved as far \[points\].
const PATH_STEP: f32 = 6.0;

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    let drive = drive_of(&state.setup, state.setup.explore.map.source);
    let again = Panel::left("map controls")
        .exact_size(CONTROLS_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("map controls")
                .auto_shrink([false, false])
                .show(ui, |ui| controls(ui, state, drive.as_ref().ok()))
                .inner
        })
        .inner;
    let request = drive.and_then(|drive| {
        let of = (&state.setup.preset.model, &drive);
        request_of(&state.setup.explore.map, of).map_err(|error| error.to_string())
    });
    state.exploring.map.update(request, again, ui.ctx());
    Panel::right("map case")
        .exact_size(READOUT_WIDTH)
        .show(ui, |ui| case::show(ui, state));
    CentralPanel::default().show(ui, |ui| picture(ui, state));
}

/// The controls; returns whether the map is to be computed again.
fn controls(ui: &mut Ui, state: &mut State, drive: Option<&Waveform>) -> bool {
    let model = &state.setup.preset.model;
    let choices = &mut state.setup.explore.map;
    if let Some(chosen) = source(ui, choices.source) {
        choices.source = chosen;
    }
    if let Some(drive) = drive {
        remark(ui, &drive.to_string());
        axes(ui, choices, (model, drive));
    }
    measure(ui, choices);
    let row = Row {
        label: "points along each axis",
        name: "Points",
        help: "Points along each axis; the time grows with their square",
        value: choices.points as f64,
        unit: "",
    };
    let (fewest, most) = POINT_COUNTS;
    if let Some(points) = row.show(ui, |v| within(v, fewest, most, "points")) {
        choices.points = points.round() as usize;
    }
    ui.separator();
    let mapping = &mut state.exploring.map;
    let again = progress::show(ui, &mapping.run, mapping.is_stopped, |grown| {
        let (map, points) = (&grown.answer, grown.answer.states.len());
        let solved = map.count(PointState::Solved) + map.count(PointState::Hole);
        format!("{solved} of {}", counted(points, "point"))
    });
    if again == progress::Asked::Stop {
        mapping.stop();
    }
    let can_export = mapping.run.growing().is_some();
    let (text, help) = Command::ExportMap.text();
    let export = ui.add_enabled(can_export, Button::new(text).small());
    if export.on_hover_text(help).clicked() {
        state.commands.push(Command::ExportMap);
    }
    let mapping = &mut state.exploring.map;
    ui.separator();
    let shown = measure_of(&state.setup.explore.map);
    legend_of(ui, mapping, shown);
    again == progress::Asked::Again
}

fn axes(ui: &mut Ui, choices: &mut MapChoices, of: (&Model, &Waveform)) {
    for (title, choice) in [("Horizontal", &mut choices.x), ("Vertical", &mut choices.y)] {
        let picker = AxisPicker {
            title,
            scope: "map",
            of,
        };
        picker.show(ui, choice);
    }
    let swap = ui.small_button("Exchange the axes");
    if swap.on_hover_text("Horizontal becomes vertical").clicked() {
        std::mem::swap(&mut choices.x, &mut choices.y);
    }
}

fn measure(ui: &mut Ui, choices: &mut MapChoices) {
    let spec = measure_of(choices).spec();
    ui.horizontal(|ui| {
        name(ui, "Measure", "What the colours show");
        let picker = ComboBox::from_id_salt("map measure")
            .width(138.0)
            .truncate()
            .selected_text(spec.name)
            .show_ui(ui, |ui| {
                for row in &MEASURES {
                    let entry = ui.selectable_label(row.measure == spec.measure, row.name);
                    if entry.on_hover_text(row.meaning).clicked() {
                        choices.measure = row.id.to_owned();
                    }
                }
            });
        picker.response.on_hover_text("What the colours show");
    });
    remark(ui, spec.meaning);
}

/// What the colours stand for.
fn legend_of(ui: &mut Ui, mapping: &Mapping, shown: MeasureId) {
    let Some(growing) = mapping.run.growing() else {
        return;
    };
    let grown = growing.lock();
    let map = &grown.answer;
    if shown.spec().drawn == Drawn::Category {
        heading(ui, "Regimes, share of the map");
        for (regime, share) in shares(map) {
            let value = format!("{:.1} %", 100.0 * share);
            legend::entry(ui, regime_color(regime), &regime.label(), &value);
        }
    } else if let Some(axis) = value_axis(map, shown) {
        legend::scale(ui, &axis);
        remark(ui, "Grey: the response has no such value.");
    }
    if !map.holes.is_empty() {
        let holes = counted(map.holes.len(), "point");
        remark(
            ui,
            &format!("Hatched: {holes} impossible; the pointer shows why."),
        );
    }
}

/// Regimes of the points that are known, with their shares.
fn shares(map: &MapResult) -> Vec<(Regime, f64)> {
    let mut counts = std::collections::BTreeMap::new();
    let values = map.of(MeasureId::Regime).unwrap_or_default();
    for value in values.iter().filter(|v| v.is_finite()) {
        *counts.entry(value.round() as u32).or_insert(0usize) += 1;
    }
    let all: usize = counts.values().sum();
    let share = |count: usize| count as f64 / all.max(1) as f64;
    let known = counts.into_iter();
    known
        .filter_map(|(code, count)| Some((Regime::from_code(code)?, share(count))))
        .collect()
}

/// The paper's cases, if the axes are frequency and amplitude and the device is the paper's.
fn marks(setup: &Setup, axes: &[Axis], drive: &Waveform) -> Vec<CaseMark> {
    let ids = [axes[0].id.as_str(), axes[1].id.as_str()];
    let is_turned = match ids {
        ["frequency", "amplitude"] => false,
        ["amplitude", "frequency"] => true,
        _ => return Vec::new(),
    };
    if !setup.preset.model.name.starts_with("paper") {
        return Vec::new();
    }
    let all = cases().iter().map(|case| {
        let place = if is_turned {
            [case.amplitude, case.frequency]
        } else {
            [case.frequency, case.amplitude]
        };
        CaseMark {
            place,
            name: format!("Table A.1: {}", case.name()),
            has_same_form: std::mem::discriminant(drive)
                == std::mem::discriminant(&case.waveform()),
        }
    });
    all.collect()
}

fn picture(ui: &mut Ui, state: &mut State) {
    if let Some(error) = &state.exploring.map.run.error {
        refusal(ui, &format!("No map: {error}."));
        return;
    }
    let Some(growing) = state.exploring.map.run.growing().cloned() else {
        ui.spinner();
        return;
    };
    let Some(request) = state.exploring.map.run.asked().cloned() else {
        return;
    };
    let cases = marks(&state.setup, &request.axes, &request.drive);
    let room = ui.available_size();
    let note_height = 18.0;
    let grown = growing.lock();
    let picture = MapPicture {
        map: &grown.answer,
        measure: measure_of(&state.setup.explore.map),
        version: grown.version,
        cases: &cases,
        point: state.exploring.map.point,
        path: &state.exploring.map.path,
    };
    let output = picture.show(ui, vec2(room.x, room.y - note_height));
    drop(grown);
    let marked = output
        .response
        .hover_pos()
        .and_then(|pos| case_at(&output, &cases, pos));
    let text = match marked {
        Some(case) if case.has_same_form => case.name.clone(),
        Some(case) => format!("{} (another form of drive than the map's)", case.name),
        None if cases.is_empty() => {
            "Click opens the case in Tune; drag draws a path for Live.".to_owned()
        }
        None => "Click: open in Tune. Drag: path for Live. Table A.1: diamonds; squares with \
             another form of drive."
            .to_owned(),
    };
    let text = crate::app::widgets::text::small(text).weak();
    ui.add(Label::new(text).truncate());
    react(ui, state, &output, &request.axes);
}

/// Pointer and keys on the map.
fn react(ui: &Ui, state: &mut State, output: &PlaneOutput, axes: &[Axis]) {
    let response = &output.response;
    let index_of = |[x, y]: [f64; 2]| {
        let along = |axis: &Axis, value: f64| {
            let last = axis.count.saturating_sub(1) as f64;
            axis.position(value).round().clamp(0.0, last) as usize
        };
        along(&axes[0], x) + along(&axes[1], y) * axes[0].count
    };
    let mapping = &mut state.exploring.map;
    if let Some(place) = output.hovered() {
        mapping.look_at(index_of(place), ui.ctx());
    }
    if response.drag_started() {
        mapping.path.clear();
    }
    if response.dragged()
        && let Some(pos) = response.interact_pointer_pos()
    {
        let frame = output.frame();
        let pos = pos.clamp(frame.min, frame.max);
        let last = mapping.path.last().map(|place| output.on_screen(*place));
        if last.is_none_or(|last| last.distance(pos) >= PATH_STEP) {
            mapping.path.push(output.value_at(pos));
        }
    }
    if response.clicked() {
        response.request_focus();
        mapping.path.clear();
        if let Some(pos) = response.interact_pointer_pos() {
            mapping.look_at(index_of(output.value_at(pos)), ui.ctx());
            open_case::open_point(state);
        }
    }
    if response.has_focus() {
        keys(ui, state, output, axes);
    }
}

fn keys(ui: &Ui, state: &mut State, output: &PlaneOutput, axes: &[Axis]) {
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(output.response.id, filter));
    let pressed = |key: Key| ui.input(|input| input.key_pressed(key));
    let step = |less: Key, more: Key| i64::from(pressed(more)) - i64::from(pressed(less));
    let by = (
        step(Key::ArrowLeft, Key::ArrowRight),
        step(Key::ArrowDown, Key::ArrowUp),
    );
    let columns = axes[0].count.max(1);
    if by != (0, 0) {
        let at = state.exploring.map.point.unwrap_or(0);
        let moved = |at: usize, by: i64, count: usize| {
            (at as i64 + by).clamp(0, count.saturating_sub(1) as i64) as usize
        };
        let i = moved(at % columns, by.0, columns);
        let j = moved(at / columns, by.1, axes[1].count);
        state.exploring.map.look_at(i + j * columns, ui.ctx());
    }
    if pressed(Key::Enter) {
        open_case::open_point(state);
    }
}
