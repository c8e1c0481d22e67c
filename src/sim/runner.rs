//! The hybrid automaton: flight and held phases, events between them, output.

use crate::model::Model;
mod budget;
mod contact;
mod emit;

use crate::model::drive::{Segment, Waveform};

use super::device::{Device, dot};
use super::error::{Options, SimError};
use super::linear::Oscillator;
use super::output::Sink;
use super::step::{LEVELS, Step, Tables, Touch};
use super::trace::{Event, EventKind, Trace};
use contact::Stop;

/// No limit of the steps is shorter than this [s]: a run must get on.
const LEAST_LIMIT: f64 = 1e-7;

/// What the proof mass is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Flight,
    /// On the ground since `since` [s], at `level` [m].
    Held {
        since: f64,
        level: f64,
    },
    /// Held by friction at `level` [m], away from a rigid ground.
    Stuck {
        level: f64,
    },
}

/// A device in motion that can be advanced piece by piece and changed on the way.
#[derive(Debug, Clone)]
pub struct Runner {
    options: Options,
    device: Device,
    drive: Waveform,
    index: usize,
    /// The drive's segment, and the piece of it that is run through.
    whole: Segment,
    segment: Segment,
    t: f64,
    phase: Phase,
    /// Direction in which the mass slides against friction, and its contact with a
    /// compliant ground.
    sliding: f64,
    touch: Option<Touch>,
    /// Modal state in flight, held state on the ground, extra states.
    q: Vec<f64>,
    v: Vec<f64>,
    r: Vec<f64>,
    dr: Vec<f64>,
    z: Vec<f64>,
    flight_tables: Tables,
    held_tables: Tables,
    flight: Step,
    held: Step,
    /// Free motion of the modes over one sample interval.
    flight_sampling: Vec<[f64; 4]>,
    held_sampling: Vec<[f64; 4]>,
    level: usize,
    /// Time by which samples are late [s].
    delay: f64,
    next_sample: u64,
    steps: u64,
    events: u64,
}

impl Runner {
    /// A device at its initial state at t = 0.
    ///
    /// # Errors
    /// [`SimError`] if model, drive or options make no sense.
    pub fn new(model: &Model, drive: &Waveform, options: &Options) -> Result<Self, SimError> {
        options.check()?;
        drive.check()?;
        let device = Device::new(model)?;
        let index = drive.index_at(0.0);
        let (q, v) = initial_state(&device);
        // Before t = 0 the device rested where it starts, without a voltage.
        let still = vec![0.0; v.len()];
        let z = device.settled_states(&device.flight_kinematics(0.0, 0.0, &q, &still));
        let m = device.held_modes.len();
        let [flight_tables, held_tables] = tables(&device, options);
        let mut runner = Self {
            options: *options,
            drive: drive.clone(),
            whole: drive.segment(index),
            segment: device.piece(drive.segment(index), 0.0, &z),
            index,
            t: 0.0,
            phase: Phase::Flight,
            sliding: 0.0,
            touch: None,
            flight_sampling: sampling(&device.flight, options),
            held_sampling: sampling(&device.held_modes, options),
            flight: Step::new(q.len(), &device.rates),
            held: Step::new(m, &device.rates),
            q,
            v,
            r: vec![0.0; m],
            dr: vec![0.0; m],
            z: z.clone(),
            flight_tables,
            held_tables,
            level: 0,
            delay: device.reading_delay(),
            next_sample: 0,
            steps: 0,
            events: 0,
            device,
        };
        runner.set_out();
        Ok(runner)
    }

    /// A device at a given state at `t` \[s\]; `held_since` if the mass is on the ground.
    /// The readings are of no use: samples are counted from zero.
    ///
    /// # Errors
    /// As [`Runner::new`].
    pub fn from_state(
        model: &Model,
        drive: &Waveform,
        options: &Options,
        t: f64,
        state: &super::stretch::StretchState,
        held_since: Option<f64>,
    ) -> Result<Self, SimError> {
        let mut runner = Self::new(model, drive, options)?;
        runner.t = t;
        runner.index = runner.drive.index_at(t);
        runner.whole = runner.drive.segment(runner.index);
        runner.phase = Phase::Flight;
        runner.next_sample = (t * options.rate).ceil().max(0.0) as u64;
        let (q, v) = match held_since {
            None => (&mut runner.q, &mut runner.v),
            Some(since) => {
                let level = runner.device.ground_level(t);
                runner.phase = Phase::Held { since, level };
                (&mut runner.r, &mut runner.dr)
            }
        };
        for (own, given) in [(q, &state.q), (v, &state.v), (&mut runner.z, &state.z)] {
            own.iter_mut().zip(given).for_each(|(a, b)| *a = *b);
        }
        runner.segment = runner.device.piece(runner.whole, t, &runner.z);
        if let Phase::Held { since, level } = runner.phase
            && runner.device.is_compliant()
        {
            runner.lift(level);
            runner.touch = Some(Touch { level, since });
        }
        if !matches!(runner.phase, Phase::Held { .. }) {
            runner.set_out();
        }
        Ok(runner)
    }

    /// An empty trace to advance into; its first sample is the next one due.
    pub fn new_trace(&self) -> Trace {
        let sensor = self.device.sensor;
        Trace {
            t0: self.next_sample as f64 / self.options.rate,
            dt: 1.0 / self.options.rate,
            ground_level: self.device.ground.map(|g| g.level + sensor.offset_p),
            forces: self.options.forces.then(Default::default),
            ..Trace::default()
        }
    }

    /// Time reached [s].
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Runs on until `until` [s] is passed, appending samples, events and contacts to
    /// `trace`. Whole steps are taken: the run may reach a little further than asked,
    /// and gives the same result in one piece or in many.
    ///
    /// # Errors
    /// [`SimError`]; `trace` holds what was reached.
    pub fn advance(&mut self, until: f64, trace: &mut Trace) -> Result<(), SimError> {
        while self.t <= until {
            self.enter_segment(trace)?;
            match self.phase {
                Phase::Flight => self.fly(trace)?,
                Phase::Held { since, level } => self.hold(since, level, trace)?,
                Phase::Stuck { level } => self.rest(level, trace)?,
            }
        }
        Ok(())
    }

    /// Changes parameters on the running device: positions and velocities are kept.
    ///
    /// # Errors
    /// [`SimError`]; then nothing is changed.
    pub fn set_model(&mut self, model: &Model) -> Result<(), SimError> {
        let device = Device::new(model)?;
        let level = device.ground_level(self.t);
        // Held motion is taken over in flight coordinates, which outlive the change.
        let mut contact = self.touch.map(|touch| touch.since);
        match self.phase {
            Phase::Held { level, since } => {
                contact = Some(since);
                self.lift(level);
            }
            Phase::Stuck { level } => self.lift(level),
            Phase::Flight => {}
        }
        self.phase = Phase::Flight;
        self.device.end_piece(&self.segment, self.t, &mut self.z);
        self.q.resize(device.flight.len(), 0.0);
        self.v.resize(device.flight.len(), 0.0);
        self.z = {
            let voltage = self.segment.shape.voltage(self.t);
            let mut at = device.flight_kinematics(self.t, voltage, &self.q, &self.v);
            device.drive_force(&mut at, self.segment.branch, &vec![0.0; device.rates.len()]);
            device.adopt_states(&self.device, &self.z, device.settled_states(&at))
        };
        let m = device.held_modes.len();
        self.r.resize(m, 0.0);
        self.dr.resize(m, 0.0);
        [self.flight_tables, self.held_tables] = tables(&device, &self.options);
        self.flight_sampling = sampling(&device.flight, &self.options);
        self.held_sampling = sampling(&device.held_modes, &self.options);
        self.flight = Step::new(self.q.len(), &device.rates);
        self.held = Step::new(m, &device.rates);
        self.level = 0;
        self.delay = device.reading_delay();
        self.segment = device.piece(self.whole, self.t, &self.z);
        self.device = device;
        self.touch = None;
        match contact {
            Some(since) if self.device.is_compliant() => {
                let (x, v) = self.proof_mass();
                if x > level {
                    self.place(level, v.min(0.0));
                }
                self.touch = Some(Touch { level, since });
                self.set_out();
            }
            Some(since) if level.is_finite() => {
                self.place(level, 0.0);
                self.land(since, level);
            }
            _ => {
                let (x, v) = self.proof_mass();
                // The ground was raised above the mass: it is lifted with it.
                if x < level {
                    self.place(level, v.max(0.0));
                }
                self.set_out();
            }
        }
        Ok(())
    }

    /// Takes no step longer than `longest` [s] from now on.
    pub fn limit_step(&mut self, longest: f64) {
        self.options.longest_step = Some(longest.max(LEAST_LIMIT));
        [self.flight_tables, self.held_tables] = tables(&self.device, &self.options);
        self.level = 0;
    }

    /// Changes the drive from now on.
    ///
    /// # Errors
    /// [`SimError`]; then nothing is changed.
    pub fn set_drive(&mut self, drive: &Waveform) -> Result<(), SimError> {
        drive.check()?;
        self.device.end_piece(&self.segment, self.t, &mut self.z);
        self.drive = drive.clone();
        self.index = self.drive.index_at(self.t);
        self.whole = self.drive.segment(self.index);
        self.segment = self.device.piece(self.whole, self.t, &self.z);
        Ok(())
    }

    fn proof_mass(&self) -> (f64, f64) {
        (
            dot(&self.device.phi_p, &self.q),
            dot(&self.device.phi_p, &self.v),
        )
    }

    /// Moves the proof mass to `x` with velocity `v` by an impulse on it alone.
    fn place(&mut self, x: f64, v: f64) {
        let (x0, v0) = self.proof_mass();
        for i in 0..self.q.len() {
            let anchor = self.device.held.anchor[i];
            self.q[i] += anchor * (x - x0);
            self.v[i] += anchor * (v - v0);
        }
    }

    /// From flight coordinates to held ones on the ground.
    fn land(&mut self, since: f64, level: f64) {
        self.hold_at(level);
        self.sliding = 0.0;
        self.phase = Phase::Held { since, level };
    }

    /// From flight coordinates to held ones.
    fn hold_at(&mut self, level: f64) {
        let held = &self.device.held;
        let m = self.r.len();
        for k in 0..m {
            self.r[k] = 0.0;
            self.dr[k] = 0.0;
            for i in 0..self.q.len() {
                let z = held.basis[i * m + k];
                self.r[k] += z * (self.q[i] - level * held.anchor[i]);
                self.dr[k] += z * self.v[i];
            }
        }
    }

    /// From held coordinates to flight ones; the phase is left to the caller.
    fn lift(&mut self, level: f64) {
        let held = &self.device.held;
        let m = self.r.len();
        for i in 0..self.q.len() {
            let row = &held.basis[i * m..(i + 1) * m];
            self.q[i] = level * held.anchor[i] + dot(row, &self.r);
            self.v[i] = dot(row, &self.dr);
        }
    }

    fn enter_segment(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        while self.segment.end <= self.t {
            let before = self
                .device
                .piezo_force(self.segment.shape.voltage(self.t), self.segment.branch);
            self.device.end_piece(&self.segment, self.t, &mut self.z);
            if self.whole.end <= self.t {
                self.index += 1;
                self.whole = self.drive.segment(self.index);
            }
            self.segment = self.device.piece(self.whole, self.t, &self.z);
            let after = self
                .device
                .piezo_force(self.segment.shape.voltage(self.t), self.segment.branch);
            if (after - before).abs() > 1e-6 * before.abs().max(after.abs()) {
                let velocity = match self.phase {
                    Phase::Flight => self.proof_mass().1,
                    Phase::Held { .. } | Phase::Stuck { .. } => 0.0,
                };
                self.report(trace, EventKind::DriveStep, [velocity; 2], 0.0, 0.0)?;
            }
        }
        if self.device.has_effects() {
            self.follow_ground(trace)?;
        }
        Ok(())
    }

    fn report(
        &mut self,
        trace: &mut Trace,
        kind: EventKind,
        velocity: [f64; 2],
        pull_off_force: f64,
        contact_duration: f64,
    ) -> Result<(), SimError> {
        trace.events.push(Event {
            time: self.t,
            kind,
            velocity_before: velocity[0],
            velocity_after: velocity[1],
            pull_off_force,
            contact_duration,
        });
        self.events += 1;
        if self.events > self.options.max_events as u64 {
            return Err(SimError::too_much(
                self.t,
                "events",
                self.events,
                self.burden(trace),
            ));
        }
        Ok(())
    }

    /// First level whose step does not reach far beyond the segment's end.
    fn covering_level(&self, tables: &Tables) -> usize {
        if self.options.fixed_step.is_some() || !self.segment.end.is_finite() {
            return 0;
        }
        let remaining = self.segment.end - self.t;
        if remaining >= tables.length(0) {
            return 0;
        }
        let halvings = (tables.length(0) / remaining).log2().floor();
        halvings.clamp(0.0, (LEVELS - 1) as f64) as usize
    }

    /// Takes one step of the present phase into its scratch; returns the step's length.
    fn step(&mut self, trace: &mut Trace) -> Result<f64, SimError> {
        let held = match self.phase {
            Phase::Held { level, .. } | Phase::Stuck { level } => Some(level),
            Phase::Flight => None,
        };
        (self.flight.sliding, self.flight.touch) = (self.sliding, self.touch);
        let covering = self.covering_level(&self.flight_tables);
        let mut level = self.level.max(covering);
        let mut rejected = false;
        loop {
            self.count_step(trace)?;
            let taken = match held {
                Some(ground) => self.held.held(
                    &self.device,
                    &self.held_tables,
                    level,
                    &self.segment,
                    self.t,
                    (&self.r, &self.dr, &self.z),
                    ground,
                    self.options.tolerance,
                ),
                None => self.flight.flight(
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
            let (error, size) = (step.error, step.xp[0].abs());
            // Errors below rounding cannot be asked for.
            let tolerance = self.options.tolerance + 16.0 * f64::EPSILON * size;
            let fixed = self.options.fixed_step.is_some();
            if taken.is_ok() && (fixed || error <= tolerance) {
                if rejected {
                    self.level = level;
                } else if error < tolerance / 64.0 && level == self.level && level > 0 {
                    self.level -= 1;
                }
                return Ok(self.flight_tables.length(level));
            }
            rejected = true;
            level += 1;
            if level >= LEVELS || (fixed && taken.is_err()) {
                // Away from the ground it is not the film that needs ever shorter steps.
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

    fn fly(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        let h = self.step(trace)?;
        let end = ((self.segment.end - self.t) / h).min(1.0);
        let stop = self.first_stop(h, end);
        let s = stop.map_or(end, |(s, _)| s);
        self.emit_flight(h, s, trace);
        if s >= 1.0 {
            const LAST: usize = super::nodes::S - 1;
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

    /// Takes over the held state at fraction `s` of the step.
    fn take_held(&mut self, h: f64, s: f64, whole: bool) {
        if s >= 1.0 {
            const LAST: usize = super::nodes::S - 1;
            self.r.copy_from_slice(self.held.q_at(LAST));
            self.dr.copy_from_slice(self.held.v_at(LAST));
            self.z.copy_from_slice(self.held.z_at(LAST));
        } else {
            self.held.modal_at(s, &mut self.r, &mut self.dr);
            self.z.copy_from_slice(self.held.states_at(s).as_slice());
        }
        self.t = self.time_after(h, s, whole);
    }

    /// Time at fraction `s` of a step; a segment's end is met exactly.
    fn time_after(&self, h: f64, s: f64, whole: bool) -> f64 {
        if whole && s < 1.0 {
            self.segment.end
        } else {
            self.t + s * h
        }
    }
}

/// Free motion of each oscillator over one sample interval.
fn sampling(oscillators: &[Oscillator], options: &Options) -> Vec<[f64; 4]> {
    oscillators
        .iter()
        .map(|o| o.free_motion(1.0 / options.rate))
        .collect()
}

/// Modal state for the initial displacement (bent as by a static force on the mass)
/// and velocity (given as by an impulse on it).
fn initial_state(device: &Device) -> (Vec<f64>, Vec<f64>) {
    let (x0, v0) = device.initial;
    let anchor = &device.held.anchor;
    let v = anchor.iter().map(|a| a * v0).collect();
    let free = device.flight.iter().any(|o| o.omega2 == 0.0);
    let q = if free {
        anchor.iter().map(|a| a * x0).collect()
    } else {
        let shape: Vec<f64> = device
            .flight
            .iter()
            .zip(&device.phi_p)
            .map(|(o, phi)| phi / o.omega2)
            .collect();
        let force = x0 / dot(&device.phi_p, &shape);
        shape.iter().map(|s| s * force).collect()
    };
    (q, v)
}

/// Tables of both phases; levels have the same length in both.
pub(super) fn tables(device: &Device, options: &Options) -> [Tables; 2] {
    let structure = device.longest_step();
    let by_itself = if structure.is_finite() {
        structure
    } else {
        64.0 / options.rate
    };
    let limit = options.longest_step.unwrap_or(f64::INFINITY);
    let longest = options.fixed_step.unwrap_or(by_itself.min(limit));
    let none = vec![0.0; device.held_modes.len()];
    [
        Tables::new(
            longest,
            &device.flight,
            &device.rates,
            &device.phi_p,
            &device.phi_d,
        ),
        Tables::new(longest, &device.held_modes, &device.rates, &none, &none),
    ]
}
