//! Identification: what a device's parameters are, and what its data can tell of them.

pub mod cma;
pub mod steps;
pub mod table_a1;
pub mod table_fit;
pub mod validate;
