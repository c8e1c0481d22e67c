//! Bounds on the work of a run, and what causes most of it.

use super::Runner;
use crate::sim::error::{Burden, SimError};
use crate::sim::trace::{EventKind, Trace};

impl Runner {
    /// What causes most of the work.
    pub(super) fn burden(&self, trace: &Trace) -> Burden {
        // Only the latest events count: a live run has dropped the first ones.
        let events = &trace.events[trace.events.len().saturating_sub(1000)..];
        let corners = events.iter().filter(|e| e.kind == EventKind::DriveStep);
        let usual = self.flight_tables.length(0);
        let mean = self.t / self.steps.max(1) as f64;
        let piece = self.whole.end - self.whole.start.max(0.0);
        if piece < 2.0 * usual || (!events.is_empty() && 2 * corners.count() > events.len()) {
            Burden::Drive
        } else if mean > 0.3 * usual {
            Burden::Span
        } else if 10 * self.events > self.steps {
            Burden::Contacts
        } else if self.device.ground.is_some() {
            Burden::Film
        } else {
            Burden::Motion
        }
    }

    /// Counts an attempted step and ends a run that takes too many.
    pub(super) fn count_step(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        self.steps += 1;
        trace.steps += 1;
        if self.steps > self.options.max_steps {
            return Err(SimError::too_much(
                self.t,
                "steps",
                self.steps,
                self.burden(trace),
            ));
        }
        Ok(())
    }
}
