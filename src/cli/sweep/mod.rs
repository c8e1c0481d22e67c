//! `sweep`: measures of the steady response over one or two axes as CSV, whole or in shards that merge to
//! the same bytes.

mod command_line;
mod ensemble;
mod grid;
mod merge;
mod table;

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;

use self::command_line::Sweep;
use self::table::Table;
use super::{Failure, interrupt, output, terminal, wrong_command};
use crate::explore::map::{self, MapError};
use crate::explore::measures::MEASURES;
use crate::explore::robustness::{self, RobustnessError};

/// Syntax, measures and examples, for `--help`.
fn lists() -> String {
    let mut text = String::from(
        "Axes for --grid, one or two, joined by a comma:\n  ID=FROM:TO:COUNT[UNIT][:log]   f=5:100:20Hz is from 5 to 100 Hz in 20 points,\n                                 both ends with it; an end may have its own unit, or\n                                 be a multiple of the device's value: Cs=0.5x:2x:9:log\n  ID is a number of the drive (f, V, offset, lambda, duty, asymmetry, phase, h1, t1)\n  or a parameter of the device or of an effect (Cs, gp, gravity.g); a wrong one lists all\n\nCoefficients for --over, joined by a comma:\n  ID:LOW..HIGH[:linear]          Cs:0.5x..2x is from half to twice the device's value,\n                                 equal ratios equally likely; linear: equal differences\n\nMeasures for --measure, joined by a comma (unit; meaning):\n",
    );
    for row in MEASURES {
        let unit = if row.unit.is_empty() { "-" } else { row.unit };
        text += &format!("  {:<20} {unit:<10} {}\n", row.id, row.meaning);
    }
    text += "  contact is short for contact_share\n\nThe environment's RAYON_NUM_THREADS sets the number of threads.\n";
    text
}

/// Arguments of `sweep`.
#[derive(Debug, Args)]
#[command(after_help = lists())]
pub struct Arguments {
    /// Device: paper, paper-as-printed, oscillator, faller, bouncing-ball, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Drive; a kind alone (square, sine, triangle, ramped) takes frequency and amplitude of the preset's
    /// drive [default: the preset's]
    #[arg(long, allow_hyphen_values = true)]
    drive: Option<String>,
    /// One or two axes, e.g. f=5:100:20Hz,V=4:8:9V
    #[arg(long, value_name = "AXIS[,AXIS]", allow_hyphen_values = true)]
    grid: Option<String>,
    /// Coefficients that vary in an ensemble, e.g. Cs:0.5x..2x
    #[arg(long, value_name = "ID:LOW..HIGH,...")]
    over: Vec<String>,
    /// Devices of the ensemble [default with --over: 32]
    #[arg(long, value_name = "N")]
    ensemble: Option<usize>,
    /// What is wanted of the response, for the column of its probability: regime=sticks or
    /// contact=0.3..0.4; repeatable
    #[arg(long, value_name = "MEASURE=LOW..HIGH")]
    want: Vec<String>,
    /// Measures [default: regime,contact_share,peak,impact_speed_first]
    #[arg(long, value_name = "ID,...")]
    measure: Option<String>,
    /// Parameter to change, e.g. Cs=2e-21 or gp="72 um"; repeatable
    #[arg(long, value_name = "ID=VALUE")]
    set: Vec<String>,
    /// Effect to switch on, e.g. quadratic_drag:cd=1e-7; repeatable
    #[arg(long, value_name = "ID[:PARAMETER=VALUE,...]")]
    effect: Vec<String>,
    /// Seed of the ensemble
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Compute only part I of N: points I-1, I-1+N, ...
    #[arg(long, value_name = "I/N")]
    shard: Option<String>,
    /// Put shards together, whatever their order; one that is given twice counts once
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["grid", "over", "ensemble", "want", "measure", "set", "effect", "shard", "drive"])]
    merge: Vec<PathBuf>,
    /// File for the table (CSV); - for standard output
    #[arg(long, value_name = "F.csv")]
    out: PathBuf,
}

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

/// `I/N` with I from 1 to N.
fn shard(text: &str) -> anyhow::Result<(usize, usize)> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    match numbers {
        Some((i, n)) if i >= 1 && i <= n => Ok((i, n)),
        _ => Err(anyhow!(
            "--shard {text}: write I/N with I from 1 to N, for example 3/8"
        )),
    }
}
