//! The strip at the top: whole span or live, the simulated span, and the controls of a live
//! run.

use eframe::egui::{Align, Button, Id, Layout, Panel, RichText, Ui, vec2};

use crate::app::analysis::explore::source::drive_of;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::Setup;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::explore::DriveSource;
use crate::app::simulation::snapshot::LiveState;
use crate::app::state::State;
use crate::app::widgets::callout;
use crate::app::widgets::icon::{Icon, icon_button, icon_button_enabled};
use crate::app::widgets::quantity_field::QuantityField;
use crate::app::widgets::slider_track::SliderTrack;
use crate::model::unit::{format_number, format_quantity};

/// Shortest and longest simulated span \[s\].
const SPAN_RANGE: (f64, f64) = (1e-4, 1000.0);
/// Slowest and fastest live speed, simulated seconds per second of wall time.
const SPEED_RANGE: (f64, f64) = (1e-5, 1.0);

/// Height of the strip \[points\].
const STRIP_HEIGHT: f32 = 28.0;
/// Room below which the strip leaves out what can be read elsewhere \[points\].
const NARROW_STRIP: f32 = 860.0;
/// Room for the time and the button after the history \[points\].
const SCRUB_TEXT_WIDTH: f32 = 166.0;

/// Live speed at which a device can be watched: real time if its preset spans seconds, slow
/// motion if it spans milliseconds. Simulated seconds per second of wall time.
pub fn usual_speed(setup: &Setup) -> f64 {
    let span = setup.preset.duration;
    if span >= 1.0 {
        return SPEED_RANGE.1;
    }
    10f64
        .powf((span / 40.0).log10().round())
        .clamp(SPEED_RANGE.0, SPEED_RANGE.1)
}

/// Draws the strip.
pub fn show(ui: &mut Ui, state: &mut State) {
    Panel::top("tune transport").show(ui, |ui| {
        // The switch on the right is placed first, so that it is whole in a narrow window.
        let size = vec2(ui.available_width(), STRIP_HEIGHT);
        ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
            ui.set_min_height(STRIP_HEIGHT);
            ui.toggle_value(&mut state.view.side_panel, "Recordings")
                .on_hover_text(hint(Command::SidePanel));
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let is_narrow = ui.available_width() < NARROW_STRIP;
                mode(ui, state);
                ui.separator();
                match state.view.mode {
                    Mode::WholeSpan => whole_span(ui, state, is_narrow),
                    Mode::Live => live(ui, state, is_narrow),
                }
            });
        });
    });
}

fn mode(ui: &mut Ui, state: &mut State) {
    for (mode, name) in [(Mode::WholeSpan, "Whole span"), (Mode::Live, "Live")] {
        let command = Command::SetMode(mode);
        let button = ui.selectable_label(state.view.mode == mode, name);
        // The whole span is asked for again to come back from a zoom.
        let changes = state.view.mode != mode || mode == Mode::WholeSpan;
        if button.on_hover_text(hint(command)).clicked() && changes {
            state.ask(command);
        }
    }
}

/// The help of a command with its shortcut.
fn hint(command: Command) -> String {
    command.with_keys(command.text().1)
}

/// End of the visible recordings after their time shifts \[s\].
pub fn recordings_end(setup: &Setup) -> Option<f64> {
    setup
        .overlays
        .iter()
        .filter(|overlay| overlay.visible)
        .map(|overlay| overlay.recording.span().1 + overlay.alignment.time_shift)
        .filter(|end| *end > 0.0)
        .fold(None, |longest: Option<f64>, end| {
            Some(longest.map_or(end, |l| l.max(end)))
        })
}

fn whole_span(ui: &mut Ui, state: &mut State, is_narrow: bool) {
    ui.label("Span");
    let field = QuantityField {
        id: Id::unique("span"),
        label: "span",
        value: state.setup.duration,
        unit: "s",
        width: 72.0,
        enabled: true,
    };
    let typed = field.show(ui, |value| {
        (!(SPAN_RANGE.0..=SPAN_RANGE.1).contains(&value)).then(|| {
            format!(
                "the span must lie between {} and {}",
                format_quantity(SPAN_RANGE.0, "s", 3),
                format_quantity(SPAN_RANGE.1, "s", 3)
            )
        })
    });
    if let Some(value) = typed.value {
        state.setup.duration = value;
    }
    if let Some(error) = &typed.error {
        callout::error(ui, "span", typed.response.rect, error);
    }
    typed
        .response
        .on_hover_text("Simulated span from t = 0, for example \"400 ms\"");
    if let Some(end) = recordings_end(&state.setup) {
        let end = end.clamp(SPAN_RANGE.0, SPAN_RANGE.1);
        let fits = (end - state.setup.duration).abs() < 1e-9 * end;
        let button = ui.add_enabled(!fits, Button::new("Match recording length"));
        if button
            .on_hover_text(format!(
                "Simulate to the end of the recordings, {}",
                format_quantity(end, "s", 4)
            ))
            .clicked()
        {
            state.setup.duration = end;
        }
    }
    let is_on = state.view.from_steady;
    let is_possible = is_on || drive_of(&state.setup, DriveSource::Tune).is_ok();
    let steady = ui.add_enabled(is_possible, Button::selectable(is_on, "Steady state"));
    if steady
        .on_hover_text(hint(Command::SteadyState))
        .on_disabled_hover_text("Only a drive that repeats has a steady response")
        .clicked()
    {
        state.ask(Command::SteadyState);
    }
    // In a narrow window the status bar alone says it.
    if let Some(snapshot) = state.snapshot.as_ref().filter(|_| !is_narrow) {
        let cost = format_quantity(snapshot.cost.as_secs_f64(), "s", 2);
        ui.weak(format!("computed in {cost}"));
    }
    if state.fitting.shown {
        ui.colored_label(ui.visuals().warn_fg_color, "showing the fit, not applied")
            .on_hover_text(format!(
                "{}; moving a slider also ends it",
                Command::FitPanel.with_keys("Apply or discard it in the fit panel")
            ));
    }
}

fn live(ui: &mut Ui, state: &mut State, is_narrow: bool) {
    let reached = state.snapshot.as_ref().and_then(|s| s.live);
    let (icon, name) = if state.paused {
        (Icon::Run, "run")
    } else {
        (Icon::Pause, "pause")
    };
    if icon_button(ui, icon, name)
        .on_hover_text(hint(Command::TogglePause))
        .clicked()
    {
        state.ask(Command::TogglePause);
    }
    let step = icon_button_enabled(ui, Icon::Step, "step", state.paused);
    if step.on_hover_text(hint(Command::Step)).clicked() {
        state.ask(Command::Step);
    }
    if icon_button(ui, Icon::Restart, "restart")
        .on_hover_text(hint(Command::Restart))
        .clicked()
    {
        state.ask(Command::Restart);
    }
    ui.separator();
    speed(ui, state, reached, is_narrow);
    ui.separator();
    match reached {
        Some(reached) => scrub(ui, state, reached),
        None => {
            ui.weak("waiting for the first step");
        }
    }
}

/// `1/100`, `1/2.5`, `1` for simulated seconds per wall second.
pub fn speed_text(speed: f64) -> String {
    if speed >= 0.9995 {
        format_number(speed, 3)
    } else if speed > 0.0 {
        format!("1/{}", format_number(1.0 / speed, 3))
    } else {
        "0".to_owned()
    }
}

fn speed(ui: &mut Ui, state: &mut State, reached: Option<LiveState>, is_narrow: bool) {
    let position = |speed: f64| (speed / SPEED_RANGE.0).ln() / (SPEED_RANGE.1 / SPEED_RANGE.0).ln();
    let text = speed_text(state.view.slow_down);
    let usual = usual_speed(&state.setup);
    if !is_narrow {
        ui.label("Speed");
    }
    let track = SliderTrack {
        id: Id::unique("slow-down"),
        label: "speed",
        text: &text,
        numeric: (state.view.slow_down, SPEED_RANGE.0, SPEED_RANGE.1),
        fraction: position(state.view.slow_down),
        mark: Some(position(usual)),
        extrapolated_from: 1.0,
        enabled: true,
        error: false,
        size: vec2(if is_narrow { 60.0 } else { 100.0 }, 18.0),
    };
    let moved = track.show(ui);
    if let Some(fraction) = moved.fraction {
        let slower =
            (1.0 / (SPEED_RANGE.0 * (SPEED_RANGE.1 / SPEED_RANGE.0).powf(fraction))).max(1.0);
        // Round to two digits of the slow-down: 1/100 rather than 1/98.6.
        let unit = 10f64.powf(slower.log10().floor() - 1.0).max(0.1);
        state.view.slow_down = 1.0 / ((slower / unit).round() * unit);
    }
    if let Some(value) = moved.value {
        state.view.slow_down = value.clamp(SPEED_RANGE.0, SPEED_RANGE.1);
    }
    if moved.reset {
        state.view.slow_down = usual;
    }
    moved.response.on_hover_text(format!(
        "Simulated time per real time. Double-click: {}. Shift: fine steps.",
        speed_text(usual)
    ));
    let text = match reached {
        Some(r) if r.paused => {
            let text = if is_narrow {
                "paused"
            } else {
                "paused, Space resumes"
            };
            RichText::new(text).color(ui.visuals().warn_fg_color)
        }
        Some(r) if r.speed > 0.0 && !is_narrow => {
            RichText::new(format!("{text}, reached {}", speed_text(r.speed)))
        }
        _ => RichText::new(text),
    };
    ui.add_sized(
        [if is_narrow { 56.0 } else { 150.0 }, 18.0],
        eframe::egui::Label::new(text).halign(eframe::egui::Align::LEFT),
    )
    .on_hover_text("Requested speed, and the speed that the computer reaches");
}

fn scrub(ui: &mut Ui, state: &mut State, reached: LiveState) {
    let span = (reached.time - reached.history_start).max(1e-12);
    let at = state.scrub.unwrap_or(reached.time);
    let text = format_quantity(at, "s", 5);
    let following = state.scrub.is_none();
    let width = (ui.available_width() - SCRUB_TEXT_WIDTH).clamp(40.0, 500.0);
    let track = SliderTrack {
        id: Id::unique("scrub"),
        label: "history",
        text: &text,
        numeric: (at, reached.history_start, reached.time),
        fraction: (at - reached.history_start) / span,
        mark: None,
        extrapolated_from: 1.0,
        enabled: true,
        error: false,
        size: vec2(width, 18.0),
    };
    let moved = track.show(ui);
    if let Some(fraction) = moved.fraction {
        state.scrub = (fraction < 1.0).then_some(reached.history_start + fraction * span);
    }
    if let Some(time) = moved.value {
        state.scrub = Some(time.clamp(reached.history_start, reached.time));
    }
    if moved.reset {
        state.scrub = None;
    }
    moved.response.on_hover_text("Drag to look back in time");
    ui.add_sized(
        [86.0, 18.0],
        eframe::egui::Label::new(format!("t = {text}")),
    );
    if ui
        .add_enabled(!following, Button::new("Follow"))
        .on_hover_text("Return to the latest moment")
        .clicked()
    {
        state.scrub = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::transport::*;

    #[test]
    fn speeds_are_written_as_fractions() {
        assert_eq!(speed_text(0.01), "1/100");
        assert_eq!(speed_text(0.4), "1/2.5");
        assert_eq!(speed_text(1.0), "1");
        assert_eq!(speed_text(0.0), "0");
    }
}
