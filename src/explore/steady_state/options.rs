//! What a steady state is asked for.

use super::error::SteadyError;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::Options;

/// Largest multiple of the period that can be asked for; each costs memory and comparisons.
const LARGEST_MULTIPLE: usize = 64;

/// Local error of a step of a map, as a share of the height of the zero position over the ground.
const MAP_STEP_ERROR: f64 = 2e-6;
/// Recurrence of a map.
const MAP_RECURRENCE: f64 = 1e-5;

/// How a steady state is searched. All tolerances are relative.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyOptions {
    /// The simulator's tolerance and budgets; its rate and samples are not used.
    pub simulator: Options,
    /// Error of the state at the strobe up to which a response counts as periodic, as a share of
    /// the response's amplitude.
    pub recurrence: f64,
    /// Most periods of the drive after which a response may recur.
    pub max_multiple: usize,
    /// Periods of the drive after which a response without recurrence is not periodic.
    pub max_periods: usize,
    /// Periods that a response keeps that is not periodic.
    pub kept_periods: usize,
    /// Phase of the drive at which states are compared, from 0 to below 1.
    pub strobe_phase: f64,
    /// Whether slow transients may be cut short by shooting. A basin of attraction asks for the
    /// response that the transient leads to, and so for transients alone.
    pub shooting: bool,
    /// Whether to compute the multipliers of the map: twice as many periods as it has coordinates.
    pub multipliers: bool,
    /// Periods over which a response that is not periodic is tested for chaos; 0 for none.
    pub chaos_periods: usize,
}

impl Default for SteadyOptions {
    fn default() -> Self {
        Self {
            simulator: Options::default(),
            recurrence: 1e-6,
            max_multiple: 8,
            max_periods: 400,
            kept_periods: 32,
            strobe_phase: 0.0,
            shooting: true,
            multipliers: true,
            chaos_periods: 40,
        }
    }
}

impl SteadyOptions {
    /// Those of a map of many points for devices like `model`: no multipliers, fewer periods, and an
    /// accuracy that no picture shows the limits of.
    #[must_use]
    pub fn for_maps(model: &Model) -> Self {
        let usual = Options::default();
        let height = if model.has_ground {
            model.parameters[ParameterId::Dp].abs()
        } else {
            0.0
        };
        Self {
            simulator: Options {
                tolerance: usual.tolerance.max(MAP_STEP_ERROR * height),
                ..usual
            },
            recurrence: MAP_RECURRENCE,
            multipliers: false,
            max_periods: 200,
            chaos_periods: 0,
            ..Self::default()
        }
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`SteadyError::Options`].
    pub fn check(&self) -> Result<(), SteadyError> {
        let refuse = |what, reason: String| Err(SteadyError::Options { what, reason });
        if !(self.recurrence > 0.0 && self.recurrence < 1.0) {
            return refuse(
                "recurrence",
                format!("{} is not between 0 and 1; 1e-6 is usual", self.recurrence),
            );
        }
        if !(1..=LARGEST_MULTIPLE).contains(&self.max_multiple) {
            return refuse(
                "max_multiple",
                format!("{} is not in 1 .. {LARGEST_MULTIPLE}", self.max_multiple),
            );
        }
        if self.max_periods < 2 * self.max_multiple {
            return refuse(
                "max_periods",
                format!(
                    "{} periods do not show a response of {} periods twice; give at least {}",
                    self.max_periods,
                    self.max_multiple,
                    2 * self.max_multiple
                ),
            );
        }
        if !(0.0..1.0).contains(&self.strobe_phase) {
            return refuse(
                "strobe_phase",
                format!("{} is not in 0 .. 1", self.strobe_phase),
            );
        }
        Ok(())
    }
}
