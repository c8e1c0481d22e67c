//! Names of columns, as people write them.

pub(in crate::recording::csv) use super::role::Role;
use super::units::{UnitKind, kind_of, split_unit};

/// Words with which a column is about another quantity, or about another's error.
const OTHER_WORDS: [&str; 23] = [
    "error",
    "err",
    "std",
    "sd",
    "sigma",
    "uncertainty",
    "fehler",
    "base",
    "reference",
    "ref",
    "setpoint",
    "target",
    "noise",
    "frequency",
    "freq",
    "temperature",
    "temp",
    "sideways",
    "lateral",
    "angle",
    "trigger",
    "current",
    "force",
];
/// Words of a velocity and of an acceleration.
const VELOCITY_WORDS: [&str; 7] = [
    "velocity",
    "vel",
    "speed",
    "geschwindigkeit",
    "vitesse",
    "velocidad",
    "velocita",
];
const ACCELERATION_WORDS: [&str; 6] = [
    "acceleration",
    "accel",
    "acc",
    "beschleunigung",
    "aceleracion",
    "accelerazione",
];
/// Names of numbered rows.
const INDEX_NAMES: [&str; 10] = [
    "", "sample", "samples", "index", "n", "i", "nr", "no", "point", "sequence",
];
/// Names of an instrument's channels.
const CHANNEL_WORDS: [&str; 14] = [
    "ch",
    "channel",
    "c",
    "in",
    "ai",
    "trace",
    "ampl",
    "amplitude",
    "value",
    "signal",
    "input",
    "kanal",
    "voie",
    "analog",
];

/// A column of a header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::recording::csv) struct Column {
    /// Name without unit.
    pub name: String,
    /// Unit as written.
    pub unit: Option<String>,
    pub kind: Option<UnitKind>,
    /// Name without case, spaces, signs, accents and final number.
    key: String,
    words: Vec<String>,
    /// The final number of the name: of a trial, a channel.
    pub number: Option<usize>,
}

impl Column {
    /// A cell of a header.
    pub(in crate::recording::csv) fn of(cell: &str) -> Self {
        let (name, unit) = split_unit(cell);
        let unit = unit.filter(|u| !u.is_empty());
        let folded: String = name
            .chars()
            .flat_map(char::to_lowercase)
            .map(plain)
            .collect();
        let whole: String = folded.chars().filter(|c| c.is_alphanumeric()).collect();
        let key = whole
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .to_owned();
        let number = whole.get(key.len()..).and_then(|n| n.parse().ok());
        let words = folded
            .split(|c: char| !c.is_alphanumeric())
            .filter(|word| !word.is_empty())
            .map(|word| {
                let short = word.trim_end_matches(|c: char| c.is_ascii_digit());
                if short.is_empty() { word } else { short }.to_owned()
            })
            .collect();
        Self {
            kind: unit.as_deref().and_then(kind_of),
            name,
            unit,
            key,
            words,
            number,
        }
    }

    fn has(&self, words: &[&str]) -> bool {
        self.words.iter().any(|word| words.contains(&word.as_str()))
    }

    /// Whether the column is a velocity or an acceleration.
    pub(in crate::recording::csv) fn is_rate(&self, kind: UnitKind) -> bool {
        let (words, letter): (&[&str], &str) = match kind {
            UnitKind::Velocity => (&VELOCITY_WORDS, "v"),
            _ => (&ACCELERATION_WORDS, "a"),
        };
        match self.kind {
            Some(own) => own == kind,
            None => {
                let axis = |word: &str| matches!(word, "x" | "y" | "z");
                let of_axis = match self.words.as_slice() {
                    [only] => only
                        .strip_prefix(letter)
                        .is_some_and(|rest| axis(rest) && rest.len() == 1),
                    [first, second] => first == letter && axis(second),
                    _ => false,
                };
                self.has(words) || of_axis
            }
        }
    }

    /// How well the name fits: 0 for a whole name, 1 for a word of it; `None` if it does not.
    pub(in crate::recording::csv) fn rank(&self, role: Role) -> Option<u8> {
        if role.names().contains(&self.key.as_str()) {
            // A velocity may be called v; it has no voltage's unit then.
            return Some(0);
        }
        if self.is_rate(UnitKind::Velocity) || self.is_rate(UnitKind::Acceleration) {
            return None;
        }
        let other_roles: &[Role] = match role {
            Role::ProofMass => &[Role::Cantilever],
            _ => &[],
        };
        let other = self.has(&OTHER_WORDS) || other_roles.iter().any(|r| self.has(r.words()));
        (!other && self.has(role.words())).then_some(1)
    }

    /// Whether the unit is one of `role`, or there is none.
    pub(in crate::recording::csv) fn fits(&self, role: Role) -> bool {
        match &self.unit {
            None => true,
            Some(_) => self.kind == Some(role.kind()),
        }
    }

    /// Whether a scale can make it a quantity of `role`.
    pub(in crate::recording::csv) fn is_scalable(&self, role: Role) -> bool {
        let unit = self.unit.as_deref().unwrap_or_default().to_lowercase();
        let raw = matches!(
            unit.as_str(),
            "%" | "px" | "pixel" | "pixels" | "counts" | "lsb" | "a.u."
        );
        match role {
            Role::Time => false,
            Role::Voltage => raw,
            _ => raw || self.kind == Some(UnitKind::Voltage),
        }
    }

    /// Whether the column numbers the rows.
    pub(in crate::recording::csv) fn is_index(&self) -> bool {
        self.unit.is_none() && INDEX_NAMES.contains(&self.key.as_str()) && self.number.is_none()
    }

    /// Whether it is a channel that an instrument named.
    pub(in crate::recording::csv) fn is_channel(&self) -> bool {
        let named = |word: &String| {
            CHANNEL_WORDS.contains(&word.as_str())
                || word.len() == 1
                || word.bytes().all(|b| b.is_ascii_digit())
        };
        matches!(self.kind, None | Some(UnitKind::Voltage))
            && self.words.iter().all(named)
            && (!self.words.is_empty() || self.unit.is_some())
            || CHANNEL_WORDS.contains(&self.key.as_str())
    }

    /// Name without its final number, if it has one.
    pub(in crate::recording::csv) fn stem(&self) -> Option<&str> {
        self.number.map(|_| self.key.as_str())
    }

    /// The axis of a plane, if that is the name.
    pub(in crate::recording::csv) fn axis(&self) -> Option<char> {
        match self.key.as_str() {
            "x" => Some('x'),
            "y" => Some('y'),
            "z" => Some('z'),
            _ => None,
        }
    }

    /// Whether it is a column of dates by its name.
    pub(in crate::recording::csv) fn is_date(&self) -> bool {
        matches!(
            self.key.as_str(),
            "date" | "datum" | "fecha" | "data" | "day"
        )
    }
}

/// A letter without its accent.
fn plain(c: char) -> char {
    match c {
        '\u{e0}'..='\u{e5}' => 'a',
        '\u{e8}'..='\u{eb}' => 'e',
        '\u{ec}'..='\u{ef}' => 'i',
        '\u{f2}'..='\u{f6}' => 'o',
        '\u{f9}'..='\u{fc}' => 'u',
        '\u{e7}' => 'c',
        '\u{f1}' => 'n',
        c => c,
    }
}

/// Whether the cells can be a header: one of them is a time column by name, or two
/// are known names.
pub(in crate::recording::csv) fn is_header(cells: &[String]) -> bool {
    let columns: Vec<Column> = cells.iter().map(|cell| Column::of(cell)).collect();
    let known = |role: Role| columns.iter().any(|c| c.rank(role).is_some());
    let roles = Role::ALL.into_iter().filter(|role| known(*role)).count();
    cells.len() >= 2 && (known(Role::Time) || roles >= 2)
}

#[cfg(test)]
mod tests {
    use super::super::names::*;

    #[test]
    fn names_of_many_laboratories() {
        for (cell, role, rank) in [
            ("xp1 [um]", Role::ProofMass, Some(0)),
            ("D\u{e9}placement (\u{b5}m)", Role::ProofMass, Some(0)),
            ("Displacement tip [um]", Role::ProofMass, Some(1)),
            ("Displacement centre [um]", Role::ProofMass, None),
            ("Displacement centre [um]", Role::Cantilever, Some(1)),
            ("xp error [um]", Role::ProofMass, None),
            ("Base displacement (um)", Role::ProofMass, None),
            ("Amplifier monitor [V]", Role::Voltage, Some(1)),
            ("Spannung U_B1 / V", Role::Voltage, Some(1)),
            ("Temperature", Role::Voltage, None),
            ("\u{65f6}\u{95f4}(s)", Role::Time, Some(0)),
        ] {
            assert_eq!(Column::of(cell).rank(role), rank, "{cell}");
        }
        assert!(Column::of("v_{y}").is_rate(UnitKind::Velocity));
        assert!(Column::of("v (mm/s)").is_rate(UnitKind::Velocity));
        assert!(!Column::of("V").is_rate(UnitKind::Velocity));
        assert!(Column::of("CH1 [V]").is_channel() && Column::of("1").is_channel());
        assert!(!Column::of("xp [um]").is_channel());
        assert!(Column::of("").is_index() && Column::of("Sample").is_index());
    }
}
