//! What is uncertain, what is wanted, and over what the map goes.

use eframe::egui::{Button, ComboBox, Ui};

use crate::app::setup::explore::{RobustnessChoices, UncertainCoefficient, WishChoices};
use crate::app::state::State;
use crate::app::widgets::icon::{Icon, icon_button};
use crate::app::widgets::text::heading;
use crate::app::workspaces::explore::axis_picker::AxisPicker;
use crate::app::workspaces::explore::fields::{Row, positive, remark, source, within};
use crate::app::workspaces::explore::progress;
use crate::explore::map::Axis;
use crate::explore::measures::Regime;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::unit::counted;

/// Regimes that can be wished for.
const WISHED_REGIMES: [Regime; 5] = [
    Regime::TapsOnce,
    Regime::Bounces(2),
    Regime::Bounces(3),
    Regime::BouncesThenSticks,
    Regime::Sticks,
];
/// Devices of an ensemble, and points along an axis of the map.
const MEMBER_COUNTS: (f64, f64) = (2.0, 10_000.0);
const POINT_COUNTS: (f64, f64) = (2.0, 300.0);
/// Factor of a coefficient that is added, and the largest one.
const FIRST_FACTOR: f64 = 1.2;
const LARGEST_FACTOR: f64 = 1e3;

/// Draws them; returns whether the map is asked for.
pub(super) fn show(ui: &mut Ui, state: &mut State, drive: Option<&Waveform>) -> bool {
    let has_fit = state.fitting.result.is_some();
    let model = &state.setup.preset.model;
    let choices = &mut state.setup.explore.robustness;
    if let Some(chosen) = source(ui, choices.source) {
        choices.source = chosen;
    }
    if let Some(drive) = drive {
        remark(ui, &drive.to_string());
    }
    wish(ui, &mut choices.wish);
    ui.separator();
    uncertain(ui, choices, model, has_fit);
    ui.separator();
    heading(ui, "Map of probabilities");
    if let Some(drive) = drive {
        let of = (model, drive);
        for (title, choice) in [("Horizontal", &mut choices.x), ("Vertical", &mut choices.y)] {
            let scope = "robustness";
            AxisPicker { title, scope, of }.show(ui, choice);
        }
    }
    let points = Row {
        label: "points of the map of probabilities",
        name: "Points",
        help: "Points along each axis",
        value: choices.points as f64,
        unit: "",
    };
    let (fewest, most) = POINT_COUNTS;
    if let Some(new) = points.show(ui, |v| within(v, fewest, most, "points")) {
        choices.points = new.round() as usize;
    }
    let start = ui.add_enabled(drive.is_some(), Button::new("Compute the map"));
    let mut is_asked = start
        .on_hover_text("Begin the map with the present choices")
        .clicked();
    let robust = &mut state.exploring.robust;
    if robust.map.growing().is_some() {
        let pressed = progress::show(ui, &robust.map, robust.is_stopped, |grown| {
            let points = &grown.answer.points;
            let done = points.iter().flatten().count();
            format!("{done} of {}", counted(points.len(), "point"))
        });
        if pressed == progress::Asked::Stop {
            robust.is_stopped = true;
            robust.map.stop();
        }
        is_asked |= pressed == progress::Asked::Again;
    }
    is_asked
}

/// What is wanted.
fn wish(ui: &mut Ui, wish: &mut WishChoices) {
    heading(ui, "Wanted response");
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for regime in WISHED_REGIMES {
            let code = regime.code();
            let is_on = wish.regimes.contains(&code);
            let button = ui.selectable_label(is_on, regime.label());
            let help = "Press to want this regime; with none pressed, any will do";
            if button.on_hover_text(help).clicked() {
                if is_on {
                    wish.regimes.retain(|own| *own != code);
                } else {
                    wish.regimes.push(code);
                }
            }
        }
    });
    let mut has_share = wish.contact_share.is_some();
    let help = "Share of the time in contact between two bounds";
    ui.horizontal(|ui| {
        let switch = ui.checkbox(&mut has_share, "contact share");
        if switch.on_hover_text(help).changed() {
            wish.contact_share = has_share.then_some((0.3, 0.4));
        }
        if let Some((low, high)) = &mut wish.contact_share {
            for (label, value) in [
                ("least contact share", low),
                ("largest contact share", high),
            ] {
                let row = Row {
                    label,
                    name: label,
                    help,
                    value: *value,
                    unit: "",
                };
                if let Some(new) = row.narrow_field(ui, |v| within(v, 0.0, 1.0, "it")) {
                    *value = new;
                }
            }
        }
    });
    let mut has_speed = wish.impact_speed.is_some();
    let help = "No arrival at the ground is faster";
    ui.horizontal(|ui| {
        let switch = ui.checkbox(&mut has_speed, "impact speed up to");
        if switch.on_hover_text(help).changed() {
            wish.impact_speed = has_speed.then_some(0.02);
        }
        if let Some(value) = &mut wish.impact_speed {
            let row = Row {
                label: "largest impact speed",
                name: "impact speed",
                help,
                value: *value,
                unit: "m/s",
            };
            if let Some(new) = row.narrow_field(ui, |v| positive(v, "the speed")) {
                *value = new;
            }
        }
    });
}

/// What is uncertain.
fn uncertain(ui: &mut Ui, choices: &mut RobustnessChoices, model: &Model, has_fit: bool) {
    heading(ui, "Uncertain coefficients");
    let can_take_fit = has_fit || choices.from_fit;
    let fit = eframe::egui::Checkbox::new(&mut choices.from_fit, "covariance of the last fit");
    ui.add_enabled(can_take_fit, fit)
        .on_hover_text("Parameters jointly as the fit in Tune left them")
        .on_disabled_hover_text("There is no fit yet; fit parameters in Tune first");
    if !choices.from_fit {
        ranges(ui, choices, model);
    }
    let members = Row {
        label: "devices of the ensemble",
        name: "Devices",
        help: "How many devices are drawn; more make the probability more exact",
        value: choices.members as f64,
        unit: "",
    };
    let (fewest, most) = MEMBER_COUNTS;
    if let Some(new) = members.show(ui, |v| within(v, fewest, most, "devices")) {
        choices.members = new.round() as usize;
    }
    let seed = Row {
        label: "seed of the ensemble",
        name: "Seed",
        help: "The same seed draws the same devices",
        value: choices.seed as f64,
        unit: "",
    };
    if let Some(new) = seed.show(ui, |v| within(v, 0.0, 1e9, "the seed")) {
        choices.seed = new.round() as u64;
    }
}

/// A factor for each coefficient.
fn ranges(ui: &mut Ui, choices: &mut RobustnessChoices, model: &Model) {
    let mut removed = None;
    for (i, coefficient) in choices.coefficients.iter_mut().enumerate() {
        ui.horizontal(|ui| {
            let label = format!("factor of {}", coefficient.id);
            let row = Row {
                label: &label,
                name: &coefficient.id,
                help: "Between its value divided by this factor and times it; 1.2 is about 20 % \
                       either way",
                value: coefficient.factor,
                unit: "",
            };
            crate::app::workspaces::explore::fields::name(ui, &coefficient.id, row.help);
            let new = row.narrow_field(ui, |v| {
                let is_wrong = !(v > 1.0 && v <= LARGEST_FACTOR);
                is_wrong.then(|| format!("the factor must lie above 1, up to {LARGEST_FACTOR}"))
            });
            let remove = format!("hold {}", coefficient.id);
            if icon_button(ui, Icon::Remove, &remove)
                .on_hover_text("It is certain")
                .clicked()
            {
                removed = Some(i);
            }
            if let Some(new) = new {
                coefficient.factor = new;
            }
        });
    }
    if let Some(i) = removed {
        choices.coefficients.remove(i);
    }
    let own = &mut choices.coefficients;
    let picker = ComboBox::from_id_salt("uncertain coefficient")
        .width(180.0)
        .selected_text("Add a coefficient...")
        .show_ui(ui, |ui| {
            for id in Axis::ids(model, &Waveform::Rest) {
                if own.iter().any(|c| c.id == id) {
                    continue;
                }
                if ui.selectable_label(false, &id).clicked() {
                    own.push(UncertainCoefficient {
                        id,
                        factor: FIRST_FACTOR,
                    });
                }
            }
        });
    picker
        .response
        .on_hover_text("A parameter of the device or of an effect that is uncertain too");
}
