//! The preset file as TOML has it: sections and keys, not yet checked.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Version of the preset format that is written.
pub(super) const FORMAT: u32 = 1;

/// The file as written; checked and turned into a [`super::Preset`] afterwards.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) format: u32,
    pub(super) name: String,
    #[serde(default)]
    pub(super) about: String,
    pub(super) start: Start,
    pub(super) device: Device,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) piezo: Option<PiezoEntry>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, f64>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) ranges: BTreeMap<String, (f64, f64)>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) known: BTreeMap<String, (f64, f64)>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) effects: BTreeMap<String, BTreeMap<String, f64>>,
    pub(super) mode: Vec<ModeEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Start {
    pub(super) drive: String,
    pub(super) duration: f64,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Device {
    pub(super) proof_mass: f64,
    pub(super) ground: bool,
    pub(super) cantilever: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) coordinate: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) bounce: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) stick_speed: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) adhesion_reach: Option<f64>,
}

/// The drive: one polynomial, or one for each direction of the voltage. Constant term first.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct PiezoEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) gain: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rising: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) falling: Option<Vec<f64>>,
}

/// A mode by its shape, or a single mass on a spring.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ModeEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) frequency: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) zeta: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) phi_c: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) phi_p: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) phi_drive: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mass: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) stiffness: Option<f64>,
}
