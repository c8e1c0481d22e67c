//! Devices with one mode at most: a mass on a spring, a pendulum, a falling ball. No ground and no
//! drive; each run begins with a start of its own and dies away, or falls.

pub mod apparatus;
pub mod law;
pub(crate) mod law_draws;
pub(crate) mod motion;
pub(crate) mod size;
#[cfg(test)]
mod tests;
