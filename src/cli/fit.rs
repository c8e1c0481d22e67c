//! `fit`: parameters from recordings.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::Context;
use clap::Args;
use serde_json::{Map, Value, json};

use super::device::{add_effect, set_parameter};
use super::{Failure, output, steps, wrong_command};
use crate::fit::{
    Control, FitError, FitOptions, FitResult, Misfit, Part, Progress, fit as run_fit,
};
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::unit::{format_number, format_quantity};
use crate::recording::Recording;
use crate::recording::csv::import_auto;

/// Arguments of the command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Recordings to fit to (CSV); without --held-out the last third of each is kept out
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Device and starting values: paper, paper-as-printed, oscillator, faller, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Parameters to fit, e.g. Cs,gp,eta or quadratic_drag.cd; by default all that are usually tuned
    #[arg(long, value_delimiter = ',', value_name = "ID,...")]
    free: Vec<String>,
    /// Recording to keep out and to measure the fit on; repeatable
    #[arg(long, value_name = "FILE")]
    held_out: Vec<PathBuf>,
    /// Starting value, e.g. Cs=2e-21 or gp="72 um"; repeatable
    #[arg(long, value_name = "ID=VALUE")]
    set: Vec<String>,
    /// Effect to switch on, e.g. quadratic_drag:cd=1e-7; its parameters are fitted too; repeatable
    #[arg(long, value_name = "ID[:PARAMETER=VALUE,...]")]
    effect: Vec<String>,
    /// Further starts drawn at random
    #[arg(long, default_value_t = 0)]
    starts: usize,
    /// Seed of those
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// One step of the paper's identification instead of a whole fit; guide says which the recordings allow
    #[arg(long, value_parser = steps::NAMES, conflicts_with_all = ["out", "held_out"])]
    step: Option<String>,
    /// File for the fitted device (a preset)
    #[arg(long, value_name = "FITTED.toml")]
    out: Option<PathBuf>,
    /// File for the result as JSON; - for standard output
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] with the exit code.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let mut preset = Preset::load(&args.preset)?;
    for text in &args.effect {
        add_effect(&mut preset.model, text).map_err(wrong_command)?;
    }
    for text in &args.set {
        set_parameter(&mut preset.model, text).map_err(wrong_command)?;
    }
    preset
        .model
        .check()
        .map_err(|error| wrong_command(error.into()))?;
    let mut options = FitOptions::for_model(&preset.model);
    if !args.free.is_empty() {
        options.free = args.free.iter().map(|id| id.trim().to_owned()).collect();
    }
    options.starts = args.starts;
    options.seed = args.seed;
    let recordings = read(&args.recordings)?;
    let cancel = AtomicBool::new(false);
    let live = std::io::stderr().is_terminal();
    let progress = |p: &Progress| show_progress(p, live);
    let control = Control {
        cancel: &cancel,
        progress: &progress,
    };
    if let Some(step) = &args.step {
        let bench = steps::Bench {
            model: &preset.model,
            recordings: &recordings,
            options: &options,
            control: &control,
        };
        return Ok(steps::run(step, &bench, args.json.as_deref())?);
    }
    let (train, held_out): (Vec<Part>, Vec<Part>) = if args.held_out.is_empty() {
        recordings.into_iter().map(Part::split).unzip()
    } else {
        let kept = read(&args.held_out)?;
        (
            recordings.into_iter().map(Part::whole).collect(),
            kept.into_iter().map(Part::whole).collect(),
        )
    };
    let result = run_fit(&preset.model, &train, &held_out, &options, &control);
    if live {
        eprint!("\r\x1b[K");
    }
    let result = result.map_err(|error| match error {
        FitError::UnknownParameter { .. } | FitError::Unused { .. } | FitError::NothingFree => {
            wrong_command(error.into())
        }
        other => other.into(),
    })?;
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    if !to_stdout {
        print!("{}", summary(&result));
    }
    if let Some(path) = &args.out {
        preset.model = result.model.clone();
        preset.about = format!("{} (fitted)", preset.about.trim_end_matches(" (fitted)"));
        std::fs::write(path, preset.to_toml())
            .with_context(|| format!("cannot write {}; choose another folder", path.display()))?;
    }
    if let Some(path) = &args.json {
        output::json(path, &as_json(&result))?;
    }
    Ok(())
}

/// Reads recordings as their headers say.
pub(super) fn read(paths: &[PathBuf]) -> Result<Vec<Arc<Recording>>, Failure> {
    let read_one = |path: &PathBuf| {
        let recording = import_auto(path, None)?;
        for warning in &recording.warnings {
            log::warn!("{}: {warning:?}", recording.name);
        }
        Ok(Arc::new(recording))
    };
    paths.iter().map(read_one).collect()
}

fn show_progress(p: &Progress, live: bool) {
    let line = format!(
        "{}: iteration {}, misfit {} x noise, at most {:.0} s left",
        p.stage,
        p.iteration,
        format_number(p.misfit, 3),
        p.remaining.as_secs_f64()
    );
    if live {
        eprint!("\r\x1b[K{line}");
    } else {
        eprintln!("{line}");
    }
}

/// The result as a person reads it.
fn summary(result: &FitResult) -> String {
    let mut text = String::new();
    let mut line = |l: String| {
        text.push_str(&l);
        text.push('\n');
    };
    line(format!(
        "{:<22} {:>16} {:>14} {:>16}",
        "parameter", "value", "std. error", "before"
    ));
    for p in &result.parameters {
        let write = |v: f64, digits| format_quantity(v, p.unit, digits);
        line(format!(
            "{:<22} {:>16} {:>14} {:>16}{}",
            p.id,
            write(p.value, 5),
            if p.std_error.is_finite() {
                write(p.std_error, 2)
            } else {
                "not told".to_owned()
            },
            write(p.start, 4),
            if p.at_bound { "  at its bound" } else { "" }
        ));
    }
    if let Some(film) = film_at_contact(result) {
        line(format!(
            "film damping at contact {}",
            format_quantity(film, "N s/m", 4)
        ));
    }
    for remark in &result.remarks {
        line(format!("note: {remark}"));
    }
    let held_out = result.held_out.as_ref();
    for (title, set) in [("fitted to", Some(&result.train)), ("held out", held_out)] {
        let Some((all, each)) = set else { continue };
        line(format!("{title}: {}", misfit(all)));
        for one in each.iter().filter(|_| each.len() > 1) {
            line(format!("  {}: {}", one.name, misfit(one)));
        }
    }
    text
}

/// `Cs / (gp - dp)^3` where there is a film \[N s/m\].
fn film_at_contact(result: &FitResult) -> Option<f64> {
    let p = &result.model.parameters;
    let thickness = p[ParameterId::Gp] - p[ParameterId::Dp];
    result
        .model
        .has_ground
        .then(|| p[ParameterId::Cs] / thickness.powi(3))
}

fn misfit(m: &Misfit) -> String {
    let aside = if m.set_aside > 0.0 {
        format!(
            "; {:.1} % of the samples lie around events that could not be read",
            100.0 * m.set_aside
        )
    } else {
        String::new()
    };
    format!(
        "rms {} against noise {} (chi2 {}){aside}",
        format_quantity(m.rms, "m", 3),
        format_quantity(m.noise, "m", 3),
        format_number(m.chi2, 3)
    )
}

fn as_json(result: &FitResult) -> Value {
    let mut parameters = Map::new();
    for p in &result.parameters {
        let value = json!({ "value": p.value, "std_error": p.std_error, "unit": p.unit });
        parameters.insert(p.id.clone(), value);
    }
    let of = |m: &Misfit| {
        json!({
            "rms_um": m.rms * 1e6,
            "noise_um": m.noise * 1e6,
            "chi2": m.chi2,
            "set_aside": m.set_aside,
        })
    };
    json!({
        "parameters": parameters,
        "train": of(&result.train.0),
        "held_out": result.held_out.as_ref().map(|h| of(&h.0)),
        "remarks": result.remarks,
    })
}
