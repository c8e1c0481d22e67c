//! Orbit diagram (bifurcation diagram): one number is swept up, then down, and each value begins with
//! the state that the one before ended in. Where responses coexist, both ways differ (hysteresis).
//!
//! # Interface
//! [`OrbitRequest`] says what is swept; [`compute`] follows it and hands over each value as it is
//! done ([`OrbitSlice`]), in order. A slice has what to draw as points: the mass at each strobe, speeds of
//! arrival, bounces of each period of the drive; and the largest Lyapunov exponent beneath. Values that are
//! impossible are holes with their reason. The sweep is one long run, so it takes one thread and gives
//! the same bits each time.
//!
//! # Examples
//! ```
//! use std::sync::atomic::AtomicBool;
//! use impactscope::explore::map::Axis;
//! use impactscope::explore::orbit::{OrbitRequest, compute};
//! use impactscope::model::{drive::Waveform, preset::Preset};
//!
//! let model = Preset::default().model;
//! let drive = Waveform::parse("square:50Hz:7V", 0.02)?;
//! let axis = Axis::new("V", (&model, &drive), (3.0, 8.0), 3)?;
//! let diagram = compute(&OrbitRequest::new(model, drive, axis), &AtomicBool::new(false), &mut |_| {})?;
//! assert_eq!((diagram.up.len(), diagram.down.len()), (3, 3));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compute;
mod diagram;
mod request;
#[cfg(test)]
mod tests;

pub use self::compute::compute;
pub use self::diagram::{Direction, OrbitAnswer, OrbitDiagram, OrbitSlice};
pub use self::request::OrbitRequest;
