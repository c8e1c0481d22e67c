//! What a trial conceals, in an envelope that is sealed with a hash before it is opened.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::instrument::{DeviceParameters, Instruments, StructureKind};
use super::one_mode::apparatus::OneModeDevice;
use super::rescale::UnitFactors;

/// Version of the truth file.
pub const FORMAT: u32 = 2;

/// What kind of answer is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Nothing is concealed but decoys, which cannot be seen.
    Nothing,
    /// One effect of the catalogue.
    One,
    /// Two effects of the catalogue.
    Two,
    /// A law that the catalogue does not have.
    Outside,
}

/// One concealed effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConcealedEffect {
    /// Id in the catalogue, or a name that begins with `outside_`.
    pub id: String,
    /// Which formulation of it the generator used.
    pub formulation: String,
    /// Its size over the smallest visible one (five standard deviations).
    pub times_smallest_visible: f64,
    /// Its largest force \[nN\], where it is a force.
    pub size_nn: Option<f64>,
    /// The law with its parameters, SI.
    pub law: serde_json::Value,
    /// Ids of other effects of the catalogue that say the same: naming one of them is right.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub same_as: Vec<String>,
}

/// The device of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum DeviceTruth {
    /// An impact actuator.
    Actuator(DeviceParameters),
    /// A device with one mode at most.
    OneMode(OneModeDevice),
}

/// One recording of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingNote {
    /// Its name.
    pub name: String,
    /// Its drive.
    pub drive: String,
    /// How long \[s\].
    pub duration: f64,
    /// Whether it is held out.
    pub held_out: bool,
}

/// The truth of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Version of this file.
    pub format: u32,
    /// Seed of the trial.
    pub seed: u64,
    /// Name of the rig; `None` for an actuator with the settings' own numbers.
    #[serde(default)]
    pub rig: Option<String>,
    /// By what lengths, times and masses are multiplied in the recordings and in the preset. All
    /// else here is in the units before.
    #[serde(default)]
    pub units: Option<UnitFactors>,
    /// Kind of answer that is right.
    pub class: Class,
    /// Kind of actuator; `None` for a device with one mode.
    #[serde(default)]
    pub structure: Option<StructureKind>,
    /// The device.
    pub device: DeviceTruth,
    /// The instruments.
    pub instruments: Instruments,
    /// The concealed effects.
    pub effects: Vec<ConcealedEffect>,
    /// What is there and cannot be seen; naming it is a false alarm.
    pub decoys: Vec<ConcealedEffect>,
    /// The recordings.
    pub recordings: Vec<RecordingNote>,
}

impl Truth {
    /// Rms of the noise of a reading \[m\], in the unit of the recordings.
    #[must_use]
    pub fn noise(&self) -> f64 {
        let rounding = self.instruments.reading_step / 12f64.sqrt();
        let length = self.units.map_or(1.0, |units| units.length);
        length * self.instruments.noise.hypot(rounding)
    }

    /// Whether the device is a beam, with more modes than the model.
    #[must_use]
    pub fn is_beam(&self) -> bool {
        self.structure == Some(StructureKind::Beam)
    }
}

/// The sealed truth: its seal can be read by anyone, the truth only when it is opened.
#[derive(Debug, Clone, PartialEq)]
pub struct Envelope {
    text: String,
    seal: String,
    truth: Truth,
}

impl Envelope {
    /// Closes an envelope around the truth.
    ///
    /// # Errors
    /// The error of `serde_json` if a number of the truth cannot be written.
    pub(crate) fn close(truth: Truth) -> Result<Self, serde_json::Error> {
        let text = serde_json::to_string_pretty(&truth)?;
        let seal = Sha256::digest(text.as_bytes())
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        Ok(Self { text, seal, truth })
    }

    /// SHA-256 of the truth file, lower-case hexadecimal; to be shown before the
    /// diagnosis begins.
    #[must_use]
    pub fn seal(&self) -> &str {
        &self.seal
    }

    /// Opens the envelope: the truth and the text of its file, whose hash is the seal.
    #[must_use]
    pub fn open(self) -> (Truth, String) {
        (self.truth, self.text)
    }

    /// The truth.
    pub(crate) fn peek(&self) -> &Truth {
        &self.truth
    }
}
