//! What the ensemble says of the present drive.

use eframe::egui::{Grid, Label, RichText, Ui};

use crate::app::plots::explore::colors::regime_color;
use crate::app::plots::explore::legend;
use crate::app::state::State;
use crate::app::widgets::text::{heading, small};
use crate::app::workspaces::explore::fields::{refusal, remark};
use crate::explore::robustness::{Quantiles, Robustness};
use crate::model::unit::format_quantity;

/// Draws it.
pub(super) fn show(ui: &mut Ui, state: &mut State) {
    let robust = &mut state.exploring.robust;
    ui.horizontal(|ui| {
        heading(ui, "The present drive");
        if robust.point.is_waiting() {
            ui.spinner();
        }
    });
    if let Some(reason) = &robust.refusal {
        refusal(ui, &format!("No answer: {reason}."));
        return;
    }
    let Some(newest) = robust.point.newest() else {
        ui.weak("is being computed");
        return;
    };
    match &newest.answer {
        Ok(found) => answer(ui, found),
        Err(error) => refusal(ui, &format!("No answer: {error}.")),
    }
}

/// Draws an answer.
pub(super) fn answer(ui: &mut Ui, found: &Robustness) {
    let text = format!(
        "{:.0} % \u{b1} {:.0} %",
        100.0 * found.probability,
        100.0 * found.std_error()
    );
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).size(17.0).strong())
            .on_hover_text("Share of the devices with the wanted response, and its standard error");
        ui.label(small(format!("of {} devices", found.members)));
    });
    for (regime, share) in &found.regimes {
        let share = format!("{:.0} %", 100.0 * share);
        legend::entry(ui, regime_color(*regime), &regime.label(), &share);
    }
    quantiles(ui, &found.quantiles);
    let breaker = match &found.breaker {
        Some(breaker) => {
            let way = if breaker.difference > 0.0 {
                "large"
            } else {
                "small"
            };
            format!(
                "It breaks first where {} is {way} ({:+.1} standard deviations).",
                breaker.id, breaker.difference
            )
        }
        None => "No coefficient alone decides whether it breaks.".to_owned(),
    };
    ui.add(Label::new(small(breaker)).wrap());
    if let Some(reason) = &found.first_failure {
        let text = format!(
            "{} devices are impossible; the first: {reason}",
            found.failed
        );
        remark(ui, &text);
    }
}

/// Between which values nine of ten devices lie.
fn quantiles(ui: &mut Ui, all: &[Quantiles]) {
    let known: Vec<&Quantiles> = all.iter().filter(|q| q.count > 0).collect();
    if known.is_empty() {
        return;
    }
    Grid::new("robustness quantiles")
        .num_columns(4)
        .spacing([8.0, 2.0])
        .show(ui, |ui| {
            for title in ["", "5 %", "median", "95 %"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for quantiles in known {
                let spec = quantiles.measure.spec();
                ui.label(small(spec.name)).on_hover_text(spec.meaning);
                for value in [quantiles.low, quantiles.median, quantiles.high] {
                    let text = format_quantity(value, spec.unit, 3);
                    ui.label(small(text).monospace());
                }
                ui.end_row();
            }
        });
}
