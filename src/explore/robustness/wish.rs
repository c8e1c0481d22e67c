//! Which response is wanted.

use super::error::RobustnessError;
use crate::explore::measures::{Basis, MeasureId, Regime, value};
use crate::explore::steady_state::SteadyResponse;

/// A condition that is missed by more than its own width is missed altogether.
const MISSED_ALTOGETHER: f64 = 1.0;

/// Bounds on a measure; `None` is no bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasureBound {
    /// The measure; one that rests on events.
    pub measure: MeasureId,
    /// Lowest value.
    pub low: Option<f64>,
    /// Highest value.
    pub high: Option<f64>,
}

/// A wanted response: all conditions hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Wish {
    /// One of these regimes; any if empty.
    pub regimes: Vec<Regime>,
    /// Bounds on measures. Where a response has no value, such as an impact speed without contact, an
    /// upper bound holds and a lower one does not.
    pub bounds: Vec<MeasureBound>,
}

impl Wish {
    /// A contact share between two bounds.
    #[must_use]
    pub fn in_contact(low: f64, high: f64) -> Self {
        Self {
            regimes: Vec::new(),
            bounds: vec![MeasureBound {
                measure: MeasureId::ContactShare,
                low: Some(low),
                high: Some(high),
            }],
        }
    }

    /// One regime.
    #[must_use]
    pub fn regime(regime: Regime) -> Self {
        Self {
            regimes: vec![regime],
            bounds: Vec::new(),
        }
    }

    /// Checks it.
    ///
    /// # Errors
    /// [`RobustnessError::Wish`].
    pub fn check(&self) -> Result<(), RobustnessError> {
        if self.regimes.is_empty() && self.bounds.is_empty() {
            return Err(RobustnessError::Wish(
                "nothing is wanted; choose a regime or a bound on a measure".to_owned(),
            ));
        }
        for bound in &self.bounds {
            let spec = bound.measure.spec();
            let refuse =
                |reason: &str| Err(RobustnessError::Wish(format!("{}: {reason}", spec.id)));
            if spec.basis == Basis::Integrals || bound.measure == MeasureId::LargestMultiplier {
                return refuse("only measures of events can be wanted, such as contact_share");
            }
            match (bound.low, bound.high) {
                (None, None) => return refuse("it has no bound; give a lower or an upper one"),
                (Some(low), Some(high)) if low.is_nan() || high.is_nan() || low > high => {
                    return refuse("the lower bound is above the upper one; exchange them");
                }
                _ => {}
            }
            if [bound.low, bound.high]
                .into_iter()
                .flatten()
                .any(f64::is_nan)
            {
                return refuse("a bound is no number");
            }
        }
        Ok(())
    }

    /// By how much a response misses it, from 0 where it holds to 1; the mean over the conditions.
    #[must_use]
    pub fn shortfall(&self, response: &SteadyResponse) -> f64 {
        let regime = (!self.regimes.is_empty()).then(|| {
            let holds = self.regimes.contains(&Regime::of(response));
            if holds { 0.0 } else { MISSED_ALTOGETHER }
        });
        let bounds = self.bounds.iter();
        let bounds = bounds.map(|bound| bound.shortfall(value(bound.measure, response, None)));
        let all: Vec<f64> = regime.into_iter().chain(bounds).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    }
}

impl MeasureBound {
    /// 0 where it holds; the distance over the interval's width or the bound's size, at most 1.
    fn shortfall(&self, value: Option<f64>) -> f64 {
        let Some(value) = value else {
            return if self.low.is_some() {
                MISSED_ALTOGETHER
            } else {
                0.0
            };
        };
        let width = match (self.low, self.high) {
            (Some(low), Some(high)) if high > low => high - low,
            (Some(bound), _) | (_, Some(bound)) => bound.abs(),
            (None, None) => return 0.0,
        };
        let below = self.low.map_or(0.0, |low| low - value);
        let above = self.high.map_or(0.0, |high| value - high);
        let missed = below.max(above).max(0.0);
        if missed == 0.0 {
            0.0
        } else if width > 0.0 {
            (missed / width).min(MISSED_ALTOGETHER)
        } else {
            MISSED_ALTOGETHER
        }
    }
}
