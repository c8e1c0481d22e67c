//! Presets: a device with values, in a commented TOML file. Five are built in.

mod error;
mod file;
mod keys;
pub mod known_value;
mod read;
#[cfg(test)]
mod tests;
pub mod toml_fault;

use std::collections::BTreeMap;
use std::path::Path;

pub use self::error::PresetError;

use self::error::Source;
use self::file::{Device, FORMAT, File, ModeEntry, PiezoEntry, Start};
use self::known_value::{KnownValue, device_parameter};
use self::read::{
    read_bounce, read_coordinate, read_effects, read_known, read_modes, read_parameters,
    read_piezo, read_ranges,
};
use self::toml_fault::{TomlFault, short_key};
use super::Model;
use super::drive::Waveform;
use super::ground::{BounceRule, StickSpeed};
use super::parameter::ParameterId;
use super::piezo::Piezo;
use super::unit::Coordinate;

/// The built-in presets: name and text.
pub const EMBEDDED: [(&str, &str); 5] = [
    ("paper", include_str!("../../../presets/paper.toml")),
    (
        "paper-as-printed",
        include_str!("../../../presets/paper-as-printed.toml"),
    ),
    (
        "oscillator",
        include_str!("../../../presets/oscillator.toml"),
    ),
    ("faller", include_str!("../../../presets/faller.toml")),
    (
        "bouncing-ball",
        include_str!("../../../presets/bouncing-ball.toml"),
    ),
];

/// A device with its usual drive and slider ranges.
#[derive(Debug, Clone, PartialEq)]
pub struct Preset {
    /// One line on what it is.
    pub about: String,
    /// Usual drive, as on the command line.
    pub drive: String,
    /// Usual span \[s\].
    pub duration: f64,
    /// The device.
    pub model: Model,
    /// Slider ranges that differ from the table's.
    pub ranges: BTreeMap<ParameterId, (f64, f64)>,
    /// What is known of its parameters beforehand, by id.
    pub known: Vec<KnownValue>,
}

impl Default for Preset {
    fn default() -> Self {
        // The embedded presets are read by a test of their own.
        Self::embedded("paper").unwrap_or_else(|| unreachable!("the paper preset is built in"))
    }
}

impl Preset {
    /// A built-in preset by name.
    pub fn embedded(name: &str) -> Option<Self> {
        let (name, text) = EMBEDDED.iter().find(|(known, _)| *known == name)?;
        Self::parse(name, text).ok()
    }

    /// A built-in preset by name, or a preset file by path.
    ///
    /// # Errors
    /// [`PresetError`] with file, line, key and reason.
    ///
    /// # Examples
    /// ```
    /// use impactscope::model::preset::Preset;
    ///
    /// let mut model = Preset::load("paper")?.model;
    /// model.set("alpha", 0.4)?;
    /// assert_eq!(model.get("alpha"), Some(0.4));
    /// assert!(model.set("alfa", 0.4).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn load(name_or_path: &str) -> Result<Self, PresetError> {
        if let Some(preset) = Self::embedded(name_or_path) {
            return Ok(preset);
        }
        let unreadable = |reason: String| PresetError::Unreadable {
            file: name_or_path.to_owned(),
            reason,
        };
        let bytes = std::fs::read(Path::new(name_or_path))
            .map_err(|error| unreadable(error.to_string()))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| unreadable("this is not text; a preset is a TOML file".to_owned()))?;
        Self::parse(name_or_path, &text)
    }

    /// Reads the text of a preset; `file` is named in errors.
    ///
    /// # Errors
    /// [`PresetError::Invalid`] at the first thing that makes no sense.
    pub fn parse(file: &str, text: &str) -> Result<Self, PresetError> {
        let source = Source { file, text };
        let read: File = toml::from_str(text).map_err(|error| {
            let fault = TomlFault::new(text, &error);
            let line = fault.line;
            let key = text
                .lines()
                .nth(line - 1)
                .and_then(|l| l.split('=').next())
                .map(|l| l.trim().to_owned())
                .unwrap_or_default();
            // A misspelt key is the likely cause of one that is missing.
            if error.message().starts_with("missing field")
                && let Some((section, nth, key, known)) = keys::unknown(text)
            {
                let reason = format!(
                    "there is no such key here; there are {}. Also: {}",
                    known.join(", "),
                    error.message()
                );
                return source.invalid(&section, nth, &key, reason);
            }
            PresetError::Invalid {
                file: file.to_owned(),
                line,
                key: short_key(&key),
                reason: fault.reason,
            }
        })?;
        if read.format != FORMAT {
            let reason = format!(
                "format {} is not known; this program reads {FORMAT}",
                read.format
            );
            return Err(source.invalid("", 0, "format", reason));
        }
        let mut modes = read_modes(&source, &read)?;
        let parameters = read_parameters(&source, &read, &modes)?;
        for (mode, (frequency, zeta)) in modes.iter_mut().zip(super::MODE_PARAMETERS) {
            mode.frequency = parameters[frequency];
            mode.zeta = parameters[zeta];
        }
        let model = Model {
            name: read.name.clone(),
            parameters,
            modes,
            proof_mass: read.device.proof_mass,
            piezo: read_piezo(&source, &read)?,
            coordinate: read_coordinate(&source, &read)?,
            has_ground: read.device.ground,
            bounce: read_bounce(&source, &read)?,
            has_cantilever: read.device.cantilever,
            effects: read_effects(&source, &read)?,
        };
        model.check().map_err(|error| {
            let section = match error.parameter.as_str() {
                "proof_mass" | "stick_speed" | "adhesion_reach" => "device",
                _ => "parameters",
            };
            source.invalid(section, 0, &error.parameter, error.reason)
        })?;
        let duration = read.start.duration;
        if !(duration > 0.0 && duration <= 1e6) {
            let reason = format!("the span must lie between 0 and 1e6 s, not {duration}");
            return Err(source.invalid("start", 0, "duration", reason));
        }
        Waveform::parse(&read.start.drive, duration)
            .map_err(|error| source.invalid("start", 0, "drive", error.to_string()))?;
        Ok(Self {
            about: read.about.clone(),
            drive: read.start.drive.clone(),
            duration,
            ranges: read_ranges(&source, &read)?,
            known: read_known(&source, &read, &model)?,
            model,
        })
    }

    /// The preset as a TOML text that [`Preset::parse`] reads.
    pub fn to_toml(&self) -> String {
        let model = &self.model;
        let file = File {
            format: FORMAT,
            name: model.name.clone(),
            about: self.about.clone(),
            start: Start {
                drive: self.drive.clone(),
                duration: self.duration,
            },
            device: device_entry(model),
            piezo: model.piezo.as_ref().map(piezo_entry),
            parameters: model
                .parameters
                .iter()
                .filter(|(id, _)| model.uses(*id))
                .map(|(id, value)| (id.spec().id.to_owned(), value))
                .collect(),
            ranges: self
                .ranges
                .iter()
                .map(|(id, range)| (id.spec().id.to_owned(), *range))
                .collect(),
            // Of an effect that is off now nothing is known: the text could not be read again.
            known: self
                .known
                .iter()
                .filter(|known| device_parameter(model, &known.id).is_ok())
                .map(|known| (known.id.clone(), (known.value, known.std_error)))
                .collect(),
            effects: model
                .effects
                .iter()
                .map(|effect| {
                    let values = effect.spec.parameters.iter().zip(&effect.values);
                    (
                        effect.spec.id.to_owned(),
                        values.map(|(p, v)| (p.id.to_owned(), *v)).collect(),
                    )
                })
                .collect(),
            mode: model
                .modes
                .iter()
                .enumerate()
                .map(|(i, mode)| ModeEntry {
                    frequency: (i >= 2).then_some(mode.frequency),
                    zeta: (i >= 2).then_some(mode.zeta),
                    phi_c: Some(mode.phi_c),
                    phi_p: Some(mode.phi_p),
                    phi_drive: Some(mode.phi_drive),
                    mass: None,
                    stiffness: None,
                })
                .collect(),
        };
        // All map keys are strings and all values finite, which TOML can always hold.
        toml::to_string(&file).unwrap_or_default()
    }

    /// Slider range of a parameter for this device.
    pub fn range(&self, id: ParameterId) -> (f64, f64) {
        self.ranges.get(&id).copied().unwrap_or(id.spec().range)
    }
}

/// The section on the drive.
fn piezo_entry(piezo: &Piezo) -> PiezoEntry {
    if !piezo.has_hysteresis() {
        return PiezoEntry {
            gain: Some(piezo.rising.to_vec()),
            ..PiezoEntry::default()
        };
    }
    PiezoEntry {
        gain: None,
        rising: Some(piezo.rising.to_vec()),
        falling: Some(piezo.falling.to_vec()),
    }
}

/// The section on the device.
fn device_entry(model: &Model) -> Device {
    let (bounce, stick_speed, adhesion_reach) = match model.bounce {
        BounceRule::Restitution(stick) if model.has_ground => {
            let (speed, reach) = match stick {
                StickSpeed::Given(speed) => (Some(speed), None),
                StickSpeed::AdhesionOver(reach) => (None, Some(reach)),
            };
            (Some("restitution".to_owned()), speed, reach)
        }
        _ => (None, None, None),
    };
    Device {
        proof_mass: model.proof_mass,
        ground: model.has_ground,
        cantilever: model.has_cantilever,
        coordinate: (model.coordinate != Coordinate::Length)
            .then(|| model.coordinate.id().to_owned()),
        bounce,
        stick_speed,
        adhesion_reach,
    }
}
