//! The stroboscopic map: the state a period of the drive later, and what happened on the way.

use super::error::SteadyError;
use super::response::{Cycle, StrobePoint};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::sim::{
    Event, EventKind, Integrals, MotionPhase, MotionState, Notes, Options, Runner, Trace,
};

/// One period of the drive, from strobe to strobe.
#[derive(Debug, Clone)]
pub(super) struct PeriodRecord {
    /// State at its beginning.
    pub start: MotionState,
    /// With the run's times.
    pub events: Vec<Event>,
    pub notes: Notes,
}

impl PeriodRecord {
    /// Whether the mass meets or leaves the ground in the same order.
    pub fn has_events_of(&self, other: &Self) -> bool {
        let kinds = |record: &Self| {
            let own = record.events.iter().map(|e| e.kind);
            own.filter(|kind| *kind != EventKind::DriveStep)
                .collect::<Vec<_>>()
        };
        kinds(self) == kinds(other)
    }

    /// Whether a contact ends in it.
    pub fn has_release(&self) -> bool {
        self.events.iter().any(|e| e.kind == EventKind::Release)
    }
}

/// A device under a periodic drive, stopped at the same phase of each period.
#[derive(Debug, Clone)]
pub(super) struct Stroboscope {
    pub runner: Runner,
    trace: Trace,
    phase: f64,
    period: f64,
    /// Number of the period of the drive whose strobe is next.
    next: u64,
    /// Device time that was simulated \[s\].
    pub device_seconds: f64,
}

impl Stroboscope {
    pub fn new(model: &Model, options: &Options, phase: f64) -> Result<Self, SteadyError> {
        let mut runner = Runner::new(model, &Waveform::Rest, options)?;
        runner.stop_sampling();
        runner.start_notes(false);
        Ok(Self {
            runner,
            trace: Trace::default(),
            phase,
            period: 1.0,
            next: 0,
            device_seconds: 0.0,
        })
    }

    /// Another drive; the device begins at `switched_on` periods \[0, 1) of it, at displacement and
    /// velocity `initial`, the model's if `None`.
    pub fn begin(
        &mut self,
        drive: &Waveform,
        switched_on: f64,
        initial: Option<(f64, f64)>,
    ) -> Result<(), SteadyError> {
        drive.check().map_err(crate::sim::SimError::from)?;
        self.period = drive.period().ok_or(SteadyError::DriveNotPeriodic)?;
        self.device_seconds = 0.0;
        // A ground that moves once moves before, and a table has begun.
        let moved = self.runner.last_ground_jump().unwrap_or(0.0);
        let first = (moved.max(beginning(drive)) / self.period).ceil();
        let start = (first + switched_on) * self.period;
        self.runner.begin_with(drive, start, initial)?;
        self.runner
            .check_repeats(start, self.period)
            .map_err(|what| SteadyError::DeviceNotPeriodic {
                what,
                period: self.period,
            })?;
        // The first period of a table is entered otherwise than the later ones.
        self.next = first as u64 + 1 + u64::from(switched_on > self.phase);
        Ok(())
    }

    /// Begins at a strobe with `state`, of an earlier response, in place of the initial one.
    pub fn begin_from(&mut self, state: &MotionState) -> Result<(), SteadyError> {
        let time = self.strobe(self.next);
        let mut own = state.clone();
        own.time = time;
        let later = time - state.time;
        if let MotionPhase::Held { since, level } = &mut own.phase {
            *since += later;
            *level = self.runner.ground_level(time);
        }
        if let Some((level, since)) = &mut own.sunk {
            *level = self.runner.ground_level(time);
            *since += later;
        }
        // A memory belongs to its own drive.
        let fresh = self.runner.motion_state().coordinates.z;
        let rates = self.runner.state_rates();
        if own.coordinates.z.len() == fresh.len() {
            for (i, z) in own.coordinates.z.iter_mut().enumerate() {
                if rates[i] == 0.0 {
                    *z = fresh[i];
                }
            }
        }
        self.runner.restore(&own)?;
        self.next += 1;
        let (x, _) = self.runner.mass_in(&own);
        let ground = self.runner.ground_level(time);
        if x < ground && own.sunk.is_none() {
            return Err(SteadyError::Start(format!(
                "the state given has the mass at {x} m, in the ground at {ground} m; begin from rest"
            )));
        }
        Ok(())
    }

    /// The instant of a strobe \[s\].
    fn strobe(&self, number: u64) -> f64 {
        (number as f64 + self.phase) * self.period
    }

    pub fn period(&self) -> f64 {
        self.period
    }

    /// The present state.
    pub fn state(&self) -> MotionState {
        self.runner.motion_state()
    }

    /// On to the next strobe.
    pub fn advance(&mut self) -> Result<PeriodRecord, SteadyError> {
        let start = self.runner.motion_state();
        self.trace.events.clear();
        self.trace.contacts.clear();
        self.trace.steps = 0;
        self.runner.take_notes();
        let end = self.strobe(self.next);
        self.device_seconds += end - start.time;
        self.runner.advance_to(end, &mut self.trace)?;
        self.next += 1;
        Ok(PeriodRecord {
            start,
            events: self.trace.events.clone(),
            notes: self.runner.take_notes(),
        })
    }

    /// Goes back, or over, to `state` at a strobe.
    pub fn restore(&mut self, state: &MotionState) -> Result<(), SteadyError> {
        self.next = (state.time / self.period - self.phase).round().max(0.0) as u64 + 1;
        self.runner.restore(state)?;
        Ok(())
    }

    /// The map of `multiple` periods from `state`: what happens, and the state at the end.
    pub fn map(
        &mut self,
        state: &MotionState,
        multiple: usize,
    ) -> Result<(Vec<PeriodRecord>, MotionState), SteadyError> {
        self.restore(state)?;
        let records = (0..multiple)
            .map(|_| self.advance())
            .collect::<Result<Vec<_>, _>>()?;
        Ok((records, self.state()))
    }

    /// The periods of `records` as one cycle.
    pub fn cycle(&self, records: &[PeriodRecord]) -> Option<Cycle> {
        let start = records.first()?.start.clone();
        let origin = start.time;
        let end = self.runner.motion_state();
        let ground_level = self.runner.ground_level(origin);
        let mut cycle = Cycle {
            periods: records.len(),
            duration: records.len() as f64 * self.period,
            events: Vec::new(),
            turns: Vec::new(),
            arrivals: Vec::new(),
            strobes: Vec::new(),
            top_speed: 0.0,
            highest: f64::NEG_INFINITY,
            lowest: f64::INFINITY,
            least_hold_share: f64::INFINITY,
            ground_level,
            impact_mass: self.runner.impact_mass(),
            has_compliant_ground: self.runner.has_compliant_ground(),
            start,
        };
        // A flight over a strobe goes on; the last one leads to the first arrival again.
        let tails = records.iter().rev().map(|r| &r.notes);
        let mut fastest = 0.0f64;
        for notes in tails {
            fastest = fastest.max(notes.fastest_since_arrival);
            if !notes.arrivals.is_empty() {
                break;
            }
        }
        for record in records {
            let (x, v) = self.runner.mass_in(&record.start);
            cycle.include(x);
            cycle.strobes.push(StrobePoint {
                displacement: x,
                velocity: v,
            });
            cycle.append(record, origin, &mut fastest);
        }
        cycle.include(self.runner.mass_in(&end).0);
        if !cycle.arrivals.is_empty() {
            cycle.include(ground_level);
        }
        Some(cycle)
    }
}

impl Cycle {
    fn include(&mut self, displacement: f64) {
        self.highest = self.highest.max(displacement);
        self.lowest = self.lowest.min(displacement);
    }

    /// Appends a period; `fastest` is the largest speed of the flight that leads into it, and then of
    /// that which leads out of it [m/s].
    fn append(&mut self, record: &PeriodRecord, origin: f64, fastest: &mut f64) {
        let notes = &record.notes;
        self.events.extend(record.events.iter().map(|e| Event {
            time: e.time - origin,
            ..*e
        }));
        for turn in &notes.turns {
            self.include(turn.displacement);
            let mut turn = *turn;
            turn.time -= origin;
            self.turns.push(turn);
        }
        for arrival in &notes.arrivals {
            let mut arrival = *arrival;
            arrival.time -= origin;
            arrival.fastest = arrival.fastest.max(*fastest);
            *fastest = 0.0;
            self.arrivals.push(arrival);
        }
        *fastest = fastest.max(notes.fastest_since_arrival);
        self.top_speed = self.top_speed.max(notes.top_speed);
        self.least_hold_share = self.least_hold_share.min(notes.least_hold_share);
    }
}

impl Stroboscope {
    /// What forces do over a cycle.
    pub fn integrals(&mut self, cycle: &Cycle) -> Result<Integrals, SteadyError> {
        self.restore(&cycle.start)?;
        self.runner.start_notes(true);
        let end = cycle.start.time + cycle.duration;
        let result = self.runner.advance_to(end, &mut self.trace);
        let notes = self.runner.take_notes();
        self.runner.start_notes(false);
        self.trace.events.clear();
        self.trace.contacts.clear();
        result?;
        Ok(notes.integrals.unwrap_or_default())
    }
}

/// When a drive begins to repeat \[s\]: not before 0.
fn beginning(drive: &Waveform) -> f64 {
    let Waveform::Table(table) = drive else {
        return 0.0;
    };
    let points = table.points().and_then(|(times, _)| times.first());
    points.copied().unwrap_or(0.0).max(0.0)
}

/// A cycle as a trace with the samples of `options`, times from its start.
pub(super) fn sampled(
    model: &Model,
    drive: &Waveform,
    cycle: &Cycle,
    options: &Options,
) -> Result<Trace, SteadyError> {
    let mut runner = Runner::new(model, drive, options)?;
    runner.restore(&cycle.start)?;
    let mut trace = runner.new_trace();
    runner.advance_to(cycle.start.time + cycle.duration, &mut trace)?;
    trace.shift(-cycle.start.time);
    Ok(trace)
}
