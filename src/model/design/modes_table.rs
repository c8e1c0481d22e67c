//! A device from a table of its modes: CSV with one mode a row, or TOML with one `[[mode]]` each.
//!
//! Columns (keys) are `frequency` or `f`, `zeta` or `Q`, `phi_p`, and optionally `phi_c`, `phi_drive` and
//! `modal_mass`. A unit may follow in brackets: `f [kHz]`, `zeta [%]`, `modal_mass [ng]`. Shapes are
//! mass-normalised [kg^-1/2], or of any scale where the modal mass of that scale is given.

use serde::Deserialize;

use super::error::{DesignError, positive};
use super::setting::{Designed, Parts, Setting};
use crate::model::MAX_MODES;
use crate::model::ground::BounceRule;
use crate::model::preset::toml_fault::{TomlFault, short_reason};
use crate::model::structure::Mode;
use crate::model::unit::{Coordinate, format_quantity, parse_quantity, unit_factor};

/// Modes as tabulated.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModesTable {
    /// Modes in order of frequency, shapes mass-normalised.
    pub modes: Vec<Mode>,
    /// Whether shapes at the cantilever's centre were given.
    pub has_cantilever: bool,
    /// Whether damping was given for each.
    pub has_damping: bool,
    /// Whether couplings to the drive were given.
    pub has_drive: bool,
}

/// One mode as a TOML file has it.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Entry {
    #[serde(alias = "f")]
    frequency: Option<f64>,
    zeta: Option<f64>,
    #[serde(rename = "Q", alias = "q")]
    quality: Option<f64>,
    phi_c: Option<f64>,
    phi_p: Option<f64>,
    phi_drive: Option<f64>,
    modal_mass: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TomlFile {
    mode: Vec<Entry>,
}

/// Roles of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Frequency,
    Zeta,
    Quality,
    PhiC,
    PhiP,
    PhiDrive,
    ModalMass,
}

/// What is wrong, and in which column (from 0).
type Fault = (usize, String);

/// Names of the columns, for a message.
const COLUMNS: &str =
    "frequency (or f), zeta or Q, phi_p, and optionally phi_c, phi_drive, modal_mass";

impl Role {
    fn find(name: &str) -> Option<Self> {
        let plain = name.trim().to_ascii_lowercase().replace(' ', "_");
        Some(match plain.as_str() {
            "frequency" | "f" | "freq" => Self::Frequency,
            "zeta" | "damping" | "damping_ratio" => Self::Zeta,
            "q" | "quality" | "quality_factor" => Self::Quality,
            "phi_c" => Self::PhiC,
            "phi_p" => Self::PhiP,
            "phi_drive" | "phi_d" => Self::PhiDrive,
            "modal_mass" => Self::ModalMass,
            _ => return None,
        })
    }

    /// Factor of a unit in brackets.
    fn factor(self, unit: &str) -> Option<f64> {
        match self {
            Self::Frequency => unit_factor(unit, "Hz"),
            Self::ModalMass => unit_factor(unit, "kg"),
            Self::Zeta if unit == "%" => Some(1e-2),
            Self::PhiC | Self::PhiP | Self::PhiDrive => {
                matches!(unit, "" | "kg^-1/2" | "1/sqrt(kg)" | "kg^-0.5").then_some(1.0)
            }
            Self::Zeta | Self::Quality => matches!(unit, "" | "-" | "1").then_some(1.0),
        }
    }
}

impl ModesTable {
    /// Reads a table; `file` is named in errors, and its ending decides: `.toml` or CSV.
    ///
    /// # Errors
    /// [`DesignError::Table`] with line and column.
    ///
    /// # Examples
    /// ```
    /// use impactscope::model::design::ModesTable;
    ///
    /// let text = "f [kHz]; Q; phi_c; phi_p\n0,623; 19; 13381; 50145\n6,424; 20; 74487; -12923\n";
    /// let table = ModesTable::parse("modes.csv", text)?;
    /// assert_eq!(table.modes.len(), 2);
    /// assert!((table.modes[0].zeta - 0.5 / 19.0).abs() < 1e-12);
    /// # Ok::<(), impactscope::model::design::DesignError>(())
    /// ```
    pub fn parse(file: &str, text: &str) -> Result<Self, DesignError> {
        if file.to_ascii_lowercase().ends_with(".toml") {
            Self::parse_toml(file, text)
        } else {
            Self::parse_csv(file, text)
        }
    }

    fn parse_toml(file: &str, text: &str) -> Result<Self, DesignError> {
        let read: TomlFile = toml::from_str(text).map_err(|error| {
            let fault = TomlFault::new(text, &error);
            DesignError::Table {
                file: file.to_owned(),
                line: fault.line,
                column: fault.column,
                reason: fault.reason,
            }
        })?;
        let line_of = |nth: usize| {
            let heads = text.lines().enumerate();
            let mut heads = heads.filter(|(_, l)| l.trim_start().starts_with("[[mode]]"));
            heads.nth(nth).map_or(1, |(i, _)| i + 1)
        };
        let rows = read.mode.into_iter().enumerate();
        Self::of_entries(file, rows.map(|(i, e)| (line_of(i), e)).collect())
    }

    fn parse_csv(file: &str, text: &str) -> Result<Self, DesignError> {
        let fail = |line: usize, (column, reason): Fault| DesignError::Table {
            file: file.to_owned(),
            line: line + 1,
            column: column + 1,
            reason: short_reason(&reason),
        };
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let is_content = |l: &&str| !l.trim().is_empty() && !l.trim_start().starts_with('#');
        let mut lines = text.lines().enumerate().filter(|(_, l)| is_content(l));
        let Some((head_line, head)) = lines.next() else {
            return Err(fail(
                0,
                (0, format!("there is no table; its header names {COLUMNS}")),
            ));
        };
        let separator = [';', '\t', ',']
            .into_iter()
            .find(|c| head.contains(*c))
            .unwrap_or(',');
        let columns = head
            .split(separator)
            .enumerate()
            .map(|(i, name)| column(name).map_err(|reason| fail(head_line, (i, reason))))
            .collect::<Result<Vec<_>, _>>()?;
        let twice = (1..columns.len()).find(|&i| columns[..i].iter().any(|c| c.0 == columns[i].0));
        if let Some(i) = twice {
            return Err(fail(
                head_line,
                (i, "this column is there twice".to_owned()),
            ));
        }
        let mut rows = Vec::new();
        for (line, row) in lines {
            let cells: Vec<&str> = row.split(separator).collect();
            if cells.len() != columns.len() {
                let reason = format!("{} cells for {} columns", cells.len(), columns.len());
                return Err(fail(line, (cells.len().min(columns.len()), reason)));
            }
            let mut entry = Entry::default();
            for (i, (cell, (role, factor))) in cells.iter().zip(&columns).enumerate() {
                let value = parse_quantity(cell, "").map_err(|e| fail(line, (i, e.to_string())))?;
                entry.set(*role, value * factor);
            }
            rows.push((line + 1, entry));
            if rows.len() > MAX_MODES {
                return Err(fail(
                    line,
                    (0, format!("a device has at most {MAX_MODES} modes")),
                ));
            }
        }
        Self::of_entries(file, rows)
    }

    fn of_entries(file: &str, rows: Vec<(usize, Entry)>) -> Result<Self, DesignError> {
        let fail = |line: usize, reason: String| DesignError::Table {
            file: file.to_owned(),
            line,
            column: 1,
            reason,
        };
        if rows.is_empty() || rows.len() > MAX_MODES {
            return Err(fail(
                1,
                format!("{} modes; give 1 to {MAX_MODES}", rows.len()),
            ));
        }
        let all = |has: &dyn Fn(&Entry) -> bool| rows.iter().all(|(_, e)| has(e));
        let mut table = Self {
            modes: Vec::new(),
            has_cantilever: all(&|e| e.phi_c.is_some()),
            has_damping: all(&|e| e.zeta.is_some() || e.quality.is_some()),
            has_drive: all(&|e| e.phi_drive.is_some()),
        };
        for (line, entry) in &rows {
            table
                .modes
                .push(entry.mode().map_err(|reason| fail(*line, reason))?);
        }
        table
            .modes
            .sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        Ok(table)
    }
}

/// A column's role, and the factor of its unit.
fn column(name: &str) -> Result<(Role, f64), String> {
    let (plain, unit) = match name.split_once(['[', '(']) {
        Some((plain, unit)) => (plain, unit.trim_end().trim_end_matches([']', ')']).trim()),
        None => (name, ""),
    };
    let role = Role::find(plain).ok_or_else(|| {
        format!(
            "\"{}\" is no column of a table of modes; it has {COLUMNS}",
            name.trim()
        )
    })?;
    let factor = role
        .factor(unit)
        .ok_or_else(|| format!("\"{unit}\" is no unit of {}", plain.trim()))?;
    Ok((role, factor))
}

impl Entry {
    fn set(&mut self, role: Role, value: f64) {
        let slot = match role {
            Role::Frequency => &mut self.frequency,
            Role::Zeta => &mut self.zeta,
            Role::Quality => &mut self.quality,
            Role::PhiC => &mut self.phi_c,
            Role::PhiP => &mut self.phi_p,
            Role::PhiDrive => &mut self.phi_drive,
            Role::ModalMass => &mut self.modal_mass,
        };
        *slot = Some(value);
    }

    fn mode(&self) -> Result<Mode, String> {
        let all = [
            self.frequency,
            self.zeta,
            self.quality,
            self.phi_c,
            self.phi_p,
            self.phi_drive,
            self.modal_mass,
        ];
        if all.iter().flatten().any(|v| !v.is_finite()) {
            return Err("all values must be finite numbers".to_owned());
        }
        let frequency = self.frequency.ok_or("the mode has no frequency [Hz]")?;
        let zeta = match (self.zeta, self.quality) {
            (Some(_), Some(_)) => return Err("give zeta or Q, not both".to_owned()),
            (Some(zeta), None) => zeta,
            (None, Some(q)) if q > 0.0 => 0.5 / q,
            (None, Some(q)) => return Err(format!("Q must be above 0, not {q}")),
            (None, None) => super::setting::ASSUMED_ZETA,
        };
        if frequency < 0.0 || zeta < 0.0 {
            return Err("frequency and damping must not be negative".to_owned());
        }
        let phi_p = self
            .phi_p
            .ok_or("the mode has no phi_p, its shape at the proof mass")?;
        let scale = match self.modal_mass {
            None => 1.0,
            Some(mass) if mass > 0.0 => 1.0 / mass.sqrt(),
            Some(mass) => return Err(format!("the modal mass must be above 0 kg, not {mass}")),
        };
        let phi_c = scale * self.phi_c.unwrap_or(0.0);
        Ok(Mode {
            frequency,
            zeta,
            phi_c,
            phi_p: scale * phi_p,
            phi_drive: self.phi_drive.map_or(phi_c, |phi| scale * phi),
        })
    }
}

/// The device of a table of modes. `proof_mass` \[kg\] is the rigid mass at the tip on which weight
/// acts; `None` for the mass that an impulse on it moves.
///
/// # Errors
/// [`DesignError`] naming the value at fault.
pub fn modes_device(
    table: &ModesTable,
    proof_mass: Option<f64>,
    setting: &Setting,
) -> Result<Designed, DesignError> {
    let mut notes = Vec::new();
    let mut modes = table.modes.clone();
    if !table.has_damping {
        notes.extend(setting.damping_notes(modes.len()));
    } else if !setting.zetas.is_empty() {
        return Err(DesignError::value(
            "zeta",
            "the table has the damping of each mode already",
        ));
    }
    if !setting.zetas.is_empty() {
        for (i, mode) in modes.iter_mut().enumerate() {
            mode.zeta = setting.zeta(i);
        }
    }
    let mobility: f64 = modes.iter().map(|m| m.phi_p * m.phi_p).sum();
    if !(mobility > 0.0 && mobility.is_finite()) {
        return Err(DesignError::value(
            "phi_p",
            "no mode moves the proof mass: give phi_p of at least one mode",
        ));
    }
    let proof_mass = match proof_mass {
        Some(mass) => positive("mass", mass, "kg")?,
        None => {
            let moved = 1.0 / mobility;
            notes.push(format!(
                "No proof mass was given: {} is taken, the mass that an impulse on it moves.",
                super::beam::device::format_mass(moved)
            ));
            moved
        }
    };
    let drives = modes.iter().any(|m| m.phi_drive != 0.0);
    if setting.force_per_volt.is_some() && !drives {
        if table.has_cantilever || table.has_drive {
            return Err(DesignError::value(
                "force",
                "it drives no mode: give phi_c or phi_drive of at least one",
            ));
        }
        notes.push(
            "There is no phi_c and no phi_drive: the drive acts on the proof mass.".to_owned(),
        );
        for mode in &mut modes {
            mode.phi_drive = mode.phi_p;
        }
    } else if setting.force_per_volt.is_none() {
        notes.push("No force per volt was given: the device has no drive.".to_owned());
    }
    let highest = modes.last().map_or(0.0, |m| m.frequency);
    setting.device(Parts {
        about: format!(
            "{} from a table, up to {}",
            crate::model::unit::counted(modes.len(), "mode"),
            format_quantity(highest, "Hz", 4)
        ),
        modes,
        proof_mass,
        has_cantilever: table.has_cantilever,
        coordinate: Coordinate::Length,
        drive: None,
        bounce: BounceRule::PullOff,
        start: Vec::new(),
        notes,
    })
}
