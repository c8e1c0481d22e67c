//! The measured quantities of a recording.

use serde::{Deserialize, Serialize};

/// One measured quantity of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// The drive voltage \[V\].
    Voltage,
    /// Displacement of the proof mass \[m\].
    ProofMass,
    /// Displacement of the cantilever's centre \[m\].
    Cantilever,
}

impl Channel {
    /// All channels, in the order in which they are written.
    pub const ALL: [Channel; 3] = [Channel::Voltage, Channel::ProofMass, Channel::Cantilever];

    /// The symbol used in headers: `V`, `xp`, `xc`.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Channel::Voltage => "V",
            Channel::ProofMass => "xp",
            Channel::Cantilever => "xc",
        }
    }

    /// SI unit of the channel.
    #[must_use]
    pub fn base_unit(self) -> &'static str {
        match self {
            Channel::Voltage => "V",
            Channel::ProofMass | Channel::Cantilever => "m",
        }
    }
}
