//! What a diagnosis is asked beyond its recordings: how long it may take, which effects are compared,
//! and which parameters are free, held or known. The usual is right without a look at it.

use eframe::egui::{CollapsingHeader, Id, Role, Ui, WidgetInfo};

use crate::app::setup::current_setup::{ParameterChoice, Setup};
use crate::app::state::State;
use crate::app::widgets::quantity_field::QuantityField;
use crate::app::widgets::text::small;
use crate::app::workspaces::tune::fit::choose::symbol;
use crate::model::effects::CATALOGUE;
use crate::model::preset::known_value::device_ids;
use crate::model::unit::format_quantity;

/// Time that is offered first where there is to be a limit \[s\].
const USUAL_LIMIT_S: f64 = 60.0;
/// Error that is offered first for a known value, as a share of the value.
const USUAL_ERROR_SHARE: f64 = 0.01;
/// Width of a field for a quantity \[points\].
const FIELD_WIDTH: f32 = 84.0;

/// What can be chosen of a parameter, with help.
const CHOICE_BUTTONS: [(&str, &str); 4] = [
    (
        "usual",
        "Parameters of the device are re-tuned, those of its effects held, known ones fitted against what the preset knows",
    ),
    ("free", "Re-tune it"),
    ("held", "Hold it at the value of the Tune workspace"),
    (
        "known",
        "Re-tune it against a known value with its standard error; the answer says so if the recordings contradict it",
    ),
];

/// Draws the options.
pub fn show(ui: &mut Ui, state: &mut State) {
    let busy = state.diagnosing.running.is_some();
    let count = chosen(&state.setup);
    let title = match count {
        0 => "Options".to_owned(),
        n => format!("Options ({n} chosen)"),
    };
    CollapsingHeader::new(small(title))
        .id_salt("diagnosis options")
        .show(ui, |ui| {
            ui.add_enabled_ui(!busy, |ui| {
                time(ui, &mut state.setup);
                effects(ui, &mut state.setup);
                parameters(ui, &mut state.setup);
                if count > 0 && ui.small_button("All as usual").clicked() {
                    state.setup.diagnosis = Default::default();
                }
            });
        });
}

/// How many things are chosen.
fn chosen(setup: &Setup) -> usize {
    let asked = &setup.diagnosis;
    let skipped = CATALOGUE.iter().filter(|e| asked.skipped.contains(e.id));
    let ids = device_ids(&setup.preset.model);
    let own = ids.iter().filter(|id| asked.parameters.contains_key(*id));
    usize::from(asked.longest.is_some()) + usize::from(skipped.count() > 0) + own.count()
}

fn time(ui: &mut Ui, setup: &mut Setup) {
    let longest = &mut setup.diagnosis.longest;
    ui.horizontal_wrapped(|ui| {
        let mut limited = longest.is_some();
        let check = ui.checkbox(&mut limited, small("limit the time"));
        check.on_hover_text("End with the best answer so far when the time is used up. The answer says what was not compared.");
        if limited != longest.is_some() {
            *longest = limited.then_some(USUAL_LIMIT_S);
        }
        if let Some(seconds) = longest {
            let field = QuantityField {
                id: Id::unique("longest time of a diagnosis"),
                label: "longest time of a diagnosis",
                value: *seconds,
                unit: "s",
                width: FIELD_WIDTH,
                enabled: ui.is_enabled(),
            };
            let check = |v: f64| (v <= 0.0).then(|| "the time must be above 0 s".to_owned());
            let output = field.show(ui, check);
            if let Some(error) = output.error {
                output.response.on_hover_text(error);
            }
            *seconds = output.value.unwrap_or(*seconds);
        }
    });
}

fn effects(ui: &mut Ui, setup: &mut Setup) {
    let model = &setup.preset.model;
    let skipped = &mut setup.diagnosis.skipped;
    let all: Vec<_> = CATALOGUE.iter().filter(|e| model.allows(e)).collect();
    let compared = all.iter().filter(|e| !skipped.contains(e.id)).count();
    let title = if compared == all.len() {
        "Effects compared: all".to_owned()
    } else {
        format!("Effects compared: {compared} of {}", all.len())
    };
    CollapsingHeader::new(small(title))
        .id_salt("effects compared")
        .show(ui, |ui| {
            ui.horizontal(|ui| {
                let button = |ui: &mut Ui, text: &str, label: &str| {
                    let (button, enabled) = (ui.small_button(text), ui.is_enabled());
                    button.widget_info(|| WidgetInfo::labeled(Role::Button, enabled, label));
                    button.clicked()
                };
                if button(ui, "all", "compare all effects") {
                    skipped.clear();
                }
                if button(ui, "none", "compare no effect") {
                    skipped.extend(CATALOGUE.iter().map(|e| e.id.to_owned()));
                }
            });
            for effect in all {
                let mut on = !skipped.contains(effect.id);
                let check = ui.checkbox(&mut on, small(effect.name));
                check.on_hover_text(effect.sentence);
                if on {
                    skipped.remove(effect.id);
                } else {
                    skipped.insert(effect.id.to_owned());
                }
            }
        });
}

fn parameters(ui: &mut Ui, setup: &mut Setup) {
    let ids = device_ids(&setup.preset.model);
    let own = &setup.diagnosis.parameters;
    let count = ids.iter().filter(|id| own.contains_key(*id)).count();
    let title = match count {
        0 => "Parameters: as usual".to_owned(),
        n => format!("Parameters: {n} chosen"),
    };
    CollapsingHeader::new(small(title))
        .id_salt("parameters of a diagnosis")
        .show(ui, |ui| {
            for id in &ids {
                parameter(ui, setup, id);
            }
        });
}

/// A parameter: what is done with it, and what is known.
fn parameter(ui: &mut Ui, setup: &mut Setup, id: &str) {
    let model = &setup.preset.model;
    let unit = model.unit_of(id).unwrap_or_default();
    let value = model.get(id).unwrap_or_default();
    let preset_knows = setup.preset.known.iter().find(|known| known.id == id);
    let locked = setup.locked.contains(id);
    let mut facts = format!("{id}, now {}", format_quantity(value, unit, 4));
    if let Some(known) = preset_knows {
        facts += &format!("; the preset knows {}", known.text(unit));
    }
    if locked {
        facts += "; locked at its slider, and so held as usual";
    }
    let before = setup.diagnosis.parameters.get(id).copied();
    let chosen = number_of(before.as_ref());
    let mut now = chosen;
    ui.label(small(symbol(id))).on_hover_text(facts);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        ui.spacing_mut().button_padding.x = 5.0;
        for (k, (text, help)) in CHOICE_BUTTONS.iter().enumerate() {
            let response = ui.selectable_value(&mut now, k, small(*text));
            let label = format!("{id}: {text}");
            let (enabled, on) = (ui.is_enabled(), now == k);
            response.widget_info(|| WidgetInfo::selected(Role::Button, enabled, on, &label));
            response.on_hover_text(*help);
        }
    });
    if now != chosen {
        let error = USUAL_ERROR_SHARE * value.abs();
        let first = preset_knows.map_or((value, error), |k| (k.value, k.std_error));
        let spec = crate::model::preset::known_value::device_parameter(model, id);
        // Nothing of a value of 0 is a share of it.
        let range = spec.map_or(1.0, |(_, spec)| spec.range.1 - spec.range.0);
        let std_error = if first.1 > 0.0 {
            first.1
        } else {
            USUAL_ERROR_SHARE * range
        };
        let choice = match now {
            1 => Some(ParameterChoice::Free),
            2 => Some(ParameterChoice::Held),
            3 => Some(ParameterChoice::Known {
                value: first.0,
                std_error,
            }),
            _ => None,
        };
        let all = &mut setup.diagnosis.parameters;
        match choice {
            Some(choice) => all.insert(id.to_owned(), choice),
            None => all.remove(id),
        };
    }
    known(ui, setup, (id, unit));
}

/// Position among [`CHOICE_BUTTONS`].
fn number_of(choice: Option<&ParameterChoice>) -> usize {
    match choice {
        None => 0,
        Some(ParameterChoice::Free) => 1,
        Some(ParameterChoice::Held) => 2,
        Some(ParameterChoice::Known { .. }) => 3,
    }
}

/// The fields of a known value.
fn known(ui: &mut Ui, setup: &mut Setup, (id, unit): (&str, &str)) {
    let spec = crate::model::preset::known_value::device_parameter(&setup.preset.model, id);
    let Some(ParameterChoice::Known { value, std_error }) = setup.diagnosis.parameters.get_mut(id)
    else {
        return;
    };
    let refused = |v: f64| spec.as_ref().ok().and_then(|(_, spec)| spec.refusal(v));
    let no_error = |v: f64| (v <= 0.0).then(|| "the error must be above 0".to_owned());
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let field =
            |ui: &mut Ui, what: &str, value: &mut f64, check: &dyn Fn(f64) -> Option<String>| {
                let label = format!("{id}: {what}");
                let field = QuantityField {
                    id: Id::unique(("known", id, what)),
                    label: &label,
                    value: *value,
                    unit,
                    width: FIELD_WIDTH,
                    enabled: ui.is_enabled(),
                };
                let output = field.show(ui, check);
                if let Some(error) = output.error {
                    output.response.on_hover_text(error);
                }
                *value = output.value.unwrap_or(*value);
            };
        field(ui, "known value", value, &refused);
        ui.label(small("+-"));
        field(ui, "standard error", std_error, &no_error);
    });
}
