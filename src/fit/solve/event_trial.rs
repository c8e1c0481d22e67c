//! One segment fitted with one reading of its events, and how far it then is from the data.
//!
//! Parameters and nuisances are held; only the segment's own unknowns move. The misfit is
//! judged by its mean and by its worst run of samples: a misread event shows in a few
//! samples, however long the segment is.

use super::levenberg_marquardt::Control;
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::residual::residual_rows::{Nuisances, Row, rows};
use crate::fit::residual::residuals::residuals;
use crate::fit::segment::Segment;
use crate::fit::thresholds::{SUSPECT_MEAN_COST, SUSPECT_RUN_MEAN_SQUARE, SUSPECT_RUN_SAMPLES};
use crate::model::Model;
use crate::sim::{StretchSimulator, Stretcher};

/// Rounds of fitting for each reading tried.
const REVISION_ROUNDS: usize = 8;
/// Loss while a reading settles: hardly robust.
const REVISION_LOSS: Huber = Huber(100.0);

/// How badly a segment fits.
#[derive(Debug, Clone, Copy)]
pub(super) struct SegmentMisfit {
    /// Mean cost of its rows.
    pub(super) mean: f64,
    /// Largest mean square of [`SUSPECT_RUN_SAMPLES`] readings in a row.
    worst_run: f64,
}

impl SegmentMisfit {
    /// Above 1 where it is suspect, with a mean cost that is `usual` for the others.
    pub(super) fn relative_to(self, usual: f64) -> f64 {
        let run = self.worst_run / SUSPECT_RUN_MEAN_SQUARE;
        (self.mean / SUSPECT_MEAN_COST).max(run) / usual.max(1.0)
    }
}

/// Misfit of a segment with its unknowns at `locals`, where its robust cost is known already.
pub(super) fn segment_misfit(
    problem: &Problem,
    segment: &Segment,
    locals: &[f64],
    (simulator, states): (&StretchSimulator, &[f64]),
    (cost, nuisances): (f64, &Nuisances),
) -> SegmentMisfit {
    let mean = cost / problem.rows(segment).len().max(1) as f64;
    let context = problem.context(segment, states);
    let (mut stretcher, mut r) = (Stretcher::new(simulator), Vec::new());
    if residuals(segment, &context, &mut stretcher, nuisances, locals, &mut r).is_err() {
        let worst_run = f64::INFINITY;
        return SegmentMisfit { mean, worst_run };
    }
    let kinds = rows(segment, &context);
    let worst = |point: Row| {
        let own: Vec<f64> = r
            .iter()
            .zip(&kinds)
            .filter(|(_, kind)| **kind == point)
            .map(|(r, _)| r * r)
            .collect();
        let means = own
            .windows(SUSPECT_RUN_SAMPLES)
            .map(|w| w.iter().sum::<f64>() / SUSPECT_RUN_SAMPLES as f64);
        means.fold(0.0, f64::max)
    };
    SegmentMisfit {
        mean,
        worst_run: worst(Row::ProofMass).max(worst(Row::Cantilever)),
    }
}

/// What a reading of a segment's events is fitted with: parameters and nuisances stay as they are.
pub(crate) struct EventTrial<'a> {
    pub(crate) problem: &'a Problem,
    pub(crate) simulator: &'a StretchSimulator,
    pub(crate) model: &'a Model,
    pub(crate) states: &'a [f64],
    pub(crate) x: &'a [f64],
    pub(super) huber: Huber,
    pub(super) control: &'a Control<'a>,
}

impl EventTrial<'_> {
    /// Fits a segment's own unknowns. Returns its misfit; above 1 its events are suspect.
    pub(crate) fn fit(&self, segment: &mut Segment) -> f64 {
        let nuisances = self.problem.nuisances_of(self.x, segment.recording);
        let refine = |s: &Segment, huber: Huber, rounds| {
            let start = s.locals.clone();
            let p = self.problem;
            p.refine(
                s,
                self.states,
                self.simulator,
                &nuisances,
                start,
                huber,
                rounds,
            )
        };
        segment.locals = refine(segment, REVISION_LOSS, REVISION_ROUNDS).locals;
        let refined = refine(segment, self.huber, REVISION_ROUNDS);
        segment.locals = refined.locals;
        segment_misfit(
            self.problem,
            segment,
            &segment.locals,
            (self.simulator, self.states),
            (refined.cost, &nuisances),
        )
        .relative_to(1.0)
    }
}
