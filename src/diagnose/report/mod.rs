//! What a diagnosis says, for people and programs: a summary for the terminal
//! ([`text()`]), a value for programs ([`json()`]) and a page with figures ([`html()`]).
//!
//! All three say what [`Diagnosis`](super::result::Diagnosis) holds and judge nothing
//! themselves.

pub mod ground;
mod html;
mod json;
pub mod rest;
mod svg;
mod text;
pub mod words;

pub use html::html;
pub use json::json;
pub use text::text;
pub use words::{headline, probability, verdict_sentence};

#[cfg(test)]
pub(crate) mod fixture;
#[cfg(test)]
mod tests;
