//! Effects that the re-tuning has to ask for on its way, for no baseline without them comes near.

use super::fitted::{Bound, Fitted};
use crate::diagnose::thresholds::LOST_TRACK_CHI2;
use crate::model::effects::ActiveEffect;

/// An effect without which the baseline is far off, as fitted with all else from afar.
#[derive(Debug, Clone)]
pub struct RequiredEffect {
    /// The effect that the fit began with.
    pub start: ActiveEffect,
    /// Ids of what was fitted of it.
    pub free: Vec<String>,
    /// Bounds of that.
    pub bounds: Vec<Bound>,
    /// Ids of what else its law may have.
    pub shape: Vec<String>,
    /// The fit.
    pub fitted: Fitted,
}

impl Fitted {
    /// Whether the fit has lost its way.
    pub fn is_lost(&self) -> bool {
        self.per_value() > LOST_TRACK_CHI2
    }
}
