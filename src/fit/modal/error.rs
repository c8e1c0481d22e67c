//! Why a sweep tells no modes.

use thiserror::Error;

/// Why modes cannot be identified.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModalError {
    /// No recording was given.
    #[error(
        "no recording was given; give a swept sine of low voltage, for example 100 Hz to 10 kHz at 1 V over 10 s"
    )]
    NoRecording,
    /// A recording has no voltage.
    #[error("{recording} has no V: the modes need it; record it, or name its column on import")]
    NoVoltage {
        /// Name of the recording.
        recording: String,
    },
    /// The voltage is no drive.
    #[error("{recording}: {reason}; check the column of V")]
    Drive {
        /// Name of the recording.
        recording: String,
        /// What is wrong.
        reason: String,
    },
    /// The recording does not excite a band of frequencies.
    #[error(
        "{recording}: {reason}; record a swept sine of low voltage over the resonances, so small that the mass stays clear of the ground"
    )]
    NoSweep {
        /// Name of the recording.
        recording: String,
        /// What it lacks.
        reason: String,
    },
    /// Nothing rises above the noise.
    #[error(
        "no resonance rises above the noise between {from} and {to}; sweep more slowly, with more voltage, or over another band"
    )]
    NoMode {
        /// Lowest frequency looked at.
        from: String,
        /// Highest.
        to: String,
    },
    /// The equations cannot be solved.
    #[error("the modes cannot be told apart: {reason}; record a longer sweep")]
    Singular {
        /// What failed.
        reason: String,
    },
    /// Cancelled by the user.
    #[error("cancelled")]
    Cancelled,
}
