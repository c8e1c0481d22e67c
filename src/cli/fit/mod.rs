//! `fit`: parameters from recordings, with a profile of one of them, or one step of the paper's
//! identification.

pub(super) mod choices;
pub(super) mod profile;
pub(super) mod result;
pub(super) mod steps;

use std::path::{Path, PathBuf};
use std::sync::Once;

use anyhow::anyhow;
use clap::Args;

use self::choices::Choices;
use self::profile::Profile;
use super::device::{add_effect, set_parameter};
use super::output::Results;
use super::recordings::ReadingArguments;
use super::{Failure, interrupt, output, recordings, terminal, wrong_command};
use crate::fit::{Control, FitError, FitOptions, Progress, fit as run_fit};
use crate::model::preset::Preset;
use crate::model::unit::{format_number, time_left};

/// Arguments of the command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Recordings to fit to (CSV); without --held-out the last third of each is held out
    #[arg(required = true)]
    recordings: Vec<PathBuf>,
    /// Device and starting values: paper, paper-as-printed, oscillator, faller, bouncing-ball, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    #[command(flatten)]
    choices: Choices,
    /// Not for a fit, which compares no effects: use --effect, or diagnose
    #[arg(long, value_delimiter = ',', value_name = "ID,...", hide = true)]
    candidates: Vec<String>,
    /// Held-out recording: not fitted to, the error on it is reported; repeatable
    #[arg(long, value_name = "FILE")]
    held_out: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingArguments,
    /// Starting value, e.g. Cs=2e-21 or gp="72 um"; repeatable
    #[arg(long, value_name = "ID=VALUE")]
    set: Vec<String>,
    /// Effect to switch on, e.g. quadratic_drag:cd=1e-7; its parameters are fitted too; repeatable
    #[arg(long, value_name = "ID[:PARAMETER=VALUE,...]")]
    effect: Vec<String>,
    /// Number of additional random starts
    #[arg(long, default_value_t = 0)]
    starts: usize,
    /// Seed of the random starts
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// One step of the paper's identification instead of a fit; guide lists the steps that the
    /// recordings allow
    #[arg(long, value_parser = steps::STEP_NAMES, conflicts_with = "held_out")]
    step: Option<String>,
    /// After the fit, hold this parameter at values around the best and refit the others: profile and 95 % interval
    #[arg(long, value_name = "ID", conflicts_with = "step")]
    profile: Option<String>,
    /// File for the fitted device (a preset); with --step the device with the result of the step; -
    /// for standard output, then without the summary
    #[arg(long, value_name = "FITTED.toml")]
    out: Option<PathBuf>,
    /// File for the result as JSON; - for standard output, then without the summary
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] with the exit code.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let (mut preset, options) = device_and_options(args)?;
    let outputs = [
        ("--out", args.out.as_deref()),
        ("--json", args.json.as_deref()),
    ];
    let inputs = [&args.recordings[..], &args.held_out].concat();
    let mut results = output::ready(&outputs, &inputs)?;
    let doubted = Once::new();
    let progress = |p: &Progress| {
        doubted.call_once(|| show_doubts(p));
        show_progress(p);
    };
    // Only from here on: while files are read, Ctrl-C ends the program.
    let control = || Control {
        cancel: interrupt::flag(),
        progress: &progress,
    };
    if let Some(step) = &args.step {
        let recordings = recordings::read(&args.recordings, &args.reading)?;
        let inputs = steps::StepInputs {
            model: &preset.model,
            recordings: &recordings,
            options: &options,
            control: &control(),
        };
        if let Some(found) = steps::run(step, &inputs, args.json.as_deref(), &mut results)? {
            found.apply(&mut preset.model);
        }
        add_device(&mut results, preset, args.out.as_deref());
        return end(results);
    }
    let (train, held_out) =
        recordings::both_sides(&args.recordings, &args.held_out, &args.reading)?;
    let fitted = run_fit(&preset.model, &train, &held_out, &options, &control());
    terminal::end_of_progress();
    let fitted = fitted.map_err(for_the_command_line)?;
    preset.model = fitted.model.clone();
    add_device(&mut results, preset, args.out.as_deref());
    results.say(&result::text(&fitted));
    let mut value = result::as_json(&fitted);
    let mut profiled = Ok(());
    // A cancelled fit is not at its minimum, so it has no profile.
    if let Some(id) = args.profile.as_deref().filter(|_| !fitted.cancelled) {
        // A profile takes long, and what is found already does not wait for it.
        results.deliver();
        let profile = Profile::new(&fitted, &train, id, &options, &control());
        terminal::end_of_progress();
        profiled = profile.map(|profile| {
            results.say(&profile.text());
            value["profile"] = profile.as_json();
        });
    }
    if let Some(path) = &args.json {
        results.add_json(path, &value);
    }
    let ended = end(results);
    profiled?;
    ended
}

/// The device to begin with, and what is asked of the fit.
fn device_and_options(args: &Arguments) -> Result<(Preset, FitOptions), Failure> {
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
    if !args.candidates.is_empty() {
        return Err(wrong_command(anyhow!(
            "--candidates {}: a fit compares no effects; fit with one by --effect {}, or compare by impactscope diagnose --candidates",
            args.candidates.join(","),
            args.candidates[0]
        )));
    }
    let choices = args.choices.of(&preset)?;
    preset.model = choices.start(&preset.model)?;
    let usual = FitOptions::for_model(&preset.model);
    let mut options = FitOptions {
        free: choices.free_ids(usual.free.clone()),
        known: choices.known,
        budget: args.choices.time()?.or(None),
        ..usual
    };
    if let Some(id) = &args.profile
        && !options
            .free
            .iter()
            .any(|free| free.eq_ignore_ascii_case(id))
    {
        return Err(wrong_command(anyhow!(
            "--profile {id}: only a parameter that is fitted has a profile; there are {}",
            options.free.join(", ")
        )));
    }
    options.starts = args.starts;
    options.seed = args.seed;
    if let Some(step) = args.step.as_deref().filter(|_| args.out.is_some())
        && !steps::finds_values(step)
    {
        return Err(wrong_command(anyhow!(
            "--step {step} finds no parameter values; omit --out"
        )));
    }
    Ok((preset, options))
}

/// Adds the device to the results, if `--out` is given.
fn add_device(results: &mut Results, mut preset: Preset, out: Option<&Path>) {
    if let Some(path) = out {
        preset.about = format!("{} (fitted)", preset.about.trim_end_matches(" (fitted)"));
        results.add(path, preset.to_toml());
    }
}

/// Writes the results. Cancelled work ends with an error, but only after everything that it found
/// is written.
fn end(results: Results) -> Result<(), Failure> {
    results.end()?;
    if interrupt::stopped() {
        return Err(interrupt::cancelled());
    }
    Ok(())
}

/// The error with a remedy for the command line, where a parameter is locked by not naming it.
fn for_the_command_line(error: FitError) -> Failure {
    match error {
        FitError::IrrelevantParameter { id, device } => wrong_command(anyhow!(
            "{id} has no effect on the device {device}; remove it from --free"
        )),
        FitError::NoContact { parameters, reason } => anyhow!(
            "there is no contact in any of the recordings ({reason}), so that {parameters} cannot be fitted; free only others, for example --free eta,zeta1, or add a recording in which the mass hits the ground"
        )
        .into(),
        FitError::UnknownParameter { .. } | FitError::NothingFree | FitError::NuisanceParameter { .. } => wrong_command(error.into()),
        other => other.into(),
    }
}

/// Prints doubts about the recordings before the first line of progress.
fn show_doubts(p: &Progress) {
    for doubt in p.doubts.iter() {
        terminal::warning(doubt);
    }
}

fn show_progress(p: &Progress) {
    let line = format!(
        "{}: iteration {}, misfit {} x noise{}",
        p.stage,
        p.iteration,
        format_number(p.misfit, 3),
        time_left(p.remaining)
    );
    terminal::progress(&line, true);
}

#[cfg(test)]
mod tests {
    use super::super::fit::*;

    #[cfg(feature = "gui")]
    #[test]
    fn the_window_asks_for_the_same_fit() {
        use crate::app::analysis::fit::{Fitting, inputs};

        let setup = crate::app::files::built_in::setup();
        let (train, held_out, options) = inputs(&setup, Fitting::default().free(&setup));
        let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        let files = ["made-up-paper.csv", "made-up-sweep.csv"].map(|name| assets.join(name));
        let args = Arguments {
            recordings: files.to_vec(),
            preset: "paper".to_owned(),
            choices: Choices::default(),
            candidates: Vec::new(),
            held_out: Vec::new(),
            set: Vec::new(),
            effect: Vec::new(),
            starts: 0,
            seed: 0,
            step: None,
            profile: None,
            out: None,
            json: None,
            reading: ReadingArguments::default(),
        };
        let (preset, asked) = device_and_options(&args).ok().unwrap();
        assert_eq!(preset.model, setup.preset.model);
        assert_eq!(asked, options);
        let (own_train, own_held_out) = recordings::both_sides(&files, &[], &args.reading)
            .ok()
            .unwrap();
        for (own, windows) in [(own_train, train), (own_held_out, held_out)] {
            assert_eq!(own.len(), windows.len());
            for (a, b) in own.iter().zip(&windows) {
                assert_eq!(a.samples, b.samples);
                let (a, b) = (&a.recording, &b.recording);
                assert_eq!((&a.time, &a.voltage), (&b.time, &b.voltage));
                assert_eq!(
                    (&a.proof_mass, &a.cantilever),
                    (&b.proof_mass, &b.cantilever)
                );
            }
        }
    }

    #[test]
    fn messages_speak_of_command_line_options() {
        let unused = FitError::IrrelevantParameter {
            id: "dp".into(),
            device: "oscillator".into(),
        };
        let contact = FitError::NoContact {
            parameters: "dp, gp".into(),
            reason: "the mass never rests".into(),
        };
        for (error, code) in [(unused, 2), (contact, 1)] {
            let failure = for_the_command_line(error);
            let text = failure.error.to_string();
            assert_eq!(failure.code, code);
            assert!(text.contains("--free") && !text.contains("lock"), "{text}");
        }
    }
}
