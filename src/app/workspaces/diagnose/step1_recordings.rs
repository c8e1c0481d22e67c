//! Step 1: the recordings, the role of each, and its measured noise.

use eframe::egui::{Align, Frame, Label, Layout, RichText, Sense, Ui, vec2};

use super::options;
use super::words::scrolled;
use crate::app::analysis::{recording_noise, recording_roles};
use crate::app::flows::load_example;
use crate::app::plots::frame::style::overlay_color;
use crate::app::setup::command::Command;
use crate::app::setup::overlay::{Overlay, OverlayId, Role};
use crate::app::state::State;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::role_choice::role_choice;
use crate::app::widgets::text::small;
use crate::app::workspaces::recording_faults;
use crate::app::workspaces::tune::recordings::remove as remove_recording;
use crate::model::unit::format_quantity;

/// Draws the step.
pub fn show(ui: &mut Ui, state: &mut State) {
    scrolled(ui, "diagnose recordings", |ui| {
        device(ui, state);
        options::show(ui, state);
        list(ui, state);
        ui.add_space(4.0);
        sources(ui, state);
    });
}

fn device(ui: &mut Ui, state: &State) {
    let model = &state.setup.preset.model;
    let with = match model.effects.len() {
        0 => String::new(),
        1 => format!(" with {}", model.effects[0].spec.name),
        n => format!(" with {n} effects"),
    };
    let text = small(format!("Model: {}{with}, re-tuned first", model.name)).weak();
    ui.add(Label::new(text).wrap())
        .on_hover_text("The device of the Tune workspace. Its parameters are re-tuned before any effect is called missing.");
}

fn list(ui: &mut Ui, state: &mut State) {
    let busy = state.diagnosing.running.is_some();
    let (mut chosen, mut removed) = (None, None);
    if let Some(sealed) = &state.diagnosing.trial.sealed {
        let text = format!(
            "Sealed trial, seed {}: your recordings are set aside.",
            sealed.draw.seed
        );
        ui.label(small(text).color(ui.visuals().warn_fg_color));
    }
    let all = recording_roles::of(&state.setup);
    let count = |role: Role| all.iter().filter(|(_, r)| *r == role).count();
    let held_out = count(Role::HeldOut);
    let quietest = recording_noise::quietest(ui, all.iter().map(|(overlay, _)| *overlay));
    for (overlay, role) in &all {
        ui.push_id(overlay.id, |ui| {
            let frame = Frame::group(ui.style()).inner_margin(5);
            frame.show(ui, |ui| {
                ui.set_width(ui.available_width());
                ui.spacing_mut().item_spacing.y = 2.0;
                name(ui, overlay, busy, &mut removed);
                ui.add_enabled_ui(!busy, |ui| {
                    if let Some(role) = role_choice(ui, &overlay.recording.name, *role) {
                        chosen = Some((overlay.id, role));
                    }
                });
                facts(ui, overlay, quietest);
            });
        });
    }
    if all.is_empty() {
        ui.label("Drop CSV files with t, V and xp on the window.");
    } else if held_out == 0 {
        let text = "No recording is held out, so the last third of each is. A separate recording \
                    with another drive is a stricter check.";
        ui.label(small(text).weak());
    } else if !recording_roles::is_chosen(&state.setup) {
        let which = if recording_roles::are_named(&all) {
            "Recordings named \"held-out\" are"
        } else {
            "The last quarter is"
        };
        let text = format!("{which} held out to check the result; click to change.");
        ui.label(small(text).weak());
    }
    if recording_roles::is_chosen(&state.setup)
        && !busy
        && state.diagnosing.trial.sealed.is_none()
        && ui
            .small_button("Choose for me")
            .on_hover_text(
                "Hold out recordings named held-out, or else the last quarter (at least one)",
            )
            .clicked()
    {
        recording_roles::forget(&mut state.setup);
    }
    if let Some((id, role)) = chosen {
        recording_roles::choose(&mut state.setup, id, role);
    }
    if let Some(id) = removed {
        remove_recording(state, id);
    }
}

/// Width of a card below which the origin of a recording has a row of its own \[points\], so that
/// the name stays whole.
const NARROW_CARD: f32 = 220.0;

fn name(ui: &mut Ui, overlay: &Overlay, busy: bool, removed: &mut Option<OverlayId>) {
    let name = &overlay.recording.name;
    let is_narrow = ui.available_width() < NARROW_CARD;
    let origin = |ui: &mut Ui| {
        ui.label(small("synthetic").color(ui.visuals().warn_fg_color))
            .on_hover_text("Not a measurement: it comes with the program");
    };
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
        let color = overlay_color(ui, overlay.color);
        ui.painter().rect_filled(rect, 2.0, color);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if !busy
                && icon_button(ui, Icon::Remove, &format!("remove {name}"))
                    .on_hover_text("Remove it from the list (can be undone)")
                    .clicked()
            {
                *removed = Some(overlay.id);
            }
            if overlay.made_up && !is_narrow {
                origin(ui);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let label = ui.add(Label::new(RichText::new(name).strong()).wrap());
                if let Some(path) = &overlay.recording.path {
                    label.on_hover_text(path.display().to_string());
                }
            });
        });
    });
    if overlay.made_up && is_narrow {
        origin(ui);
    }
}

fn facts(ui: &mut Ui, overlay: &Overlay, quietest: f64) {
    let r = &overlay.recording;
    let text = format!(
        "{} at {}, noise {}",
        format_quantity(r.duration(), "s", 3),
        format_quantity(r.sampling_rate(), "Hz", 3),
        recording_noise::text(ui, overlay, quietest),
    );
    let has = |channel: bool, name: &'static str| if channel { name } else { "" };
    let channels = [
        "xp",
        has(r.voltage.is_some(), "V"),
        has(r.cantilever.is_some(), "xc"),
    ];
    let channels: Vec<&str> = channels.into_iter().filter(|c| !c.is_empty()).collect();
    ui.add(Label::new(small(text).weak()).wrap())
        .on_hover_text(format!(
            "{} samples; channels {}. The noise of xp is estimated from its highest frequencies. Fast motion can inflate it, so the quietest recording gives the best estimate.",
            r.len(),
            channels.join(", ")
        ));
    recording_faults::show(ui, overlay);
    if r.voltage.is_none() {
        ui.label(small("no voltage").color(ui.visuals().warn_fg_color));
    }
}

fn sources(ui: &mut Ui, state: &mut State) {
    let on_trial = state.diagnosing.trial.sealed.is_some();
    let busy = state.diagnosing.running.is_some();
    let width = ui.available_width();
    let button = |ui: &mut Ui, text: &str, help: &str, enabled: bool| {
        let add = |ui: &mut Ui| ui.add_sized([width, 22.0], eframe::egui::Button::new(text));
        ui.add_enabled_ui(enabled, add)
            .inner
            .on_hover_text(help)
            .clicked()
    };
    if button(
        ui,
        "Open recordings...",
        "CSV files with time, voltage and displacement; you can also drop them on the window",
        !on_trial,
    ) {
        state.ask(Command::Open);
    }
    if !load_example::is_loaded(&state.setup)
        && button(
            ui,
            "Try the example",
            "Nine synthetic recordings of a device that differs from the paper's. Your own recordings are ignored; can be undone.",
            !on_trial && !busy,
        )
    {
        state.ask(Command::Example);
    }
    let text = if on_trial {
        "Show the sealed trial..."
    } else {
        "Start a sealed trial..."
    };
    if button(
        ui,
        text,
        "The program conceals an effect in synthetic recordings. You may guess it, the diagnosis looks for it, then the envelope is opened.",
        !busy || on_trial,
    ) {
        state.diagnosing.trial.open = true;
    }
}
