//! Periodic drives as they are typed: `square:15Hz:8V:offset=1V:duty=30%:phase=90deg:burst=3/5`,
//! `drawn:15Hz:smooth:0/-8,25%/8`.

use std::fmt;
use std::sync::Arc;

use super::DriveError;
use super::cycle::{Cycle, EVEN_SHARE};
use super::handles::{Handle, Handles, Interpolation};
use super::pattern::Burst;
use super::periodic::PeriodicDrive;
use crate::model::unit::parse_quantity;

/// Powers of ten by which percents are rounded for the text; a share that then reads otherwise is
/// written as it is.
const PERCENT_ROUNDING: f64 = 1e10;

/// Reads the positional fields of a periodic drive; `None` for another name.
pub(super) fn parse_cycle(
    text: &str,
    name: &str,
    fields: &[&str],
) -> Option<Result<PeriodicDrive, DriveError>> {
    let (units, form): (&[&str], &'static str) = match name {
        "sine" => (&["Hz", "V"], "sine:F:A"),
        "square" => (&["Hz", "V"], "square:F:A"),
        "triangle" => (&["Hz", "V"], "triangle:F:A"),
        "ramped" => (&["Hz", "V", ""], "ramped:F:A:LAMBDA"),
        "drawn" => return Some(parse_drawn(text, fields)),
        _ => return None,
    };
    let values = positional(text, fields, units, form);
    Some(values.map(|[frequency, amplitude, lambda]| {
        let cycle = match name {
            "sine" => Cycle::Sine { amplitude },
            "square" => Cycle::Square {
                amplitude,
                duty: EVEN_SHARE,
            },
            "triangle" => Cycle::Triangle {
                amplitude,
                asymmetry: EVEN_SHARE,
            },
            _ => Cycle::Ramped {
                amplitude,
                lambda,
                duty: EVEN_SHARE,
            },
        };
        PeriodicDrive::new(cycle, frequency)
    }))
}

/// Values without a name, up to three; those that are not asked for are 0.
pub(super) fn positional(
    text: &str,
    fields: &[&str],
    units: &[&str],
    form: &'static str,
) -> Result<[f64; 3], DriveError> {
    if fields.len() != units.len() {
        return Err(DriveError::Fields {
            text: text.to_owned(),
            found: fields.len(),
            needed: units.len(),
            form,
        });
    }
    let mut values = [0.0; 3];
    for ((value, field), unit) in values.iter_mut().zip(fields).zip(units) {
        *value = parse_quantity(field, unit).map_err(|source| DriveError::Quantity {
            text: text.to_owned(),
            source,
        })?;
    }
    Ok(values)
}

/// `F:linear:T/V,T/V,...`
fn parse_drawn(text: &str, fields: &[&str]) -> Result<PeriodicDrive, DriveError> {
    let problem = |problem: String| DriveError::Field {
        text: shortened(text),
        problem,
    };
    let [frequency, word, list] = fields else {
        return Err(DriveError::Fields {
            text: shortened(text),
            found: fields.len(),
            needed: 3,
            form: "drawn:F:linear:T/V,T/V...",
        });
    };
    let quantity = |field: &str, unit| {
        parse_quantity(field, unit).map_err(|source| DriveError::Quantity {
            text: shortened(text),
            source,
        })
    };
    let frequency = quantity(frequency, "Hz")?;
    let kinds = [Interpolation::Linear, Interpolation::Smooth];
    let Some(interpolation) = kinds.into_iter().find(|k| k.word() == word.trim()) else {
        return Err(problem(format!(
            "\"{word}\" does not say what leads from handle to handle; write linear or smooth"
        )));
    };
    let mut points = Vec::new();
    for pair in list.split(',') {
        let Some((time, voltage)) = pair.split_once('/') else {
            return Err(problem(format!(
                "\"{pair}\" is not a handle; write its share of the period and its voltage, like 0.25/8V"
            )));
        };
        points.push(Handle {
            time: parse_share(text, time)?,
            voltage: quantity(voltage, "V")?,
        });
    }
    let handles = Handles::new(points, interpolation)?;
    Ok(PeriodicDrive::new(
        Cycle::Drawn(Arc::new(handles)),
        frequency,
    ))
}

/// A long text is named by its beginning.
fn shortened(text: &str) -> String {
    const SHOWN_CHARACTERS: usize = 60;
    match text.char_indices().nth(SHOWN_CHARACTERS) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// A share: `0.3` or `30%`.
fn parse_share(text: &str, field: &str) -> Result<f64, DriveError> {
    let (number, factor) = match field.trim().strip_suffix('%') {
        Some(number) => (number, 100.0),
        None => (field, 1.0),
    };
    let value = parse_quantity(number, "").map_err(|source| DriveError::Quantity {
        text: shortened(text),
        source,
    })?;
    Ok(value / factor)
}

fn share_text(value: f64) -> String {
    let percent = (value * 100.0 * PERCENT_ROUNDING).round() / PERCENT_ROUNDING;
    if percent / 100.0 == value {
        format!("{percent}%")
    } else {
        value.to_string()
    }
}

impl PeriodicDrive {
    /// The same with named fields as they are typed: `offset=1V`, `phase=90deg`, `burst=3/5`,
    /// `duty=30%`, `asymmetry=70%`; `frequency=20Hz` and `amplitude=4V` too, for a drive that
    /// comes from a file. `text` is the whole drive, for messages.
    ///
    /// # Errors
    /// [`DriveError`] if a field is unknown, given twice or not a quantity of its unit. Ranges are
    /// checked by [`PeriodicDrive::waveform`].
    pub fn with_fields(mut self, text: &str, fields: &[&str]) -> Result<Self, DriveError> {
        let mut keys: Vec<&str> = Vec::new();
        for field in fields {
            let (key, value) = field.split_once('=').unwrap_or((field, ""));
            let key = key.trim();
            if keys.contains(&key) {
                return Err(DriveError::Field {
                    text: shortened(text),
                    problem: format!("{key}= is given twice"),
                });
            }
            keys.push(key);
            self.set_field(text, key, value)?;
        }
        Ok(self)
    }

    fn set_field(&mut self, text: &str, key: &str, value: &str) -> Result<(), DriveError> {
        let problem = |problem: String| DriveError::Field {
            text: shortened(text),
            problem,
        };
        let quantity = |unit| {
            parse_quantity(value, unit).map_err(|source| DriveError::Quantity {
                text: shortened(text),
                source,
            })
        };
        match (key, &mut self.cycle) {
            ("offset", _) => self.offset = quantity("V")?,
            ("phase", _) => self.phase = quantity("deg")?,
            ("frequency", _) => self.frequency = quantity("Hz")?,
            ("amplitude", _) => {
                let amplitude = quantity("V")?;
                self.cycle = self.cycle.with_amplitude(amplitude)?;
            }
            ("burst", _) => {
                let numbers = value
                    .split_once('/')
                    .and_then(|(on, of)| Some((on.trim().parse().ok()?, of.trim().parse().ok()?)));
                let Some((on, of)) = numbers else {
                    return Err(problem(format!(
                        "\"{value}\" is no burst; write burst=3/5 for 3 periods of each 5"
                    )));
                };
                self.burst = Some(Burst { on, of });
            }
            ("duty", Cycle::Square { duty, .. } | Cycle::Ramped { duty, .. }) => {
                *duty = parse_share(text, value)?;
            }
            ("asymmetry", Cycle::Triangle { asymmetry, .. }) => {
                *asymmetry = parse_share(text, value)?;
            }
            (_, cycle) => {
                let own = match cycle {
                    Cycle::Square { .. } | Cycle::Ramped { .. } => ", burst= and duty=",
                    Cycle::Triangle { .. } => ", burst= and asymmetry=",
                    Cycle::Sine { .. } | Cycle::Drawn(_) => " and burst=",
                };
                return Err(problem(format!(
                    "there is no {key}= here; {} takes offset=, phase={own}",
                    cycle.name()
                )));
            }
        }
        Ok(())
    }
}

impl fmt::Display for PeriodicDrive {
    /// The form that [`super::Waveform::parse`] reads.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, frequency) = (self.cycle.name(), self.frequency);
        write!(f, "{name}:{frequency}Hz")?;
        match &self.cycle {
            Cycle::Ramped {
                amplitude, lambda, ..
            } => write!(f, ":{amplitude}V:{lambda}")?,
            Cycle::Drawn(handles) => {
                write!(f, ":{}:", handles.interpolation().word())?;
                for (i, Handle { time, voltage }) in handles.points().iter().enumerate() {
                    let comma = if i == 0 { "" } else { "," };
                    write!(f, "{comma}{time}/{voltage}")?;
                }
            }
            cycle => write!(f, ":{}V", cycle.amplitude())?,
        }
        if self.offset != 0.0 {
            write!(f, ":offset={}V", self.offset)?;
        }
        match self.cycle {
            Cycle::Square { duty, .. } | Cycle::Ramped { duty, .. } if duty != EVEN_SHARE => {
                write!(f, ":duty={}", share_text(duty))?;
            }
            Cycle::Triangle { asymmetry, .. } if asymmetry != EVEN_SHARE => {
                write!(f, ":asymmetry={}", share_text(asymmetry))?;
            }
            _ => {}
        }
        if self.phase != 0.0 {
            write!(f, ":phase={}deg", self.phase)?;
        }
        if let Some(Burst { on, of }) = self.burst {
            write!(f, ":burst={on}/{of}")?;
        }
        Ok(())
    }
}
