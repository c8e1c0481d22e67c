//! `demo`: the main job without a window, on recordings that come with the program.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use clap::Args;

use super::watch::watched;
use super::{Failure, output};
use crate::diagnose::report;
use crate::fit::Part;
use crate::model::preset::Preset;
use crate::recording::csv::import_bytes_auto;

/// A file that comes with the program: name and text.
type File = (&'static str, &'static str);

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../assets/demo/", $name)))),*]
    };
}

const TRAIN: &[File] = files![
    "train-1.csv",
    "train-2.csv",
    "train-3.csv",
    "train-4.csv",
    "train-5.csv",
];
const HELD_OUT: &[File] = files![
    "held-out-1.csv",
    "held-out-2.csv",
    "held-out-3.csv",
    "held-out-4.csv",
];
/// What was put into the recordings.
const TRUTH: &str = include_str!("../../assets/demo/truth.json");

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
    // A folder that cannot be made is said before the work, not after it.
    std::fs::create_dir_all(&args.out).with_context(|| {
        format!(
            "cannot make {}; choose another folder with --out",
            args.out.display()
        )
    })?;
    let say = |text: &str| output::to_stdout(|out| Ok(out.write_all(text.as_bytes())?));
    say(&format!(
        "{} made-up recordings of a device that is not quite the paper's, {} of them kept out.\n\
         The model of the paper is re-tuned to them; what does it leave out?\n\n",
        TRAIN.len() + HELD_OUT.len(),
        HELD_OUT.len()
    ))?;
    let model = Preset::default().model;
    let answer = watched(&model, &read(TRAIN)?, &read(HELD_OUT)?)?;
    say(&report::text(&answer))?;
    say(&format!("\nWhat had been put in: {}\n", put_in()?))?;
    let page = args.out.join("report.html");
    output::text(&page, &report::html(&answer))?;
    output::json(&args.out.join("diagnosis.json"), &report::json(&answer))?;
    say(&format!("The report with figures: {}\n", page.display()))?;
    Ok(())
}

fn read(files: &[File]) -> anyhow::Result<Vec<Part>> {
    let part = |(name, text): &File| {
        let mut recording = import_bytes_auto(name, text.as_bytes())?;
        recording.name = name.trim_end_matches(".csv").to_owned();
        Ok(Part::whole(Arc::new(recording)))
    };
    files.iter().map(part).collect()
}

/// The truth in a few words.
fn put_in() -> anyhow::Result<String> {
    let truth: crate::diagnose::trial::Truth =
        serde_json::from_str(TRUTH).context("the demo's truth cannot be read")?;
    let effects: Vec<String> = truth
        .effects
        .iter()
        .map(|e| {
            let size = e
                .size_nn
                .map_or_else(String::new, |nn| format!(", about {nn:.1} nN"));
            format!("{} ({}{size})", e.id, e.formulation)
        })
        .collect();
    Ok(effects.join(" and "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recordings_can_be_read() {
        let all = [read(TRAIN).unwrap(), read(HELD_OUT).unwrap()].concat();
        assert_eq!(all.len(), 9);
        for part in &all {
            assert!(
                part.recording.warnings.is_empty(),
                "{}",
                part.recording.name
            );
            assert!(part.recording.cantilever.is_some());
            assert!((part.recording.sampling_rate() - 25e3).abs() < 1.0);
        }
        let bytes: usize = TRAIN.iter().chain(HELD_OUT).map(|f| f.1.len()).sum();
        assert!(bytes < 1_500_000, "{bytes}");
        assert!(put_in().unwrap().contains("quadratic_drag"));
    }
}
