//! Basins of attraction: which response each initial displacement and velocity, or each phase of switching
//! on, leads to.
//!
//! # Interface
//! [`BasinRequest`] says device, drive and which beginnings ([`Beginnings`]); [`compute`] follows
//! each until its response is steady, by transients alone, and tells responses apart by the states at
//! their strobes. It hands over a whole [`BasinMap`] after each pass, coarse beginnings first; numbers of
//! responses stay the same in later passes. The share of a basin is its part of the beginnings
//! that led anywhere. Responses that do not repeat count as one, because two runs on one such response share no state.
//!
//! # Examples
//! ```
//! use std::sync::atomic::AtomicBool;
//! use impactscope::explore::basin::{BasinRequest, Beginnings, compute};
//! use impactscope::model::{drive::Waveform, preset::Preset};
//!
//! let model = Preset::default().model;
//! let drive = Waveform::parse("square:50Hz:3V", 0.02)?;
//! let request = BasinRequest::new(model, drive, Beginnings::Phases { count: 4 });
//! let map = compute(&request, &AtomicBool::new(false), &|_| {})?;
//! let shares: f64 = map.responses.iter().map(|r| r.share).sum();
//! assert!((shares - 1.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compute;
mod request;
mod responses;
#[cfg(test)]
mod tests;

pub use self::compute::{BasinMap, BasinPoint, compute};
pub use self::request::{BasinRequest, Beginnings};
pub use self::responses::BasinResponse;
