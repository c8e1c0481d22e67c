//! What the person has set up: everything that undo covers. A session file holds it
//! together with the view.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::drive_choice::DriveChoice;
use super::explore::ExploreChoices;
use super::kept_curve::KeptCurve;
use super::overlay::Overlay;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

/// What undo and redo step through. One step per finished interaction.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The device with its values, effects and slider ranges.
    pub preset: Preset,
    /// The preset as it was read; a reset goes back to it.
    pub original: Arc<Preset>,
    /// Its drive.
    pub drive: DriveChoice,
    /// Span of the whole-span mode \[s\].
    pub duration: f64,
    /// Ids of parameters that are locked against change.
    pub locked: BTreeSet<String>,
    /// Recordings shown over the simulation.
    pub overlays: Vec<Overlay>,
    /// Curves kept to compare with.
    pub kept: Vec<KeptCurve>,
    /// What a diagnosis is asked beyond its recordings.
    pub diagnosis: DiagnosisChoices,
    /// What was chosen and drawn in the Explore workspace.
    pub explore: ExploreChoices,
}

/// What a person chose of a parameter for a diagnosis, in place of the usual.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ParameterChoice {
    /// Re-tuned.
    Free,
    /// Held at the device's value.
    Held,
    /// Re-tuned against what is known of it \[SI\].
    Known {
        /// The value.
        value: f64,
        /// Its standard error, above 0.
        std_error: f64,
    },
}

/// What a diagnosis is asked beyond its recordings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DiagnosisChoices {
    /// Time after which it ends with the best answer so far \[s\]; `None` for no limit.
    pub longest: Option<f64>,
    /// Ids of effects that are not compared.
    pub skipped: BTreeSet<String>,
    /// What was chosen of parameters, by id.
    pub parameters: BTreeMap<String, ParameterChoice>,
}

impl DiagnosisChoices {
    /// Whether nothing was chosen.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// Changes the device. Recordings and locks stay, and so does the drive if both devices
/// have one.
pub fn choose_preset(setup: &mut Setup, preset: &Preset) {
    let keeps_drive = setup.preset.model.piezo.is_some() && preset.model.piezo.is_some();
    if !keeps_drive {
        if let Ok(drive) = Waveform::parse(&preset.drive, preset.duration) {
            setup.drive = DriveChoice::Waveform(drive);
        }
        setup.duration = preset.duration;
    }
    setup.preset = preset.clone();
    setup.original = Arc::new(preset.clone());
}

/// Gives the device the values and effects of a kept curve, locked ones too. The drive stays,
/// unless the present device or that of the curve has none.
pub fn restore_parameters(setup: &mut Setup, curve: &KeptCurve) {
    let origin = &curve.origin;
    let (now, kept) = (&setup.preset.model, &origin.preset.model);
    if now.piezo.is_some() != kept.piezo.is_some() {
        setup.drive = origin.drive.clone();
        setup.duration = origin.duration;
    }
    if setup.original.model.name != kept.name {
        setup.original = Arc::new(origin.preset.clone());
    }
    setup.preset = origin.preset.clone();
}
