//! `diagnose`: from recordings to what the model leaves out, as text, JSON and an HTML report.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::fit::choices::{Choices, candidates};
use super::recordings::ReadingArguments;
use super::watch::{watched, watched_force_balance};
use super::{Failure, interrupt, output, recordings};
use crate::diagnose::{DiagnoseOptions, report};
use crate::model::preset::Preset;

/// Time that the diagnosis of a usual set may take: what a person waits for an answer.
const USUAL_BUDGET: Duration = Duration::from_secs(60);
/// Rows of such a set: nine recordings of 5,000.
const USUAL_ROWS: f64 = 45_000.0;

/// Arguments of the command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Recordings to diagnose (CSV); without --held-out the last third of each is held out
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Device: paper, paper-as-printed, oscillator, faller, bouncing-ball, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Held-out recording, used to check the answer; repeatable
    #[arg(long, value_name = "FILE")]
    held_out: Vec<PathBuf>,
    #[command(flatten)]
    choices: Choices,
    /// Effects that are compared, e.g. quadratic_drag,dry_friction; by default all of the catalogue
    #[arg(long, value_delimiter = ',', value_name = "ID,...")]
    candidates: Vec<String>,
    #[command(flatten)]
    reading: ReadingArguments,
    /// One stage alone: force-balance finds the forces that act on the measured motion in flight, without simulating
    #[arg(long, value_name = "STAGE", conflicts_with = "report")]
    only: Option<Stage>,
    /// File for the answer as JSON; - for standard output, then without the summary
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
    /// File for a report with figures (HTML, one file); - for standard output, then without the summary
    #[arg(long, value_name = "F.html")]
    report: Option<PathBuf>,
}

/// A stage that can be asked for alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Stage {
    ForceBalance,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] with the exit code.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let preset = Preset::load(&args.preset)?;
    let budget = args.choices.time()?;
    let mut options = DiagnoseOptions {
        candidates: candidates(&args.candidates)?,
        choices: args.choices.of(&preset)?,
        ..DiagnoseOptions::default()
    };
    let outputs = [
        ("--json", args.json.as_deref()),
        ("--report", args.report.as_deref()),
    ];
    let inputs = [&args.recordings[..], &args.held_out].concat();
    let mut results = output::ready(&outputs, &inputs)?;
    let split = args.held_out.is_empty();
    let (train, held_out) =
        recordings::both_sides(&args.recordings, &args.held_out, &args.reading)?;
    let rows = train.iter().chain(&held_out).map(|part| part.samples.len());
    options.budget = budget.or(Some(usual_budget(rows.sum())));
    if args.only == Some(Stage::ForceBalance) {
        let found = watched_force_balance(&preset.model, (&train, &held_out), &options)?;
        if let Some(path) = &args.json {
            results.add_json(path, &report::force_balance::json(found.as_ref()));
        }
        results.say(&report::force_balance::text(found.as_ref()));
        results.end()?;
        return Ok(());
    }
    let mut answer = watched(&preset.model, (&train, &held_out), &options)?;
    if split {
        answer
            .remarks
            .insert(0, crate::diagnose::findings::Remark::LastThirdHeldOut);
    }
    if let Some(path) = &args.report {
        results.add(path, report::html(&answer));
    }
    if let Some(path) = &args.json {
        results.add_json(path, &report::json(&answer));
    }
    results.say(&report::text(&answer));
    results.end()?;
    // An answer that came in its time is one, whatever was not asked.
    if answer.cancelled && interrupt::stopped() {
        return Err(interrupt::cancelled());
    }
    Ok(())
}

/// Time that a diagnosis of so many rows may take.
fn usual_budget(rows: usize) -> Duration {
    USUAL_BUDGET.mul_f64(f64::max(1.0, rows as f64 / USUAL_ROWS))
}

#[cfg(test)]
mod tests {
    use super::super::diagnose::*;
    use clap::Parser;
    use std::path::Path;

    #[derive(Debug, Parser)]
    struct Only {
        #[command(flatten)]
        arguments: Arguments,
    }

    #[test]
    fn files_go_to_their_options() {
        let line = "diagnose a.csv b.csv --held-out c.csv --held-out d.csv --report r.html";
        let args = Only::try_parse_from(line.split(' ')).unwrap().arguments;
        assert_eq!(args.recordings.len(), 2);
        assert_eq!(args.held_out.len(), 2);
        assert_eq!(args.preset, "paper");
        assert_eq!(args.report.as_deref(), Some(Path::new("r.html")));
        assert!(Only::try_parse_from(["diagnose"]).is_err());
        let line = "diagnose a.csv --fix f1 --known g=9.81+-0.05 --candidates gravity,dry_friction --budget 5";
        let args = Only::try_parse_from(line.split(' ')).unwrap().arguments;
        assert_eq!(args.candidates, ["gravity", "dry_friction"]);
        assert_eq!(args.choices.known, ["g=9.81+-0.05"]);
        assert_eq!(args.choices.budget.as_deref(), Some("5"));
        let only = |stage: &str| Only::try_parse_from(["diagnose", "a.csv", "--only", stage]);
        let stage = only("force-balance").unwrap().arguments.only;
        assert_eq!(stage, Some(Stage::ForceBalance));
        assert!(only("everything").is_err());
        assert_eq!(usual_budget(100), USUAL_BUDGET);
        assert_eq!(usual_budget(90_000), 2 * USUAL_BUDGET);
    }
}
