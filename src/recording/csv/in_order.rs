//! The rows in the order of time: counters that begin again, rows turned round, lines of text, rows that
//! stand elsewhere.

use super::read::{Rows, Source};
use super::rows::Table;
use super::rows::layout::TIME_SLOT;
use super::rows::order::{Order, sorted};
use crate::model::unit::{counted, format_quantity};
use crate::recording::error::{ImportWarning, WarningKind};
use crate::recording::times::exact_time::ExactTime;

impl Source<'_> {
    /// Adds what counters had counted, turns and sorts the rows, drops lines of text.
    pub(super) fn in_order(
        &self,
        mut table: Table,
        zero: ExactTime,
        found: &Order,
        warnings: &mut Vec<ImportWarning>,
    ) -> Rows {
        let mut columns = std::mem::take(&mut table.columns);
        let mut warn = |kind, count, message: String| {
            warnings.push(ImportWarning::new(kind, count, None, &message));
        };
        if let Some(time) = columns[TIME_SLOT].as_mut() {
            for (row, period) in &found.wraps {
                time.iter_mut().skip(*row).for_each(|t| *t += period);
            }
        }
        if let Some((_, period)) = found.wraps.first() {
            let period = format_quantity(*period, "s", 6);
            let times = counted(found.wraps.len(), "time");
            let message = format!(
                "the clock begins again at zero {times}, after {period}; what it had counted is added"
            );
            warn(WarningKind::CounterWrap, found.wraps.len(), message);
        }
        let rows = table.rows;
        let mut order: Option<Vec<usize>> = None;
        if found.reversed {
            let message = "the rows are newest first; they are turned round".to_owned();
            warn(WarningKind::RowsReordered, rows, message);
            order = Some((0..rows).rev().collect());
        }
        let text_rows = std::mem::take(&mut table.text_rows);
        if !text_rows.is_empty() {
            let lines = counted(text_rows.len(), "line");
            let message = format!("{lines} of text among or after the rows of numbers left out");
            warn(WarningKind::TextRows, text_rows.len(), message);
            let mut is_text = vec![false; rows];
            text_rows.iter().for_each(|row| is_text[*row] = true);
            let mut kept = order.unwrap_or_else(|| (0..rows).collect());
            kept.retain(|row| !is_text[*row]);
            order = Some(kept);
        }
        if let Some(order) = &order {
            columns.iter_mut().flatten().for_each(|c| permute(c, order));
        }
        let moved = columns[TIME_SLOT].as_deref().and_then(sorted);
        if let Some((by_time, count)) = moved {
            let message = format!(
                "{} stood out of order and {} sorted by time",
                counted(count, "row"),
                if count == 1 { "is" } else { "are" }
            );
            warn(WarningKind::RowsReordered, count, message);
            columns
                .iter_mut()
                .flatten()
                .for_each(|c| permute(c, &by_time));
            order = Some(match order {
                Some(order) => by_time.iter().map(|row| order[*row]).collect(),
                None => by_time,
            });
        }
        Rows {
            table,
            columns,
            zero,
            order,
            text_rows: text_rows.len(),
        }
    }
}

fn permute(column: &mut Vec<f64>, order: &[usize]) {
    let all = order
        .iter()
        .map(|row| column.get(*row).copied().unwrap_or(f64::NAN));
    *column = all.collect();
}
