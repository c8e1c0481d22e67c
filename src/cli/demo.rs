//! `demo`: a whole diagnosis without a window, of recordings that come with the program, with the
//! report and the concealed effect at the end.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use super::watch::watched;
use super::{Failure, interrupt, output};
use crate::diagnose::{DiagnoseOptions, report};
use crate::fit::{ParameterChoices, Part};
use crate::model::preset::Preset;
use crate::trial::demo;

/// Arguments of the command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the report
    #[arg(long, value_name = "DIR", default_value = "impactscope-demo")]
    out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] with the exit code.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    // A folder that cannot be made is reported before the work, not after it.
    std::fs::create_dir_all(&args.out).with_context(|| {
        format!(
            "cannot make {}; choose another folder with --out",
            args.out.display()
        )
    })?;
    let [page, json] = ["report.html", "diagnosis.json"].map(|name| args.out.join(name));
    let mut results = output::ready(&[("--out", Some(&page)), ("--out", Some(&json))], &[])?;
    let put_in = demo::put_in().context("the demo's truth cannot be read")?;
    let recordings = demo::recordings()?;
    let (train, held_out) = (recordings.train.len(), recordings.held_out.len());
    results.say(&format!(
        "{} synthetic recordings of a device that is not quite the paper's, {} of them held out.\n\
         The paper's model is fitted to the others. What does it leave out?\n\n",
        train + held_out,
        held_out
    ));
    results.deliver();
    let preset = Preset::default();
    let options = DiagnoseOptions {
        choices: ParameterChoices::default()
            .resolve(&preset)
            .context("the demo's preset")?,
        ..DiagnoseOptions::default()
    };
    let [train, held_out] = [recordings.train, recordings.held_out]
        .map(|side| side.into_iter().map(Part::whole).collect::<Vec<_>>());
    let answer = watched(&preset.model, (&train, &held_out), &options)?;
    results.add(&page, report::html(&answer));
    results.add_json(&json, &report::json(&answer));
    results.say(&report::text(&answer));
    results.say(&format!("\nThe concealed effect was: {put_in}\n"));
    results.deliver();
    if results.has_written(&page) {
        results.say(&format!("The report with figures: {}\n", page.display()));
    }
    results.end()?;
    if answer.cancelled {
        return Err(interrupt::cancelled());
    }
    Ok(())
}
