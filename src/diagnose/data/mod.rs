//! What the recordings show before any model is fitted: whether they can be used at all, which of
//! their segments are free of events at the ground, how noisy they are and how the level of the
//! ground drifts.

pub mod event_free_segments;
pub(super) mod level_drift;
pub(super) mod misread_segments;
pub(super) mod missed_contacts;
pub mod noise_model;
pub(super) mod reading_assumptions;
pub(super) mod rest_level;
pub(super) mod robust_loss;
pub mod screening;
pub(super) mod side;
pub(super) mod walking_zero;
