//! Why a device cannot be made of what was given.

use thiserror::Error;

use crate::model::ModelError;
use crate::model::unit::UnitError;

/// What is wrong with the description of a device, where, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DesignError {
    /// A part of the text that is no `key=value`, or a key that there is not.
    #[error("\"{field}\": {reason}")]
    Field {
        /// The part of the text.
        field: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A value that is no quantity of its unit.
    #[error("{key}: {source}")]
    Quantity {
        /// The key.
        key: String,
        /// What is wrong with the text.
        source: UnitError,
    },
    /// A value that no device has.
    #[error("{what}: {reason}")]
    Value {
        /// The key or the quantity.
        what: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A table of modes that cannot be read.
    #[error("{file}, line {line}, column {column}: {reason}")]
    Table {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column of the table, from 1.
        column: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// The device as a whole makes no sense.
    #[error("the device makes no sense: {0}")]
    Model(#[from] ModelError),
}

impl DesignError {
    pub(super) fn value(what: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Value {
            what: what.into(),
            reason: reason.into(),
        }
    }
}

/// That a quantity is a finite number above 0.
pub(super) fn positive(what: &str, value: f64, unit: &str) -> Result<f64, DesignError> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    let reason = format!("must be a finite number above 0 {unit}, not {value}");
    Err(DesignError::value(what, reason))
}

/// That a quantity is a finite number and not negative.
pub(super) fn not_negative(what: &str, value: f64, unit: &str) -> Result<f64, DesignError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    let reason = format!("must be a finite number, not below 0 {unit}, not {value}");
    Err(DesignError::value(what, reason))
}
