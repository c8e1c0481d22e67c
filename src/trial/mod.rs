//! Sealed trials: recordings of a device with a concealed effect, made by another model
//! and another solver than the instrument's, and the score of what a diagnosis says.
//!
//! Nothing here uses the simulator or the laws of the instrument. A device is a set of
//! mass, damping and stiffness matrices ([`device::structure`], [`device::beam`]) under forces
//! in formulations of their own ([`concealed`]), followed by a Runge-Kutta pair with root
//! finding ([`hybrid::integrator`], [`hybrid`]). [`Case::draw`] draws
//! device, instruments and effect from a seed, sized by how visible they are ([`mod@visibility`]).
//!
//! A rig ([`mod@rigs`]) says which kind of device is read by which instruments: impact actuators with
//! good and with poor ones, masses on springs, balls and pendulums ([`one_mode`]), and all of them in
//! other units ([`rescale`]).
//!
//! [`Recordings`] is all that a diagnosis is given; the truth waits in an [`Envelope`]
//! whose seal is published first. Devices that no preset of the program describes bring the one that a
//! person with such a device would have ([`Case::preset`]).

// Sums over indices read as in the texts; a comparison is negated where a NaN must fail it.
#![allow(
    clippy::needless_range_loop,
    clippy::manual_memcpy,
    clippy::neg_cmp_op_on_partial_ord
)]

#[cfg(test)]
pub(crate) mod case_tests;
pub mod concealed;
pub mod demo;
pub mod device;
pub(crate) mod draw;
pub(crate) mod files;
pub mod hybrid;
pub mod instrument;
pub mod one_mode;
pub mod rescale;
pub mod rig;
pub mod rigs;
pub mod rng;
pub mod score;
pub(crate) mod shuffle;
#[cfg(test)]
mod tests;
pub(crate) mod truth;
pub mod visibility;
pub mod voltage;

pub use self::draw::settings::RIG_SIZES;
pub use self::draw::size::visibility;
pub use self::draw::{Case, Mix, Recordings, RigChoice, Settings, TrialError};
pub use self::files::{CaseFiles, write_case, write_preset, write_truth};
pub use self::instrument::StructureKind;
pub use self::truth::{Class, ConcealedEffect, DeviceTruth, Envelope, RecordingNote, Truth};
