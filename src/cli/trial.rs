//! `trial`: concealed effects, diagnosed from their recordings alone, then scored.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, anyhow, bail};
use clap::Args;
use serde_json::{Value, json};

use super::output::Results;
use super::watch::watched;
use super::{Failure, interrupt, output, terminal, wrong_command};
use crate::diagnose::{DiagnoseOptions, report};
use crate::fit::{ParameterChoices, Part};
use crate::model::preset::Preset;
use crate::model::unit::{counted, parse_quantity};
use crate::recording::Recording;
use crate::trial::score::{
    Diagnosis, Outcome, Verdict, aggregate, may_also_name, score, score_shuffled,
};
use crate::trial::{
    Case, Class, Mix, RIG_SIZES, RigChoice, Settings, StructureKind, write_case, write_preset,
    write_truth,
};

/// Arguments of the command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Seed of the first trial; further trials use the seeds after it
    #[arg(long)]
    seed: u64,
    /// How many trials
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    count: u64,
    /// Device that the diagnosis of an impact actuator starts from; other devices bring their own
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Device and instruments: both-points, voltage-noise, proof-mass-alone, coarse, walking-zero,
    /// spot-anew, beam, spring, ball, pendulum or rescaled; by default one after the other, by the seed
    #[arg(long, value_name = "NAME", conflicts_with_all = ["noise", "rate", "xp_only", "beam"])]
    rig: Option<String>,
    /// Smallest and largest size of what is concealed, over the smallest visible [default: 1:30]
    #[arg(long, value_name = "A:B")]
    sizes: Option<String>,
    /// Rms of the noise of a plain actuator, the device of earlier trials, in place of a rig [default: 20 nm]
    #[arg(long)]
    noise: Option<String>,
    /// Samples per second of the same [default: 50 kHz]
    #[arg(long)]
    rate: Option<String>,
    /// Record the proof mass of the same alone
    #[arg(long)]
    xp_only: bool,
    /// Use a distributed beam with four modes; naming a further mode is then not wrong
    #[arg(long)]
    beam: bool,
    /// What to conceal: an effect's id, none, one, two, outside, or outside_...; by default a mixture
    #[arg(long, value_name = "ID|none|one|two|outside")]
    conceal: Option<String>,
    /// Conceal effects of the size that they have on a real actuator, not near the smallest visible
    #[arg(long)]
    realistic: bool,
    /// Exchange the voltages between recordings; naming any effect is then wrong
    #[arg(long)]
    shuffle: bool,
    /// Folder for the recordings, the reports and, after the diagnosis, the truth
    #[arg(long, value_name = "DIR")]
    files: Option<PathBuf>,
    /// File for all outcomes as JSON; - for standard output, then without the table
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] with the exit code; also if a trial could not be made or diagnosed.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let settings = settings(args).map_err(wrong_command)?;
    let preset = Preset::load(&args.preset)?;
    let mut results = output::ready(&[("--json", args.json.as_deref())], &[])?;
    let end = args
        .seed
        .checked_add(args.count)
        .ok_or_else(|| wrong_command(anyhow!("--seed {} is too large", args.seed)))?;
    let json_file = args.json.as_deref();
    let mut tally = Tally::default();
    for seed in args.seed..end {
        match Case::draw(seed, &settings) {
            Ok(case) => {
                let seal = format!("seed {seed}: sealed, SHA-256 {}", case.seal());
                say(&mut results, &seal);
                match one(case, &preset, args, seed) {
                    Ok((outcome, note, written)) => {
                        let line = format!("seed {seed}: {}", line(&outcome, &note));
                        say(&mut results, &line);
                        tally.outcomes.push(outcome);
                        tally.cases.push(note);
                        if let Err(error) = written {
                            terminal::line(&format!("seed {seed}: {error:#}"));
                            tally.unwritten += 1;
                        }
                    }
                    // A cancelled diagnosis is not an answer that can be scored.
                    Err(_) if interrupt::stopped() => break,
                    Err(error) => tally.fail(seed, format!("{error:#}")),
                }
            }
            Err(error) if error.is_of_settings() => return Err(wrong_command(error.into())),
            Err(error) => tally.fail(seed, error.to_string()),
        }
        // Many trials take hours: results so far are kept.
        if let Some(path) = json_file
            && results.is_stdout_for_people()
        {
            results.add_json(path, &tally.json(&settings));
            results.deliver();
        }
    }
    if args.count > 1 {
        let table = aggregate(&tally.outcomes).text();
        say(&mut results, &format!("\n{}", table.trim_end()));
    }
    if let Some(path) = json_file {
        results.add_json(path, &tally.json(&settings));
    }
    results.end()?;
    if interrupt::stopped() {
        return Err(interrupt::cancelled());
    }
    tally.end(args.count)
}

/// Says a line at once, on standard error if standard output is taken.
fn say(results: &mut Results, line: &str) {
    if results.is_stdout_for_people() {
        results.say(&format!("{line}\n"));
        results.deliver();
    } else {
        terminal::line(line);
    }
}

/// Trials so far.
#[derive(Default)]
struct Tally {
    outcomes: Vec<Outcome>,
    cases: Vec<Value>,
    failed: Vec<Value>,
    /// Number of trials that were scored, but whose report or truth is not in its file.
    unwritten: usize,
}

impl Tally {
    fn fail(&mut self, seed: u64, error: String) {
        terminal::line(&format!("seed {seed}: {error}"));
        self.failed.push(json!({ "seed": seed, "error": error }));
    }

    /// The error of what failed in `count` trials.
    fn end(&self, count: u64) -> Result<(), Failure> {
        if !self.failed.is_empty() {
            let failed = self.failed.len();
            return Err(anyhow!("{failed} of {count} trials failed").into());
        }
        if self.unwritten > 0 {
            return Err(anyhow!(
                "the report or the truth of {} could not be written; they are scored all the same",
                counted(self.unwritten, "trial")
            )
            .into());
        }
        Ok(())
    }

    fn json(&self, settings: &Settings) -> Value {
        json!({
            "settings": {
                "rig": settings.rig,
                "sizes": settings.sizes,
                "structure": settings.structure,
                "cantilever": settings.cantilever,
                "noise": settings.noise,
                "rate": settings.rate,
                "mix": settings.mix,
                "realistic": settings.realistic,
            },
            "cases": self.cases,
            "failed": self.failed,
            "table": aggregate(&self.outcomes),
        })
    }
}

/// The outcome of a trial, the trial as JSON, and whether its report and its truth were written.
type Scored = (Outcome, Value, anyhow::Result<()>);

/// Diagnoses one case from its recordings alone, then reads its truth and scores the diagnosis.
fn one(case: Case, preset: &Preset, args: &Arguments, seed: u64) -> anyhow::Result<Scored> {
    let own = case.preset().map(str::to_owned);
    let preset = match &own {
        Some(text) => &Preset::parse("the preset of the trial", text)?,
        None => preset,
    };
    let options = DiagnoseOptions {
        choices: ParameterChoices::default().resolve(preset)?,
        ..DiagnoseOptions::default()
    };
    let (mut recordings, envelope) = case.into_parts();
    if args.shuffle {
        recordings = recordings.with_voltages_exchanged()?;
    }
    let folder = args
        .files
        .as_ref()
        .map(|folder| folder.join(format!("seed-{seed}")));
    if let Some(folder) = &folder {
        write_case(folder, &recordings)?;
        if let Some(text) = &own {
            write_preset(&folder.join("preset.toml"), text)?;
        }
    }
    let whole = |list: &[Arc<Recording>]| -> Vec<Part> {
        list.iter().map(|r| Part::whole(Arc::clone(r))).collect()
    };
    let started = Instant::now();
    let (train, held_out) = (whole(&recordings.train), whole(&recordings.held_out));
    let answer = watched(&preset.model, (&train, &held_out), &options)?;
    if answer.cancelled {
        bail!("cancelled");
    }
    let seconds = started.elapsed().as_secs_f64();
    let seal = envelope.seal().to_owned();
    // What could not be written takes nothing from the score.
    let written = folder.map_or(Ok(()), |folder| {
        let report = output::text(&folder.join("report.html"), &report::html(&answer));
        let truth = write_truth(&folder.join("truth.json"), envelope.clone());
        report.and(truth.map_err(Into::into))
    });
    let (truth, text) = envelope.open();
    let may_add = may_also_name(truth.is_beam());
    let said = Diagnosis::from(&answer);
    let scored = if args.shuffle {
        score_shuffled(&truth, &said)
    } else {
        score(&truth, &said, may_add)
    };
    let outcome = Outcome { seconds, ..scored };
    let note = json!({
        "seed": seed,
        "sha256": seal,
        "truth": text,
        "diagnosis": report::json(&answer),
        "outcome": outcome,
        "seconds": seconds,
    });
    Ok((outcome, note, written))
}

/// One trial in a line.
fn line(outcome: &Outcome, note: &Value) -> String {
    let concealed = match outcome.concealed.as_slice() {
        [] => "nothing".to_owned(),
        ids => format!(
            "{} ({:.1} x smallest visible)",
            ids.join(" + "),
            outcome.size
        ),
    };
    let answer = match (outcome.named.as_slice(), outcome.verdict) {
        ([], verdict) => verdict.text().to_owned(),
        (ids, Verdict::PartlyExplained) => format!("{} in part", ids.join(" + ")),
        (ids, _) => ids.join(" + "),
    };
    let rig = outcome
        .rig
        .as_ref()
        .map_or_else(String::new, |rig| format!("{rig}, "));
    let [before, after] = outcome.rms_over_noise;
    let exchanged = if outcome.shuffled {
        " (voltages exchanged)"
    } else {
        ""
    };
    format!(
        "{rig}{}{exchanged}: concealed {concealed}; answer {answer}; held-out error {before:.2} to {after:.2} x noise; {:.1} s",
        outcome.mark.text(),
        note["seconds"].as_f64().unwrap_or(f64::NAN)
    )
}

/// Sizes as typed: `1:30`.
fn sizes(text: &str) -> anyhow::Result<(f64, f64)> {
    let number = |part: &str| part.trim().parse::<f64>().ok();
    text.split_once(':')
        .and_then(|(low, high)| Some((number(low)?, number(high)?)))
        .with_context(|| {
            format!("--sizes {text}: give two numbers, the smaller one first, as 1:30")
        })
}

fn settings(args: &Arguments) -> anyhow::Result<Settings> {
    let quantity = |option: &str, text: &Option<String>, unit: &str, usual: f64| match text {
        Some(text) => parse_quantity(text, unit).with_context(|| format!("{option} {text}")),
        None => Ok(usual),
    };
    let kind = if args.beam {
        StructureKind::Beam
    } else {
        StructureKind::Lumped
    };
    let typed = args.beam || args.xp_only || args.noise.is_some() || args.rate.is_some();
    // Not every rig has a voltage to exchange, or effects of a known size.
    let plain = typed || args.shuffle || args.realistic;
    let rig = match &args.rig {
        Some(name) => RigChoice::Named(name.clone()),
        None if plain => RigChoice::OfSettings,
        None => RigChoice::Each,
    };
    let usual = Settings::default();
    Ok(Settings {
        sizes: match &args.sizes {
            Some(text) => Some(sizes(text)?),
            // A plain actuator keeps the sizes of earlier trials, and with them their seeds.
            None if rig == RigChoice::OfSettings => None,
            None => Some(RIG_SIZES),
        },
        rig,
        structure: Some(kind),
        cantilever: !args.xp_only,
        noise: quantity("--noise", &args.noise, "m", usual.noise)?,
        rate: quantity("--rate", &args.rate, "Hz", usual.rate)?,
        mix: match args.conceal.as_deref() {
            None => Mix::Standard,
            Some("none") => Mix::Only(Class::Nothing),
            Some("one") => Mix::Only(Class::One),
            Some("two") => Mix::Only(Class::Two),
            Some("outside") => Mix::Only(Class::Outside),
            Some("") => bail!("--conceal: name an effect, none, one, two or outside"),
            Some(id) => Mix::Effect(id.to_owned()),
        },
        realistic: args.realistic,
    })
}

#[cfg(test)]
mod tests {
    use super::super::trial::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Only {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn parse(line: &str) -> Result<Arguments, clap::Error> {
        Only::try_parse_from(line.split(' ')).map(|only| only.arguments)
    }

    #[test]
    fn settings_are_read_as_typed() {
        let each = settings(&parse("trial --seed 7").unwrap()).unwrap();
        assert_eq!(each.rig, RigChoice::Each);
        assert_eq!(each.sizes, Some((1.0, 30.0)));
        // A plain actuator is that of earlier trials.
        let plain = settings(&parse("trial --seed 7 --noise 20nm").unwrap()).unwrap();
        assert_eq!(plain, Settings::default());
        for line in ["trial --seed 7 --shuffle", "trial --seed 7 --realistic"] {
            let plain = settings(&parse(line).unwrap()).unwrap();
            assert_eq!(
                (plain.rig, plain.sizes),
                (RigChoice::OfSettings, None),
                "{line}"
            );
        }
        let spring = parse("trial --seed 7 --rig spring --sizes 2:5").unwrap();
        let spring = settings(&spring).unwrap();
        assert_eq!(spring.rig, RigChoice::Named("spring".into()));
        assert_eq!(spring.sizes, Some((2.0, 5.0)));
        let all = "trial --seed 7 --noise 150nm --rate 25kHz --xp-only --beam --conceal gap_step";
        let all = settings(&parse(all).unwrap()).unwrap();
        assert!((all.noise - 150e-9).abs() < 1e-18);
        assert!((all.rate - 25e3).abs() < 1e-9);
        assert!(!all.cantilever);
        assert_eq!(all.structure, Some(StructureKind::Beam));
        assert_eq!(all.mix, Mix::Effect("gap_step".into()));
        let none = parse("trial --seed 7 --conceal none").unwrap();
        assert_eq!(settings(&none).unwrap().mix, Mix::Only(Class::Nothing));
    }

    #[test]
    fn wrong_settings_are_refused() {
        assert!(parse("trial").is_err());
        assert!(parse("trial --seed 7 --count 0").is_err());
        assert!(parse("trial --seed -1").is_err());
        for beside in ["--noise 20nm", "--rate 25kHz", "--xp-only", "--beam"] {
            let line = format!("trial --seed 7 --rig coarse {beside}");
            assert!(parse(&line).is_err(), "{line}");
        }
        for text in ["3", "a:b", "1:", ""] {
            let error = sizes(text).unwrap_err().to_string();
            assert!(
                error.contains("--sizes") && error.contains("1:30"),
                "{error}"
            );
        }
        let metres = parse("trial --seed 7 --noise 3V").unwrap();
        assert!(
            settings(&metres)
                .unwrap_err()
                .to_string()
                .contains("--noise 3V")
        );
    }
}
