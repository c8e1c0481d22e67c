//! Devices and drives from command-line options: `--set`, `--effect`, `--drive`.

use std::path::PathBuf;

use anyhow::{Context, bail};

use super::{Failure, terminal, wrong_command};
use crate::explore::waveform::{WaveformError, file_and_fields, read_drive_file};
use crate::model::drive::{DriveReading, Waveform};
use crate::model::effects::ActiveEffect;
use crate::model::piezo::MEASURED_VOLTAGE;
use crate::model::preset::Preset;
use crate::model::unit::{counted, format_quantity, parse_quantity};
use crate::model::{Model, effects};
use crate::recording::import::import_voltage;
use crate::recording::measured_drive::drive_of_samples;

/// Factor outside its slider's range from which a value is odd.
const ODD_VALUE_FACTOR: f64 = 10.0;

/// The file of a drive and how it is read, if the drive is one.
fn drive_file(text: &str) -> Option<(&str, DriveReading)> {
    let measured = text
        .strip_prefix("table:")
        .map(|file| (file, DriveReading::Recognised));
    let points = || {
        text.strip_prefix("points:")
            .map(|file| (file, DriveReading::PointByPoint))
    };
    measured.or_else(points)
}

/// The file that a drive is read from, if it is one.
pub fn drive_input(text: &str) -> Option<PathBuf> {
    let drawn = || {
        text.strip_prefix("handles:")
            .map(|rest| file_and_fields(rest).0)
    };
    let file = drive_file(text).map(|(file, _)| file).or_else(drawn);
    file.map(PathBuf::from)
}

/// A drive as on the command line, files included. How a file was read is said.
pub fn read_drive(text: &str, duration: f64) -> Result<Waveform, Failure> {
    if let Some((file, reading)) = drive_file(text) {
        let (time, voltage) = import_voltage(file.as_ref())?;
        let rows = time.len();
        let drive = drive_of_samples(file, time, voltage, reading)?;
        let Waveform::Table(table) = &drive else {
            return Ok(drive);
        };
        let read = match table.text() {
            Some(text) => format!("read as {text}; points:FILE joins its rows by straight lines"),
            None => format!("{} joined by straight lines", counted(rows, "row")),
        };
        terminal::line(&format!("{file}: {read}"));
        return Ok(drive);
    }
    if let Some(file) = text.strip_prefix("handles:") {
        return read_drive_file(file).map_err(|error| match error {
            WaveformError::Drive(_) => wrong_command(error.into()),
            _ => error.into(),
        });
    }
    if text == "recorded" {
        return Err(wrong_command(anyhow::anyhow!(
            "`recorded` needs a recording; use table:FILE with the recording's file"
        )));
    }
    Waveform::parse(text, duration).map_err(|error| wrong_command(error.into()))
}

/// Applies `id=value`.
pub fn set_parameter(model: &mut Model, text: &str) -> anyhow::Result<()> {
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
pub fn add_effect(model: &mut Model, text: &str) -> anyhow::Result<()> {
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
    // An effect of the preset that is named again takes the new values.
    model.effects.retain(|active| active.spec != spec);
    model.effects.push(effect);
    Ok(())
}

/// Warns on standard error of values far from anything known. The result is still exact, for an
/// unlikely device.
pub fn warn_of_odd_values(preset: &Preset, model: &Model, drive: &Waveform) {
    for (id, value) in model.parameters.iter().filter(|(id, _)| model.uses(*id)) {
        let spec = id.spec();
        let (low, high) = preset.range(id);
        let (below, above) = (
            low.min(ODD_VALUE_FACTOR * low),
            high.max(ODD_VALUE_FACTOR * high),
        );
        let below = if low > 0.0 {
            low / ODD_VALUE_FACTOR
        } else {
            below
        };
        if value != 0.0 && !(below..=above).contains(&value) {
            let text = |value| format_quantity(value, spec.unit, 3);
            terminal::warning(format_args!(
                "{} = {} is far from the usual {} to {}; check its unit",
                spec.id,
                text(value),
                text(low),
                text(high)
            ));
        }
    }
    let volts = drive.amplitude();
    if model.piezo.is_some() && volts > 2.0 * MEASURED_VOLTAGE {
        terminal::warning(format_args!(
            "the drive reaches {}, but the piezo's branches were measured only up to {MEASURED_VOLTAGE} V; the result is an extrapolation",
            format_quantity(volts, "V", 3)
        ));
    }
}
