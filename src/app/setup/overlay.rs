//! A recording as it lies over the simulation: its data, alignment, colour and role.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::own_drive::OwnDrive;
use crate::fit::FreeNuisances;
use crate::model::drive::DriveReading;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::recording::csv::ImportSettings;
use crate::recording::experiment_setup::InstrumentUnknowns;

/// Number of a recording within a session; never given to another recording.
pub type OverlayId = u64;

/// What a recording is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Fitted to.
    Train,
    /// Held out: not fitted to, but used to check a fit or a diagnosis.
    HeldOut,
    /// Not used.
    Unused,
}

/// Standard deviation of the scale of a reading around 1, where it is estimated.
const SCALE_SIGMA: f64 = 0.01;

/// What of a recording's instrument is estimated with every comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Estimates {
    /// The zero of each reading.
    pub zeros: bool,
    /// The clock of the readings against that of the voltage.
    pub clock: bool,
    /// The scale of each reading.
    pub scales: bool,
    /// The state in which it begins, where that is not rest.
    pub start: bool,
}

impl Default for Estimates {
    /// A scale is held: it would hide an error of the drive's strength.
    fn default() -> Self {
        Self {
            zeros: true,
            clock: true,
            scales: false,
            start: true,
        }
    }
}

impl Estimates {
    /// The same with its priors, for readings that lag \[s\] behind the voltage.
    #[must_use]
    pub fn unknowns(&self, lag: f64) -> InstrumentUnknowns {
        InstrumentUnknowns {
            zeros: self.zeros,
            scale: self.scales.then_some(SCALE_SIGMA),
            clock: FreeNuisances::default().skew.filter(|_| self.clock),
            lag,
        }
    }
}

/// A recording laid over the simulation.
#[derive(Debug, Clone)]
pub struct Overlay {
    /// Its number.
    pub id: OverlayId,
    /// The data, immutable.
    pub recording: Arc<Recording>,
    /// How its columns were read.
    pub import: ImportSettings,
    /// Shift and scale against the simulation.
    pub alignment: Alignment,
    /// What drives its own run.
    pub drive: OwnDrive,
    /// What of its instrument is estimated with every comparison.
    pub estimates: Estimates,
    /// Whether it is drawn and compared.
    pub visible: bool,
    /// Index into the palette of recordings.
    pub color: usize,
    /// Whether it is a made-up recording that comes with the program.
    pub made_up: bool,
    /// What it is used for; `None` until a person has chosen.
    pub role: Option<Role>,
}

impl PartialEq for Overlay {
    /// Recordings are immutable and keep their number: the number stands for the data.
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
            && self.alignment == other.alignment
            && self.drive == other.drive
            && self.estimates == other.estimates
            && self.visible == other.visible
            && self.color == other.color
            && self.role == other.role
    }
}

/// Whether all that is computed of two lists of recordings is the same.
#[must_use]
pub fn have_same_numbers(a: &[Overlay], b: &[Overlay]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.has_same_numbers(b))
}

impl Overlay {
    /// Whether all that is computed of both is the same. Colour and role say how a recording is drawn
    /// and what it is used for, and change no number.
    #[must_use]
    pub fn has_same_numbers(&self, other: &Self) -> bool {
        self.id == other.id
            && self.visible == other.visible
            && self.alignment == other.alignment
            && self.drive == other.drive
            && self.estimates == other.estimates
    }

    /// Whether its run is that of the simulation: it is told so, or has no voltage of its own.
    #[must_use]
    pub fn is_under_shared_drive(&self) -> bool {
        match self.drive {
            OwnDrive::Shared => true,
            OwnDrive::Measured(_) => !self.recording.has_voltage(),
            OwnDrive::Chosen(_) => false,
        }
    }

    /// How its measured voltage is read.
    #[must_use]
    pub fn reading(&self) -> DriveReading {
        match self.drive {
            OwnDrive::Measured(reading) => reading,
            OwnDrive::Shared | OwnDrive::Chosen(_) => DriveReading::Recognised,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::files::built_in;

    #[test]
    fn a_colour_or_a_role_changes_no_number() {
        let before = built_in::setup().overlays;
        let mut after = before.clone();
        after[0].color += 1;
        after[0].role = Some(Role::HeldOut);
        assert_ne!(before, after);
        assert!(have_same_numbers(&before, &after));
        assert!(!have_same_numbers(&before, &after[1..]));
        let mut hidden = before.clone();
        hidden[0].visible = !hidden[0].visible;
        assert!(!have_same_numbers(&before, &hidden));
        after[0].estimates.scales = true;
        assert!(!have_same_numbers(&before, &after));
    }
}
