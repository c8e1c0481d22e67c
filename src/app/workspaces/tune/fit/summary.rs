//! The end of the guided identification: what the steps told, and which recording would tell the
//! rest.

use eframe::egui::Ui;

use crate::app::analysis::identification::Identification;
use crate::app::widgets::text::{heading, small};
use crate::diagnose::report::words::capitalised;
use crate::fit::paper_steps::summary::summary;

/// Draws the summary, once every step that the recordings allow has been taken.
pub(super) fn show(ui: &mut Ui, guide: &Identification) {
    if !guide.is_at_its_end() {
        return;
    }
    let summary = summary(&guide.allowances, |step| {
        let finding = guide.findings.get(step.id())?;
        Some(finding.as_ref().map_err(String::as_str))
    });
    ui.separator();
    heading(ui, "The identification is at its end");
    for found in &summary.identified {
        ui.label(found.text());
    }
    for (_, text) in &summary.others {
        ui.label(small(capitalised(text)));
    }
    for untold in &summary.untold {
        let text = format!("Not identified, {}: {}", untold.step.title(), untold.text());
        ui.label(small(text).color(ui.visuals().warn_fg_color));
    }
}
