//! What the device is; no time stepping.

pub mod unit;
