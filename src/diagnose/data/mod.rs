//! TODO-doc

pub mod event_free_segments;
pub(super) mod level_drift;
pub(super) mod misread_segments;
pub(super) mod missed_contacts;
pub mod noise_model;
pub(super) mod reading_assumptions;
pub(super) mod robust_loss;
pub mod screening;
pub(super) mod side;
