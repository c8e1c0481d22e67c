//! The first rows of a file, split with the present settings.

use eframe::egui::{RichText, ScrollArea, Ui};
use egui_extras::{Column, TableBuilder};

use super::sample::{Cells, is_number};
use crate::app::theme;
use crate::recording::csv::Decimal;

/// Columns in use, each with the name of its quantity.
pub type Roles = Vec<(usize, &'static str)>;

/// Most columns drawn, because a wrong delimiter can give thousands.
const MAX_COLUMNS: usize = 64;

/// Name of a column, numbered from 1 where the file has none.
pub fn column_name(cells: &Cells, index: usize) -> String {
    match cells.header.get(index) {
        Some(name) if !name.trim().is_empty() => name.clone(),
        _ => format!("column {}", index + 1),
    }
}

/// Draws the table. Cells of chosen columns are marked if they are not numbers.
pub fn show(ui: &mut Ui, cells: &Cells, decimal: Decimal, roles: &Roles) {
    if cells.rows.is_empty() {
        ui.weak("no rows found: reduce the lines before the data, or choose another delimiter");
        return;
    }
    let columns = cells.columns.min(MAX_COLUMNS);
    let color = theme::error(ui.visuals().dark_mode);
    let role = |column: usize| roles.iter().find(|(i, _)| *i == column).map(|(_, n)| *n);
    // Few columns share the width, many are scrolled through.
    let width = (ui.available_width() / columns.max(1) as f32 - 10.0).clamp(110.0, 260.0);
    ScrollArea::horizontal().show(ui, |ui| {
        TableBuilder::new(ui)
            .id_salt("import table")
            .striped(true)
            .max_scroll_height(96.0)
            .columns(
                Column::initial(width).at_least(70.0).resizable(true),
                columns,
            )
            .header(34.0, |mut header| {
                for i in 0..columns {
                    header.col(|ui| {
                        ui.vertical(|ui| {
                            ui.strong(column_name(cells, i));
                            ui.weak(role(i).unwrap_or("not used"));
                        });
                    });
                }
            })
            .body(|mut body| {
                for row in &cells.rows {
                    body.row(16.0, |mut line| {
                        for i in 0..columns {
                            line.col(|ui| {
                                let cell = row.get(i).map_or("", String::as_str);
                                let mut text = RichText::new(cell).monospace();
                                if role(i).is_some() && !is_number(cell, decimal) {
                                    text = text.color(color);
                                }
                                ui.label(text);
                            });
                        }
                    });
                }
            });
    });
    if cells.columns > MAX_COLUMNS {
        ui.weak(format!("and {} more columns", cells.columns - MAX_COLUMNS));
    }
}
