//! Modal identification from a swept sine: frequencies, damping ratios and mass-normalised shapes at
//! the measured points, with standard errors (section 3.1 of the paper, which used a sweep of 1 V and
//! the circle fit).
//!
//! 1. [`time_domain::data`]: the readings as stretches free of the ground; the input is `gc(V, V')` by the
//!    device's branches, or the voltage. At 1 V the branches are far from a straight line, and their
//!    jumps at each turn of the voltage excite all modes at once.
//! 2. [`frequency_domain::spectra`]: responses by windowed spectra, H1, H2 and Hv with coherence.
//! 3. [`frequency_domain::search`] finds a resonance in what is left of the readings,
//!    [`time_domain::least_squares`] fits all modes found so far with residual terms; again, until
//!    another mode gains nothing that chance would not.
//! 4. [`frequency_domain::circle`]: the circle fit of Kennelly and Pancu for each mode, beside.
//! 5. [`shapes`]: mode shapes from residues, by `eta` or a known mass or stiffness.
//!
//! [`identify()`] runs all of it; [`ModalFit::apply`] gives a device the modes found.

mod error;
mod finish;
pub mod frequency_domain;
mod identify;
mod remarks;
mod result;
mod search;
pub mod shapes;
mod sweeps;
#[cfg(test)]
mod tests;
pub mod thresholds;
pub mod time_domain;

pub use self::error::ModalError;
pub use self::identify::identify;
pub use self::result::{IdentifiedMode, InputChoice, ModalFit, ModalOptions, Quality};
pub use self::shapes::{Estimate, Normalisation, Shape};
pub use self::sweeps::{is_sweep, sweeps_clear_of_ground};
