//! The hybrid simulator: flight, events, contact.
//!
//! [`simulate`] is a pure function of model, drive and options. [`Runner`] does the
//! same piece by piece, for a device that runs live while its parameters change.

mod trace;

pub use trace::{Event, EventKind, ForceTraces, Trace};
