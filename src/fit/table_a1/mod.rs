//! TODO-doc

pub mod calibrate;
pub mod cma_es;
pub mod compare;
pub mod measurements;
pub mod rank_effects;
