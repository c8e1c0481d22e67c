//! The search: bounded, robust Levenberg-Marquardt over all segments, from several starts.
//!
//! [`multistart`] draws the starts and orders the stages, [`levenberg_marquardt`] takes the steps
//! by the normal equations of all segments, [`event_revision`] corrects misread events.

pub(crate) mod budget;
pub(super) mod estimate_states;
pub(super) mod event_alternatives;
pub mod event_revision;
pub(crate) mod event_trial;
pub mod levenberg_marquardt;
pub mod multistart;
pub(crate) mod normal_equations;
pub(crate) mod point;
pub(super) mod predicted_events;
pub(crate) mod start_film;
