//! What is asked of an orbit diagram.

use crate::explore::map::{Axis, MapError, MapRequest};
use crate::explore::measures::MeasureId;
use crate::explore::steady_state::SteadyOptions;
use crate::model::Model;
use crate::model::drive::Waveform;

/// Periods that are drawn of a response that does not repeat.
const KEPT_PERIODS: usize = 100;
/// Periods over which the exponent is measured: its error is some percent of a period.
const LYAPUNOV_PERIODS: usize = 60;
/// Most values of an axis; each may take some seconds of device time.
const MOST_VALUES: usize = 100_000;

/// An orbit diagram that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitRequest {
    /// Device, drive and the one axis; its start is that of the first value. Its `options` hold periods
    /// kept and followed.
    pub map: MapRequest,
    /// Whether it is swept down again.
    pub is_swept_back: bool,
    /// Periods over which the largest Lyapunov exponent is measured; 0 for none.
    pub lyapunov_periods: usize,
}

impl OrbitRequest {
    /// With usual choices: up and down, from rest.
    #[must_use]
    pub fn new(model: Model, drive: Waveform, axis: Axis) -> Self {
        let mut map = MapRequest::new(model, drive, vec![axis], vec![MeasureId::Peak]);
        map.options = SteadyOptions {
            kept_periods: KEPT_PERIODS,
            ..map.options
        };
        Self {
            map,
            is_swept_back: true,
            lyapunov_periods: LYAPUNOV_PERIODS,
        }
    }

    /// Checks it.
    ///
    /// # Errors
    /// [`MapError`].
    pub fn check(&self) -> Result<(), MapError> {
        self.map.check()?;
        let [axis] = self.map.axes.as_slice() else {
            return Err(MapError::Axes(
                "an orbit diagram has one axis; hold the other".to_owned(),
            ));
        };
        if axis.count > MOST_VALUES {
            return Err(MapError::Axis {
                id: axis.id.clone(),
                reason: format!("{} values are more than {MOST_VALUES}", axis.count),
            });
        }
        Ok(())
    }
}
