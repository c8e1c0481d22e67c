//! Presets for one's own device: from the geometry of a beam, from a table of modes, or from a
//! mass on a spring, a pendulum or a free mass.
//!
//! Every way ends in a [`Designed`]: a [`Preset`] that the writer of presets can write, with the
//! ranges of its sliders made from the device's own lengths, times and forces, and notes on what
//! was assumed where nothing was given. Nothing is assumed without a note.
//!
//! [`describe`] reads the texts of the command line, for example
//! `L=750um,W=100um,layers=Si:5um+PZT:1um,mass_size=150x100x10um,ground=58um`.

mod beam;
mod error;
mod film;
mod lumped;
mod materials;
mod modes_table;
mod ranges;
mod setting;
#[cfg(test)]
mod tests;
mod text;

pub use self::beam::{BeamDesign, BeamMode, EndMass, Layer, Section, beam_device, beam_modes};
pub use self::error::DesignError;
pub use self::film::plate_film_coefficient;
pub use self::lumped::{FreeMass, MassOnSpring, Pendulum};
pub use self::materials::{MATERIALS, Material};
pub use self::modes_table::{ModesTable, modes_device};
pub use self::ranges::slider_ranges;
pub use self::setting::{AIR_VISCOSITY, Designed, GroundDesign, Setting};
pub use self::text::{DesignKind, describe};
