//! The command line. Progress goes to stderr, results to stdout or files; the exit
//! code is 0 when done, 1 when the work failed, 2 when the command was wrong.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::{Args, Parser, Subcommand};

use crate::app;
use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::effects::{self, ActiveEffect};
use crate::model::preset::Preset;
use crate::model::unit::parse_quantity;
use crate::recording::TimeAxis;
use crate::recording::csv::{import_auto, write_csv};
use crate::sim::{self, Options};

/// Impact dynamics of piezoelectric micro-cantilevers: simulation live over recordings.
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    window: WindowArgs,
}

#[derive(Debug, Args)]
struct WindowArgs {
    /// Recordings (CSV), presets (.toml) or a session (.impactscope.toml) to open
    files: Vec<PathBuf>,
    /// Preset to open: paper, paper-as-printed, oscillator, faller, or a file
    #[arg(long)]
    preset: Option<String>,
    /// Workspace to open
    #[arg(long, value_parser = app::workspaces::NAMES)]
    workspace: Option<String>,
    /// Save a picture of the settled window (PNG) and exit
    #[arg(long, value_name = "OUT.png")]
    screenshot: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a device and write the trace as CSV
    Simulate(SimulateArgs),
}

#[derive(Debug, Args)]
struct SimulateArgs {
    /// Device: paper, paper-as-printed, oscillator, faller, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Drive: rest, sine|square|triangle:F:A, ramped:F:A:LAMBDA, chirp:F0:F1:A, or table:FILE (CSV with t and V)
    #[arg(long)]
    drive: Option<String>,
    /// Span, e.g. 0.4 or 400ms
    #[arg(long)]
    duration: Option<String>,
    /// Samples per second, e.g. 50kHz
    #[arg(long, default_value = "50kHz")]
    rate: String,
    /// Parameter to change, e.g. Cs=2e-21 or gp="72 um"; repeatable
    #[arg(long, value_name = "ID=VALUE")]
    set: Vec<String>,
    /// Effect to switch on, e.g. quadratic_drag:cd=1e-7; repeatable
    #[arg(long, value_name = "ID[:PARAMETER=VALUE,...]")]
    effect: Vec<String>,
    /// Seed of the sensor noise (parameter `noise`)
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// File for the trace; standard output without it
    #[arg(long, value_name = "TRACE.csv")]
    out: Option<PathBuf>,
    /// File for the list of events (CSV)
    #[arg(long, value_name = "EVENTS.csv")]
    events: Option<PathBuf>,
}

/// Runs the program.
pub fn main() -> ExitCode {
    // clap exits with 2 by itself where the command is wrong.
    let cli = Cli::parse();
    let result = match cli.command {
        Some(Command::Simulate(args)) => simulate(&args),
        None => app::run(app::WindowOptions {
            files: cli.window.files,
            preset: cli.window.preset,
            workspace: cli.window.workspace,
            screenshot: cli.window.screenshot,
        })
        .map_err(Failure::from),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("impactscope: {:#}", failure.error);
            ExitCode::from(failure.code)
        }
    }
}

/// An error with its exit code.
struct Failure {
    code: u8,
    error: anyhow::Error,
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self {
            code: 1,
            error: error.into(),
        }
    }
}

/// Marks an error as one of the command itself.
fn wrong_command(error: anyhow::Error) -> Failure {
    Failure { code: 2, error }
}

fn simulate(args: &SimulateArgs) -> Result<(), Failure> {
    let preset = Preset::load(&args.preset)?;
    let duration = match &args.duration {
        Some(text) => parse_quantity(text, "s")
            .context("--duration")
            .map_err(wrong_command)?,
        None => preset.duration,
    };
    let options = Options {
        rate: parse_quantity(&args.rate, "Hz")
            .context("--rate")
            .map_err(wrong_command)?,
        ..Options::default()
    };
    let drive = read_drive(args.drive.as_deref().unwrap_or(&preset.drive), duration)?;
    let mut model = preset.model;
    for text in &args.set {
        set_parameter(&mut model, text).map_err(wrong_command)?;
    }
    for text in &args.effect {
        add_effect(&mut model, text).map_err(wrong_command)?;
    }
    let mut trace = sim::simulate(&model, &drive, duration, &options)?;
    let sensor = crate::model::sensor::Sensor::new(&model.parameters);
    if sensor.noise > 0.0 {
        sensor.add_noise(&mut trace.proof_mass, args.seed);
        // The channels' noises are independent: the second has a seed of its own.
        sensor.add_noise(&mut trace.cantilever, args.seed ^ 0x9e37_79b9_7f4a_7c15);
    }
    let axis = TimeAxis::Samples(&trace.times());
    let cantilever = (!trace.cantilever.is_empty()).then_some(trace.cantilever.as_slice());
    let write = |out: &mut dyn Write| -> anyhow::Result<()> {
        write_csv(
            out,
            axis,
            Some(&trace.voltage),
            &trace.proof_mass,
            cantilever,
        )?;
        Ok(out.flush()?)
    };
    match &args.out {
        Some(path) => {
            let file = std::fs::File::create(path).with_context(|| {
                format!("cannot write {}; choose another folder", path.display())
            })?;
            write(&mut std::io::BufWriter::with_capacity(1 << 20, file))
                .with_context(|| format!("writing {}", path.display()))?;
        }
        None => match write(&mut std::io::BufWriter::new(std::io::stdout().lock())) {
            // The reader of a pipe may have had enough.
            Err(error) if is_broken_pipe(&error) => {}
            other => other?,
        },
    }
    if let Some(path) = &args.events {
        crate::recording::events_file::write(path, &trace.events)
            .with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(())
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| {
        cause
            .downcast_ref::<std::io::Error>()
            .is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
    })
}

/// A drive as on the command line, files included.
fn read_drive(text: &str, duration: f64) -> Result<Waveform, Failure> {
    if let Some(file) = text.strip_prefix("table:") {
        let recording = import_auto(file.as_ref(), None)?;
        let Some((time, voltage)) = recording.drive_table() else {
            return Err(anyhow::anyhow!(
                "{file}: there is no voltage column; give a CSV with t and V"
            )
            .into());
        };
        let table = VoltageTable::from_recording(file, time, voltage)?;
        return Ok(Waveform::Table(Arc::new(table)));
    }
    if text == "recorded" {
        return Err(wrong_command(anyhow::anyhow!(
            "`recorded` needs a recording; use table:FILE with the recording's file"
        )));
    }
    Waveform::parse(text, duration).map_err(|error| wrong_command(error.into()))
}

/// Applies `id=value`.
fn set_parameter(model: &mut Model, text: &str) -> anyhow::Result<()> {
    let Some((id, value)) = text.split_once('=') else {
        bail!("--set {text}: write ID=VALUE, for example Cs=2e-21");
    };
    let id = id.trim();
    let unit = model.unit_of(id).unwrap_or("");
    let value = parse_quantity(value, unit).with_context(|| format!("--set {text}"))?;
    model
        .set(id, value)
        .with_context(|| format!("--set {text}"))
}

/// Applies `effect` or `effect:parameter=value,...`.
fn add_effect(model: &mut Model, text: &str) -> anyhow::Result<()> {
    let (id, values) = text.split_once(':').unwrap_or((text, ""));
    let Some(spec) = effects::find(id) else {
        let known: Vec<&str> = effects::CATALOGUE.iter().map(|e| e.id).collect();
        bail!(
            "--effect {text}: there is no effect {id}; there are {}",
            known.join(", ")
        );
    };
    let mut effect = ActiveEffect::new(spec);
    for pair in values.split(',').filter(|pair| !pair.is_empty()) {
        let known = || {
            spec.parameters
                .iter()
                .map(|p| p.id)
                .collect::<Vec<_>>()
                .join(", ")
        };
        let Some((key, value)) = pair.split_once('=') else {
            bail!(
                "--effect {text}: write PARAMETER=VALUE after the colon; {id} has {}",
                known()
            );
        };
        let Some(parameter) = spec.parameters.iter().find(|p| p.id == key.trim()) else {
            bail!(
                "--effect {text}: {id} has no parameter {key}; it has {}",
                known()
            );
        };
        let value =
            parse_quantity(value, parameter.unit).with_context(|| format!("--effect {text}"))?;
        effect.set(parameter.id, value);
    }
    // Named again, an effect of the preset takes the new values.
    model.effects.retain(|active| active.spec != spec);
    model.effects.push(effect);
    Ok(())
}
