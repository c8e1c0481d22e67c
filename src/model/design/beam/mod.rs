//! Cantilevers with a rigid mass at their end: section, modes, and the device that they make.

pub mod device;
mod modes;
mod section;

pub use self::device::beam_device;
pub use self::modes::{BeamMode, beam_modes};
pub use self::section::{BeamDesign, EndMass, Layer, Section};
