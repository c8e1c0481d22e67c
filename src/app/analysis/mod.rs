//! Long computations (fit, identification, sensitivity, diagnosis, sealed trial) and their
//! results. Each runs on a thread of its own and changes nothing that the person did not ask for.

pub mod diagnosis;
pub(super) mod diagnosis_answer;
pub mod diagnosis_view;
pub mod explore;
pub mod fit;
pub mod identification;
pub mod job;
pub mod learning;
pub(super) mod origin;
pub(super) mod recording_noise;
pub mod recording_roles;
pub mod sealed_trial;
pub mod sensitivity;
