//! Steps in flight and in held phases, as long as the tolerance and the drive allow.

use super::contact::Stop;
use super::{Phase, Runner};
use crate::sim::error::SimError;
use crate::sim::nodes;
use crate::sim::output::Sink;
use crate::sim::step::tables::{LEVELS, Tables};
use crate::sim::trace::Trace;

impl Runner {
    /// First level of the table whose step does not end far beyond the segment.
    fn covering_level(&self, tables: &Tables) -> usize {
        let end = self.piece_end();
        if self.options.fixed_step.is_some() || !end.is_finite() {
            return 0;
        }
        tables.covering(end - self.t)
    }

    fn tables_of(&self, held: bool) -> &Tables {
        if held {
            &self.held_tables
        } else {
            &self.flight_tables
        }
    }

    /// Computes one step of the present phase in its scratch, and returns its length.
    pub(super) fn step(&mut self, trace: &mut Trace) -> Result<f64, SimError> {
        let held = match self.phase {
            Phase::Held { level, .. } | Phase::Stuck { level } => Some(level),
            Phase::Flight => None,
        };
        (self.flight.sliding, self.flight.touch) = (self.sliding, self.touch);
        let tables = self.tables_of(held.is_some());
        let mut level = self.level.max(self.covering_level(tables));
        let mut rejected = false;
        loop {
            self.count_step(trace)?;
            let taken = match held {
                Some(ground) => self.held.held_step(
                    &self.device,
                    &self.held_tables,
                    level,
                    &self.segment,
                    self.t,
                    (&self.r, &self.dr, &self.z),
                    ground,
                    self.options.tolerance,
                ),
                None => self.flight.flight_step(
                    &self.device,
                    &self.flight_tables,
                    level,
                    &self.segment,
                    self.t,
                    (&self.q, &self.v, &self.z),
                    self.options.tolerance,
                ),
            };
            let step = if held.is_some() {
                &self.held
            } else {
                &self.flight
            };
            self.pace.spend(step.sweeps);
            let (error, size) = (step.error, step.xp[0].abs());
            // No error below rounding can be reached.
            let tolerance = self.options.tolerance + 16.0 * f64::EPSILON * size;
            let fixed = self.options.fixed_step.is_some();
            if taken.is_ok() && (fixed || error <= tolerance) {
                if rejected {
                    self.level = level;
                } else if error < tolerance / 64.0 && level == self.level && level > 0 {
                    self.level -= 1;
                }
                return Ok(self.tables_of(held.is_some()).length(level));
            }
            rejected = true;
            level += 1;
            if level >= LEVELS || (fixed && taken.is_err()) {
                // Above its zero the film cannot be the cause: the motion diverges.
                let runs_away = self.phase == Phase::Flight && self.proof_mass().0 > 0.0;
                return Err(
                    if self.q.iter().any(|q| !q.is_finite()) || (runs_away && !fixed) {
                        SimError::diverged(self.t)
                    } else if fixed {
                        SimError::Options {
                            what: "fixed step [s]",
                            reason: format!("too long for the film at t = {:.6} s", self.t),
                        }
                    } else {
                        SimError::step_too_small(self.t)
                    },
                );
            }
        }
    }

    pub(super) fn fly(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        let h = self.step(trace)?;
        let end = ((self.piece_end() - self.t) / h).min(1.0);
        let stop = self.first_stop(h, end);
        let s = stop.map_or(end, |(s, _)| s);
        self.emit_flight(h, s, trace);
        self.note_flight(h, s);
        if s >= 1.0 {
            const LAST: usize = nodes::S - 1;
            self.q.copy_from_slice(self.flight.q_at(LAST));
            self.v.copy_from_slice(self.flight.v_at(LAST));
            self.z.copy_from_slice(self.flight.z_at(LAST));
        } else {
            self.flight.modal_at(s, &mut self.q, &mut self.v);
            self.z.copy_from_slice(self.flight.states_at(s).as_slice());
        }
        self.t = self.time_after(h, s, stop.is_none());
        let (x, v) = self.proof_mass();
        if !(x.is_finite() && v.is_finite() && x.abs() < 1e9) {
            return Err(SimError::diverged(self.t));
        }
        if let Some(touch) = self.touch {
            Sink::open_contact(trace, touch.since, self.t);
        }
        match stop.map(|(_, stop)| stop) {
            Some(Stop::Hit) if self.device.is_compliant() => self.enter(v, trace),
            Some(Stop::Hit) => self.impact(v, trace),
            Some(Stop::Leave) => self.leave(trace),
            Some(Stop::Turn) => {
                self.turn(x);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Sets the held state to that at fraction `s` of the step.
    pub(super) fn take_held(&mut self, h: f64, s: f64, whole: bool) {
        if s >= 1.0 {
            const LAST: usize = nodes::S - 1;
            self.r.copy_from_slice(self.held.q_at(LAST));
            self.dr.copy_from_slice(self.held.v_at(LAST));
            self.z.copy_from_slice(self.held.z_at(LAST));
        } else {
            self.held.modal_at(s, &mut self.r, &mut self.dr);
            self.z.copy_from_slice(self.held.states_at(s).as_slice());
        }
        self.t = self.time_after(h, s, whole);
    }

    /// Time at fraction `s` of a step. The end of a segment is reached exactly.
    fn time_after(&self, h: f64, s: f64, whole: bool) -> f64 {
        if whole && s < 1.0 {
            self.piece_end()
        } else {
            self.t + s * h
        }
    }
}
