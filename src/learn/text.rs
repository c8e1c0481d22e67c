//! Texts of a lesson with numbers that are computed: `{contact_time:ms}`.
//!
//! | placeholder | what it shows |
//! |---|---|
//! | `{impact_speed}` | a measure or parameter, with a unit that suits its size |
//! | `{contact_time:ms}` | the same in a given unit |
//! | `{contact_share:%:2}` | an expression in a given unit, with 2 digits; `%` is a unit of its own |
//! | `{rebound_height:mm @ alpha=0.9}` | the same of the scene with another value |
//! | `{0.3 m = x0 + dp}` | the text on the left, checked against the expression on the right |
//!
//! `{{` and `}}` are braces.

use thiserror::Error;

use super::expression::{Expression, ExpressionError};
use super::run::{Run, Scene};
use crate::model::drive::Waveform;
use crate::model::unit::{format_number, format_quantity, unit_factor};

/// The name of the drive among changes of a scene.
const DRIVE_KEY: &str = "drive";
/// The name of the span among changes of a scene.
const DURATION_KEY: &str = "duration";
/// Span of a chirp after `@` that names none \[s\].
const USUAL_DRIVE_SPAN: f64 = 1.0;
/// Digits of a number without a number of its own.
const USUAL_DIGITS: usize = 3;
/// SI units whose prefixes and multiples may be asked for.
const BASE_UNITS: [&str; 12] = [
    "s", "m", "m/s", "m/s^2", "N", "V", "Hz", "J", "kg", "rad", "N/m", "N m^2 s",
];
/// Two numbers are the same if they differ by less than this share of the last written digit.
const ROUNDING_SHARE: f64 = 0.5 + 1e-6;

/// A text with computed numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    source: String,
    parts: Vec<Part>,
}

#[derive(Debug, Clone, PartialEq)]
enum Part {
    Plain(String),
    Number(Number),
}

/// A number of a text.
#[derive(Debug, Clone, PartialEq)]
struct Number {
    expression: Expression,
    unit: Option<String>,
    digits: usize,
    /// What the text states, if it does not show the computed value.
    stated: Option<String>,
    /// What of the scene differs for this number: id and value, or `drive` and its text.
    changes: Vec<(String, Change)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Change {
    Value(f64),
    Drive(Waveform),
}

/// A text that cannot be read, or does not hold.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TextError {
    /// A brace is missing.
    #[error(
        "the placeholder at \"{0}\" does not end; write {{...}} and double a brace of the text"
    )]
    Open(String),
    /// The expression is wrong.
    #[error(transparent)]
    Expression(#[from] ExpressionError),
    /// The unit is none.
    #[error("\"{0}\" is no unit; write for example ms, um, nN, mm/s, Hz, % or deg")]
    Unit(String),
    /// What stands after `@`.
    #[error("\"{0}\" after @ is no change; write for example @ alpha=0.9, gravity.g=1.6")]
    Change(String),
    /// A stated number is not what is computed.
    #[error("the text states {stated}, but {expression} is {found}")]
    Differs {
        /// As written.
        stated: String,
        /// As computed.
        expression: String,
        /// Its value in the same unit.
        found: String,
    },
    /// A number outside of a placeholder.
    #[error(
        "the number {0} is not computed; write it as a placeholder such as {{contact_time:ms}}, or with its check, {{{0} = alpha}}"
    )]
    Bare(String),
    /// The changed scene cannot be simulated.
    #[error("{0}")]
    Scene(String),
}

impl Text {
    /// Reads a text.
    ///
    /// # Errors
    /// [`TextError`], for what can be seen without a run.
    pub fn parse(source: &str) -> Result<Self, TextError> {
        let mut parts = Vec::new();
        let mut plain = String::new();
        let mut rest = source;
        while let Some(at) = rest.find(['{', '}']) {
            let (before, after) = rest.split_at(at);
            plain.push_str(before);
            let brace = if after.starts_with('{') { '{' } else { '}' };
            if after.chars().nth(1) == Some(brace) {
                plain.push(brace);
                rest = after.get(2..).unwrap_or_default();
                continue;
            }
            let shown = || after.chars().take(20).collect::<String>();
            let end = after.find('}').filter(|_| brace == '{');
            let end = end.ok_or_else(|| TextError::Open(shown()))?;
            check_plain(&plain)?;
            parts.push(Part::Plain(std::mem::take(&mut plain)));
            let inner = after.get(1..end).unwrap_or_default();
            parts.push(Part::Number(Number::parse(inner)?));
            rest = after.get(end + 1..).unwrap_or_default();
        }
        plain.push_str(rest);
        check_plain(&plain)?;
        parts.push(Part::Plain(plain));
        Ok(Self {
            source: source.to_owned(),
            parts,
        })
    }

    /// The text as it stands in the file.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Whether it states numbers.
    pub fn has_numbers(&self) -> bool {
        self.numbers().next().is_some()
    }

    fn numbers(&self) -> impl Iterator<Item = &Number> {
        self.parts.iter().filter_map(|part| match part {
            Part::Number(number) => Some(number),
            Part::Plain(_) => None,
        })
    }

    /// Calls `with` with each name in its expressions and changes.
    ///
    /// # Errors
    /// The first of `with`.
    pub fn each_name<E>(&self, with: &mut dyn FnMut(&str) -> Result<(), E>) -> Result<(), E> {
        for number in self.numbers() {
            number.expression.each_name(with)?;
            let ids = number.changes.iter().map(|(id, _)| id);
            for id in ids.filter(|id| ![DRIVE_KEY, DURATION_KEY].contains(&id.as_str())) {
                with(id)?;
            }
        }
        Ok(())
    }

    /// The text with the numbers of a scene and its run.
    ///
    /// # Errors
    /// [`TextError`]: a measure that the run does not have, or a stated number that does not hold.
    pub fn written(&self, scene: &Scene, run: &Run) -> Result<String, TextError> {
        let mut text = String::new();
        for part in &self.parts {
            match part {
                Part::Plain(plain) => text.push_str(plain),
                Part::Number(number) => text.push_str(&number.written(scene, run)?),
            }
        }
        Ok(text)
    }
}

/// A digit in plain text is a number that nothing computes. Those in words such as `x0` are names.
fn check_plain(plain: &str) -> Result<(), TextError> {
    let is_part = |c: char| c.is_alphanumeric() || matches!(c, '.' | ',' | '_' | '/' | '-');
    for word in plain.split(|c: char| !is_part(c)) {
        let word = word.trim_matches(|c: char| !c.is_alphanumeric());
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            return Err(TextError::Bare(word.to_owned()));
        }
    }
    Ok(())
}

/// SI value of one `unit`, with the SI unit: `1e-3` and `s` for `ms`. `%` is a unit of its own.
pub fn unit_scale(unit: &str) -> Option<(f64, &'static str)> {
    if unit == "%" {
        return Some((0.01, ""));
    }
    if unit.is_empty() {
        return Some((1.0, ""));
    }
    let known = BASE_UNITS.iter();
    let mut scales = known.filter_map(|base| Some((unit_factor(unit, base)?, *base)));
    scales.next()
}

impl Number {
    fn parse(inner: &str) -> Result<Self, TextError> {
        let (inner, changes) = match inner.split_once('@') {
            Some((inner, changes)) => (inner, read_changes(changes)?),
            None => (inner, Vec::new()),
        };
        if let Some((stated, expression)) = inner.split_once('=') {
            let stated = stated.trim().to_owned();
            split_stated(&stated).ok_or_else(|| TextError::Unit(stated.clone()))?;
            return Ok(Self {
                expression: Expression::parse(expression)?,
                unit: None,
                digits: USUAL_DIGITS,
                stated: Some(stated),
                changes,
            });
        }
        let mut fields = inner.split(':');
        let expression = Expression::parse(fields.next().unwrap_or_default())?;
        let unit = fields.next().map(|unit| unit.trim().to_owned());
        let unit = unit.filter(|unit| !unit.is_empty());
        if let Some(unit) = unit.as_ref().filter(|unit| unit_scale(unit).is_none()) {
            return Err(TextError::Unit(unit.clone()));
        }
        let digits = match fields.next().map(str::trim) {
            None => USUAL_DIGITS,
            Some(digits) => match digits.parse() {
                Ok(digits @ 1..=9) => digits,
                _ => return Err(TextError::Unit(digits.to_owned())),
            },
        };
        Ok(Self {
            expression,
            unit,
            digits,
            stated: None,
            changes,
        })
    }

    fn value(&self, scene: &Scene, run: &Run) -> Result<f64, TextError> {
        let of = |run: &Run| self.expression.value(&|id, nth| run.value(id, nth));
        if self.changes.is_empty() {
            return Ok(of(run)?);
        }
        let mut changed = scene.clone();
        for (id, value) in &self.changes {
            match value {
                Change::Value(span) if id == DURATION_KEY => changed.duration = *span,
                Change::Drive(drive) => changed.drive = drive.clone(),
                Change::Value(value) => {
                    let set = changed.preset.model.set(id, *value);
                    set.map_err(|error| TextError::Scene(error.to_string()))?;
                }
            }
        }
        match changed.run(&|| true) {
            Ok(Some(run)) => Ok(of(&run)?),
            Ok(None) => Err(TextError::Scene("the run was given up".to_owned())),
            Err(error) => Err(TextError::Scene(error.to_string())),
        }
    }

    fn written(&self, scene: &Scene, run: &Run) -> Result<String, TextError> {
        let value = self.value(scene, run)?;
        if let Some(stated) = &self.stated {
            let (number, step, unit) =
                split_stated(stated).ok_or_else(|| TextError::Unit(stated.clone()))?;
            let (factor, _) = unit_scale(unit).unwrap_or((1.0, ""));
            let found = value / factor;
            if (found - number).abs() > ROUNDING_SHARE * step {
                return Err(TextError::Differs {
                    stated: stated.clone(),
                    expression: self.expression.to_string(),
                    found: format!("{} {unit}", format_number(found, 5)),
                });
            }
            return Ok(on_screen(stated));
        }
        match &self.unit {
            Some(unit) => {
                let (factor, _) = unit_scale(unit).unwrap_or((1.0, ""));
                let number = format_number(value / factor, self.digits);
                Ok(format!("{number} {}", on_screen(unit)))
            }
            None => {
                let name = self.expression.single_name();
                let base = name.and_then(|id| run.unit_of(id)).unwrap_or_default();
                Ok(format_quantity(value, base, self.digits))
            }
        }
    }
}

/// A unit as it is shown: micro with its sign.
fn on_screen(unit: &str) -> String {
    let prefixed = ["um", "uN", "us", "uJ", "ug"];
    let mut shown = unit.to_owned();
    for text in prefixed {
        shown = shown.replace(text, &text.replacen('u', "\u{b5}", 1));
    }
    shown
}

/// A stated number: its value, the step of its last digit, and its unit.
fn split_stated(text: &str) -> Option<(f64, f64, &str)> {
    let end = text
        .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-')))
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let decimals = number.split_once('.').map_or(0, |(_, after)| after.len());
    let unit = unit.trim();
    unit_scale(unit)?;
    Some((number.parse().ok()?, 10f64.powi(-(decimals as i32)), unit))
}

fn read_changes(text: &str) -> Result<Vec<(String, Change)>, TextError> {
    let each = text.split(',').map(|change| {
        let (id, value) = change.split_once('=')?;
        let (id, value) = (id.trim(), value.trim());
        let value = match id {
            DRIVE_KEY => Change::Drive(Waveform::parse(value, USUAL_DRIVE_SPAN).ok()?),
            _ => Change::Value(value.parse().ok()?),
        };
        Some((id.to_owned(), value))
    });
    let changes: Option<Vec<_>> = each.collect();
    changes.ok_or_else(|| TextError::Change(text.trim().to_owned()))
}
