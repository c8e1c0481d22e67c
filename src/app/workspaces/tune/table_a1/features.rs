//! The features of Table A.1 (bounces, peak, contact time) for the simulation and each
//! recording, side by side.

use std::sync::Arc;

use eframe::egui::{Grid, Id, RichText, ScrollArea, Ui};

use crate::app::setup::overlay::OverlayId;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::app::widgets::text::{name_of, short, small};
use crate::fit::table_a1::measurements::Figures;
use crate::model::unit::format_number;
use crate::recording::features::Features;

/// Why features are missing, if any are.
fn missing(features: &Features) -> Option<String> {
    let steady = features.steady.as_ref().err();
    let missing = steady.or(features.contact_level.as_ref().err());
    missing.map(ToString::to_string)
}

/// The features, or the previous ones while new ones are computed, so that the numbers do not
/// flicker.
pub fn latest(
    ui: &Ui,
    whose: Option<OverlayId>,
    features: &Option<Arc<Features>>,
) -> Option<Arc<Features>> {
    let key = Id::unique(("latest features", whose));
    match features {
        Some(features) => {
            ui.data_mut(|data| data.insert_temp(key, features.clone()));
            Some(features.clone())
        }
        None => ui.data(|data| data.get_temp(key)),
    }
}

/// A row of the features' table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Row {
    /// Bounces per period.
    Bounces,
    /// Peak displacement.
    Peak,
    /// Contact time per period.
    Contact,
}

/// All rows in order.
pub const FEATURE_ROWS: [Row; 3] = [Row::Bounces, Row::Peak, Row::Contact];

impl Row {
    /// Name with the unit of [`Self::value`].
    pub fn title(self) -> &'static str {
        match self {
            Row::Bounces => "bounces",
            Row::Peak => "peak [µm]",
            Row::Contact => "contact [ms]",
        }
    }

    /// What it means.
    pub fn help(self) -> &'static str {
        match self {
            Row::Bounces => {
                "Rebounds above 5 µm before sustained contact, per period; 0 if contact is never sustained"
            }
            Row::Peak => {
                "Highest xp after break-off while the voltage falls or is held, minus the lowest xp, per period"
            }
            Row::Contact => {
                "Time on the ground per period; rebounds below 5 µm do not end a contact"
            }
        }
    }

    /// The number in the unit of [`Self::title`].
    pub fn value(self, figures: &Figures) -> Option<f64> {
        match self {
            Row::Bounces => figures.bounces,
            Row::Peak => figures.peak.map(|v| 1e6 * v),
            Row::Contact => figures.contact.map(|v| 1e3 * v),
        }
    }
}

/// A column of the table.
struct Column {
    /// The recording, or `None` for the simulation.
    overlay: Option<OverlayId>,
    name: String,
    figures: Figures,
    features: Option<Arc<Features>>,
    missing: Option<String>,
}

/// Draws the table.
pub fn show(ui: &mut Ui, state: &State, snapshot: &Snapshot) {
    let mut columns = vec![column(ui, None, "now".to_owned(), &snapshot.features)];
    for entry in &snapshot.comparisons {
        let name = name_of(&state.setup, entry.id);
        columns.push(column(ui, Some(entry.id), name, &entry.features));
    }
    ScrollArea::horizontal().id_salt("features").show(ui, |ui| {
        Grid::new("features")
            .num_columns(1 + columns.len())
            .striped(true)
            .spacing([7.0, 3.0])
            .show(ui, |ui| table(ui, &columns));
    });
    if columns
        .iter()
        .all(|column| column.figures == Figures::default() && column.missing.is_none())
    {
        ui.label(small("not computed yet").weak());
    }
    for column in columns {
        if let Some(reason) = column.missing {
            let name = short(&column.name, 22);
            ui.label(small(format!("{name}: {reason}")).weak())
                .on_hover_text(column.name);
        }
    }
}

fn column(
    ui: &Ui,
    overlay: Option<OverlayId>,
    name: String,
    features: &Option<Arc<Features>>,
) -> Column {
    let features = latest(ui, overlay, features);
    Column {
        overlay,
        name,
        figures: features.as_deref().map(Figures::of).unwrap_or_default(),
        missing: features.as_deref().and_then(missing),
        features,
    }
}

fn table(ui: &mut Ui, columns: &[Column]) {
    ui.label("");
    for column in columns {
        let title = small(short(&column.name, 24)).strong();
        ui.label(title).on_hover_text(&column.name);
    }
    ui.end_row();
    for row in FEATURE_ROWS {
        ui.label(row.title()).on_hover_text(row.help());
        let simulated = columns.first().and_then(|own| row.value(&own.figures));
        for column in columns {
            let of_recording = column.overlay.is_some();
            if row == Row::Bounces && bounces(ui, column) {
                continue;
            }
            let text = match (row.value(&column.figures), simulated) {
                (None, _) => "-".to_owned(),
                (Some(value), Some(simulated)) if of_recording => format!(
                    "{} ({})",
                    format_number(value, 3),
                    signed(simulated - value)
                ),
                (Some(value), _) => format_number(value, 3),
            };
            let label = ui.label(RichText::new(text).monospace().size(11.5));
            if of_recording {
                label.on_hover_text("Recording (simulation minus recording)");
            }
        }
        ui.end_row();
    }
}

/// Bounces as they were counted, period by period; a mean of them alone is misread. Whether there
/// are any to say.
fn bounces(ui: &mut Ui, column: &Column) -> bool {
    let features = column.features.as_deref();
    let said = features.and_then(|f| f.bounces_text().zip(f.bounces_sentence()));
    let Some((text, sentence)) = said else {
        return false;
    };
    ui.label(RichText::new(text).monospace().size(11.5))
        .on_hover_text(sentence);
    true
}

/// A difference with its sign, to two digits.
fn signed(value: f64) -> String {
    let sign = if value < 0.0 { "" } else { "+" };
    format!("{sign}{}", format_number(value, 2))
}
