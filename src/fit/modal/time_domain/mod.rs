//! The rational model in the time domain: readings and input, the sampled oscillator, least squares.

pub mod data;
pub mod input;
pub mod kernel;
pub mod least_squares;
mod normal;
