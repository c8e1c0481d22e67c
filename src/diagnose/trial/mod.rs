//! Sealed trials.
pub mod beam;
pub mod bench;
pub mod device;
pub mod hybrid;
pub mod integrator;
pub mod preisach;
pub mod structure;
pub mod terms;
pub mod voltage;
#[cfg(test)]
mod solver_tests;
pub mod dice;
pub mod law;
pub mod menu;
