//! What several commands share: how drives, parameters and effects are written.

use std::sync::Arc;

use anyhow::{Context, bail};

use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::effects::{self, ActiveEffect};
use crate::model::unit::parse_quantity;
use crate::recording::csv::import_auto;

/// An error with its exit code.
pub struct Failure {
    /// Exit code.
    pub code: u8,
    /// What went wrong.
    pub error: anyhow::Error,
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
pub fn wrong_command(error: anyhow::Error) -> Failure {
    Failure { code: 2, error }
}

/// A drive as on the command line, files included.
pub fn read_drive(text: &str, duration: f64) -> Result<Waveform, Failure> {
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
    // Named again, an effect of the preset takes the new values.
    model.effects.retain(|active| active.spec != spec);
    model.effects.push(effect);
    Ok(())
}
