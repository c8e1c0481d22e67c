//! One period of a periodic drive, in shares of the period.

use std::sync::Arc;

use super::handles::{Handles, line_pieces, sine_pieces};
use super::{DriveError, HIGHEST_VOLTAGE, Segment, within};

/// Usual share of the period that a square is high, or a triangle rises.
pub(super) const EVEN_SHARE: f64 = 0.5;

/// The form of one period. Amplitudes in V, without the drive's offset.
#[derive(Debug, Clone, PartialEq)]
pub enum Cycle {
    /// `A sin(2 pi u)`, `u` the share of the period.
    Sine { amplitude: f64 },
    /// `+A` for the share `duty` of the period, then `-A`.
    Square { amplitude: f64, duty: f64 },
    /// Starts at 0, rising; rises for the share `asymmetry` of the period. At 1 it is a sawtooth
    /// that rises, at 0 one that falls.
    Triangle { amplitude: f64, asymmetry: f64 },
    /// Rises from `-A` over the share `lambda`, holds until `duty`, falls over `lambda`, holds
    /// (fig. 6 of the paper, where `duty` is 1/2).
    Ramped {
        amplitude: f64,
        lambda: f64,
        duty: f64,
    },
    /// Drawn by hand.
    Drawn(Arc<Handles>),
}

impl Cycle {
    /// The name in the text form.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Sine { .. } => "sine",
            Self::Square { .. } => "square",
            Self::Triangle { .. } => "triangle",
            Self::Ramped { .. } => "ramped",
            Self::Drawn(_) => "drawn",
        }
    }

    /// Amplitude \[V\], signed; of a drawn period the largest voltage by magnitude.
    pub fn amplitude(&self) -> f64 {
        match self {
            Self::Sine { amplitude }
            | Self::Square { amplitude, .. }
            | Self::Triangle { amplitude, .. }
            | Self::Ramped { amplitude, .. } => *amplitude,
            Self::Drawn(handles) => handles.amplitude(),
        }
    }

    /// The same with another amplitude \[V\].
    ///
    /// # Errors
    /// [`DriveError::Value`] for a drawn period without a voltage, and for one that would lose
    /// its form.
    pub fn with_amplitude(&self, new: f64) -> Result<Self, DriveError> {
        let mut cycle = self.clone();
        match &mut cycle {
            Self::Sine { amplitude }
            | Self::Square { amplitude, .. }
            | Self::Triangle { amplitude, .. }
            | Self::Ramped { amplitude, .. } => *amplitude = new,
            Self::Drawn(handles) => {
                let old = handles.amplitude();
                if old == 0.0 || new == 0.0 {
                    return Err(DriveError::Value(format!(
                        "a drawn period of {old} V cannot be scaled to {new} V; its form would be lost, so move its handles"
                    )));
                }
                *handles = Arc::new(handles.scaled(new / old)?);
            }
        }
        Ok(cycle)
    }

    /// Checks all values.
    ///
    /// # Errors
    /// [`DriveError::Value`] naming the value and its range.
    pub fn check(&self) -> Result<(), DriveError> {
        let limit = HIGHEST_VOLTAGE;
        within("amplitude", self.amplitude(), -limit, limit, "V")?;
        match *self {
            Self::Square { duty, .. } => within("duty", duty, 0.0, 1.0, ""),
            Self::Triangle { asymmetry, .. } => within("asymmetry", asymmetry, 0.0, 1.0, ""),
            Self::Ramped { lambda, duty, .. } => {
                within("duty", duty, 0.0, 1.0, "")?;
                // The ramps must end before the voltage turns back.
                within("lambda", lambda, 0.0, duty.min(1.0 - duty), "")
            }
            Self::Sine { .. } | Self::Drawn(_) => Ok(()),
        }
    }

    /// The period as smooth pieces from 0 to 1 without gaps; the branches are still to be found.
    pub(super) fn pieces(&self) -> Vec<Segment> {
        match *self {
            Self::Sine { amplitude } => sine_pieces(amplitude),
            Self::Square { amplitude: a, duty } => {
                line_pieces(&[(0.0, a), (duty, a), (duty, -a), (1.0, -a)])
            }
            Self::Triangle {
                amplitude: a,
                asymmetry,
            } => {
                let quarter = 0.5 * asymmetry;
                line_pieces(&[(0.0, 0.0), (quarter, a), (1.0 - quarter, -a), (1.0, 0.0)])
            }
            Self::Ramped {
                amplitude: a,
                lambda,
                duty,
            } => line_pieces(&[
                (0.0, -a),
                (lambda, a),
                (duty, a),
                ((duty + lambda).min(1.0), -a),
                (1.0, -a),
            ]),
            Self::Drawn(ref handles) => handles.pieces(),
        }
    }
}
