//! `sweep`: measures of the steady response over one or two axes as CSV, whole or in shards that merge to
//! the same bytes.

mod arguments;
mod command_line;
mod ensemble;
mod grid;
mod merge;
mod shard;
mod table;

use std::path::Path;

pub use self::arguments::Arguments;
use self::command_line::Sweep;
use self::table::Table;
use super::{Failure, interrupt, output, terminal, wrong_command};
use crate::explore::map::{self, MapError};
use crate::explore::robustness::{self, RobustnessError};

/// Computes or merges, and writes.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    if !args.merge.is_empty() {
        let mut results = output::ready(&[("--out", Some(&args.out))], &args.merge)?;
        results.add(&args.out, merge::merged(&args.merge)?);
        return results.end();
    }
    let sweep = Sweep::read(args)?;
    let mut results = output::ready(&[("--out", Some(&args.out))], &sweep.inputs)?;
    let (table, is_cancelled) = computed(&sweep)?;
    say_holes(&table, &args.out);
    results.add(&args.out, table.text());
    results.end()?;
    if is_cancelled {
        return Err(interrupt::cancelled());
    }
    Ok(())
}

/// The table with its rows, and whether it was cancelled.
fn computed(sweep: &Sweep) -> Result<(Table, bool), Failure> {
    let indices = sweep.indices();
    let cancel = interrupt::flag();
    let mut table = Table::new(sweep);
    match &sweep.robustness {
        None => {
            let told = |update: map::MapUpdate| progress(update.solved, update.total);
            let found = map::compute_points(&sweep.map, &indices, cancel, &told);
            terminal::end_of_progress();
            for point in found.map_err(refused)? {
                table.add_point(sweep, &point);
            }
        }
        Some(request) => {
            let told = |update: robustness::RobustUpdate| progress(update.done, update.total);
            let found = robustness::compute_points(request, &indices, cancel, &told);
            terminal::end_of_progress();
            for (index, answer) in found.map_err(refused_ensemble)? {
                table.add_answer(sweep, index, &answer);
            }
        }
    }
    let missing = indices.len() - table.rows.len();
    if missing > 0 {
        table.note_incomplete(indices.len());
    }
    Ok((table, missing > 0))
}

/// Wrong values on the command line are errors of the command, not of the work.
fn refused(error: MapError) -> Failure {
    wrong_command(error.into())
}

fn refused_ensemble(error: RobustnessError) -> Failure {
    wrong_command(error.into())
}

fn progress(done: usize, total: usize) {
    let percent = 100.0 * done as f64 / total.max(1) as f64;
    terminal::progress(&format!("{percent:3.0} % {done} of {total} points"), false);
}

/// Holes are in the table; here they are counted, with the first reason.
fn say_holes(table: &Table, out: &Path) {
    if let Some(first) = &table.first_hole {
        terminal::warning(format_args!(
            "{} of {} points are impossible (column \"hole\" of {}); the first: {first}",
            table.holes,
            table.rows.len(),
            out.display()
        ));
    }
}
