//! Hypotheses on what is missing: each family of effects proposes starting values, from the score
//! test, a search over time or frequency, or the residuals.

pub(super) mod base_vibration;
pub(super) mod extra_mode;
pub(super) mod lag_twins;
pub(super) mod level_step;
pub(super) mod level_step_time;
pub mod propose;
pub(super) mod raised_level;
pub(super) mod second_mode;
pub(super) mod vibration_clock;
