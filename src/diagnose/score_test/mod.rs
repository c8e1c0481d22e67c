//! TODO-doc

pub mod basis_forces;
pub mod forms;
pub mod scan;
