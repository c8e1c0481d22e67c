//! Which recording tells which parameter. The guided identification and the remarks of a fit say the
//! same.

/// For the modes of the structure.
pub(crate) const LOW_SWEEP: &str = "a slow swept sine of low voltage over the resonances, for example 100 Hz to 10 kHz at 1 V over 10 s, without touching the ground";
/// For the branches of the drive.
pub(crate) const SLOW_CYCLES: &str = "whole slow cycles, for example 5 Hz sines of 6 V and 8 V";
/// For the restitution.
pub(crate) const TAPS: &str = "a 300 Hz square or sine that just begins to hit the ground";
/// For the adhesion.
pub(crate) const SLOW_PULLS: &str = "5 Hz ramped squares of 8 V with several lambda";
/// For the film.
pub(crate) const BREAK_OFF: &str = "a 5 Hz ramped square of 8 V, with the ring after break-off";

/// The recording that tells a parameter of the ground or the film; `None` for the others, which any
/// motion tells.
pub(crate) fn recording_for(id: &str) -> Option<&'static str> {
    match id {
        "alpha" => Some(TAPS),
        "Ca" | "Ca0" => Some(SLOW_PULLS),
        "Cs" | "gp" => Some(BREAK_OFF),
        _ => None,
    }
}
