//! What is asked of a basin.

use crate::explore::map::MapError;
use crate::explore::steady_state::SteadyOptions;
use crate::model::Model;
use crate::model::drive::Waveform;

/// Most beginnings: each is a whole transient.
const MOST_BEGINNINGS: usize = 1_000_000;
/// Responses are one if their strobes differ by less than this share of their size. A hundred times
/// the recurrence, so that one response is never two.
const SAME_RESPONSE_SHARE: f64 = 1e-3;
/// Longest that a beginning is followed \[s of device time\].
const POINT_DEVICE_SECONDS: f64 = 100.0;

/// Where responses begin.
#[derive(Debug, Clone, PartialEq)]
pub enum Beginnings {
    /// Initial displacements and velocities of the mass, the drive switched on at a phase.
    Plane {
        /// Lowest and highest displacement \[m\].
        displacement: (f64, f64),
        /// Lowest and highest velocity [m/s].
        velocity: (f64, f64),
        /// Number of displacements and of velocities, with both ends.
        count: (usize, usize),
        /// Phase of the drive at which it is switched on, from 0 to below 1.
        switched_on: f64,
    },
    /// From rest, the drive switched on at so many phases from 0 to below 1.
    Phases {
        /// How many.
        count: usize,
    },
}

/// A basin that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct BasinRequest {
    /// The device.
    pub model: Model,
    /// The drive.
    pub drive: Waveform,
    /// Where responses begin.
    pub beginnings: Beginnings,
    /// How steady states are searched; shooting would lead elsewhere than the transient.
    pub options: SteadyOptions,
    /// Responses are one if their strobes differ by less than this share of their size.
    pub tolerance: f64,
    /// Longest that a beginning is followed \[s of device time\]; it is a hole then.
    pub point_device_seconds: f64,
}

impl BasinRequest {
    /// With usual choices.
    #[must_use]
    pub fn new(model: Model, drive: Waveform, beginnings: Beginnings) -> Self {
        let options = SteadyOptions {
            shooting: false,
            ..SteadyOptions::for_maps(&model)
        };
        Self {
            model,
            drive,
            beginnings,
            options,
            tolerance: SAME_RESPONSE_SHARE,
            point_device_seconds: POINT_DEVICE_SECONDS,
        }
    }

    /// Beginnings along each direction.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        match self.beginnings {
            Beginnings::Plane { count, .. } => count,
            Beginnings::Phases { count } => (count, 1),
        }
    }

    /// Displacement \[m\], velocity [m/s] and phase of a beginning; the first two are `None` for rest.
    /// Index `i + j * shape().0`.
    #[must_use]
    pub fn beginning(&self, index: usize) -> (Option<(f64, f64)>, f64) {
        let first = self.shape().0.max(1);
        let (i, j) = (index % first, index / first);
        let along = |(low, high): (f64, f64), at: usize, count: usize| {
            low + (high - low) * at as f64 / count.saturating_sub(1).max(1) as f64
        };
        match self.beginnings {
            Beginnings::Plane {
                displacement,
                velocity,
                count,
                switched_on,
            } => {
                let x = along(displacement, i, count.0);
                (Some((x, along(velocity, j, count.1))), switched_on)
            }
            Beginnings::Phases { count } => (None, i as f64 / count.max(1) as f64),
        }
    }

    /// Checks it.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn check(&self) -> Result<(), MapError> {
        let refuse = |id: &str, reason: String| {
            Err(MapError::Axis {
                id: id.to_owned(),
                reason,
            })
        };
        let ranges = match &self.beginnings {
            Beginnings::Plane {
                displacement,
                velocity,
                count,
                switched_on,
            } => {
                if !(0.0..1.0).contains(switched_on) {
                    return refuse("phase", format!("{switched_on} is not in 0 .. 1"));
                }
                vec![
                    ("displacement", *displacement, count.0),
                    ("velocity", *velocity, count.1),
                ]
            }
            Beginnings::Phases { count } => vec![("phase", (0.0, 1.0), *count)],
        };
        for (id, (low, high), count) in ranges {
            if !(low.is_finite() && high.is_finite()) || low == high {
                return refuse(
                    id,
                    format!("{low} to {high} is an empty range; give two values"),
                );
            }
            if count < 2 {
                return refuse(id, format!("{count} are no axis; give at least 2"));
            }
        }
        let points = self.shape().0.saturating_mul(self.shape().1);
        if points > MOST_BEGINNINGS {
            return refuse(
                "beginnings",
                format!("{points} are more than {MOST_BEGINNINGS}; take fewer"),
            );
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            return refuse(
                "tolerance",
                format!("{} is not between 0 and 1", self.tolerance),
            );
        }
        self.options
            .check()
            .map_err(|error| MapError::Setup(error.to_string()))
    }
}
