//! The period under the pointer: handles are dragged, added by a double click, and deleted by key
//! or menu.

use eframe::egui::{EventFilter, Key, Response, Ui, vec2};

use crate::app::analysis::explore::drawing::Drawing;
use crate::app::plots::explore::drawing::{DrawingPicture, handle_at, voltages_in_view};
use crate::app::plots::explore::plane::PlaneOutput;
use crate::app::state::State;
use crate::app::widgets::text::small;
use crate::explore::waveform::{EditableWaveform, SnapGrid};
use crate::model::drive::Handle;
use crate::model::unit::format_quantity;

/// Steps of the arrow keys without a grid: share of the period, and volts.
const FREE_STEP: (f64, f64) = (0.01, 0.1);

/// Draws the period `height` points high and carries out what is done to it.
pub fn show(ui: &mut Ui, state: &mut State, height: f32) {
    let drawn = &mut state.setup.explore.drawn;
    let drawing = &mut state.exploring.drawing;
    drawing.selected = drawing.selected.filter(|i| *i < drawn.handles().len());
    status(ui, drawn, drawing);
    let range = drawing
        .held_range
        .unwrap_or_else(|| voltages_in_view(drawn));
    let picture = DrawingPicture {
        drawn,
        selected: drawing.selected,
        range,
    };
    let size = vec2(ui.available_width(), height - ui.spacing().interact_size.y);
    let output = picture.show(ui, size);
    pointer(ui, &output, drawn, drawing, range);
    menu(&output, drawn, drawing);
    keys(ui, &output.response, drawn, drawing);
}

/// What to do, or what was refused, in the line above.
fn status(ui: &mut Ui, drawn: &EditableWaveform, drawing: &Drawing) {
    let row = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui(row, |ui| {
        ui.set_min_size(row);
        if let Some(refusal) = &drawing.refusal {
            let color = crate::app::widgets::text::error_color(ui);
            ui.label(small(refusal).color(color));
            return;
        }
        let text = match drawing.selected.and_then(|i| drawn.handles().get(i)) {
            Some(handle) => format!(
                "Handle {} at {} ({:.1} %), {}",
                drawing.selected.map_or(0, |i| i + 1),
                format_quantity(handle.time / drawn.frequency, "s", 4),
                100.0 * handle.time,
                format_quantity(handle.voltage + drawn.offset, "V", 4)
            ),
            None => "Drag a handle; double-click adds one; Delete removes it; Shift: off the grid"
                .to_owned(),
        };
        ui.label(small(text).weak());
    });
}

/// The point of a period that a place of the picture stands for.
fn point(drawn: &EditableWaveform, [time, voltage]: [f64; 2]) -> Handle {
    Handle {
        time: (time * drawn.frequency).clamp(0.0, 1.0),
        voltage: voltage - drawn.offset,
    }
}

fn pointer(
    ui: &Ui,
    output: &PlaneOutput,
    drawn: &mut EditableWaveform,
    drawing: &mut Drawing,
    range: (f64, f64),
) {
    let response = &output.response;
    let pos = response.interact_pointer_pos();
    let pressed = ui.input(|input| input.pointer.press_origin());
    if response.is_pointer_button_down_on() && drawing.dragged.is_none() {
        if let Some(origin) = pressed {
            drawing.dragged = handle_at(output, drawn, origin);
        }
        if drawing.dragged.is_some() {
            drawing.selected = drawing.dragged;
            drawing.held_range = Some(range);
        }
        response.request_focus();
    }
    if response.dragged()
        && let (Some(i), Some(pos)) = (drawing.dragged, pos)
    {
        let target = point(drawn, output.value_at(pos));
        let free = ui.input(|input| input.modifiers.shift);
        let moved = with_grid(drawn, free, |drawn| drawn.move_to(i, target).map(|_| ()));
        drawing.refusal = moved.err();
    }
    if !ui.input(|input| input.pointer.any_down()) {
        drawing.dragged = None;
        drawing.held_range = None;
    }
    if response.double_clicked()
        && let Some(pos) = pos
        && handle_at(output, drawn, pos).is_none()
    {
        add(drawn, drawing, point(drawn, output.value_at(pos)));
    } else if response.clicked()
        && let Some(pos) = pos
    {
        drawing.selected = handle_at(output, drawn, pos);
        drawing.refusal = None;
    }
    if response.secondary_clicked()
        && let Some(pos) = pos
    {
        drawing.selected = handle_at(output, drawn, pos);
        let at = point(drawn, output.value_at(pos));
        drawing.menu_at = Some((at.time, at.voltage));
    }
}

/// Changes the drawn period, with its grid or without.
fn with_grid(
    drawn: &mut EditableWaveform,
    is_free: bool,
    change: impl FnOnce(&mut EditableWaveform) -> Result<(), crate::explore::waveform::WaveformError>,
) -> Result<(), String> {
    let grid = drawn.grid;
    if is_free {
        drawn.grid = SnapGrid::default();
    }
    let changed = change(drawn);
    drawn.grid = grid;
    changed.map_err(|error| error.to_string())
}

fn add(drawn: &mut EditableWaveform, drawing: &mut Drawing, at: Handle) {
    match drawn.insert(at) {
        Ok(i) => {
            drawing.selected = Some(i);
            drawing.refusal = None;
        }
        Err(error) => drawing.refusal = Some(error.to_string()),
    }
}

/// Takes the selected handle away.
pub fn remove(drawn: &mut EditableWaveform, drawing: &mut Drawing) {
    let Some(i) = drawing.selected.take() else {
        return;
    };
    match drawn.remove(i) {
        Ok(_) => drawing.refusal = None,
        Err(error) => drawing.refusal = Some(error.to_string()),
    }
}

fn menu(output: &PlaneOutput, drawn: &mut EditableWaveform, drawing: &mut Drawing) {
    output.response.context_menu(|ui| {
        if drawing.selected.is_some() {
            if ui.button("Delete this handle").clicked() {
                remove(drawn, drawing);
                ui.close();
            }
            return;
        }
        let Some((time, voltage)) = drawing.menu_at else {
            return;
        };
        if ui.button("Add a handle here").clicked() {
            add(drawn, drawing, Handle { time, voltage });
            ui.close();
        }
    });
}

fn keys(ui: &Ui, response: &Response, drawn: &mut EditableWaveform, drawing: &mut Drawing) {
    if !response.has_focus() {
        return;
    }
    let filter = EventFilter {
        horizontal_arrows: true,
        vertical_arrows: true,
        ..EventFilter::default()
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    let pressed = |key: Key| ui.input(|input| input.key_pressed(key));
    if pressed(Key::Delete) || pressed(Key::Backspace) {
        remove(drawn, drawing);
    }
    let count = drawn.handles().len();
    if pressed(Key::PageDown) {
        drawing.selected = Some(drawing.selected.map_or(0, |i| (i + 1) % count));
    }
    if pressed(Key::PageUp) {
        drawing.selected = Some(drawing.selected.map_or(0, |i| (i + count - 1) % count));
    }
    let Some(i) = drawing.selected else {
        return;
    };
    let free = ui.input(|input| input.modifiers.shift);
    let fine = if free { 0.1 } else { 1.0 };
    let time = fine * drawn.grid.time.unwrap_or(FREE_STEP.0);
    let voltage = fine * drawn.grid.voltage.unwrap_or(FREE_STEP.1);
    let step = |less: Key, more: Key| f64::from(i8::from(pressed(more)) - i8::from(pressed(less)));
    let (dx, dy) = (
        step(Key::ArrowLeft, Key::ArrowRight),
        step(Key::ArrowDown, Key::ArrowUp),
    );
    if dx == 0.0 && dy == 0.0 {
        return;
    }
    let old = drawn.handles()[i];
    let target = Handle {
        time: (old.time + dx * time).clamp(0.0, 1.0),
        voltage: old.voltage + dy * voltage,
    };
    let moved = with_grid(drawn, free, |drawn| drawn.move_to(i, target).map(|_| ()));
    drawing.refusal = moved.err();
}
