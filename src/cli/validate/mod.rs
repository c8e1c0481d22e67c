//! `validate`: simulates the cases of Table A.1, compares with both columns of the paper (Table 3),
//! and on request fits to them and ranks missing effects.

pub(super) mod rank_effects;

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

use clap::Args;
use serde::Serialize;

use super::device::{add_effect, set_parameter};
use super::fit::result;
use super::output::Results;
use super::{Failure, interrupt, output, terminal, wrong_command};
use crate::fit::table_a1::calibrate::{
    FREE_PARAMETERS, LeftOut, MAX_GENERATIONS, Misfit, TABLE_LIMITS, TableFit, fit_table,
};
use crate::fit::table_a1::compare::{
    Column, REPRODUCED_MEANS, Row, Statistics, statistics, validate,
};
use crate::fit::table_a1::rank_effects::{EffectRanking, rank_effects};
use crate::model::Model;
use crate::model::preset::Preset;
use crate::model::unit::format_quantity;
use crate::sim::SimError;

/// Lines of progress of a fit: one for each of its searches.
const FIT_PROGRESS_LINES: f64 = 5.0;
/// Lines of progress of the ranking.
const RANKING_PROGRESS_LINES: f64 = 10.0;

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
    /// Fit the device to the experiments first, with leave-one-frequency-out errors (some minutes)
    #[arg(long)]
    fit: bool,
    /// Also rank the effects that could explain what the fit does not reach, and propose a
    /// recording to distinguish them (some more minutes); implies --fit
    #[arg(long)]
    suspects: bool,
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
    /// None, nor statistics, where the fitted device cannot be simulated.
    cases: Vec<CaseJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    statistics: Option<BothColumns>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<FitJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    suspects: Option<EffectRanking>,
}

/// What `--fit` adds. Values in SI.
#[derive(Debug, Serialize)]
struct FitJson {
    parameters: BTreeMap<&'static str, f64>,
    /// `null` unless each frequency was held out.
    std_errors: Option<BTreeMap<&'static str, f64>>,
    cancelled: bool,
    before: Misfit,
    after: Misfit,
    left_out: Vec<LeftOut>,
}

impl FitJson {
    fn new(fit: &TableFit) -> Self {
        let named = |values: Vec<f64>| {
            FREE_PARAMETERS
                .iter()
                .map(|id| id.spec().id)
                .zip(values)
                .collect()
        };
        let values = FREE_PARAMETERS.iter().map(|id| fit.model.parameters[*id]);
        Self {
            parameters: named(values.collect()),
            std_errors: fit.errors().map(named),
            cancelled: fit.cancelled,
            before: fit.before,
            after: fit.after,
            left_out: fit.left_out.clone(),
        }
    }
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
    model.check().map_err(|error| wrong_command(error.into()))?;
    if !(model.has_ground && model.piezo.is_some()) {
        return Err(wrong_command(anyhow::anyhow!(
            "the device {} has no ground or no drive: Table A.1 is about the paper's device; use --preset paper",
            model.name
        )));
    }
    let mut results = output::ready(&[("--json", args.json.as_deref())], &[])?;
    let fitted = (args.fit || args.suspects).then(|| fit(&model));
    if let Some(fit) = &fitted {
        say(&mut results, |out| fit_summary(out, fit))?;
        // A ranking takes long, and what is found already does not wait for it.
        results.deliver();
    }
    let whole = fitted
        .as_ref()
        .filter(|fit| args.suspects && !fit.cancelled);
    let ranking = whole.map(|fit| {
        progress("ranking effects", RANKING_PROGRESS_LINES, |go_on| {
            rank_effects(&model, fit, go_on)
        })
    });
    let rows = validate(fitted.as_ref().map_or(&model, |fit| &fit.model));
    let cancelled = fitted.as_ref().is_some_and(|fit| fit.cancelled)
        || ranking.as_ref().is_some_and(|ranking| ranking.cancelled);
    put_out(results, args.json.as_deref(), fitted, ranking, rows)?;
    if cancelled {
        return Err(interrupt::cancelled());
    }
    Ok(())
}

/// Writes what there is. Where the table itself cannot be simulated, fit and ranking are written
/// before that is said.
fn put_out(
    mut results: Results,
    json: Option<&Path>,
    fitted: Option<TableFit>,
    ranking: Option<EffectRanking>,
    rows: Result<Vec<Row>, SimError>,
) -> Result<(), Failure> {
    match &ranking {
        Some(ranking) => say(&mut results, |out| {
            self::rank_effects::summary(out, ranking)
        })?,
        None if fitted.is_some() => results.say(&format!("{TABLE_LIMITS}\n\n")),
        None => {}
    }
    let (rows, failed) = match rows {
        Ok(rows) => (Some(rows), Ok(())),
        Err(error) => (None, Err(error)),
    };
    let both = rows.as_ref().map(|rows| BothColumns {
        against_paper_simulation: statistics(rows, Column::Paper),
        against_experiment: statistics(rows, Column::Experiment),
    });
    if let (Some(rows), Some(both)) = (&rows, &both) {
        say(&mut results, |out| summary(out, rows, both))?;
    }
    if let Some(path) = json.filter(|_| rows.is_some() || fitted.is_some()) {
        let value = Json {
            cases: rows.iter().flatten().map(case).collect(),
            statistics: both,
            fit: fitted.as_ref().map(FitJson::new),
            suspects: ranking,
        };
        results.add_json(path, &value);
    }
    results.end()?;
    Ok(failed?)
}

/// Takes a text for people into the results.
fn say(
    results: &mut Results,
    write: impl FnOnce(&mut dyn Write) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut text: Vec<u8> = Vec::new();
    write(&mut text)?;
    results.say(&String::from_utf8_lossy(&text));
    Ok(())
}

/// The fit, with its progress.
fn fit(model: &Model) -> TableFit {
    progress("fitting", FIT_PROGRESS_LINES, |go_on| {
        fit_table(model, MAX_GENERATIONS, go_on)
    })
}

/// Long work with its progress on standard error: one line that changes on a terminal, else
/// one for each of so many `parts`.
fn progress<T>(what: &str, parts: f64, work: impl FnOnce(&mut dyn FnMut(f64) -> bool) -> T) -> T {
    let stop = interrupt::flag();
    let started = Instant::now();
    let mut said = None;
    let done = work(&mut |share| {
        let left = started.elapsed().as_secs_f64() * (1.0 - share) / share;
        let line = format!("{what}: {:3.0} %, about {left:.0} s left", 100.0 * share);
        let part = (parts * share).floor() as usize;
        terminal::progress(&line, said.replace(part) != Some(part));
        !stop.load(Ordering::Relaxed)
    });
    terminal::end_of_progress();
    done
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

/// The result of the fit and its limits, for people.
fn fit_summary(out: &mut dyn Write, fit: &TableFit) -> anyhow::Result<()> {
    if fit.cancelled {
        writeln!(out, "Cancelled: this is the best so far.")?;
    }
    writeln!(out, "Fitted to the experiments:")?;
    let errors = fit.errors();
    for (k, id) in FREE_PARAMETERS.into_iter().enumerate() {
        let spec = id.spec();
        let value = format_quantity(fit.model.parameters[id], spec.unit, 4);
        match &errors {
            Some(errors) => {
                let error = result::error(errors[k], spec.unit);
                writeln!(out, "  {:6} {value} +- {error}", spec.id)?;
            }
            None => writeln!(out, "  {:6} {value}", spec.id)?,
        }
    }
    if errors.is_some() {
        writeln!(
            out,
            "(standard errors by leaving out one frequency at a time)"
        )?;
    }
    let line = |m: &Misfit| {
        format!(
            "peaks {:.0} %, contacts {:.0} %, {} of {} within 30 % in both",
            100.0 * m.peak,
            100.0 * m.contact,
            m.both_within_30_percent,
            m.cases
        )
    };
    writeln!(out, "mean absolute errors before: {}", line(&fit.before))?;
    writeln!(out, "mean absolute errors after:  {}", line(&fit.after))?;
    writeln!(out, "At each held-out frequency:")?;
    for left in &fit.left_out {
        writeln!(
            out,
            "  {:3} Hz before: {}",
            left.frequency,
            line(&left.before)
        )?;
        writeln!(out, "         after:  {}", line(&left.after))?;
    }
    let missed: Vec<String> = fit.missed().iter().map(|case| case.name()).collect();
    writeln!(
        out,
        "More than 30 % off in peak or contact: {}.",
        if missed.is_empty() {
            "nothing".to_owned()
        } else {
            missed.join("; ")
        }
    )?;
    if let Some(worse) = fit.made_worse() {
        writeln!(out, "{worse}")?;
    }
    Ok(())
}

/// The table for people.
fn summary(out: &mut dyn Write, rows: &[Row], both: &BothColumns) -> anyhow::Result<()> {
    writeln!(
        out,
        "Table A.1: this simulation | the paper's simulation | experiment. In brackets: error against the experiment,\n(simulated - published) / published; + means the simulation is too high\n"
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
    line("peaks reproduced", &|s| of(s.peak_reproduced, s))?;
    line("contact durations reproduced", &|s| {
        of(s.contact_reproduced, s)
    })?;
    line("cases reproduced", &|s| of(s.reproduced, s))?;
    writeln!(out, "\n{REPRODUCED_MEANS}.")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::validate::*;

    #[test]
    fn a_fit_is_written_though_its_device_cannot_be_simulated() {
        let folder = tempfile::tempdir().unwrap();
        let json = folder.path().join("v.json");
        let model = Preset::default().model;
        // Ended at once: the best so far is the device itself.
        let fitted = fit_table(&model, 1, |_| false);
        let failed = || {
            Err(SimError::Options {
                what: "duration",
                reason: "made up".to_owned(),
            })
        };
        let outputs = [("--json", Some(json.as_path()))];
        let results = output::ready(&outputs, &[]).unwrap();
        let failure = put_out(results, Some(&json), Some(fitted), None, failed()).unwrap_err();
        assert!(failure.error.to_string().contains("made up"));
        assert_eq!(failure.code, 1);
        let text = std::fs::read_to_string(&json).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(value["fit"]["parameters"]["Cs"].is_f64(), "{text}");
        assert!(value.get("statistics").is_none(), "{text}");
        // Without a fit there is nothing to write.
        let other = folder.path().join("other.json");
        let results = output::ready(&[("--json", Some(other.as_path()))], &[]).unwrap();
        put_out(results, Some(&other), None, None, failed()).unwrap_err();
        assert!(!other.exists());
    }
}
