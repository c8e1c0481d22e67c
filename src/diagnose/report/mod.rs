//! What a diagnosis says, for people and programs: a summary for the terminal
//! ([`text()`]), a value for programs ([`json()`]) and a page with figures ([`html()`]).
//!
//! All three say what [`Diagnosis`](super::diagnosis::Diagnosis) holds and decide nothing themselves.
//! All sentences on findings, remarks and evidence are made in [`sentences`].

#[cfg(test)]
pub(crate) mod fixture;
pub mod force_balance;
pub mod ground;
pub mod headline;
mod html;
mod json;
pub mod rest;
pub mod sentences;
mod svg;
#[cfg(test)]
mod tests;
mod text;
pub mod words;

pub use self::headline::{headline, verdict_sentence};
pub use self::words::probability;
pub use html::html;
pub use json::json;
pub use text::text;
