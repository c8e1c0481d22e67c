//! The numbers of a steady response in a table, as maps name them.

use eframe::egui::{Grid, Label, RichText, Ui};

use crate::app::analysis::explore::latest::Answered;
use crate::app::analysis::explore::steady::{SteadyView, SteadyWork};
use crate::app::widgets::text::{heading, small};
use crate::explore::measures::{MEASURES, MeasureId, MeasureSpec};
use crate::explore::steady_state::{Aperiodicity, ResponseKind, Stability};
use crate::model::unit::format_quantity;

use super::fields;

/// Width of a column that holds the table \[points\].
pub const READOUT_WIDTH: f32 = 300.0;

/// A value with its unit; `-` where the response has none.
pub fn value_text(spec: &MeasureSpec, value: Option<f64>) -> String {
    value.map_or_else(
        || "-".to_owned(),
        |value| format_quantity(value, spec.unit, 3),
    )
}

/// Draws the newest answer; `waits` says that a newer one is on its way.
pub fn show(ui: &mut Ui, newest: Option<&Answered<SteadyWork>>, waits: bool) {
    ui.horizontal(|ui| {
        heading(ui, "Steady response");
        if waits {
            ui.spinner();
        }
    });
    let Some(newest) = newest else {
        ui.weak(if waits { "is being computed" } else { "none" });
        return;
    };
    match &newest.answer {
        Err(error) => fields::refusal(ui, error),
        Ok(view) => {
            table(ui, view);
            let cost = format_quantity(newest.cost.as_secs_f64(), "s", 2);
            fields::remark(ui, &format!("computed in {cost}"));
        }
    }
}

fn table(ui: &mut Ui, view: &SteadyView) {
    ui.label(RichText::new(view.regime.label()).size(16.0).strong())
        .on_hover_text("How the mass meets the ground in one cycle");
    ui.add(Label::new(small(kind_text(view))).wrap());
    ui.add_space(4.0);
    Grid::new("steady readout")
        .num_columns(2)
        .spacing([8.0, 3.0])
        .striped(true)
        .show(ui, |ui| {
            let rest = MEASURES
                .iter()
                .filter(|row| !matches!(row.measure, MeasureId::Regime | MeasureId::Multiple));
            for spec in rest {
                ui.label(small(spec.name)).on_hover_text(spec.meaning);
                let text = value_text(spec, view.value(spec.measure));
                ui.label(small(text).monospace());
                ui.end_row();
            }
        });
    ui.add_space(4.0);
    let next = format!("Nearest change: {}", view.margin.kind.label());
    ui.add(Label::new(small(next)).wrap())
        .on_hover_text("What would happen next to the sequence of events if something changed");
}

/// Periods, stability and closeness to grazing, in a sentence.
fn kind_text(view: &SteadyView) -> String {
    let mut text = match view.response.kind {
        ResponseKind::Periodic { multiple: 1 } => "repeats each period of the drive".to_owned(),
        ResponseKind::Periodic { multiple } => {
            format!("repeats every {multiple} periods of the drive")
        }
        ResponseKind::NotPeriodic(Aperiodicity::Chaotic { exponent }) => format!(
            "does not repeat: chaotic, neighbours part by e in {:.1} periods",
            1.0 / exponent
        ),
        ResponseKind::NotPeriodic(Aperiodicity::Undetermined { .. }) => {
            "did not repeat within the periods that were followed".to_owned()
        }
    };
    match &view.response.stability {
        Stability::Multipliers(all) => {
            if let Some(largest) = all.first() {
                text += &format!("; stable, largest multiplier {:.3}", largest.norm());
            }
        }
        Stability::NotSmooth => text += "; near grazing, so transients alone show that it attracts",
        Stability::NotComputed => {}
    }
    text
}
