//! The list of recordings that are plotted with the simulation, and the actions on each.

use eframe::egui::{
    Align, Button, CollapsingHeader, ComboBox, CursorIcon, Frame, Grid, Id, Label, Layout, Sense,
    Ui, vec2,
};

use super::drive::editor;
use super::start::start_from_recording;
use crate::app::analysis::recording_noise;
use crate::app::plots::frame::style::overlay_color;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::setup::own_drive::OwnDrive;
use crate::app::state::State;
use crate::app::widgets::callout;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::quantity_field::QuantityField;
use crate::app::widgets::text::small;
use crate::app::workspaces::recording_faults;
use crate::model::drive::{DriveReading, Waveform};
use crate::model::unit::{counted, format_quantity};
use crate::recording::Channel;
use crate::recording::align::Alignment;

/// The drive that is set for the simulation.
const SHARED_DRIVE: &str = "the drive of the simulation";

/// An action that was chosen in the list. It is carried out after the list is drawn, because
/// drawing borrows the recordings.
enum RecordingEdit {
    Select(OverlayId),
    Remove(OverlayId),
    Align,
    Drive(OverlayId),
    Start(OverlayId),
    Import(OverlayId),
}

/// Draws the list.
pub fn show(ui: &mut Ui, state: &mut State) {
    if state.setup.overlays.is_empty() {
        ui.weak("None yet. Drop a CSV file on the window, or open one.");
    }
    let mut edit = None;
    let selected = state.selected;
    let can_drive = state.setup.preset.model.piezo.is_some();
    let model = &state.setup.preset.model;
    let can_start = !model.has_ground && model.piezo.is_none();
    let driving = match state.setup.drive {
        DriveChoice::Recorded(id) => Some(id),
        DriveChoice::Waveform(_) => None,
    };
    let shared = match &state.setup.drive {
        DriveChoice::Waveform(waveform) => Some(waveform.clone()),
        DriveChoice::Recorded(_) => None,
    };
    let quietest = recording_noise::quietest(ui, &state.setup.overlays);
    for overlay in &mut state.setup.overlays {
        let is_selected = selected == Some(overlay.id);
        let mut frame = Frame::group(ui.style()).inner_margin(6);
        if is_selected {
            frame.fill = ui.visuals().faint_bg_color;
            frame.stroke = ui.visuals().selection.stroke;
        }
        frame.show(ui, |ui| {
            ui.push_id(overlay.id, |ui| {
                ui.set_width(ui.available_width());
                header(ui, overlay, is_selected, &mut edit);
                facts(ui, overlay, quietest);
                if !is_selected {
                    return;
                }
                own_drive(ui, overlay, &shared, can_drive);
                estimates(ui, overlay);
                alignment(ui, overlay);
                actions(
                    ui,
                    overlay,
                    [can_drive && driving != Some(overlay.id), can_start],
                    &mut edit,
                );
            });
        });
    }
    if ui.button("Open recording...").clicked() {
        state.ask(Command::Open);
    }
    if let Some(edit) = edit {
        apply(state, edit);
    }
}

fn apply(state: &mut State, edit: RecordingEdit) {
    match edit {
        RecordingEdit::Select(id) => {
            state.selected = (state.selected != Some(id)).then_some(id);
        }
        RecordingEdit::Remove(id) => remove(state, id),
        RecordingEdit::Align => state.ask(Command::AutoAlign),
        RecordingEdit::Drive(id) => state.setup.drive = DriveChoice::Recorded(id),
        RecordingEdit::Start(id) => start_from_recording(&mut state.setup, id),
        RecordingEdit::Import(id) => {
            state.selected = Some(id);
            state.ask(Command::ImportSettings);
        }
    }
}

/// Removes a recording. If its voltage was the drive, the drive of the preset replaces it.
pub fn remove(state: &mut State, id: OverlayId) {
    state.setup.overlays.retain(|overlay| overlay.id != id);
    if state.setup.drive == DriveChoice::Recorded(id) {
        use_preset_drive(&mut state.setup);
    }
    if state.selected == Some(id) {
        state.selected = None;
    }
}

fn use_preset_drive(setup: &mut Setup) {
    let name = setup
        .preset
        .drive
        .split(':')
        .next()
        .unwrap_or("rest")
        .to_owned();
    setup.drive = DriveChoice::Waveform(Default::default());
    if let Ok(drive) =
        crate::model::drive::Waveform::parse(&setup.preset.drive, setup.preset.duration)
    {
        setup.drive = DriveChoice::Waveform(drive);
    } else if let Some(drive) = editor::of_kind(setup, &name) {
        setup.drive = drive;
    }
}

fn header(ui: &mut Ui, overlay: &mut Overlay, is_selected: bool, edit: &mut Option<RecordingEdit>) {
    let name = overlay.recording.name.clone();
    ui.horizontal(|ui| {
        let color = overlay_color(ui, overlay.color);
        let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
        if overlay.visible {
            ui.painter().rect_filled(rect, 2.0, color);
        } else {
            let stroke = (1.5, color);
            ui.painter().rect_stroke(rect, 2.0, stroke, eframe::egui::StrokeKind::Inside);
        }
        ui.spacing_mut().icon_spacing = 0.0;
        let check = ui.checkbox(&mut overlay.visible, "");
        check.widget_info(|| {
            let label = format!("show {name}");
            let role = eframe::egui::Role::CheckBox;
            eframe::egui::WidgetInfo::selected(role, true, overlay.visible, label)
        });
        check.on_hover_text("Plot it and compare it with the simulation");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if icon_button(ui, Icon::Remove, &format!("remove {name}"))
                .on_hover_text("Remove it from the list (can be undone)")
                .clicked()
            {
                *edit = Some(RecordingEdit::Remove(overlay.id));
            }
            if overlay.made_up {
                let badge = small("synthetic").color(ui.visuals().warn_fg_color);
                ui.label(badge).on_hover_text(
                    "Not a measurement: simulated with other parameters, as something to tune against.",
                );
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let button = Button::selectable(is_selected, &name).truncate();
                let hover = match &overlay.recording.path {
                    Some(path) => format!("{}\nClick for shift, scale and more.", path.display()),
                    None => format!("{name}\nClick for shift, scale and more."),
                };
                if ui.add(button).on_hover_text(hover).clicked() {
                    *edit = Some(RecordingEdit::Select(overlay.id));
                }
            });
        });
    });
}

fn facts(ui: &mut Ui, overlay: &Overlay, quietest: f64) {
    let recording = &overlay.recording;
    let text = format!(
        "{} at {}, noise {}",
        format_quantity(recording.duration(), "s", 3),
        format_quantity(recording.sampling_rate(), "Hz", 3),
        recording_noise::text(ui, overlay, quietest),
    );
    let label = ui.add(Label::new(small(text).weak()).truncate());
    label.on_hover_text(format!(
        "{} samples; channels {}",
        recording.len(),
        channels(overlay)
    ));
    recording_faults::show(ui, overlay);
    let warnings = &recording.warnings;
    if warnings.is_empty() {
        return;
    }
    let count: usize = warnings.iter().map(|w| w.count.max(1)).sum();
    let title = format!("{} from the file", counted(count, "warning"));
    let title = small(title).color(ui.visuals().warn_fg_color);
    CollapsingHeader::new(title)
        .id_salt("warnings")
        .show_unindented(ui, |ui| {
            for warning in warnings {
                ui.label(small(&warning.message));
            }
        });
}

fn channels(overlay: &Overlay) -> String {
    let all = crate::recording::Channel::ALL;
    let present = all
        .into_iter()
        .filter(|c| overlay.recording.channel(*c).is_some());
    present.map(|c| c.symbol()).collect::<Vec<_>>().join(", ")
}

/// What drives the recording's own run: its voltage as it is read, the drive of the simulation, or
/// a copy of that which stays with it.
fn own_drive(ui: &mut Ui, overlay: &mut Overlay, shared: &Option<Waveform>, can_drive: bool) {
    if !can_drive {
        return;
    }
    let measured = overlay.recording.has_voltage();
    let now = match &overlay.drive {
        OwnDrive::Measured(reading) if measured => format!("its voltage: {}", reading.label()),
        OwnDrive::Measured(_) | OwnDrive::Shared => SHARED_DRIVE.to_owned(),
        OwnDrive::Chosen(waveform) => format!("chosen: {waveform}"),
    };
    ui.horizontal(|ui| {
        ui.label("drive");
        let list = ComboBox::from_id_salt("own drive")
            .width(ui.available_width())
            .truncate()
            .selected_text(now);
        let output = list.show_ui(ui, |ui| {
            if measured {
                for reading in DriveReading::ALL {
                    let text = format!("its voltage: {}", reading.label());
                    let drive = OwnDrive::Measured(reading);
                    ui.selectable_value(&mut overlay.drive, drive, text);
                }
            }
            ui.selectable_value(&mut overlay.drive, OwnDrive::Shared, SHARED_DRIVE);
            if let Some(waveform) = shared {
                let drive = OwnDrive::Chosen(waveform.clone());
                let text = format!("a drive of its own, now {waveform}");
                ui.selectable_value(&mut overlay.drive, drive, text);
            }
        });
        let id = output.response.id;
        ui.ctx()
            .accesskit_node_builder(id, |node| node.set_label("drive of this recording"));
        output
            .response
            .on_hover_text("Under which drive the device is simulated for this recording");
    });
}

/// What of its instrument is estimated.
fn estimates(ui: &mut Ui, overlay: &mut Overlay) {
    ui.horizontal_wrapped(|ui| {
        ui.label("estimate")
            .on_hover_text("What belongs to the instrument and must not count as misfit");
        let to = &mut overlay.estimates;
        ui.checkbox(&mut to.zeros, "zero")
            .on_hover_text("The zero of each reading, whatever it is");
        ui.checkbox(&mut to.clock, "clock")
            .on_hover_text("How late the readings are against the voltage: 0 within some us, and within what the edges of the voltage leave open");
        ui.checkbox(&mut to.scales, "scale")
            .on_hover_text("The scale of each reading: 1 within 1 %. It can hide an error of the drive's strength.");
        ui.checkbox(&mut to.start, "start").on_hover_text(
            "The state in which it begins, where that is not rest: cut from a longer recording, or let go from a displacement",
        );
    });
}

/// A row of the alignment: a quantity that is typed, or dragged by its name.
struct AlignmentRow {
    name: &'static str,
    help: &'static str,
    unit: &'static str,
    /// Change per point of a drag.
    speed: f64,
}

impl AlignmentRow {
    fn show(&self, ui: &mut Ui, owner: OverlayId, value: &mut f64) {
        let name = Label::new(self.name).selectable(false).sense(Sense::drag());
        let handle = ui
            .add(name)
            .on_hover_text(format!("{}\nDrag this name, or type a value.", self.help))
            .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        if handle.dragged() {
            *value += self.speed * f64::from(handle.drag_delta().x);
        }
        let field = QuantityField {
            id: Id::unique(("alignment", owner, self.name)),
            label: self.name,
            value: *value,
            unit: self.unit,
            width: 96.0,
            enabled: true,
        };
        let limit =
            |value: f64| (!value.is_finite()).then(|| "it must be a finite number".to_owned());
        let output = field.show(ui, limit);
        if let Some(error) = &output.error {
            callout::error(
                ui,
                ("alignment", owner, self.name),
                output.response.rect,
                error,
            );
        }
        output.response.on_hover_text(self.help);
        if let Some(typed) = output.value {
            *value = typed;
        }
        ui.end_row();
    }
}

fn alignment(ui: &mut Ui, overlay: &mut Overlay) {
    let recording = std::sync::Arc::clone(&overlay.recording);
    let time_step = (recording.duration() / 2000.0).max(1e-9);
    let shift = span(&recording.proof_mass) / 500.0;
    let row = |name, help, unit, speed| AlignmentRow {
        name,
        help,
        unit,
        speed,
    };
    let (owner, to) = (overlay.id, &mut overlay.alignment);
    Grid::new("alignment")
        .num_columns(2)
        .spacing([8.0, 3.0])
        .show(ui, |ui| {
            let help = "Added to the recording's times: positive moves it to the right";
            row("time shift", help, "s", time_step).show(ui, owner, &mut to.time_shift);
            let help = "Factor on the proof mass's displacements";
            row("xp scale", help, "", 0.001).show(ui, owner, &mut to.xp_scale);
            let help = "Added to the proof mass's displacements";
            row("xp offset", help, "m", shift).show(ui, owner, &mut to.xp_offset);
            if recording.channel(Channel::Cantilever).is_some() {
                let help = "Factor on the cantilever's displacements";
                row("xc scale", help, "", 0.001).show(ui, owner, &mut to.xc_scale);
                let help = "Added to the cantilever's displacements";
                row("xc offset", help, "m", shift).show(ui, owner, &mut to.xc_offset);
            }
        });
}

/// Approximate range of a channel \[m\], from at most some 500 samples: it only sets how fast a
/// drag changes the offset.
fn span(samples: &[f64]) -> f64 {
    let some = samples.iter().step_by((samples.len() / 256).max(1));
    let (low, high) = some
        .filter(|x| x.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(*x), high.max(*x))
        });
    if high > low { high - low } else { 1e-6 }
}

fn actions(
    ui: &mut Ui,
    overlay: &mut Overlay,
    [can_drive, can_start]: [bool; 2],
    edit: &mut Option<RecordingEdit>,
) {
    ui.horizontal_wrapped(|ui| {
        let button = |ui: &mut Ui, name: &str, help: &str, enabled: bool| {
            let button = Button::new(small(name));
            ui.add_enabled(enabled, button)
                .on_hover_text(help)
                .clicked()
        };
        if button(
            ui,
            "Auto-align",
            "Shift it onto the simulation by cross-correlation",
            true,
        ) {
            *edit = Some(RecordingEdit::Align);
        }
        let moved = overlay.alignment != Alignment::default();
        if button(ui, "Reset alignment", "No shift, scale 1, no offset", moved) {
            overlay.alignment = Alignment::default();
        }
        if overlay.recording.voltage.is_some()
            && button(
                ui,
                "Use its voltage as drive",
                "Simulate with the voltage that was recorded",
                can_drive,
            )
        {
            *edit = Some(RecordingEdit::Drive(overlay.id));
        }
        if can_start
            && button(
                ui,
                "Start from its first samples",
                "Set x0, v0 and the sensor offset from the recording",
                true,
            )
        {
            *edit = Some(RecordingEdit::Start(overlay.id));
        }
        if button(
            ui,
            "Import settings...",
            "Columns, units, time offset, scale, sign",
            overlay.recording.path.is_some(),
        ) {
            *edit = Some(RecordingEdit::Import(overlay.id));
        }
    });
}
