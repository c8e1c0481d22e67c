//! The quantities that a column can hold, and what people call them.

use super::units::UnitKind;
use crate::recording::csv::settings::{ColumnChoice, ImportSettings};

/// A quantity that a column can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(in crate::recording::csv) enum Role {
    Time,
    Voltage,
    ProofMass,
    Cantilever,
}

impl Role {
    pub(in crate::recording::csv) const ALL: [Role; 4] =
        [Role::Time, Role::Voltage, Role::ProofMass, Role::Cantilever];

    /// The whole names, in lower case without spaces, signs and accents.
    pub(super) fn names(self) -> &'static [&'static str] {
        match self {
            Role::Time => &[
                "t",
                "time",
                "zeit",
                "timestamp",
                "times",
                "temps",
                "tiempo",
                "tempo",
                "xaxis",
                "xvalue",
                "\u{65f6}\u{95f4}",
                "\u{6642}\u{9593}",
            ],
            Role::Voltage => &[
                "v",
                "u",
                "voltage",
                "volt",
                "volts",
                "drivevoltage",
                "inputvoltage",
                "drive",
                "input",
                "spannung",
                "vin",
                "uin",
                "tension",
                "voltaje",
                "tensione",
                "\u{7535}\u{538b}",
                "\u{96fb}\u{5727}",
            ],
            Role::ProofMass => &[
                "xp",
                "proofmass",
                "proofmassposition",
                "tip",
                "tipposition",
                "tipdisplacement",
                "x",
                "y",
                "z",
                "position",
                "pos",
                "displacement",
                "deflection",
                "height",
                "weg",
                "deplacement",
                "posicion",
                "desplazamiento",
                "spostamento",
                "posizione",
                "auslenkung",
                "\u{4f4d}\u{79fb}",
                "\u{5909}\u{4f4d}",
            ],
            Role::Cantilever => &[
                "xc",
                "cantilever",
                "cantilevercentre",
                "cantilevercenter",
                "beam",
                "centre",
                "center",
            ],
        }
    }

    /// Words that suffice among others.
    pub(super) fn words(self) -> &'static [&'static str] {
        match self {
            Role::Time => &[
                "time",
                "zeit",
                "temps",
                "tiempo",
                "tempo",
                "timestamp",
                "elapsed",
            ],
            Role::Voltage => &[
                "voltage",
                "drive",
                "spannung",
                "tension",
                "voltaje",
                "tensione",
                "command",
                "monitor",
                "actuator",
                "excitation",
                "amplifier",
            ],
            Role::ProofMass => &[
                "xp",
                "displacement",
                "position",
                "deflection",
                "height",
                "auslenkung",
                "weg",
                "deplacement",
                "posicion",
                "desplazamiento",
                "spostamento",
                "posizione",
                "tip",
                "\u{4f4d}\u{79fb}",
            ],
            Role::Cantilever => &[
                "xc",
                "cantilever",
                "beam",
                "centre",
                "center",
                "middle",
                "mitte",
                "balken",
            ],
        }
    }

    pub(in crate::recording::csv) fn base(self) -> &'static str {
        match self {
            Role::Time => "s",
            Role::Voltage => "V",
            Role::ProofMass | Role::Cantilever => "m",
        }
    }

    pub(in crate::recording::csv) fn symbol(self) -> &'static str {
        match self {
            Role::Time => "t",
            Role::Voltage => "V",
            Role::ProofMass => "xp",
            Role::Cantilever => "xc",
        }
    }

    /// The role of a symbol.
    pub(in crate::recording::csv) fn of_symbol(symbol: &str) -> Option<Self> {
        let symbol = symbol.trim();
        Self::ALL
            .into_iter()
            .find(|r| r.symbol().eq_ignore_ascii_case(symbol))
    }

    pub(in crate::recording::csv) fn quantity(self) -> &'static str {
        match self {
            Role::Time => "time",
            Role::Voltage => "voltage",
            Role::ProofMass | Role::Cantilever => "displacement",
        }
    }

    pub(in crate::recording::csv) fn units(self) -> &'static str {
        match self {
            Role::Time => "s, ms or us",
            Role::Voltage => "V or mV",
            Role::ProofMass | Role::Cantilever => "m, mm, um or nm",
        }
    }

    pub(in crate::recording::csv) fn kind(self) -> UnitKind {
        match self {
            Role::Time => UnitKind::Time,
            Role::Voltage => UnitKind::Voltage,
            Role::ProofMass | Role::Cantilever => UnitKind::Length,
        }
    }

    pub(in crate::recording::csv) fn of(self, settings: &ImportSettings) -> Option<&ColumnChoice> {
        match self {
            Role::Time => settings.time.as_ref(),
            Role::Voltage => settings.voltage.as_ref(),
            Role::ProofMass => settings.proof_mass.as_ref(),
            Role::Cantilever => settings.cantilever.as_ref(),
        }
    }

    pub(in crate::recording::csv) fn set(
        self,
        settings: &mut ImportSettings,
        choice: Option<ColumnChoice>,
    ) {
        let slot = match self {
            Role::Time => &mut settings.time,
            Role::Voltage => &mut settings.voltage,
            Role::ProofMass => &mut settings.proof_mass,
            Role::Cantilever => &mut settings.cantilever,
        };
        *slot = choice;
    }
}
