//! Waveforms as they are typed: `square:15Hz:8V`.

use std::fmt;

use super::periodic_text::{parse_cycle, positional};
use super::{DriveError, Waveform};

impl Waveform {
    /// Reads the forms of the command line but for files: `square:15Hz:8V`, with named fields
    /// after them: `square:15Hz:8V:duty=30%:offset=1V`. A chirp sweeps over `duration` \[s\].
    ///
    /// # Errors
    /// [`DriveError`]; `table:`, `handles:` and `recorded` are [`DriveError::Unknown`] here, as
    /// they need a file.
    pub fn parse(text: &str, duration: f64) -> Result<Self, DriveError> {
        let mut fields = text.trim().split(':');
        let name = fields
            .next()
            .unwrap_or_default()
            .trim()
            .to_ascii_lowercase();
        let fields: Vec<&str> = fields.collect();
        let first_named = fields.iter().position(|field| field.contains('='));
        let (fields, named) = fields.split_at(first_named.unwrap_or(fields.len()));
        if let Some(late) = named.iter().find(|field| !field.contains('=')) {
            return Err(DriveError::Field {
                text: text.to_owned(),
                problem: format!(
                    "\"{late}\" comes after a named field; write the values without a name first"
                ),
            });
        }
        if let Some(drive) = parse_cycle(text, &name, fields) {
            if let Some(set) = named.iter().find(|field| {
                let key = field.split('=').next().unwrap_or_default().trim();
                matches!(key, "frequency" | "amplitude")
            }) {
                return Err(DriveError::Field {
                    text: text.to_owned(),
                    problem: format!("\"{set}\" is set by the values without a name already"),
                });
            }
            return drive?.with_fields(text, named)?.waveform();
        }
        let units: (&[&str], &'static str) = match name.as_str() {
            "rest" => (&[], "rest"),
            "chirp" => (&["Hz", "Hz", "V"], "chirp:F0:F1:A"),
            _ => return Err(DriveError::Unknown(text.to_owned())),
        };
        if let Some(field) = named.first() {
            return Err(DriveError::Field {
                text: text.to_owned(),
                problem: format!("{name} takes no named fields like \"{field}\""),
            });
        }
        let [from, to, amplitude] = positional(text, fields, units.0, units.1)?;
        let waveform = match name.as_str() {
            "chirp" => Waveform::Chirp {
                from,
                to,
                amplitude,
                duration,
            },
            _ => Waveform::Rest,
        };
        waveform.check()?;
        Ok(waveform)
    }
}

impl fmt::Display for Waveform {
    /// The form that [`Waveform::parse`] reads, and `table:NAME`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Waveform::Rest => write!(f, "rest"),
            Waveform::Sine {
                frequency,
                amplitude,
            } => write!(f, "sine:{frequency}Hz:{amplitude}V"),
            Waveform::Square {
                frequency,
                amplitude,
            } => write!(f, "square:{frequency}Hz:{amplitude}V"),
            Waveform::Triangle {
                frequency,
                amplitude,
            } => write!(f, "triangle:{frequency}Hz:{amplitude}V"),
            Waveform::Ramped {
                frequency,
                amplitude,
                lambda,
            } => write!(f, "ramped:{frequency}Hz:{amplitude}V:{lambda}"),
            Waveform::Chirp {
                from,
                to,
                amplitude,
                ..
            } => write!(f, "chirp:{from}Hz:{to}Hz:{amplitude}V"),
            Waveform::Table(table) => write!(f, "table:{}", table.name),
            Waveform::Periodic(periodic) => write!(f, "{}", periodic.drive()),
        }
    }
}
