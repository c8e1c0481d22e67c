//! Bounds on the work of a run, and what causes most of it.

use super::pace::STEPS_PER_PIECE;
use super::{Phase, Runner};
use crate::sim::error::{Burden, SimError};
use crate::sim::trace::Trace;

/// Distance from which a mass runs away, in units of the farthest it has been in the first half of the
/// run.
const RUNAWAY_DISTANCE: f64 = 100.0;

impl Runner {
    /// What causes most of the work.
    fn burden(&self) -> Burden {
        let many_pieces = self.pace.pieces as f64 * STEPS_PER_PIECE > self.steps as f64;
        let usual = self.flight_tables.length(0);
        let mean = self.t / self.steps.max(1) as f64;
        if many_pieces {
            Burden::Drive
        } else if mean > 0.3 * usual {
            Burden::Span
        } else if let Some(id) = self.device.suspect() {
            Burden::Effect(id)
        } else if 10 * self.events > self.steps {
            Burden::Contacts
        } else if self.device.ground.is_some() {
            Burden::Film
        } else {
            Burden::Motion
        }
    }

    /// Counts an attempted step and ends a run that takes too many: more than it is given, or so
    /// many for its time that it would hardly advance.
    pub(super) fn count_step(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        self.steps += 1;
        trace.steps += 1;
        let hardly_advances = !self.pace.allows(self.t) && self.options.fixed_step.is_none();
        if self.steps > self.options.max_steps || hardly_advances {
            return Err(if self.runs_away(trace) {
                SimError::diverged(self.t)
            } else {
                self.too_much("steps", self.steps)
            });
        }
        Ok(())
    }

    /// Whether the mass is far beyond where it was before, and leaving: ever shorter steps would
    /// follow it without end.
    fn runs_away(&self, trace: &Trace) -> bool {
        let (x, v) = self.proof_mass();
        let usual = trace.proof_mass.iter().take(trace.len() / 2);
        let farthest = usual.fold(0.0, |far: f64, x| far.max(x.abs()));
        // At the very beginning it has been nowhere.
        let is_far = farthest > 0.0 && x.abs() > RUNAWAY_DISTANCE * farthest;
        is_far && self.phase == Phase::Flight && x * v > 0.0
    }

    /// The error of a run that took too many steps or events.
    pub(super) fn too_much(&self, what: &'static str, count: u64) -> SimError {
        SimError::too_much(self.t, what, count, self.burden())
    }

    /// Refuses a span \[s\] that takes more steps than are given, even if all are of full length.
    pub(in crate::sim) fn check_span(&self, span: f64) -> Result<(), SimError> {
        let longest = self.flight_tables.length(0).max(self.held_tables.length(0));
        let (needed, given) = (span / longest, self.options.max_steps as f64);
        if needed <= given + 1.0 {
            return Ok(());
        }
        Err(SimError::Options {
            what: "duration",
            reason: format!(
                "{span} s take at least {needed:.1e} steps, which are {longest:.1e} s long at most, as the fastest mode needs them; more than {given:.1e} are too many: make the span shorter or that mode slower"
            ),
        })
    }
}
