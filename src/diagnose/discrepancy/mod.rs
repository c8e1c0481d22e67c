//! TODO-doc

pub(super) mod impact_ring;
pub mod law_form;
pub mod missing_force;
pub(super) mod probes;
pub mod residual_map;
pub mod residual_spectrum;
pub(super) mod segment_joins;
