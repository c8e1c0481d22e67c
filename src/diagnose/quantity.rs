//! The quantities on which what is missing may depend.

use serde::{Deserialize, Serialize};

/// A quantity on which what is missing may depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// Displacement of the proof mass.
    #[serde(rename = "xp")]
    Displacement,
    /// Its velocity.
    #[serde(rename = "vp")]
    Velocity,
    /// The voltage.
    #[serde(rename = "V")]
    Voltage,
    /// Time.
    #[serde(rename = "t")]
    Time,
}

impl Quantity {
    /// All.
    pub const ALL: [Self; 4] = [
        Self::Displacement,
        Self::Velocity,
        Self::Voltage,
        Self::Time,
    ];

    /// Its symbol in curves and findings.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Displacement => "xp",
            Self::Velocity => "xp'",
            Self::Voltage => "V",
            Self::Time => "t",
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Displacement => "m",
            Self::Velocity => "m/s",
            Self::Voltage => "V",
            Self::Time => "s",
        }
    }

    /// The one with this symbol.
    pub fn of_symbol(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|q| q.symbol() == symbol)
    }
}
