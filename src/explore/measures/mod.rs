//! Measures of one steady cycle: how the device taps the ground, how hard, at what cost, and how
//! near it is to tapping otherwise.
//!
//! [`MEASURES`] is the table that the command line, maps and the window read. Most measures rest on the
//! events that a response holds; those of [`Basis::Integrals`] simulate the cycle once more.

mod catalogue;
mod contact;
mod margin;
mod regime;
#[cfg(test)]
mod tests;
mod values;

pub use self::catalogue::{Basis, Drawn, MEASURES, MeasureId, MeasureSpec};
pub use self::margin::{Margin, MarginKind};
pub use self::regime::Regime;
pub use self::values::{EnergyBalance, measure, value};
