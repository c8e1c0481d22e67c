//! A model fitted to one split of the recordings.

use std::sync::{Arc, OnceLock};

use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::thresholds::{EXCESS_MIN_CHI2, LOST_TRACK_CHI2};
use crate::fit::problem::{Jacobian, Problem};
use crate::fit::residual::segment_start::begins_from_reading;
use crate::fit::segment::Segment;
use crate::fit::solve::point::Point;
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::sim::{SimError, StretchSimulator};

/// Most values that the noise of a first reading, carried over into those that follow, may count
/// for.
const MAX_FIRST_READING_VALUES: f64 = 20.0;

/// A model fitted to one split.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The model with its fitted parameters.
    pub model: Model,
    /// The least-squares problem.
    pub problem: Problem,
    /// Parameters and initial states at the end of the fit.
    pub point: Point,
    /// Chi2 under [`ROBUST_LOSS`], corrected for the segments' own unknowns.
    pub cost: f64,
    /// Jacobians of the segments at that point, once computed.
    pub(crate) jacobians: Arc<OnceLock<Vec<Option<Jacobian>>>>,
}

impl Fitted {
    /// What has ended at `point`, settled under [`ROBUST_LOSS`].
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense there.
    pub(crate) fn at(problem: Problem, point: Point) -> Result<Self, SimError> {
        let own = local_unknowns(&point.segments);
        let model = problem.space.model(&point.x);
        let simulator = problem.simulator(&point.x)?;
        let segments = point.segments.iter();
        let taken_over: f64 = segments
            .map(|s| first_reading_correction(&problem, &simulator, s))
            .sum();
        Ok(Self {
            model,
            cost: point.cost + own as f64 + taken_over,
            problem,
            point,
            jacobians: Arc::default(),
        })
    }

    /// Chi2 per row of the recordings: 1 where nothing is missing. What is known of parameters beforehand
    /// is no part of it.
    pub fn per_value(&self) -> f64 {
        let recorded = self.cost - self.problem.known_cost(&self.point.x);
        recorded / self.point.rows.max(1) as f64
    }

    /// Whether the fit has lost track: what is missing has drawn everything else along.
    pub fn is_lost(&self) -> bool {
        self.per_value() > LOST_TRACK_CHI2
    }

    /// Jacobians of the segments under [`ROBUST_LOSS`]; `None` for those that are set aside or cannot be
    /// simulated.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn jacobians(&self) -> Result<&[Option<Jacobian>], SimError> {
        if let Some(known) = self.jacobians.get() {
            return Ok(known);
        }
        let Point {
            x, segments, used, ..
        } = &self.point;
        let fresh = self.problem.jacobians(x, segments, used, ROBUST_LOSS)?;
        Ok(self.jacobians.get_or_init(|| fresh))
    }

    /// Number of the segments' own unknowns.
    pub fn local_unknowns(&self) -> usize {
        local_unknowns(&self.point.segments)
    }

    /// Rows minus the segments' own unknowns.
    pub fn freedom(&self) -> f64 {
        let rows = self.point.rows.saturating_sub(self.local_unknowns());
        rows.max(1) as f64
    }
}

/// Expected fall of a segment's cost by starting from its first readings. A lasting lag of the
/// readings begins there, so these are met exactly, and their noise decays in those that follow:
/// with `f = exp(-2 r dt)` by `1 - f / (1 - f)` per channel.
pub fn first_reading_correction(
    problem: &Problem,
    simulator: &StretchSimulator,
    segment: &Segment,
) -> f64 {
    let Some(at) = simulator
        .reading_states()
        .filter(|_| begins_from_reading(segment, simulator))
    else {
        return 0.0;
    };
    let rate = simulator.state_rates()[at];
    let data = &problem.data[segment.recording].recording;
    let channels = 1.0 + f64::from(u8::from(data.cantilever.is_some()));
    let fades = (-2.0 * rate * segment.interval).exp();
    channels * (1.0 - (fades / (1.0 - fades)).min(MAX_FIRST_READING_VALUES))
}

/// Number of the segments' own unknowns.
pub(crate) fn local_unknowns(segments: &[Segment]) -> usize {
    segments.iter().map(|s| s.locals.len()).sum()
}

/// Chi2 above that of noise alone, as well as it is known.
pub fn excess_chi2(fitted: &Fitted) -> f64 {
    let rows = fitted.point.rows as f64;
    (fitted.cost - EXCESS_MIN_CHI2 * rows).max(0.0)
}

/// A parameter's id, `effect.parameter`, with its least and largest value.
pub type Bound = (String, (f64, f64));

/// An effect without which the baseline is far off, fitted together with everything else from a
/// cold start.
#[derive(Debug, Clone)]
pub struct RequiredEffect {
    /// The effect at the start of the fit.
    pub start: ActiveEffect,
    /// Ids of its fitted parameters.
    pub free: Vec<String>,
    /// Bounds of those.
    pub bounds: Vec<Bound>,
    /// Ids of further parameters that shape its law.
    pub shape: Vec<String>,
    /// Fall of chi2 that was predicted of it; 0 without a prediction.
    pub predicted_gain: f64,
    /// The fit.
    pub fitted: Fitted,
}
