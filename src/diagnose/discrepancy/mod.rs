//! What a fit leaves: where its residuals are, which force would remove them, whether segments
//! join, how far whole runs are off, which spectral peaks and rings remain, and whether named laws have
//! the wrong form.

mod excitations;
pub(super) mod impact_ring;
pub mod law_form;
pub mod missing_force;
pub(super) mod probes;
pub mod residual_map;
pub mod residual_spectrum;
pub(super) mod segment_joins;
pub(super) mod whole_runs;
