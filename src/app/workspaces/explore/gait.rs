//! The gait panel: feet with devices and delays on the left, the gait diagram and what it says on
//! the right.

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::{
    CentralPanel, Color32, ComboBox, Grid, Id, Panel, RichText, ScrollArea, Ui, vec2,
};

use super::fields::{name, refusal, remark, source};
use crate::app::analysis::explore::feet::{DrawnFoot, FeetQuestion, FeetView};
use crate::app::analysis::explore::source::drive_of;
use crate::app::plots::explore::gait::{FootPicture, GaitPicture};
use crate::app::plots::frame::style;
use crate::app::setup::command::Command;
use crate::app::setup::explore::GaitChoices;
use crate::app::state::State;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::slider_track::SliderTrack;
use crate::app::widgets::text::{heading, small};
use crate::explore::gait::{FOOT_COUNTS, Gait, GaitPreset};
use crate::model::Model;
use crate::model::preset::{EMBEDDED, Preset};
use crate::model::unit::{counted, format_quantity};

/// Width of the column of feet \[points\].
const FEET_WIDTH: f32 = 300.0;
/// How long a common cycle takes on the screen while the feet move \[s\].
const PLAYED_CYCLE: f64 = 4.0;
/// Steps of a delay: hundredths of a period.
const DELAY_STEPS: f64 = 100.0;
/// What the model leaves out.
const NO_BODY: &str = "There is no body: each foot is a device of its own that taps its own ground. \
    Feet do not feel one another, none carries a load, and nothing falls over. The diagram shows \
    when feet touch, not whether a robot walks.";

/// How the diagram is read.
const READING: &str = "Bars: contact. Triangles: bounces. At the right: share of the time in contact. \
    Drag across the bars to choose the moment that is shown.";

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    let feet = drawn_feet(&state.setup.explore.gait);
    let asked = ask(ui, state);
    let newest = state.exploring.gait.feet.newest();
    Panel::left("gait feet")
        .exact_size(FEET_WIDTH)
        .show(ui, |ui| {
            ScrollArea::vertical()
                .id_salt("gait feet")
                .auto_shrink([false, false])
                .show(ui, |ui| controls(ui, state));
        });
    CentralPanel::default().show(ui, |ui| {
        if let Err(error) = asked {
            refusal(ui, &format!("No gait: {error}."));
            return;
        }
        let Some(newest) = newest else {
            ui.spinner();
            return;
        };
        match &newest.answer {
            Err(error) => refusal(ui, &format!("No gait: {error}.")),
            Ok(view) => match view.gait(&feet) {
                Err(error) => refusal(ui, &format!("No gait: {error}.")),
                Ok(gait) => diagram(ui, state, view, &feet, &gait),
            },
        }
    });
}

/// The gait that is shown.
///
/// # Errors
/// Why there is none.
pub fn gait_of(state: &State) -> Result<Gait, String> {
    let newest = state.exploring.gait.feet.clone().newest();
    let newest = newest.ok_or("there is no gait yet; open the Gait panel")?;
    match &newest.answer {
        Ok(view) => view.gait(&drawn_feet(&state.setup.explore.gait)),
        Err(error) => Err(error.clone()),
    }
}

/// Where foot `i` of a walking device stands: rows from the front, left before right.
fn foot_name(i: usize, count: usize) -> String {
    let side = if i.is_multiple_of(2) { "left" } else { "right" };
    let rows = count.div_ceil(2);
    let row = match (i / 2, rows) {
        (_, 1) => return side.to_owned(),
        (0, _) => "front",
        (row, rows) if row + 1 == rows => "rear",
        _ => "middle",
    };
    format!("{side} {row}")
}

/// Names of the devices, each once, in the order of the first foot that has it.
fn devices(gait: &GaitChoices) -> Vec<Option<String>> {
    let mut all: Vec<Option<String>> = Vec::new();
    for foot in &gait.feet {
        if !all.contains(&foot.device) {
            all.push(foot.device.clone());
        }
    }
    all
}

fn drawn_feet(gait: &GaitChoices) -> Vec<DrawnFoot> {
    let all = devices(gait);
    let count = gait.feet.len();
    let feet = gait.feet.iter().enumerate();
    feet.map(|(i, foot)| DrawnFoot {
        name: foot_name(i, count),
        device: all.iter().position(|d| *d == foot.device).unwrap_or(0),
        delay: foot.delay,
    })
    .collect()
}

/// Asks for the responses of the devices.
fn ask(ui: &Ui, state: &mut State) -> Result<(), String> {
    let gait = &state.setup.explore.gait;
    let drive = drive_of(&state.setup, gait.source)?;
    let all = devices(gait);
    let present = state.exploring.device(&state.setup.preset.model);
    let mut models: Vec<Arc<Model>> = Vec::with_capacity(all.len());
    for device in &all {
        models.push(match device {
            None => Arc::clone(&present),
            Some(name) => embedded(&mut state.exploring.gait.devices, name)?,
        });
    }
    let question = FeetQuestion {
        devices: models,
        drive,
    };
    state.exploring.gait.feet.ask(question, ui.ctx());
    Ok(())
}

/// The device of an embedded preset, which is read once.
fn embedded(known: &mut BTreeMap<String, Arc<Model>>, name: &str) -> Result<Arc<Model>, String> {
    if let Some(model) = known.get(name) {
        return Ok(Arc::clone(model));
    }
    let preset = Preset::embedded(name)
        .ok_or_else(|| format!("there is no preset \"{name}\"; choose another one"))?;
    let model = Arc::new(preset.model);
    known.insert(name.to_owned(), Arc::clone(&model));
    Ok(model)
}

fn controls(ui: &mut Ui, state: &mut State) {
    let gait = &mut state.setup.explore.gait;
    if let Some(chosen) = source(ui, gait.source) {
        gait.source = chosen;
    }
    ui.horizontal(|ui| {
        name(ui, "Feet", "How many feet there are");
        let (fewest, most) = FOOT_COUNTS;
        let mut count = gait.feet.len();
        for n in fewest..=most {
            let button = ui.selectable_value(&mut count, n, n.to_string());
            button.on_hover_text(counted(n, "foot").replace("foots", "feet"));
        }
        if count != gait.feet.len() {
            let preset = gait.preset();
            gait.set_count(count);
            if let Some(preset) = preset {
                gait.apply(preset);
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        let now = gait.preset();
        for preset in GaitPreset::ALL {
            let is_on = now == Some(preset);
            let button = ui.selectable_label(is_on, preset.label(gait.feet.len()));
            if button.on_hover_text(gait_help(preset)).clicked() {
                gait.apply(preset);
            }
        }
    });
    ui.separator();
    for i in 0..gait.feet.len() {
        foot(ui, gait, i);
    }
    ui.separator();
    let (text, help) = Command::ExportGait.text();
    if ui.button(text).on_hover_text(help).clicked() {
        state.ask(Command::ExportGait);
    }
    remark(ui, NO_BODY);
}

fn gait_help(preset: GaitPreset) -> &'static str {
    match preset {
        GaitPreset::InPhase => "All feet at once",
        GaitPreset::Alternating => "The left feet, half a period later the right ones",
        GaitPreset::Tripod => {
            "Each foot with those diagonally beside it: the trot of four feet, the tripod of six"
        }
        GaitPreset::Wave => "One after another, from the rear to the front, evenly spaced",
    }
}

/// Device and delay of a foot.
fn foot(ui: &mut Ui, gait: &mut GaitChoices, i: usize) {
    let count = gait.feet.len();
    let title = foot_name(i, count);
    let color = device_color(ui, drawn_feet(gait)[i].device);
    let foot = &mut gait.feet[i];
    ui.horizontal(|ui| {
        ui.label(RichText::new(&title).strong().color(color));
        let present = "present device";
        let shown = foot.device.as_deref().unwrap_or(present);
        let picker = ComboBox::from_id_salt(("foot device", i))
            .width(132.0)
            .selected_text(shown)
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut foot.device, None, present);
                for (name, _) in EMBEDDED {
                    let value = Some(name.to_owned());
                    ui.selectable_value(&mut foot.device, value, name);
                }
            });
        picker
            .response
            .on_hover_text(format!("Device of the foot {title}"));
    });
    ui.horizontal(|ui| {
        let text = format!("{:.0} %", 100.0 * foot.delay);
        let label = format!("delay of the foot {title}");
        let track = SliderTrack {
            id: Id::unique(("foot delay", i)),
            label: &label,
            text: &text,
            numeric: (foot.delay, 0.0, 1.0),
            fraction: foot.delay,
            mark: None,
            extrapolated_from: 1.0,
            enabled: true,
            error: false,
            size: vec2(190.0, 18.0),
        };
        let moved = track.show(ui);
        if let Some(fraction) = moved.fraction {
            foot.delay = (fraction * DELAY_STEPS).round() / DELAY_STEPS;
        }
        if let Some(value) = moved.value {
            foot.delay = value.clamp(0.0, 1.0);
        }
        if moved.reset {
            foot.delay = 0.0;
        }
        moved
            .response
            .on_hover_text("By how much of a period its drive is later. Double-click: not at all.");
        ui.label(text);
    });
}

/// Colour of a device among those of the feet.
fn device_color(ui: &Ui, device: usize) -> Color32 {
    let palette = style::palette(ui);
    let others = style::overlay_colors(ui.visuals().dark_mode);
    match device {
        0 => palette.proof_mass,
        n => others[(n - 1) % others.len()],
    }
}

fn diagram(ui: &mut Ui, state: &mut State, view: &FeetView, feet: &[DrawnFoot], gait: &Gait) {
    transport(ui, state, gait);
    let moment = state.exploring.gait.moment;
    let heights: Vec<f64> = feet
        .iter()
        .map(|foot| view.height(foot, moment, gait.periods).unwrap_or(0.0))
        .collect();
    let highest = feet.iter().map(|foot| highest(view, foot));
    let highest = highest.fold(f64::MIN_POSITIVE, f64::max);
    let pictures: Vec<FootPicture> = feet
        .iter()
        .enumerate()
        .map(|(i, foot)| FootPicture {
            color: device_color(ui, foot.device),
            bounces: view.bounces(foot, gait.periods),
            height: (heights[i] / highest) as f32,
            is_down: gait.bars[i]
                .iter()
                .any(|bar| (bar.start..=bar.end).contains(&moment)),
        })
        .collect();
    let picture = GaitPicture {
        gait,
        feet: &pictures,
        moment,
    };
    let table_height = 26.0 * (feet.len() as f32 / 2.0).ceil() + 64.0;
    let size = vec2(
        ui.available_width(),
        (ui.available_height() - table_height).max(180.0),
    );
    if let Some(moment) = picture.show(ui, size) {
        state.exploring.gait.moment = moment;
        state.exploring.gait.plays = false;
    }
    remark(ui, READING);
    shares(ui, gait);
}

/// Highest position of a foot over the ground \[m\].
fn highest(view: &FeetView, foot: &DrawnFoot) -> f64 {
    let Ok(response) = view.response(foot) else {
        return 0.0;
    };
    let trace = &response.trace;
    let level = trace.ground_level.unwrap_or(0.0);
    trace
        .proof_mass
        .iter()
        .fold(0.0, |most, x| f64::max(most, x - level))
}

/// Run and pause, and the moment shown.
fn transport(ui: &mut Ui, state: &mut State, gait: &Gait) {
    let bench = &mut state.exploring.gait;
    if bench.plays {
        let passed = f64::from(ui.input(|input| input.stable_dt)).min(0.1);
        bench.moment = (bench.moment + passed / PLAYED_CYCLE).fract();
        ui.ctx().request_repaint();
    }
    ui.horizontal(|ui| {
        let (icon, label) = if bench.plays {
            (Icon::Pause, "stop the feet")
        } else {
            (Icon::Run, "move the feet")
        };
        if icon_button(ui, icon, label)
            .on_hover_text("Let the feet move through the cycle in slow motion")
            .clicked()
        {
            bench.plays = !bench.plays;
        }
        let periods = counted(
            usize::try_from(gait.periods).unwrap_or(usize::MAX),
            "period",
        );
        ui.label(format!(
            "cycle {} ({periods} of the drive)",
            format_quantity(gait.cycle, "s", 4)
        ))
        .on_hover_text("Shortest time in which all feet repeat together");
        let now = format_quantity(bench.moment * gait.cycle, "s", 3);
        ui.weak(format!("shown: t = {now}"));
        if bench.feet.is_waiting() {
            ui.spinner();
        }
    });
}

/// Shares of the time with fewer than k feet down.
fn shares(ui: &mut Ui, gait: &Gait) {
    ui.add_space(4.0);
    heading(ui, "Share of the time with");
    let count = gait.names.len();
    Grid::new("support shares")
        .num_columns(8)
        .spacing([10.0, 3.0])
        .show(ui, |ui| {
            for k in 1..=count {
                let fewer = gait.share_with_fewer_than(k);
                ui.label(small(format!("fewer than {k} down")))
                    .on_hover_text("A gait that always has enough feet down shows 0 %");
                ui.label(small(format!("{:.1} %", 100.0 * fewer)).monospace());
                if k % 3 == 0 {
                    ui.end_row();
                }
            }
            ui.label(small("all down"));
            let all = 1.0 - gait.share_with_fewer_than(count);
            ui.label(small(format!("{:.1} %", 100.0 * all)).monospace());
            ui.end_row();
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feet_are_named_by_where_they_stand() {
        let names = |n: usize| (0..n).map(|i| foot_name(i, n)).collect::<Vec<_>>();
        assert_eq!(names(2), ["left", "right"]);
        assert_eq!(names(3), ["left front", "right front", "left rear"]);
        let six = names(6);
        assert_eq!((&*six[2], &*six[5]), ("left middle", "right rear"));
        let mut gait = GaitChoices::default();
        gait.feet[1].device = Some("faller".to_owned());
        let feet = drawn_feet(&gait);
        let devices: Vec<usize> = feet.iter().map(|f| f.device).collect();
        assert_eq!(devices, [0, 1, 0, 0]);
    }
}
