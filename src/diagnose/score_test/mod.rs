//! TODO-doc

pub mod basis_forces;
pub mod forms;
pub(super) mod joint;
pub(super) mod linearized;
pub mod scan;
pub(super) mod state_range;
