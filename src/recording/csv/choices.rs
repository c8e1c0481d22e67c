//! What a person says about a file in advance: the reading options of the command line.

use super::columns::meant::column_meant;
use super::columns::names::{Column, Role};
use super::columns::units::{kind_of, unit_shift};
use super::columns::{Question, Topic, found_names};
use super::preview::Preview;
use super::settings::{
    ColumnChoice, Decimal, DriftRemoval, Encoding, ImportSettings, Quantity, SampleClock,
};
use crate::recording::Channel;
use crate::recording::error::ImportError;

/// Answers to what files leave open. Channels are named by `t`, `V`, `xp` and `xc`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadingChoices {
    /// Columns by channel: a name of the header, with or without its unit, or a number from 1.
    pub columns: Vec<(String, String)>,
    /// Units by channel.
    pub units: Vec<(String, String)>,
    /// What one unit of a column stands for, by channel: `0.5um/V`; or a plain factor.
    pub scales: Vec<(String, String)>,
    /// Signs by channel: 1 or -1.
    pub signs: Vec<(String, f64)>,
    /// Interval between samples \[s\], in place of a time column.
    pub interval: Option<f64>,
    /// Which recording of several, from 1.
    pub trial: Option<usize>,
    /// The encoding of the text.
    pub encoding: Option<Encoding>,
    /// The decimal mark, where the numbers do not say it.
    pub decimal: Option<Decimal>,
    /// Whether rows may be lost that are more than a few.
    pub accept_losses: bool,
    /// What is taken out of a displacement that is integrated.
    pub drift: DriftRemoval,
}

impl ReadingChoices {
    /// Puts the answers into a preview's settings; the questions that they answer are gone.
    ///
    /// # Errors
    /// A column, a channel or a recording that the file does not have.
    pub fn apply(&self, preview: &mut Preview) -> Result<(), ImportError> {
        if let Some(decimal) = self.decimal {
            preview.settings.decimal = decimal;
            preview.settle(Topic::Decimal);
        }
        preview.settings.accept_losses |= self.accept_losses;
        if !self.drift.is_none() {
            preview.settings.drift = self.drift;
        }
        if let Some(trial) = self.trial {
            preview.choose_trial(trial)?;
        }
        if let Some(interval) = self.interval {
            self.set_clock(interval, preview);
        }
        let mut chosen: Vec<usize> = Vec::with_capacity(self.columns.len());
        for (symbol, column) in &self.columns {
            let role = role_of("--column", symbol, preview)?;
            let index = column_named(column, preview)?;
            if chosen.contains(&index) {
                return Err(twice(symbol, column, index, preview));
            }
            chosen.push(index);
            choose(role, index, preview);
        }
        for (symbol, unit) in &self.units {
            let role = role_of("--unit", symbol, preview)?;
            set_unit(role, unit, preview);
        }
        for (symbol, scale) in &self.scales {
            let role = role_of("--scale", symbol, preview)?;
            set_scale(role, scale, preview)?;
        }
        for (symbol, sign) in &self.signs {
            let role = role_of("--sign", symbol, preview)?;
            multiply(role, *sign, &mut preview.settings);
        }
        Ok(())
    }

    /// A sampling interval: the meaning of sample numbers, or the times themselves.
    fn set_clock(&self, interval: f64, preview: &mut Preview) {
        let start = preview.settings.clock.map_or(0.0, |clock| clock.start);
        preview.settings.clock = Some(SampleClock { start, interval });
        let counts = preview
            .settings
            .time
            .as_ref()
            .is_some_and(|t| t.unit == "sample");
        if !counts {
            preview.settings.time = None;
            preview.settings.date_column = None;
        }
        preview.settle(Topic::Clock);
        preview.settle(Topic::Column(Role::Time));
        preview.settle(Topic::Unit(Role::Time));
    }
}

fn role_of(option: &'static str, symbol: &str, preview: &Preview) -> Result<Role, ImportError> {
    Role::of_symbol(symbol).ok_or_else(|| ImportError::BadSetting {
        file: preview.name.clone().into(),
        setting: option,
        value: format!("\"{symbol}\", which is none of t, V, xp and xc").into(),
    })
}

/// The column that a person means.
fn column_named(name: &str, preview: &Preview) -> Result<usize, ImportError> {
    column_meant(name, &preview.header, preview.columns).ok_or_else(|| ImportError::NoColumnNamed {
        file: preview.name.clone().into(),
        name: name.trim().into(),
        found: found_names(&preview.header).into(),
    })
}

/// One column for two channels, as where a name is a number, too.
fn twice(symbol: &str, column: &str, index: usize, preview: &Preview) -> ImportError {
    let name = preview.header.get(index).map_or("", |cell| cell.trim());
    ImportError::ColumnTwice {
        file: preview.name.clone().into(),
        choice: format!("{symbol}={column}").into(),
        column: index + 1,
        name: name.into(),
    }
}

/// Takes a column for a role, in the unit that the header gives it.
fn choose(role: Role, index: usize, preview: &mut Preview) {
    let column = preview.header.get(index).map(|cell| Column::of(cell));
    let sample = preview.samples.get(index).copied();
    let named = column.as_ref().and_then(|c| c.unit.clone());
    let kind = column.as_ref().map_or(Quantity::Displacement, |c| {
        use super::columns::units::UnitKind::{Acceleration, Velocity};
        match role {
            Role::Time | Role::Voltage => Quantity::Displacement,
            _ if c.is_rate(Velocity) => Quantity::Velocity,
            _ if c.is_rate(Acceleration) => Quantity::Acceleration,
            _ => Quantity::Displacement,
        }
    });
    preview.settle(Topic::Column(role));
    preview.settle(Topic::Unit(role));
    preview.settle(Topic::Scale(role));
    if role == Role::Time {
        preview.settle(Topic::Clock);
    }
    let known = role.of(&preview.settings).filter(|c| c.index == index);
    let kept = known.map(|c| c.unit.clone());
    let base = match role {
        Role::Time | Role::Voltage => role.base(),
        _ => kind.base_unit(),
    };
    let suggested = sample.map(|sample| match role {
        Role::Time => sample.time_unit(),
        Role::Voltage => super::columns::sample::Suggestion::Clear("V"),
        _ if kind != Quantity::Displacement => super::columns::sample::Suggestion::Clear(base),
        _ => sample.length_unit(f64::NAN),
    });
    if let (None, Some(super::columns::sample::Suggestion::Guess(_))) = (&named, suggested) {
        let error = ImportError::Undecided {
            file: preview.name.clone().into(),
            line: preview.settings.skip_lines.max(1),
            question: format!("column {} names no unit", index + 1).into(),
            options: format!(
                "--unit {}={}",
                role.symbol(),
                if base == "m" { "um" } else { base }
            )
            .into(),
        };
        let topic = Topic::Unit(role);
        preview.questions.push(Question {
            topic,
            error,
            short: None,
        });
    }
    let unit = named
        .or(kept)
        .or_else(|| suggested.map(|s| s.unit().to_owned()))
        .unwrap_or_else(|| base.to_owned());
    let choice = ColumnChoice {
        kind,
        ..ColumnChoice::new(index, unit)
    };
    // A column has one role.
    for other in Role::ALL.into_iter().filter(|other| *other != role) {
        if other
            .of(&preview.settings)
            .is_some_and(|c| c.index == index)
        {
            other.set(&mut preview.settings, None);
        }
    }
    if role == Role::Time && choice.unit != "sample" {
        preview.settings.clock = None;
    }
    role.set(&mut preview.settings, Some(choice));
}

fn set_unit(role: Role, unit: &str, preview: &mut Preview) {
    preview.settle(Topic::Unit(role));
    if role == Role::Time {
        preview.settle(Topic::Clock);
        if unit != "sample" {
            preview.settings.clock = None;
        }
    }
    if let Some(own) = role.of(&preview.settings).cloned() {
        let mut own = own;
        own.unit = unit.trim().to_owned();
        let is_motion = matches!(role, Role::ProofMass | Role::Cantilever);
        let kinds = [
            Quantity::Displacement,
            Quantity::Velocity,
            Quantity::Acceleration,
        ];
        if is_motion
            && let Some(kind) = kinds
                .into_iter()
                .find(|kind| unit_shift(&own.unit, kind.base_unit()).is_some())
        {
            own.kind = kind;
            preview.settle(Topic::Scale(role));
        }
        role.set(&mut preview.settings, Some(own));
    }
}

/// `0.5um/V` says what a unit stands for; `20`, `20V/V` or `1nm/um` is a factor.
fn set_scale(role: Role, scale: &str, preview: &mut Preview) -> Result<(), ImportError> {
    let bad = |unit: String, preview: &Preview| ImportError::BadScale {
        file: preview.name.clone().into(),
        column: role.of(&preview.settings).map_or(0, |c| c.index + 1),
        scale: scale.into(),
        unit: unit.into(),
        symbol: role.symbol(),
        base: role.base(),
    };
    if let Ok(factor) = scale.trim().parse::<f64>() {
        if !factor.is_finite() || factor == 0.0 {
            return Err(bad(String::new(), preview));
        }
        multiply(role, factor, &mut preview.settings);
        return Ok(());
    }
    let Some(mut choice) = role.of(&preview.settings).cloned() else {
        return Ok(());
    };
    let base = match role {
        Role::Time | Role::Voltage => role.base(),
        _ => choice.kind.base_unit(),
    };
    // Between units of the quantity itself it is a factor.
    if unit_shift(&choice.unit, base).is_some() && kind_of(&choice.unit).is_some() {
        let is_unit = |c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E');
        let at = scale.find(is_unit).unwrap_or(scale.len());
        let (number, units) = scale.split_at(at);
        let ratio = units.rsplit_once('/').and_then(|(now, read)| {
            Some(10f64.powi(unit_shift(now, base)? - unit_shift(read, base)?))
        });
        let number: Option<f64> = number.trim().parse().ok();
        let (Some(number), Some(ratio)) = (number, ratio) else {
            return Err(bad(choice.unit, preview));
        };
        multiply(role, number * ratio, &mut preview.settings);
        return Ok(());
    }
    if super::columns::units::sensitivity(scale, &choice.unit, base).is_none() {
        return Err(bad(choice.unit, preview));
    }
    choice.scale = Some(scale.trim().to_owned());
    role.set(&mut preview.settings, Some(choice));
    preview.settle(Topic::Scale(role));
    preview.settle(Topic::Unit(role));
    Ok(())
}

fn multiply(role: Role, factor: f64, settings: &mut ImportSettings) {
    let channel = match role {
        Role::Time => return,
        Role::Voltage => Channel::Voltage,
        Role::ProofMass => Channel::ProofMass,
        Role::Cantilever => Channel::Cantilever,
    };
    match channel {
        Channel::Voltage => settings.voltage_scale *= factor,
        Channel::ProofMass => settings.xp_scale *= factor,
        Channel::Cantilever => settings.xc_scale *= factor,
    }
}
