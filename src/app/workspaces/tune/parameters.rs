//! The left panel: device, parameter sliders, drive and effects.

use eframe::egui::{
    Align, CollapsingHeader, ComboBox, FontSelection, Label, RichText, ScrollArea, Sense, Ui,
    UiBuilder, WidgetText, vec2,
};

use super::drive::editor;
use crate::app::setup::command::Command;
use crate::app::setup::current_setup::{Setup, choose_preset};
use crate::app::state::State;
use crate::app::widgets::default_value;
use crate::app::widgets::parameter_slider::{ParameterSlider, Size, SliderOutput};
use crate::app::widgets::slider_search;
use crate::app::widgets::slider_search::Findable;
use crate::app::widgets::text::small;
use crate::model::Model;
use crate::model::effects::{ActiveEffect, CATALOGUE, EffectSpec};
use crate::model::parameter::{ParameterId, ParameterSpec, Rank};
use crate::model::preset::Preset;

/// Why the current values cannot be simulated: parameter and message.
struct Problem {
    parameter: String,
    message: String,
}

/// Draws the panel.
pub fn show(ui: &mut Ui, state: &mut State) {
    preset_picker(ui, state);
    slider_search::show(ui, &findable(&state.setup));
    let target = slider_search::pending(ui);
    let problem = problem(state);
    about(ui, &state.setup, problem.as_ref());
    ui.separator();
    ScrollArea::vertical()
        .id_salt("parameters")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            // Room for the scroll bar, which would cover the content.
            ui.set_max_width(ui.available_width() - 6.0);
            for rank in [Rank::Primary, Rank::Secondary] {
                group(ui, &mut state.setup, rank, problem.as_ref());
                ui.add_space(6.0);
            }
            ui.separator();
            if state.setup.preset.model.piezo.is_some() {
                CollapsingHeader::new("Drive")
                    .default_open(true)
                    .open(opened(target.as_deref(), editor::has_slider))
                    .show_unindented(ui, |ui| {
                        editor::show(ui, state, super::drive::place::Place::Panel);
                    });
            }
            // A device without ground has few other parameters.
            let has_ground = state.setup.preset.model.has_ground;
            CollapsingHeader::new("Advanced")
                .id_salt(("advanced", has_ground))
                .default_open(!has_ground)
                .open(opened(target.as_deref(), is_advanced))
                .show_unindented(ui, |ui| {
                    group(ui, &mut state.setup, Rank::Advanced, problem.as_ref());
                });
            let on = state.setup.preset.model.effects.len();
            let title = if on == 0 {
                "Effects".to_owned()
            } else {
                format!("Effects ({on} on)")
            };
            CollapsingHeader::new(title)
                .id_salt("effects")
                .open(opened(target.as_deref(), |id| id.contains('.')))
                .show_unindented(ui, |ui| {
                    ui.weak("Physics beyond the base model. Switch one on to see what it does.");
                    let model = &state.setup.preset.model;
                    let offered: Vec<_> = CATALOGUE
                        .iter()
                        .filter(|effect| model.allows(effect) || is_on(model, effect))
                        .collect();
                    for effect in offered {
                        effect_entry(ui, &mut state.setup, effect, problem.as_ref());
                    }
                });
            ui.add_space(12.0);
        });
}

/// Opens a closed part of the panel if the slider that is searched for is in it.
fn opened(target: Option<&str>, is_inside: impl Fn(&str) -> bool) -> Option<bool> {
    target.filter(|id| is_inside(id)).map(|_| true)
}

fn is_advanced(id: &str) -> bool {
    ParameterId::from_id(id).is_some_and(|p| p.spec().rank == Rank::Advanced)
}

/// All sliders of the panel.
fn findable(setup: &Setup) -> Vec<Findable> {
    let model = &setup.preset.model;
    let entry = |id: &str, spec: &ParameterSpec| Findable {
        id: id.to_owned(),
        symbol: spec.symbol.to_owned(),
        name: spec.name.to_owned(),
    };
    let used = ParameterId::ALL.into_iter().filter(|id| model.uses(*id));
    let mut all: Vec<Findable> = used.map(|id| entry(id.spec().id, id.spec())).collect();
    if model.piezo.is_some() {
        let drive = editor::slider_specs(&setup.drive);
        all.extend(drive.iter().map(|spec| entry(spec.id, spec)));
    }
    for effect in &model.effects {
        for spec in effect.spec.parameters {
            all.push(entry(&format!("{}.{}", effect.spec.id, spec.id), spec));
        }
    }
    all
}

fn preset_picker(ui: &mut Ui, state: &mut State) {
    let name = state.setup.preset.model.name.clone();
    ui.horizontal(|ui| {
        ui.label("Device");
        let reset_width = 76.0;
        let width = ui.available_width() - reset_width - 8.0;
        ComboBox::from_id_salt("preset")
            .width(width)
            .truncate()
            .selected_text(&name)
            .show_ui(ui, |ui| {
                for preset in default_value::embedded() {
                    // A preset file may have the name of a built-in preset.
                    let chosen = preset.model.name == name && *state.setup.original == *preset;
                    let button = ui.selectable_label(chosen, &preset.model.name);
                    if button.on_hover_text(&preset.about).clicked() && !chosen {
                        choose_preset(&mut state.setup, preset);
                    }
                }
            })
            .response
            .on_hover_text("The device. The recordings stay when it is changed.");
        let changed = is_changed(&state.setup);
        let reset = ui.add_enabled(changed, eframe::egui::Button::new("Reset all"));
        if reset
            .on_hover_text("Reset all parameters and effects to the preset.")
            .clicked()
        {
            state.ask(Command::ResetParameters);
        }
    });
}

/// What a preset is, and by which rule its mass bounces if that is not the paper's.
fn said_of(preset: &Preset) -> String {
    let model = &preset.model;
    if !model.has_ground || model.bounce.is_pull_off() {
        return preset.about.clone();
    }
    let rule = model.bounce.sentence();
    if preset.about.is_empty() {
        format!("The mass {rule}.")
    } else {
        format!("{}; it {rule}", preset.about)
    }
}

/// Two lines about the device, or about why it cannot be simulated. The height is fixed, so
/// that the sliders below do not move.
fn about(ui: &mut Ui, setup: &Setup, problem: Option<&Problem>) {
    let last_valid = "The curve shown is the last valid one.";
    let text = match problem {
        None => small(said_of(&setup.preset)).weak(),
        Some(problem) if has_slider(setup, &problem.parameter) => {
            small(last_valid).color(ui.visuals().warn_fg_color)
        }
        Some(problem) => small(format!(
            "{}: {}. {last_valid}",
            problem.parameter, problem.message
        ))
        .color(crate::app::widgets::text::error_color(ui)),
    };
    let size = vec2(ui.available_width(), 30.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let whole = text.text().to_owned();
    let mut part = ui.new_child(UiBuilder::new().max_rect(rect));
    part.set_clip_rect(rect.intersect(ui.clip_rect()));
    let style = part.style().clone();
    let mut job = WidgetText::from(text)
        .into_layout_job(&style, FontSelection::Default, Align::Min)
        .as_ref()
        .clone();
    // What does not fit ends in an ellipsis; the tooltip has all of it.
    job.wrap.max_rows = 2;
    part.add(Label::new(job).wrap());
    response.on_hover_text(whole);
}

fn is_changed(setup: &Setup) -> bool {
    let model = &setup.preset.model;
    let values = model
        .parameters
        .iter()
        .any(|(id, value)| default_value::differs(value, default_value::value(setup, id)));
    values || model.effects != setup.original.model.effects
}

fn problem(state: &State) -> Option<Problem> {
    if let Err(error) = state.setup.preset.model.check() {
        return Some(Problem {
            parameter: error.parameter,
            message: error.reason,
        });
    }
    let refusal = state.refusal.as_ref()?;
    Some(Problem {
        parameter: refusal.parameter.clone(),
        message: refusal.message.clone(),
    })
}

fn has_slider(setup: &Setup, id: &str) -> bool {
    let model = &setup.preset.model;
    match id.split_once('.') {
        Some((effect, _)) => model.effects.iter().any(|e| e.spec.id == effect),
        None => ParameterId::from_id(id).is_some_and(|p| model.uses(p)),
    }
}

fn message_for<'a>(problem: Option<&'a Problem>, id: &str) -> Option<&'a str> {
    problem
        .filter(|p| p.parameter == id)
        .map(|p| p.message.as_str())
}

/// All sliders of one rank that this device uses.
fn group(ui: &mut Ui, setup: &mut Setup, rank: Rank, problem: Option<&Problem>) {
    for id in ParameterId::ALL {
        let spec = id.spec();
        if spec.rank != rank || !setup.preset.model.uses(id) {
            continue;
        }
        let slider = ParameterSlider {
            scope: "",
            id: spec.id,
            spec: ParameterSpec {
                range: setup.preset.range(id),
                ..*spec
            },
            value: setup.preset.model.parameters[id],
            original: default_value::value(setup, id),
            locked: Some(setup.locked.contains(spec.id)),
            size: if rank == Rank::Primary {
                Size::Large
            } else {
                Size::Small
            },
            problem: message_for(problem, spec.id),
            extrapolation: None,
        };
        let output = slider.show(ui);
        if let Some(value) = output.value {
            setup.preset.model.parameters.set(id, value);
        }
        lock(setup, spec.id, output);
        if rank == Rank::Primary {
            ui.add_space(3.0);
        }
    }
}

fn lock(setup: &mut Setup, id: &str, output: SliderOutput) {
    if output.toggle_lock && !setup.locked.remove(id) {
        setup.locked.insert(id.to_owned());
    }
}

/// Whether an effect is switched on, even if it does nothing on this device.
fn is_on(model: &Model, effect: &EffectSpec) -> bool {
    model.effects.iter().any(|active| active.spec == effect)
}

fn effect_entry(
    ui: &mut Ui,
    setup: &mut Setup,
    effect: &'static EffectSpec,
    problem: Option<&Problem>,
) {
    let place = setup
        .preset
        .model
        .effects
        .iter()
        .position(|e| e.spec == effect);
    let mut on = place.is_some();
    let check = ui.checkbox(&mut on, effect.name);
    let check = check.on_hover_text(format!(
        "{}\n\n{}\n\nSource: {}",
        effect.sentence, effect.law, effect.source
    ));
    if check.changed() {
        match place {
            Some(index) => {
                setup.preset.model.effects.remove(index);
            }
            None => {
                let mut active = ActiveEffect::new(effect);
                for (i, value) in active.values.iter_mut().enumerate() {
                    *value = default_value::effect_value(setup, effect, i);
                }
                setup.preset.model.effects.push(active);
            }
        }
    }
    let Some(index) = setup
        .preset
        .model
        .effects
        .iter()
        .position(|e| e.spec == effect)
    else {
        return;
    };
    ui.indent(effect.id, |ui| {
        ui.label(small(effect.sentence));
        ui.label(RichText::new(effect.law).monospace());
        for (i, spec) in effect.parameters.iter().enumerate() {
            let id = format!("{}.{}", effect.id, spec.id);
            let slider = ParameterSlider {
                scope: "",
                id: &id,
                spec: *spec,
                value: setup.preset.model.effects[index].values[i],
                original: default_value::effect_value(setup, effect, i),
                locked: Some(setup.locked.contains(&id)),
                size: Size::Small,
                problem: message_for(problem, &id),
                extrapolation: None,
            };
            let moves = setup.preset.model.effects[index].is_moved_by(i);
            let shown = ui.add_enabled_ui(moves, |ui| slider.show(ui));
            let why = "Has no influence with the other values of this effect";
            shown.response.on_disabled_hover_text(why);
            let output = shown.inner;
            if let Some(value) = output.value {
                setup.preset.model.effects[index].values[i] = value;
            }
            lock(setup, &id, output);
        }
        ui.label(small(format!("Source: {}", effect.source)).weak());
    });
    ui.add_space(4.0);
}
