//! How trials are made.

use serde::{Deserialize, Serialize};

use crate::trial::instrument::StructureKind;
use crate::trial::truth::Class;

/// What trials are drawn from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mix {
    /// A quarter nothing, half one effect, the rest two or outside the catalogue.
    Standard,
    /// Always this class.
    Only(Class),
    /// Always this one effect.
    Effect(String),
}

/// Which rig a trial uses.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RigChoice {
    /// An actuator with the structure, the noise and the rate of the settings, and clocks that
    /// run alike: the rig of the first trials, whose seeds it keeps.
    OfSettings,
    /// The rig of this name.
    Named(String),
    /// One rig after the other, by the seed.
    Each,
}

/// How trials are made.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The rig; the next four count for [`RigChoice::OfSettings`] alone.
    pub rig: RigChoice,
    /// The kind of device; drawn if `None`.
    pub structure: Option<StructureKind>,
    /// Whether the cantilever is read together with the proof mass.
    pub cantilever: bool,
    /// Rms of the noise \[m\].
    pub noise: f64,
    /// Samples per second.
    pub rate: f64,
    /// What is concealed.
    pub mix: Mix,
    /// Sizes of what is concealed over the smallest visible, drawn evenly in the logarithm. `None`:
    /// 0.5 to 30 for one effect, 3 to 30 for two and for what is outside the catalogue.
    pub sizes: Option<(f64, f64)>,
    /// Effects of actuators keep the size that they have on real devices, in place of one around the
    /// smallest visible.
    pub realistic: bool,
}

/// Sizes of the trials of rigs: from just visible to 30 times larger.
pub const RIG_SIZES: (f64, f64) = (1.0, 30.0);

impl Default for Settings {
    fn default() -> Self {
        Self {
            rig: RigChoice::OfSettings,
            structure: Some(StructureKind::Lumped),
            cantilever: true,
            noise: 20e-9,
            rate: 50e3,
            mix: Mix::Standard,
            sizes: None,
            realistic: false,
        }
    }
}

impl Settings {
    /// The rig of that name, sizes from 1 to 30 times the smallest visible.
    #[must_use]
    pub fn of_rig(name: &str) -> Self {
        Self {
            rig: RigChoice::Named(name.to_owned()),
            sizes: Some(RIG_SIZES),
            ..Self::default()
        }
    }
}
