//! `simulate`: a simulated trace and its events as CSV.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use super::device::{add_effect, drive_input, read_drive, set_parameter, warn_of_odd_values};
use super::{Failure, output, wrong_command};
use crate::model::effects;
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::model::sensor::Sensor;
use crate::model::unit::parse_quantity;
use crate::recording::TimeAxis;
use crate::recording::csv::write_csv;
use crate::recording::events::events_csv;
use crate::sim;
use crate::sim::{Options, SimError};

/// Parameters, effects and waveforms, for `--help`.
fn lists() -> String {
    let mut text = String::from(
        "Drives:\n  rest                    no voltage\n  sine:F:A                starts at 0 and rises\n  square:F:A              starts at +A\n  triangle:F:A\n  ramped:F:A:LAMBDA       a square whose edges take LAMBDA of the period\n  chirp:F0:F1:A           from F0 to F1 over the span\n  table:FILE              CSV with t and V: samples of a recorder as the voltage that\n                          acted, a few points joined by straight lines\n  points:FILE             the same, always straight lines\n  drawn:F:linear:T/V,...  a period drawn by handles: T a share of the period, V volts;\n                          smooth in place of linear joins them without overshoot\n  handles:FILE            the same from the file of a drawn waveform\n  Periodic drives take named fields at their end: offset=1V, phase=90deg, burst=3/5\n  (3 periods of each 5, the rest at the offset), square and ramped duty=30%, triangle\n  asymmetry=70%; handles:FILE also frequency=20Hz and amplitude=4V\n  F such as 15Hz, A such as 8V\n\nParameters for --set (unit; meaning), as far as the device has them:\n",
    );
    for id in ParameterId::ALL {
        let spec = id.spec();
        let unit = if spec.unit.is_empty() { "-" } else { spec.unit };
        text += &format!("  {:<10} {unit:<10} {}\n", spec.id, spec.name);
    }
    text += "\nEffects for --effect, with their parameters:\n";
    for effect in effects::CATALOGUE {
        let parameters: Vec<&str> = effect.parameters.iter().map(|p| p.id).collect();
        text += &format!("  {:<22} {}\n", effect.id, parameters.join(", "));
    }
    text
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = lists())]
pub struct Arguments {
    /// Device: paper, paper-as-printed, oscillator, faller, bouncing-ball, or a preset file
    #[arg(long, default_value = "paper")]
    preset: String,
    /// Drive: rest, sine|square|triangle:F:A, ramped:F:A:LAMBDA, chirp:F0:F1:A, table:FILE or points:FILE (CSV with t and V), handles:FILE; the list is below
    #[arg(long, allow_hyphen_values = true)]
    drive: Option<String>,
    /// Span, e.g. 0.4 or 400ms
    #[arg(long, allow_hyphen_values = true)]
    duration: Option<String>,
    /// Samples per second, e.g. 50kHz
    #[arg(long, default_value = "50kHz", allow_hyphen_values = true)]
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
    /// File for the trace; - or nothing for standard output
    #[arg(long, value_name = "TRACE.csv")]
    out: Option<PathBuf>,
    /// File for the list of events (CSV); - for standard output, then the trace needs a file
    #[arg(long, value_name = "EVENTS.csv")]
    events: Option<PathBuf>,
}

/// Simulates and writes.
pub fn run(args: &Arguments) -> Result<(), Failure> {
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
    let drive = args.drive.as_deref().unwrap_or(&preset.drive);
    let table = drive_input(drive);
    let (trace_option, trace_file) = match args.out.as_deref() {
        Some(path) => ("--out", path),
        None => ("the trace (without --out)", Path::new(output::STDOUT)),
    };
    let outputs = [
        (trace_option, Some(trace_file)),
        ("--events", args.events.as_deref()),
    ];
    let mut results = output::ready(&outputs, table.as_slice())?;
    let drive = read_drive(drive, duration)?;
    let mut model = preset.model.clone();
    for text in &args.set {
        set_parameter(&mut model, text).map_err(wrong_command)?;
    }
    for text in &args.effect {
        add_effect(&mut model, text).map_err(wrong_command)?;
    }
    warn_of_odd_values(&preset, &model, &drive);
    let simulated = sim::simulate(&model, &drive, duration, &options);
    let mut trace = simulated.map_err(|error| match error {
        // Wrong values on the command line are errors of the command, not of the work.
        SimError::Model(_) | SimError::Drive(_) | SimError::Options { .. } => {
            wrong_command(error.into())
        }
        error => error.into(),
    })?;
    let sensor = Sensor::new(&model.parameters);
    if sensor.noise > 0.0 {
        sensor.add_noise(&mut trace.proof_mass, args.seed);
        // The channels' noises are independent: the second has its own seed.
        sensor.add_noise(&mut trace.cantilever, args.seed ^ 0x9e37_79b9_7f4a_7c15);
    }
    let axis = TimeAxis::Samples(&trace.times());
    let cantilever = (!trace.cantilever.is_empty()).then_some(trace.cantilever.as_slice());
    let write = |out: &mut dyn Write| -> anyhow::Result<()> {
        Ok(write_csv(
            out,
            axis,
            Some(&trace.voltage),
            &trace.proof_mass,
            cantilever,
        )?)
    };
    if let Some(path) = &args.events {
        results.add(path, events_csv::text(&trace.events));
    }
    results.stream(trace_file, write);
    results.end()
}
