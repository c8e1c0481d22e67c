//! Score tests: by how much chi2 would fall along the direction of each candidate effect in the
//! problem linearised at a fit, with everything that the free parameters can absorb projected out
//! (Rao's score test).

pub mod basis_forces;
pub mod forms;
pub(super) mod joint;
pub(super) mod linearized;
pub(super) mod reading_scales;
pub mod scan;
pub(super) mod state_range;
