//! Frequency responses by windowed spectra, the search for resonances, and the circle fit.

pub mod circle;
pub mod search;
pub mod spectra;
