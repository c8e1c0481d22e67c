//! Waveforms as they are typed: `square:15Hz:8V`.

use std::fmt;

use super::{DriveError, Waveform};
use crate::model::unit::parse_quantity;

impl Waveform {
    /// Reads the forms of the command line but for files: `square:15Hz:8V`. A chirp
    /// sweeps over `duration` \[s\].
    ///
    /// # Errors
    /// [`DriveError`]; `table:` and `recorded` are [`DriveError::Unknown`] here, as they
    /// need a file.
    pub fn parse(text: &str, duration: f64) -> Result<Self, DriveError> {
        let mut fields = text.trim().split(':');
        let name = fields
            .next()
            .unwrap_or_default()
            .trim()
            .to_ascii_lowercase();
        let fields: Vec<&str> = fields.collect();
        let (units, form): (&[&str], &'static str) = match name.as_str() {
            "rest" => (&[], "rest"),
            "sine" => (&["Hz", "V"], "sine:F:A"),
            "square" => (&["Hz", "V"], "square:F:A"),
            "triangle" => (&["Hz", "V"], "triangle:F:A"),
            "ramped" => (&["Hz", "V", ""], "ramped:F:A:LAMBDA"),
            "chirp" => (&["Hz", "Hz", "V"], "chirp:F0:F1:A"),
            _ => return Err(DriveError::Unknown(text.to_owned())),
        };
        if fields.len() != units.len() {
            return Err(DriveError::Fields {
                text: text.to_owned(),
                found: fields.len(),
                needed: units.len(),
                form,
            });
        }
        let mut values = [0.0; 3];
        for ((value, field), unit) in values.iter_mut().zip(&fields).zip(units) {
            *value = parse_quantity(field, unit).map_err(|source| DriveError::Quantity {
                text: text.to_owned(),
                source,
            })?;
        }
        let [a, b, c] = values;
        let waveform = match name.as_str() {
            "sine" => Waveform::Sine {
                frequency: a,
                amplitude: b,
            },
            "square" => Waveform::Square {
                frequency: a,
                amplitude: b,
            },
            "triangle" => Waveform::Triangle {
                frequency: a,
                amplitude: b,
            },
            "ramped" => Waveform::Ramped {
                frequency: a,
                amplitude: b,
                lambda: c,
            },
            "chirp" => Waveform::Chirp {
                from: a,
                to: b,
                amplitude: c,
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
        }
    }
}
