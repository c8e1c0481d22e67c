//! The runs of the kept curves as far as they are computed, found by what they come from.

use std::sync::Arc;

use crate::app::setup::kept_curve::{KeptCurve, RunOrigin, same_origin};
use crate::app::simulation::snapshot::Snapshot;

/// The run of a kept curve.
#[derive(Debug, Clone)]
pub struct KeptRun {
    /// What it was computed from.
    pub origin: Arc<RunOrigin>,
    /// The run with its comparisons and features, or why there is none.
    pub run: Result<Arc<Snapshot>, String>,
    /// Whether no number is still being computed.
    pub is_complete: bool,
}

/// The runs that are known. Curves of the same origin share one.
#[derive(Debug, Clone, Default)]
pub struct KeptRuns(Vec<KeptRun>);

impl KeptRuns {
    /// The run of a kept curve; `None` while it is being computed.
    pub fn of(&self, origin: &Arc<RunOrigin>) -> Option<&KeptRun> {
        self.0.iter().find(|run| same_origin(&run.origin, origin))
    }

    /// The same, if there is something to draw.
    pub fn drawn(&self, origin: &Arc<RunOrigin>) -> Option<&Arc<Snapshot>> {
        self.of(origin)?.run.as_ref().ok()
    }

    /// Puts a run in place of what was known of the same origin.
    pub fn put(&mut self, run: KeptRun) {
        self.retain(|known| !same_origin(known, &run.origin));
        self.0.push(run);
    }

    /// Forgets the runs whose origin is not wanted any more.
    pub fn retain(&mut self, mut is_wanted: impl FnMut(&Arc<RunOrigin>) -> bool) {
        self.0.retain(|run| is_wanted(&run.origin));
    }

    /// Whether all numbers of these curves are known, or never will be.
    pub fn are_complete(&self, kept: &[KeptCurve]) -> bool {
        let is_complete = |curve: &KeptCurve| {
            let run = self.of(&curve.origin);
            run.is_some_and(|run| run.is_complete || run.run.is_err())
        };
        kept.iter().all(is_complete)
    }
}
