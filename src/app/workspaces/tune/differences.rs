//! The parameters in which two devices differ.

use eframe::egui::{Grid, ScrollArea, Ui};

use crate::app::widgets::default_value;
use crate::app::widgets::text::small;
use crate::model::Model;
use crate::model::parameter::ParameterSpec;
use crate::model::unit::format_quantity;

/// Symbol, value before and value after.
pub type Difference = [String; 3];

/// The parameters in which two devices differ, those of effects included: symbol and both
/// values as text.
pub fn differences(before: &Model, after: &Model) -> Vec<Difference> {
    let mut rows = Vec::new();
    let write = |spec: &ParameterSpec, value: f64| format_quantity(value, spec.unit, 4);
    for (id, value) in after.parameters.iter() {
        let (spec, old) = (id.spec(), before.parameters[id]);
        if after.uses(id) && default_value::differs(value, old) {
            rows.push([spec.symbol.to_owned(), write(spec, old), write(spec, value)]);
        }
    }
    if after.has_ground && before.bounce != after.bounce {
        let (old, new) = (before.bounce.sentence(), after.bounce.sentence());
        rows.push(["bounce".to_owned(), old, new]);
    }
    let find = |model: &Model, id: &str| {
        model
            .effects
            .iter()
            .find(|e| e.spec.id == id)
            .map(|e| e.values.clone())
    };
    for effect in crate::model::effects::CATALOGUE {
        let (old, new) = (find(before, effect.id), find(after, effect.id));
        if old.is_none() && new.is_none() {
            continue;
        }
        for (i, spec) in effect.parameters.iter().enumerate() {
            let at = |values: &Option<Vec<f64>>| values.as_ref().map(|v| v[i]);
            if at(&old) == at(&new) {
                continue;
            }
            let text = |value: Option<f64>| value.map_or("off".to_owned(), |v| write(spec, v));
            let name = format!("{} {}", effect.name, spec.symbol);
            rows.push([name, text(at(&old)), text(at(&new))]);
        }
    }
    rows
}

/// The differences as a table; `titles` are those of its columns.
pub fn table(ui: &mut Ui, id: &str, titles: [&str; 3], rows: &[Difference]) {
    ScrollArea::horizontal().id_salt(id).show(ui, |ui| {
        Grid::new(id)
            .num_columns(3)
            .striped(true)
            .spacing([10.0, 3.0])
            .show(ui, |ui| {
                for title in titles {
                    ui.label(small(title).strong());
                }
                ui.end_row();
                for [name, old, new] in rows {
                    ui.label(name);
                    ui.label(small(old));
                    ui.label(small(new));
                    ui.end_row();
                }
            });
    });
}
