//! The steady response under a periodic drive: periodic with one or several periods of the drive,
//! or not periodic.
//!
//! The stroboscopic map takes the state at one instant of the drive's period (strobe) to that a
//! period later: modal displacements and velocities, the effects' states, and the phase of the
//! contact. A mass that is held at the strobe has one coordinate less and the age of its contact
//! instead. A periodic response is a fixed point of the map or of one of its powers.
//!
//! [`SteadySolver::solve`] follows the transient, period by period, until states recur. Where the
//! transient dies slowly, it solves for the fixed point by Newton's method (shooting), provided
//! that this is cheaper, that the sequence of events repeats, and that the response is not near
//! grazing. An answer is accepted only if the simulated period leads back to it and, after shooting,
//! only if it is stable.
//!
//! At grazing, where the mass touches the ground with no speed, the map has a square root: its
//! Jacobian grows without bound on one side (A. B. Nordmark, J. Sound Vib. 145 (1991) 279), and so
//! Newton's method and multipliers mislead (I. Ghosh, D. J. W. Simpson, arXiv:2005.10268). Near it
//! [`Grazing::is_near`] is set, transients alone decide, and no multipliers are given.
//!
//! # Examples
//! ```
//! use impactscope::explore::steady_state::{ResponseKind, Start, SteadyOptions, SteadySolver};
//! use impactscope::model::{drive::Waveform, preset::Preset};
//!
//! let mut solver = SteadySolver::new(&Preset::default().model, SteadyOptions::default())?;
//! let drive = Waveform::parse("square:50Hz:7V", 0.02)?;
//! let response = solver.solve(&drive, Start::Rest)?;
//! assert_eq!(response.kind, ResponseKind::Periodic { multiple: 1 });
//! assert!(response.cycle.arrivals.iter().all(|a| a.time < response.period));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chaos;
mod coordinates;
mod error;
mod grazing;
mod options;
mod recurrence;
mod response;
mod shooting;
mod solver;
mod stroboscope;
#[cfg(test)]
mod tests;

pub use self::error::SteadyError;
pub use self::grazing::Grazing;
pub use self::options::SteadyOptions;
pub use self::response::{
    Aperiodicity, Cycle, Method, ResponseKind, Stability, SteadyResponse, StrobePoint,
};
pub use self::solver::{Start, SteadySolver};
