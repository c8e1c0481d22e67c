//! A device of one's own, from geometry or lumped parts: fields, and at once what follows from them.

use eframe::egui::{Align2, Button, Grid, Id, RichText, ScrollArea, TextEdit, Ui, Window};

use super::import::columns::name;
use super::{Answer, enter, escape};
use crate::app::theme;
use crate::app::widgets::text::small;
use crate::model::design::{DesignError, DesignKind, Designed, describe};
use crate::model::unit::format_quantity;

/// A field: its key in the text of a description, what it is, and an example.
type FieldSpec = (&'static str, &'static str, &'static str);

/// What every device may have.
const COMMON_FIELDS: [FieldSpec; 8] = [
    ("name", "name", "own"),
    ("zeta", "damping ratios of the modes", "0.02/0.03"),
    ("ground", "distance to the ground", "58um"),
    ("film", "gas film left at contact", "12um"),
    ("plate", "plate on the film, along x across", "150x100um"),
    ("adhesion", "adhesion at first touch", "27nN"),
    ("alpha", "coefficient of restitution", "0.38"),
    ("V", "amplitude of the drive", "8V"),
];
const BEAM_FIELDS: [FieldSpec; 10] = [
    ("L", "length of the beam", "750um"),
    ("W", "width of the beam", "100um"),
    ("layers", "layers from the bottom", "Si:5um+PZT:1um"),
    ("EI", "or bending stiffness", "1.139e-12"),
    ("m", "and mass per length", "3.519e-7"),
    (
        "mass_size",
        "end mass, along x across x height",
        "150x100x10um",
    ),
    ("mass", "its mass, if not of silicon", "0.35ug"),
    ("piezo", "piezo layer from and to", "0..500um"),
    ("force", "or force per volt", "0.3uN"),
    ("modes", "number of modes", "2"),
];
const SPRING_FIELDS: [FieldSpec; 4] = [
    ("m", "mass", "0.2kg"),
    ("k", "stiffness", "15N/m"),
    ("f", "or frequency", "1.4Hz"),
    ("x0", "start", "5cm"),
];
const PENDULUM_FIELDS: [FieldSpec; 4] = [
    ("L", "length", "1m"),
    ("angle", "start", "20deg"),
    ("m", "mass", "0.1kg"),
    ("inertia", "moment of inertia about the pivot", "1.1kg m^2"),
];
/// What a pendulum has of what others have.
const PENDULUM_COMMON_KEYS: [&str; 2] = ["name", "zeta"];
const FREE_FIELDS: [FieldSpec; 4] = [
    ("m", "mass", "57g"),
    ("x0", "start height", "2m"),
    ("v0", "start speed", "0m/s"),
    ("g", "acceleration of gravity", "9.81m/s^2"),
];

/// Kinds of devices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Beam,
    Spring,
    Pendulum,
    Free,
}

impl Kind {
    const ALL: [(Self, &'static str); 4] = [
        (Self::Beam, "cantilever with a mass"),
        (Self::Spring, "mass on a spring"),
        (Self::Pendulum, "pendulum"),
        (Self::Free, "free mass"),
    ];

    fn fields(self) -> Vec<FieldSpec> {
        let own: &[FieldSpec] = match self {
            Self::Beam => &BEAM_FIELDS,
            Self::Spring => &SPRING_FIELDS,
            Self::Pendulum => &PENDULUM_FIELDS,
            Self::Free => &FREE_FIELDS,
        };
        let is_there = |field: &&FieldSpec| {
            // A pendulum has neither ground nor drive here.
            self != Self::Pendulum || PENDULUM_COMMON_KEYS.contains(&field.0)
        };
        let common = COMMON_FIELDS.iter().filter(is_there);
        own.iter().chain(common).copied().collect()
    }

    fn design(self) -> DesignKind<'static> {
        match self {
            Self::Beam => DesignKind::Beam,
            Self::Spring => DesignKind::Spring,
            Self::Pendulum => DesignKind::Pendulum,
            Self::Free => DesignKind::Free,
        }
    }

    /// Keys of the fields that begin with their example.
    fn filled(self) -> &'static [&'static str] {
        match self {
            Self::Beam => &["L", "W", "layers", "mass_size", "ground"],
            Self::Spring => &["m", "k", "x0"],
            Self::Pendulum => &["L", "angle"],
            Self::Free => &["m", "x0", "g"],
        }
    }
}

/// The open dialog.
#[derive(Debug)]
pub struct NewDeviceDialog {
    kind: Kind,
    /// Texts of the fields of the kind, in their order.
    values: Vec<String>,
    made: Result<Box<Designed>, DesignError>,
}

impl Default for NewDeviceDialog {
    fn default() -> Self {
        Self::of(Kind::Beam)
    }
}

impl NewDeviceDialog {
    fn of(kind: Kind) -> Self {
        let begins = |&(key, _, example): &FieldSpec| {
            if kind.filled().contains(&key) {
                example.to_owned()
            } else {
                String::new()
            }
        };
        let values: Vec<String> = kind.fields().iter().map(begins).collect();
        let made = made(kind, &values);
        Self { kind, values, made }
    }

    /// Draws it; returns whether it stays open, and the answer.
    pub fn show(&mut self, ui: &mut Ui) -> (bool, Option<Answer>) {
        let mut open = !escape(ui);
        let mut accepted = enter(ui, Id::unique("new device"));
        Window::new("New device")
            .collapsible(false)
            .default_width(620.0)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ui, |ui| {
                self.kinds(ui);
                ui.separator();
                let height = (ui.ctx().content_rect().height() - 260.0).max(160.0);
                ui.horizontal_top(|ui| {
                    ScrollArea::vertical()
                        .id_salt("device fields")
                        .max_height(height)
                        .show(ui, |ui| ui.vertical(|ui| self.fields(ui)));
                    ui.separator();
                    ui.vertical(|ui| self.outcome(ui));
                });
                ui.separator();
                ui.horizontal(|ui| {
                    let button = ui.add_enabled(self.made.is_ok(), Button::new("Use device"));
                    accepted |= button
                        .on_hover_text("Take it as the present device; it can be undone")
                        .clicked();
                    if ui.button("Cancel").clicked() {
                        open = false;
                    }
                });
            });
        match &self.made {
            Ok(made) if open && accepted => {
                (false, Some(Answer::Device(Box::new(made.preset.clone()))))
            }
            _ => (open, None),
        }
    }

    fn kinds(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (kind, text) in Kind::ALL {
                if ui.selectable_label(self.kind == kind, text).clicked() && self.kind != kind {
                    *self = Self::of(kind);
                }
            }
        });
    }

    fn fields(&mut self, ui: &mut Ui) {
        let mut changed = false;
        Grid::new("device fields").num_columns(2).show(ui, |ui| {
            for ((_, text, example), value) in self.kind.fields().iter().zip(&mut self.values) {
                ui.label(*text);
                let field = ui.add(
                    TextEdit::singleline(value)
                        .hint_text(*example)
                        .desired_width(150.0),
                );
                name(&field, eframe::egui::Role::TextInput, text);
                changed |= field.changed();
                ui.end_row();
            }
        });
        if changed {
            self.made = made(self.kind, &self.values);
        }
    }

    /// What follows from the fields, or what is wrong with them.
    fn outcome(&self, ui: &mut Ui) {
        ui.set_width(270.0);
        match &self.made {
            Err(error) => {
                let color = theme::error(ui.visuals().dark_mode);
                ui.colored_label(color, error.to_string());
            }
            Ok(made) => {
                let model = &made.preset.model;
                for (i, mode) in model.structure().modes.iter().enumerate() {
                    let frequency = format_quantity(mode.frequency, "Hz", 4);
                    let text = format!("mode {}: {frequency}, damping {:.3}", i + 1, mode.zeta);
                    ui.label(RichText::new(text).strong());
                }
                for note in &made.notes {
                    ui.label(small(note.as_str()));
                }
            }
        }
    }
}

/// The device of the fields that are filled.
fn made(kind: Kind, values: &[String]) -> Result<Box<Designed>, DesignError> {
    let fields = kind.fields();
    let pairs = fields
        .iter()
        .zip(values)
        .filter_map(|((key, _, _), value)| {
            let value = value.trim();
            (!value.is_empty()).then(|| format!("{key}={value}"))
        });
    let text = pairs.collect::<Vec<_>>().join(",");
    describe(kind.design(), &text).map(Box::new)
}

#[cfg(test)]
mod tests {
    use super::super::new_device::*;

    #[test]
    fn every_kind_begins_with_a_device() {
        for (kind, text) in Kind::ALL {
            let dialog = NewDeviceDialog::of(kind);
            assert!(dialog.made.is_ok(), "{text}: {:?}", dialog.made);
        }
    }

    /// Each example is understood by the field that shows it, whatever else it needs.
    #[test]
    fn every_example_can_be_typed() {
        for (kind, _) in Kind::ALL {
            for (i, (key, _, example)) in kind.fields().iter().enumerate() {
                // Of two ways to say the same, the other one stays empty.
                if matches!(*key, "f" | "EI" | "m" | "force") {
                    continue;
                }
                let mut dialog = NewDeviceDialog::of(kind);
                dialog.values[i] = (*example).to_owned();
                if matches!(*key, "film" | "plate" | "adhesion" | "alpha") {
                    let ground = kind.fields().iter().position(|f| f.0 == "ground").unwrap();
                    dialog.values[ground] = "58um".to_owned();
                }
                let made = made(kind, &dialog.values);
                assert!(made.is_ok(), "{key}={example}: {made:?}");
            }
        }
    }
}
