//! `validate`: Table A.1 and Table 3 of the paper.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::device::{add_effect, set_parameter};
use super::{Failure, output, wrong_command};
use crate::fit::validate::{Column, Row, Statistics, statistics, validate};
use crate::model::preset::Preset;

/// Arguments of `validate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Device: paper, paper-as-printed, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Parameter to change, e.g. zeta1=0.1; repeatable
    #[arg(long, value_name = "ID=VALUE")]
    set: Vec<String>,
    /// Effect to switch on, e.g. quadratic_drag:cd=1e-7; repeatable
    #[arg(long, value_name = "ID[:PARAMETER=VALUE,...]")]
    effect: Vec<String>,
    /// File for the results as JSON; - for standard output, then without the table
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Serialize)]
struct CaseJson {
    f_hz: f64,
    v: f64,
    signal: &'static str,
    bounces: Option<f64>,
    peak_um: Option<f64>,
    contact_ms: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Json {
    cases: Vec<CaseJson>,
    statistics: BothColumns,
}

/// Table 3 against both columns.
#[derive(Debug, Serialize)]
struct BothColumns {
    against_paper_simulation: Statistics,
    against_experiment: Statistics,
}

/// Validates and writes.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let mut model = Preset::load(&args.preset)?.model;
    for text in &args.set {
        set_parameter(&mut model, text).map_err(wrong_command)?;
    }
    for text in &args.effect {
        add_effect(&mut model, text).map_err(wrong_command)?;
    }
    if !(model.has_ground && model.piezo.is_some()) {
        return Err(wrong_command(anyhow::anyhow!(
            "the device {} has no ground or no drive: Table A.1 is about the paper's device; use --preset paper",
            model.name
        )));
    }
    let rows = validate(&model)?;
    let both = BothColumns {
        against_paper_simulation: statistics(&rows, Column::Paper),
        against_experiment: statistics(&rows, Column::Experiment),
    };
    let to_stdout = args
        .json
        .as_ref()
        .is_some_and(|path| path.as_os_str() == "-");
    if !to_stdout {
        output::to_stdout(|out| summary(out, &rows, &both))?;
    }
    if let Some(path) = &args.json {
        let cases = rows.iter().map(case).collect();
        output::json(
            path,
            &Json {
                cases,
                statistics: both,
            },
        )?;
    }
    Ok(())
}

fn case(row: &Row) -> CaseJson {
    CaseJson {
        f_hz: row.case.frequency,
        v: row.case.amplitude,
        signal: row.case.signal(),
        bounces: row.model.bounces,
        peak_um: row.model.peak.map(|v| 1e6 * v),
        contact_ms: row.model.contact.map(|v| 1e3 * v),
    }
}

/// The table for people.
fn summary(out: &mut dyn Write, rows: &[Row], both: &BothColumns) -> anyhow::Result<()> {
    writeln!(
        out,
        "Table A.1: now | the paper's simulation | experiment; in brackets the error against the experiment\n"
    )?;
    writeln!(
        out,
        "{:24} {:>18} {:>30} {:>32}",
        "case", "bounces", "peak [um]", "contact [ms]"
    )?;
    for row in rows {
        let errors = row.errors(Column::Experiment);
        let (model, paper, experiment) = (row.model, row.case.simulation, row.case.experiment);
        let number = |value: Option<f64>, scale: f64, digits: usize| {
            value.map_or("-".to_owned(), |v| format!("{:.digits$}", v * scale))
        };
        let percent = |error: Option<f64>| {
            error.map_or("    -".to_owned(), |e| format!("{:+4.0} %", 100.0 * e))
        };
        let triple = |a: Option<f64>, b: Option<f64>, c: Option<f64>, scale, digits| {
            format!(
                "{:>6} |{:>5} |{:>5}",
                number(a, scale, digits),
                number(b, scale, digits.min(1)),
                number(c, scale, digits.min(1)),
            )
        };
        writeln!(
            out,
            "{:24} {:>18} {:>21} ({:>6}) {:>21} ({:>6})",
            row.case.name(),
            triple(model.bounces, paper.bounces, experiment.bounces, 1.0, 1),
            triple(model.peak, paper.peak, experiment.peak, 1e6, 0),
            percent(errors.peak),
            triple(model.contact, paper.contact, experiment.contact, 1e3, 2),
            percent(errors.contact),
        )?;
    }
    writeln!(
        out,
        "\nTable 3{:40} {:>18} {:>12}",
        "", "paper's simulation", "experiment"
    )?;
    let mut line = |name: &str, value: &dyn Fn(&Statistics) -> String| {
        writeln!(
            out,
            "{name:47} {:>18} {:>12}",
            value(&both.against_paper_simulation),
            value(&both.against_experiment)
        )
    };
    let percent = |v: f64| format!("{:.1} %", 100.0 * v);
    let of = |n: usize, s: &Statistics| format!("{n} of {}", s.cases);
    line("bounce existence predicted correctly", &|s| {
        percent(s.bounce_existence)
    })?;
    line("number of bounces correct", &|s| percent(s.bounce_number))?;
    line("mean error in number of bounces", &|s| {
        format!("{:.2}", s.bounce_mean_error)
    })?;
    line("mean error in peak, with sign", &|s| {
        percent(s.peak_mean_error)
    })?;
    line("mean absolute error in peak", &|s| {
        percent(s.peak_mean_absolute_error)
    })?;
    line("peaks within 30 %", &|s| of(s.peak_within_30_percent, s))?;
    line("mean error in contact duration, with sign", &|s| {
        percent(s.contact_mean_error)
    })?;
    line("mean absolute error in contact duration", &|s| {
        percent(s.contact_mean_absolute_error)
    })?;
    line("contact durations within 30 %", &|s| {
        of(s.contact_within_30_percent, s)
    })?;
    line("both within 30 %", &|s| of(s.both_within_30_percent, s))?;
    Ok(())
}
