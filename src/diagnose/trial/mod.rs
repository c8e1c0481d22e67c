//! Sealed trials: recordings of a device with a concealed effect, made by another model
//! and another solver than the instrument's, and the score of what a diagnosis says.
//!
//! Nothing here uses the simulator or the laws of the instrument. A device is a set of
//! mass, damping and stiffness matrices ([`structure`], [`beam`]) under forces in
//! formulations of their own ([`terms`], [`law`], [`preisach`]), followed by a
//! Runge-Kutta pair with root finding ([`integrator`], [`hybrid`]). [`Case::draw`] draws
//! device, rig and effect from a seed, sized by how visible they are ([`visibility`]).
//!
//! [`Recordings`] is all that a diagnosis is given; the truth waits in an [`Envelope`]
//! whose seal is published first.

// Sums over indices read as in the texts; a comparison is negated where a NaN must fail it.
#![allow(
    clippy::needless_range_loop,
    clippy::manual_memcpy,
    clippy::neg_cmp_op_on_partial_ord
)]

pub mod beam;
pub mod bench;
pub mod device;
pub mod dice;
mod draw;
mod files;
pub mod hybrid;
pub mod integrator;
pub mod law;
pub mod menu;
pub mod preisach;
pub mod rig;
pub mod score;
mod shuffle;
pub mod structure;
pub mod terms;
mod truth;
pub mod visibility;
pub mod voltage;

pub use draw::{Case, Mix, Recordings, Settings, TrialError, visibility};
pub use files::{CaseFiles, write_case, write_truth};
pub use rig::StructureKind;
pub use truth::{Class, ConcealedEffect, Envelope, RecordingNote, Truth};

#[cfg(test)]
mod case_tests;
#[cfg(test)]
mod solver_tests;
