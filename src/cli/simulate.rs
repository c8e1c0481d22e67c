//! `simulate`: a trace as CSV.

use std::io::Write;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use super::device::{add_effect, read_drive, set_parameter};
use super::output;
use super::{Failure, wrong_command};
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::model::unit::parse_quantity;
use crate::recording::TimeAxis;
use crate::recording::csv::write_csv;
use crate::sim::{self, Options};

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct Arguments {
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

/// Simulates and writes.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    if args.out.is_some() && args.out == args.events {
        return Err(wrong_command(anyhow::anyhow!(
            "--out and --events name the same file; give two"
        )));
    }
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
    let sensor = Sensor::new(&model.parameters);
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
        None => output::to_stdout(write)?,
    }
    if let Some(path) = &args.events {
        crate::recording::events_file::write(path, &trace.events)
            .with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(())
}
