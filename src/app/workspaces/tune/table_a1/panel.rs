//! All 16 cases of Table A.1 at the current parameters, next to the paper's simulation and the
//! experiment, with the statistics of Table 3. A click on a case sets its drive; a button fits
//! the device to the experiments.

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{Button, Grid, Id, RichText, ScrollArea, Ui};

use super::calibrate;
use super::case_picker::{choose, current};
use super::error_cell::{error, error_cell};
use super::features::FEATURE_ROWS;
use crate::app::analysis::job::{in_own_pool, panic_text};
use crate::app::state::State;
use crate::app::widgets::text::small;
use crate::fit::table_a1::compare::{
    Column, REPRODUCED_MEANS, Row, Statistics, statistics, validate,
};
use crate::model::Model;
use crate::model::unit::format_number;

/// What the rows are sorted by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Order {
    /// As in the paper.
    #[default]
    Table,
    /// Largest error first, of the figure with this index in [`FEATURE_ROWS`].
    Error(usize),
}

/// How the table is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TableView {
    order: Order,
    against: Column,
}

impl Default for TableView {
    fn default() -> Self {
        Self {
            order: Order::Table,
            against: Column::Experiment,
        }
    }
}

/// Rows, or why there are none.
type Outcome = Result<Arc<Vec<Row>>, String>;

/// The last result, and whether another is being computed.
#[derive(Debug, Default)]
struct Results {
    /// Model and its rows.
    done: Option<(Arc<Model>, Outcome)>,
    busy: bool,
}

type Shared = Arc<Mutex<Results>>;

/// The latest rows, and whether they belong to `model`. They are computed on another thread,
/// one model at a time.
fn results(ui: &Ui, model: &Model) -> (Option<Outcome>, bool) {
    let key = Id::unique("validation results");
    let shared: Shared = ui.data_mut(|data| data.get_temp_mut_or_default::<Shared>(key).clone());
    let mut held = shared.lock().unwrap_or_else(PoisonError::into_inner);
    let fresh = matches!(&held.done, Some((of, _)) if **of == *model);
    if !fresh && !held.busy {
        held.busy = true;
        let (model, context) = (Arc::new(model.clone()), ui.ctx().clone());
        let of_rows = Arc::clone(&model);
        let of_thread = Arc::clone(&shared);
        let compute = move || {
            let run = std::panic::AssertUnwindSafe(|| in_own_pool(|| validate(&model)));
            let rows = match std::panic::catch_unwind(run) {
                Ok(Ok(rows)) => Ok(Arc::new(rows)),
                Ok(Err(error)) => Err(error.to_string()),
                Err(panic) => Err(panic_text(panic.as_ref())),
            };
            let mut held = of_thread.lock().unwrap_or_else(PoisonError::into_inner);
            held.done = Some((model, rows));
            held.busy = false;
            context.request_repaint();
        };
        let thread = std::thread::Builder::new().name("table".to_owned());
        if let Err(error) = thread.spawn(compute) {
            let text = format!("no thread could be started: {error}; close other programs");
            held.done = Some((of_rows, Err(text)));
            held.busy = false;
        }
    }
    (held.done.as_ref().map(|(_, rows)| rows.clone()), fresh)
}

/// Draws the table.
pub fn show(ui: &mut Ui, state: &mut State) {
    let model = &state.setup.preset.model;
    if !(model.has_ground && model.piezo.is_some()) {
        ui.label("This device has no ground or no drive. The table is about the paper's device: choose the preset paper.");
        return;
    }
    let (rows, fresh) = results(ui, model);
    let rows = match rows {
        None => {
            ui.label("The 16 cases are being simulated...");
            return;
        }
        Some(Err(reason)) => {
            ui.colored_label(crate::app::widgets::text::error_color(ui), reason);
            return;
        }
        Some(Ok(rows)) => rows,
    };
    let key = Id::unique("validation look");
    let mut view: TableView = ui.data(|data| data.get_temp(key)).unwrap_or_default();
    ui.horizontal_wrapped(|ui| {
        ui.label("Errors against");
        ui.selectable_value(&mut view.against, Column::Experiment, "the experiment");
        ui.selectable_value(&mut view.against, Column::Paper, "the paper's simulation");
        if !fresh {
            ui.weak("updating...");
        }
    });
    calibrate::controls(ui, state);
    ScrollArea::both()
        .id_salt("validation")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            calibrate::result(ui, state);
            table(ui, state, &rows, &mut view);
            ui.add_space(8.0);
            ui.separator();
            table_3(ui, &rows);
        });
    ui.data_mut(|data| data.insert_temp(key, view));
}

fn table(ui: &mut Ui, state: &mut State, rows: &[Row], view: &mut TableView) {
    let mut order: Vec<&Row> = rows.iter().collect();
    if let Order::Error(figure) = view.order {
        // A missing figure is sorted before any error.
        let size = |row: &Row| error(row, view.against, figure).map_or(f64::INFINITY, f64::abs);
        order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    }
    let now = current(&state.setup).copied();
    let mut chosen = None;
    Grid::new("validation table")
        .num_columns(13)
        .striped(true)
        .spacing([9.0, 3.0])
        .show(ui, |ui| {
            let by_table = view.order == Order::Table;
            if sort_button(ui, by_table, "case", "Sort as in the paper") {
                view.order = Order::Table;
            }
            for (figure, row) in FEATURE_ROWS.iter().enumerate() {
                let by_this = view.order == Order::Error(figure);
                let help = format!("{}\nClick to sort by its error.", row.help());
                if sort_button(ui, by_this, row.title(), &help) {
                    view.order = Order::Error(figure);
                }
                for title in ["paper", "exp.", "error"] {
                    ui.label(small(title).weak());
                }
            }
            ui.end_row();
            for row in order {
                let selected = now == Some(row.case);
                let button = Button::selectable(selected, row.case.name());
                let button = ui.add(button);
                if button.on_hover_text("Set this drive").clicked() {
                    chosen = Some(row.case);
                }
                for (figure, kind) in FEATURE_ROWS.iter().enumerate() {
                    let cells = [row.model, row.case.simulation, row.case.experiment];
                    for (i, cell) in cells.iter().enumerate() {
                        let text = kind
                            .value(cell)
                            .map_or("-".to_owned(), |v| format_number(v, 3));
                        let text = RichText::new(text).monospace();
                        ui.label(if i == 0 { text.strong() } else { text });
                    }
                    error_cell(ui, figure, error(row, view.against, figure));
                }
                ui.end_row();
            }
        });
    if let Some(case) = chosen {
        choose(&mut state.setup, &case);
    }
}

fn sort_button(ui: &mut Ui, active: bool, title: &str, help: &str) -> bool {
    let button = Button::selectable(active, RichText::new(title).strong());
    ui.add(button).on_hover_text(help).clicked()
}

fn table_3(ui: &mut Ui, rows: &[Row]) {
    ui.label(RichText::new("Table 3: summary").strong());
    let both = [Column::Paper, Column::Experiment].map(|column| statistics(rows, column));
    let percent = |v: f64| format!("{:.1} %", 100.0 * v);
    let count = |n: usize| format!("{n} of {}", rows.len());
    type Line<'a> = (&'a str, &'a dyn Fn(&Statistics) -> String);
    let lines: [Line<'_>; 9] = [
        ("bounce existence correct", &|s| percent(s.bounce_existence)),
        ("number of bounces correct", &|s| percent(s.bounce_number)),
        ("mean error in number of bounces", &|s| {
            format!("{:.2}", s.bounce_mean_error)
        }),
        ("mean error in peak", &|s| percent(s.peak_mean_error)),
        ("mean absolute error in peak", &|s| {
            percent(s.peak_mean_absolute_error)
        }),
        ("peaks within 30 %", &|s| count(s.peak_within_30_percent)),
        ("mean absolute error in contact duration", &|s| {
            percent(s.contact_mean_absolute_error)
        }),
        ("contact durations within 30 %", &|s| {
            count(s.contact_within_30_percent)
        }),
        ("cases reproduced", &|s| count(s.reproduced)),
    ];
    Grid::new("table 3")
        .num_columns(3)
        .striped(true)
        .spacing([18.0, 3.0])
        .show(ui, |ui| {
            for title in [
                "",
                "against the paper's simulation",
                "against the experiment",
            ] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for (name, value) in lines {
                ui.label(name);
                for statistics in &both {
                    ui.label(RichText::new(value(statistics)).monospace());
                }
                ui.end_row();
            }
        });
    ui.label(small(REPRODUCED_MEANS).weak());
    ui.label(small("Errors are (now - published) / published. The experiments are the 16 published ones of Ryou and Oldham 2012.").weak());
}
