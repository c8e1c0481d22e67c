//! Several feet under one drive, each delayed by a share of its period: which feet are down when.
//!
//! Each foot is a device of its own that taps its own ground. There is no body: feet do not feel
//! one another, none carries another's load, and nothing falls over. What is computed is when
//! feet touch, not whether a robot walks.
//!
//! A foot's contacts come from its steady response ([`Foot`]); feet of one device and one drive
//! have the same ones, later by their delays, so that a device is solved once
//! ([`FootDevice::groups`]).

mod contact;
mod csv;
mod device;
mod error;
mod phases;
mod response;
#[cfg(test)]
mod tests;
mod timeline;

pub use self::contact::{Bar, Foot};
pub use self::csv::{contacts_csv, support_csv};
pub use self::device::{FootDevice, delayed};
pub use self::error::GaitError;
pub use self::phases::GaitPreset;
pub use self::timeline::{Gait, Support};

/// Fewest and most feet.
pub const FOOT_COUNTS: (usize, usize) = (2, 6);
