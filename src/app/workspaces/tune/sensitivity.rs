//! The sensitivity tool: which slider to take. One row for each slider, the one that could take away
//! most of the residual first.

use std::sync::Arc;

use eframe::egui::{
    Button, Color32, Label, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};

use crate::app::analysis::sensitivity::{Found, STEP_SHARE};
use crate::app::plots::frame::style::{palette, strong_overlay_color};
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::Mode;
use crate::app::state::State;
use crate::app::widgets::job_progress::progress_bar;
use crate::app::widgets::text::{error_color, small};
use crate::fit::experiment::{Influence, Sensitivity};
use crate::model::parameter::ParameterId;
use crate::model::unit::{format_number, format_quantity};

/// Fall of chi2 below which a slider has nothing to gain: three standard errors of its value.
const SIGNIFICANT_GAIN: f64 = 9.0;
/// Width of a slider's symbol \[points\].
const SYMBOL_WIDTH: f32 = 92.0;
/// Size of the bar of the gain, with the arrow left of it, and of the shape \[points\].
const BAR_SIZE: [f32; 2] = [96.0, 16.0];
const ARROW_SIZE: f32 = 12.0;
const SHAPE_SIZE: [f32; 2] = [56.0, 20.0];
/// Height of the first line of a row \[points\].
const ROW_HEIGHT: f32 = 24.0;

/// Draws the tool.
pub fn show(ui: &mut Ui, state: &mut State) {
    ui.add(
        Label::new(small(
            "The bar is the share of chi\u{b2} that a slider could take away, if it alone were \
             moved. It is a linear estimate; the misfit named with the value was simulated. Point \
             at a row, or press its symbol, to see its part of the residual in the residual plot.",
        ))
        .wrap(),
    );
    ui.add_space(4.0);
    progress(ui, state);
    let Some(found) = state.sensing.found().cloned() else {
        if state.sensing.progress().is_none() {
            ui.weak(why_nothing(state));
        }
        return;
    };
    let all = &found.sensitivity;
    let now = format_number(all.misfit(), 3);
    ui.label(format!("Misfit of these recordings: {now} x noise"));
    let mut order: Vec<&Influence> = all.influences.iter().collect();
    order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    for influence in order {
        row(ui, state, &found, influence);
    }
    twins(ui, &found);
    if !all.without_influence.is_empty() {
        let ids = all.without_influence.join(", ");
        ui.add(Label::new(small(format!("No influence on xp: {ids}")).weak()).wrap());
    }
    for (id, reason) in &all.failed {
        let text = small(format!("{id}: {reason}")).color(ui.visuals().warn_fg_color);
        ui.add(Label::new(text).wrap());
    }
    ui.add_space(12.0);
}

/// How far a result is that is being computed. The height is fixed, so that no row moves.
fn progress(ui: &mut Ui, state: &State) {
    let size = vec2(ui.available_width(), 20.0);
    ui.allocate_ui(size, |ui| {
        ui.set_min_size(size);
        if let Some(share) = state.sensing.progress() {
            let text = format!("computing {:.0} %", 100.0 * share);
            progress_bar(ui, share as f32, text);
        } else if let Some(error) = &state.sensing.error {
            let color = error_color(ui);
            ui.colored_label(color, format!("Not computed: {error}"));
        }
    });
}

fn why_nothing(state: &State) -> String {
    let compared = state.snapshot.as_ref().map(|s| &s.comparisons);
    if state.setup.overlays.is_empty() {
        "Open a recording first.".to_owned()
    } else if state.view.mode == Mode::Live {
        let whole_span = Command::SetMode(Mode::WholeSpan);
        whole_span.with_keys("Recordings are compared in whole-span mode") + "."
    } else if compared.is_some_and(|all| all.iter().all(|c| c.misfit().is_none())) {
        "No recording is compared in units of its noise.".to_owned()
    } else {
        "Waiting for the simulation.".to_owned()
    }
}

/// Symbol of a slider, and its name and unit.
fn named(id: &str, unit: &'static str) -> (String, String, &'static str) {
    match ParameterId::from_id(id) {
        Some(parameter) => {
            let spec = parameter.spec();
            (spec.symbol.to_owned(), spec.name.to_owned(), unit)
        }
        None => (id.to_owned(), "parameter of an effect".to_owned(), unit),
    }
}

fn row(ui: &mut Ui, state: &mut State, found: &Arc<Found>, influence: &Influence) {
    let all = &found.sensitivity;
    let id = influence.id.as_str();
    let (symbol, name, unit) = named(id, found.model.unit_of(id).unwrap_or(""));
    let whole = ui.scope(|ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 6.0;
            let is_selected = state.sensing.selected.as_deref() == Some(id);
            let button = Button::selectable(is_selected, symbol).truncate();
            let label = ui.add_sized([SYMBOL_WIDTH, ROW_HEIGHT], button);
            let help = "Press to keep its part of the residual in the plot.";
            if label.on_hover_text(format!("{name}\n{help}")).clicked() {
                state.sensing.selected = (!is_selected).then(|| id.to_owned());
            }
            bar(ui, influence, influence.gain / all.chi2.max(1e-300));
            shape(ui, state, found, influence);
            try_button(ui, state, influence, unit);
        });
        ui.add(Label::new(small(words(all, influence, unit)).weak()).wrap());
    });
    let rect = whole.response.rect;
    if ui.rect_contains_pointer(rect) {
        state.sensing.hovered = Some(id.to_owned());
    }
    ui.separator();
}

/// `1 % of its value (3.8 nN) changes xp by 0.31 x noise (rms); there: misfit 1.2`.
fn words(all: &Sensitivity, influence: &Influence, unit: &str) -> String {
    let step = format_quantity(influence.step, unit, 2);
    let rms = format_number(influence.rms, 2);
    let of = if influence.step == STEP_SHARE * influence.value {
        "value"
    } else {
        "slider"
    };
    let share = 100.0 * STEP_SHARE;
    let change = format!("{share} % of its {of} ({step}) changes xp by {rms} x noise (rms)");
    if influence.gain < SIGNIFICANT_GAIN {
        return format!("{change}; nothing to gain beyond the noise");
    }
    let Some(suggestion) = influence.suggestion else {
        return format!("{change}; no better value was found that way");
    };
    let misfit = format_number(all.misfit_of(suggestion.chi2), 3);
    let way = if suggestion.is_linear {
        "there"
    } else {
        "a part of the way there"
    };
    format!("{change}; {way}: misfit {misfit}")
}

/// The share of chi2 that could be taken away, with an arrow to the side to move to.
fn bar(ui: &mut Ui, influence: &Influence, share: f64) {
    let share = share.clamp(0.0, 1.0) as f32;
    let [width, height] = BAR_SIZE;
    let size = vec2(2.0 * ARROW_SIZE + width, ROW_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let up = influence.steps_to_best > 0.0;
    let direction = if up { "raise" } else { "lower" };
    let text = format!(
        "{direction} {}: {:.0} % of chi\u{b2}",
        influence.id,
        100.0 * share
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &text));
    let colors = palette(ui);
    let is_worth = influence.gain >= SIGNIFICANT_GAIN;
    let color = if is_worth {
        colors.proof_mass
    } else {
        colors.grid
    };
    let middle = rect.center();
    let frame = Rect::from_center_size(middle, vec2(width, height));
    let painter = ui.painter();
    painter.rect_filled(frame, 2.0, ui.visuals().extreme_bg_color);
    let filled = Rect::from_min_size(frame.min, vec2(width * share, height));
    painter.rect_filled(filled, 2.0, color.gamma_multiply(0.7));
    if is_worth {
        let x = if up {
            rect.right() - 0.5 * ARROW_SIZE
        } else {
            rect.left() + 0.5 * ARROW_SIZE
        };
        painter.add(arrow(pos2(x, middle.y), up, color));
    }
    response.on_hover_text(text);
}

/// A triangle to the right or to the left.
fn arrow(at: Pos2, to_the_right: bool, color: Color32) -> Shape {
    let side = if to_the_right { 4.0 } else { -4.0 };
    let corners = vec![
        at + vec2(side, 0.0),
        at + vec2(-side, -5.0),
        at + vec2(-side, 5.0),
    ];
    Shape::convex_polygon(corners, color, Stroke::NONE)
}

/// What it changes in the selected recording, else in the first, over its whole time.
fn shape(ui: &mut Ui, state: &State, found: &Found, influence: &Influence) {
    let size = vec2(SHAPE_SIZE[0], SHAPE_SIZE[1]);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let selected = found
        .overlays
        .iter()
        .position(|id| Some(*id) == state.selected);
    let place = selected.unwrap_or(0);
    let name = format!("shape of {}", influence.id);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    let (Some(column), Some(id)) = (influence.columns.get(place), found.overlays.get(place)) else {
        return;
    };
    let overlay = state.setup.overlays.iter().find(|o| o.id == *id);
    let color = overlay.map_or(palette(ui).text, |o| strong_overlay_color(ui, o.color));
    let top = column.iter().filter(|j| j.is_finite());
    let top = top.fold(0.0f64, |top, j| top.max(j.abs())).max(1e-300);
    let per_point = column.len().div_ceil(size.x as usize).max(1);
    let mut points = Vec::new();
    for (n, part) in column.chunks(per_point).enumerate() {
        let x = rect.left() + (n * per_point) as f32 / column.len() as f32 * rect.width();
        let known = part.iter().copied().filter(|j| j.is_finite());
        let (low, high) = known.fold((f64::MAX, f64::MIN), |(a, b), j| (a.min(j), b.max(j)));
        if low <= high {
            let y = |j: f64| rect.center().y - (j / top) as f32 * 0.5 * rect.height();
            points.extend([pos2(x, y(low)), pos2(x, y(high))]);
        }
    }
    ui.painter().line(points, Stroke::new(1.0, color));
    let recording = overlay.map_or_else(String::new, |o| format!(" in {}", o.recording.name));
    response.on_hover_text(format!("What {} changes{recording}", influence.id));
}

fn try_button(ui: &mut Ui, state: &mut State, influence: &Influence, unit: &str) {
    let id = influence.id.as_str();
    let worth = influence.gain >= SIGNIFICANT_GAIN;
    let Some(suggestion) = influence.suggestion.filter(|_| worth) else {
        return;
    };
    // What was computed for other values is no suggestion for the present ones.
    let is_current = state.setup.preset.model.get(id) == Some(influence.value);
    let is_locked = state.setup.locked.contains(id);
    let value = format_quantity(suggestion.value, unit, 4);
    let button = Button::new(format!("Try {value}"));
    let pressed = ui.add_enabled(is_current && !is_locked, button);
    pressed.widget_info(|| {
        let name = format!("try {id} {value}");
        WidgetInfo::labeled(Role::Button, is_current && !is_locked, name)
    });
    let now = format_quantity(influence.value, unit, 4);
    let help = format!("Set {id} from {now} to {value}. Undo takes it back.");
    let pressed = pressed
        .on_hover_text(help)
        .on_disabled_hover_text("The slider is locked, or was moved since.");
    if pressed.clicked() {
        // The id is of a slider of this device.
        let _ = state.setup.preset.model.set(id, suggestion.value);
    }
}

/// Which sliders do nearly the same.
fn twins(ui: &mut Ui, found: &Found) {
    let name = |i: usize| found.sensitivity.influences[i].id.as_str();
    for &(a, b, correlation) in &found.twins {
        let way = if correlation > 0.0 {
            "in the same way"
        } else {
            "in opposite ways"
        };
        let text = format!(
            "{} and {} change the residual {way} (correlation {correlation:.2}): move only one of \
             them; these recordings hardly tell them apart.",
            name(a),
            name(b)
        );
        ui.add(Label::new(small(text)).wrap());
    }
}
