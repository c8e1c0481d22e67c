//! The paper's Table A.1: 16 cases with peak, contact time and number of bounces, the comparison
//! with it (Table 3), a fit to it by CMA-ES, and the ranking of effects that could be missing.

pub mod calibrate;
pub mod cma_es;
pub mod compare;
pub mod measurements;
pub mod rank_effects;
