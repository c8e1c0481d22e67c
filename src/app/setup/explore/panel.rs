//! The panels of the Explore workspace by name.

use serde::{Deserialize, Serialize};

/// A panel of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExplorePanel {
    /// A measure over two numbers.
    #[default]
    Map,
    /// One number up and down.
    Orbit,
    /// Which start leads where.
    Basins,
    /// Over an ensemble of coefficients.
    Robustness,
    /// A period drawn by hand.
    Waveform,
    /// Several feet.
    Gait,
}

impl ExplorePanel {
    /// All, in the order of the tabs.
    pub const ALL: [Self; 6] = [
        Self::Map,
        Self::Orbit,
        Self::Basins,
        Self::Robustness,
        Self::Waveform,
        Self::Gait,
    ];

    /// Title of its tab.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Map => "Map",
            Self::Orbit => "Orbit diagram",
            Self::Basins => "Basins",
            Self::Robustness => "Robustness",
            Self::Waveform => "Waveform",
            Self::Gait => "Gait",
        }
    }

    /// Its name in the command palette.
    #[must_use]
    pub fn command_name(self) -> &'static str {
        match self {
            Self::Map => "Explore: map",
            Self::Orbit => "Explore: orbit diagram",
            Self::Basins => "Explore: basins",
            Self::Robustness => "Explore: robustness",
            Self::Waveform => "Explore: draw a waveform",
            Self::Gait => "Explore: gait",
        }
    }

    /// What it shows, in one line.
    #[must_use]
    pub fn help(self) -> &'static str {
        match self {
            Self::Map => {
                "How the device taps the ground over two numbers, such as frequency and amplitude"
            }
            Self::Orbit => {
                "One number raised and lowered again: where responses split, jump or coexist"
            }
            Self::Basins => "To which response each start leads",
            Self::Robustness => "How likely the wanted response is if coefficients are uncertain",
            Self::Waveform => "Draw a period of the drive voltage and see the steady response",
            Self::Gait => "Several feet under one drive: which are down when",
        }
    }
}
