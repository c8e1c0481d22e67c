//! The hybrid automaton: flight and held phases, events between them, output.

use crate::model::Model;
use crate::model::drive::{Segment, Waveform};

use super::crossing::first_below;
use super::device::{Device, dot};
use super::error::{Options, SimError};
use super::linear::Oscillator;
use super::output::{FastModes, Sample, Sink};
use super::step::{LEVELS, Step, Tables, Touch};
use super::trace::{Event, EventKind, Trace};

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

/// What ends a step of flight early.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stop {
    /// The mass meets the ground.
    Hit,
    /// It leaves a compliant ground.
    Leave,
    /// Its velocity comes to zero, where friction turns.
    Turn,
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

    /// Sets out in flight with friction: the mass slides as it moves, or as it is pulled,
    /// or is held.
    fn set_out(&mut self) {
        if self.device.friction == 0.0 {
            self.sliding = 0.0;
            return;
        }
        let (x, v) = self.proof_mass();
        self.sliding = if v == 0.0 { 0.0 } else { v.signum() };
        if v == 0.0 {
            self.turn(x);
        }
    }

    /// The mass is at rest at `x` for an instant, in flight coordinates: friction holds it,
    /// or it slides the way it is pulled.
    fn turn(&mut self, x: f64) {
        self.place(x, 0.0);
        let pull = self.pull_if_held() + self.reaction(x, 0.0, self.t);
        if pull.abs() > self.device.friction {
            self.sliding = pull.signum();
        } else {
            self.hold_at(x);
            self.sliding = 0.0;
            self.phase = Phase::Stuck { level: x };
        }
    }

    /// Force of a compliant ground on the mass at `x` with velocity `v`, 0 out of contact.
    fn reaction(&self, x: f64, v: f64, t: f64) -> f64 {
        self.touch.map_or(0.0, |touch| {
            self.device
                .contact_force(touch.level - x, -v, t - touch.since)
        })
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

    /// An effect may have moved the ground: a mass above is lifted with it, one that lay on
    /// it loses it.
    fn follow_ground(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        let level = self.device.ground_level(self.t);
        if let Phase::Held { since, level: old } = self.phase {
            if level > old {
                self.lift(old);
                self.place(level, 0.0);
                self.land(since, level);
            } else if level < old {
                let pull = self.pull_at_rest(old);
                self.release(since, old, pull, trace)?;
            }
            return Ok(());
        }
        let height = match (self.touch, self.phase) {
            (Some(touch), _) if touch.level == level => return Ok(()),
            (_, Phase::Stuck { level: at }) if at >= level && self.touch.is_none() => {
                return Ok(());
            }
            (None, Phase::Flight) if self.proof_mass().0 >= level => return Ok(()),
            (touch, _) => touch.map(|touch| touch.level - level),
        };
        if let Phase::Stuck { level: at } = self.phase {
            self.lift(at);
            self.phase = Phase::Flight;
        }
        let (x, v) = self.proof_mass();
        match height {
            // In a compliant ground it keeps its depth as it is lifted.
            Some(fall) if fall < 0.0 => {
                self.place(x - fall, v);
                self.touch = self.touch.map(|touch| Touch { level, ..touch });
            }
            Some(_) => self.leave(trace)?,
            None => self.place(level, v.max(0.0)),
        }
        self.set_out();
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
            return Err(SimError::too_much(self.t, "events", self.events));
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

    /// Counts a step attempt and bounds the work.
    fn count_step(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        self.steps += 1;
        trace.steps += 1;
        if self.steps > self.options.max_steps {
            return Err(SimError::too_much(self.t, "steps", self.steps));
        }
        Ok(())
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

    /// What first ends a step of flight before `end`, and at which fraction.
    fn first_stop(&self, h: f64, end: f64) -> Option<(f64, Stop)> {
        let contact = match self.touch {
            Some(touch) => self.first_leave(touch, end).map(|s| (s, Stop::Leave)),
            None if self.device.ground.is_some() => self.first_hit(h, end).map(|s| (s, Stop::Hit)),
            None => None,
        };
        if self.device.friction == 0.0 {
            return contact;
        }
        let end = contact.map_or(end, |(s, _)| s);
        self.flight
            .first_turn(&self.device.phi_p, end)
            .map(|s| (s, Stop::Turn))
            .or(contact)
    }

    /// Fraction of the step at which the mass comes up to a compliant ground's level.
    fn first_leave(&self, touch: Touch, end: f64) -> Option<f64> {
        let smooth = self.flight.smooth(&self.device.phi_p);
        let depth =
            |s: f64| touch.level - smooth.value(s) - self.flight.fast_at(&self.device.phi_p, s);
        first_below(depth, end, 1e-10 * touch.level.abs())
    }

    /// Contact with a compliant ground begins.
    fn enter(&mut self, v: f64, trace: &mut Trace) -> Result<(), SimError> {
        let level = self.device.ground_level(self.t);
        let since = self.t;
        self.touch = Some(Touch { level, since });
        Sink::open_contact(trace, since, since);
        let pull = self.pull_if_held();
        self.report(trace, EventKind::Stick, [v; 2], pull, 0.0)
    }

    /// Contact with a compliant ground ends.
    fn leave(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        let Some(touch) = self.touch.take() else {
            return Ok(());
        };
        Sink::open_contact(trace, touch.since, self.t);
        let (_, v) = self.proof_mass();
        let pull = self.pull_if_held();
        let duration = self.t - touch.since;
        self.report(trace, EventKind::Release, [v; 2], pull, duration)
    }

    /// Held by friction, away from a rigid ground.
    fn rest(&mut self, level: f64, trace: &mut Trace) -> Result<(), SimError> {
        let net = self.pull_at_rest(level) + self.reaction(level, 0.0, self.t);
        if net.abs() > self.device.friction {
            self.slide(level, net);
            return Ok(());
        }
        let h = self.step(trace)?;
        let end = ((self.segment.end - self.t) / h).min(1.0);
        let net = |s: f64| self.held_pull(s, level) + self.reaction(level, 0.0, self.t + s * h);
        let freed =
            first_below(|s| self.device.friction - net(s).abs(), end, 0.0).map(|s| (s, net(s)));
        let s = freed.map_or(end, |(s, _)| s);
        self.emit_held(h, s, None, level, trace);
        self.take_held(h, s, freed.is_none());
        if let Some(touch) = self.touch {
            Sink::open_contact(trace, touch.since, self.t);
        }
        if let Some((_, net)) = freed {
            self.slide(level, net);
        }
        Ok(())
    }

    /// Friction no longer holds the mass against the force `net`.
    fn slide(&mut self, level: f64, net: f64) {
        self.lift(level);
        self.sliding = net.signum();
        self.phase = Phase::Flight;
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

    /// Fraction of the step at which the mass meets the ground.
    fn first_hit(&self, h: f64, end: f64) -> Option<f64> {
        let step = &self.flight;
        let ground = self.device.ground_level(self.t);
        let lowest = step.xp.iter().fold(f64::INFINITY, |a, &x| a.min(x));
        let fastest = step.vp.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        // Points are at most 0.33 h apart, two radians of the fastest mode, whose greatest
        // velocity they miss by less than half. An effect may move the ground: then look.
        let far = lowest - ground > 0.35 * h * fastest;
        if far && !self.device.has_effects() {
            return None;
        }
        let smooth = step.smooth(&self.device.phi_p);
        let slack = 1e-10 * ground.abs();
        let gap = |s: f64| {
            let x = smooth.value(s) + step.fast_at(&self.device.phi_p, s);
            x - self.device.ground_level(self.t + s * h)
        };
        first_below(gap, end, slack)
    }

    fn impact(&mut self, v: f64, trace: &mut Trace) -> Result<(), SimError> {
        let level = self.device.ground_level(self.t);
        let before = v.min(0.0);
        let after = -self.device.restitution(-before) * before;
        self.place(level, after);
        let pull = self.pull_if_held();
        if pull > self.threshold(0.0) {
            self.sliding = 1.0;
            return self.report(trace, EventKind::Impact, [before, after], pull, 0.0);
        }
        self.place(level, 0.0);
        self.land(self.t, level);
        Sink::open_contact(trace, self.t, self.t);
        self.report(trace, EventKind::Stick, [before, 0.0], pull, 0.0)
    }

    /// Eq (13) in flight coordinates.
    fn pull_if_held(&self) -> f64 {
        let voltage = self.segment.shape.voltage(self.t);
        let mut at = self
            .device
            .flight_kinematics(self.t, voltage, &self.q, &self.v);
        let branch = self.segment.branch;
        let drive = self.device.drive_force(&mut at, branch, &self.z);
        (at.vp, at.film) = (0.0, 0.0);
        let on_mass = self.device.force_on_held(&at, &self.z);
        self.device.pull_flight(&self.q, &self.v, drive, on_mass)
    }

    /// Pull-off force now, of the mass held at `level`.
    fn pull_at_rest(&self, level: f64) -> f64 {
        let voltage = self.segment.shape.voltage(self.t);
        let device = &self.device;
        let mut at = device.held_kinematics(self.t, voltage, level, &self.r, &self.dr);
        let drive = device.drive_force(&mut at, self.segment.branch, &self.z);
        let on_mass = device.force_on_held(&at, &self.z);
        device.pull_held(&self.r, &self.dr, level, drive, on_mass)
    }

    fn hold(&mut self, since: f64, level: f64, trace: &mut Trace) -> Result<(), SimError> {
        let pull = self.pull_at_rest(level);
        if pull > self.threshold(self.t - since) {
            return self.release(since, level, pull, trace);
        }
        let h = self.step(trace)?;
        let end = ((self.segment.end - self.t) / h).min(1.0);
        let freed = self.first_release(h, end, since, level);
        let s = freed.map_or(end, |(s, _)| s);
        self.emit_held(h, s, Some(since), level, trace);
        self.take_held(h, s, freed.is_none());
        Sink::open_contact(trace, since, self.t);
        match freed {
            Some((_, pull)) => self.release(since, level, pull, trace),
            None => Ok(()),
        }
    }

    /// Pull-off force that frees the mass after `contact_time` [s]: friction holds it too.
    fn threshold(&self, contact_time: f64) -> f64 {
        self.device.adhesion(contact_time).max(0.0) + self.device.friction
    }

    /// Fraction of the held step at which the pull-off force exceeds adhesion, and the force.
    fn first_release(&self, h: f64, end: f64, since: f64, level: f64) -> Option<(f64, f64)> {
        let step = &self.held;
        let margin: [f64; super::nodes::S] = std::array::from_fn(|k| {
            let t = self.t + super::nodes::NODES[k] * h;
            self.threshold(t - since) - step.force[k]
        });
        let lowest = margin.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let highest = margin.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b));
        if lowest > 0.75 * (highest - lowest) {
            return None;
        }
        let pull = |s: f64| self.held_pull(s, level);
        first_below(
            |s| self.threshold(self.t + s * h - since) - pull(s),
            end,
            0.0,
        )
        .map(|s| (s, pull(s)))
    }

    /// Pull-off force at fraction `s` of the held step.
    fn held_pull(&self, s: f64, level: f64) -> f64 {
        self.held
            .held_pull(&self.device, &self.segment, self.t, s, level)
    }

    fn release(
        &mut self,
        since: f64,
        level: f64,
        pull: f64,
        trace: &mut Trace,
    ) -> Result<(), SimError> {
        self.slide(level, 1.0);
        Sink::open_contact(trace, since, self.t);
        self.report(trace, EventKind::Release, [0.0; 2], pull, self.t - since)
    }

    /// Voltage when a sample is taken that shows the device at `t`.
    #[inline]
    fn voltage_when_taken(&self, t: f64) -> f64 {
        if self.delay > 0.0 {
            self.drive.voltage(t + self.delay)
        } else {
            self.segment.shape.voltage(t)
        }
    }

    /// Samples of a flight step up to fraction `s`.
    fn emit_flight(&mut self, h: f64, s: f64, trace: &mut Trace) {
        let delay = self.delay;
        let mut sink = Sink::new(&self.options, self.t, h, s, self.next_sample, delay);
        if sink.is_empty() {
            return;
        }
        let device = &self.device;
        let p = self.flight.smooth(&device.phi_p);
        let c = self.flight.smooth(&device.phi_c);
        let mut fast = FastModes::new(&self.flight.swings, &self.flight_sampling);
        while let Some((t, s)) = sink.next() {
            fast.advance(s * h);
            if t < self.t {
                // A late sample of before the start shows the start.
                fast.restart();
            }
            let states = device.has_effects().then(|| self.flight.states_at(s));
            let (xp, vp) = fast.add(p.value_and_slope(s, h), &device.phi_p);
            let (xc, vc) = if device.has_cantilever {
                fast.add(c.value_and_slope(s, h), &device.phi_c)
            } else {
                (0.0, 0.0)
            };
            let sample = Sample {
                t,
                xp,
                vp,
                xc,
                vc,
                pull: None,
                friction: -device.friction * self.sliding,
                reaction: self.reaction(xp, vp, t),
                voltage: self.voltage_when_taken(t),
                z: states.as_ref().map_or(&[], |states| states.as_slice()),
            };
            sample.push(device, &self.segment, trace);
        }
        self.next_sample = sink.next_sample();
    }

    /// Samples of a held step up to fraction `s`; on the ground `since` [s], or held by
    /// friction.
    fn emit_held(&mut self, h: f64, s: f64, since: Option<f64>, level: f64, trace: &mut Trace) {
        let delay = self.delay;
        let mut sink = Sink::new(&self.options, self.t, h, s, self.next_sample, delay);
        if sink.is_empty() {
            return;
        }
        let device = &self.device;
        let shape = &device.held.cantilever;
        let base = level * device.anchor_c;
        let c = self.held.smooth(shape);
        let mut fast = FastModes::new(&self.held.swings, &self.held_sampling);
        while let Some((t, s)) = sink.next() {
            fast.advance(s * h);
            let states = device.has_effects().then(|| self.held.states_at(s));
            let (xc, vc) = fast.add(c.value_and_slope(s, h), shape);
            let reaction = self.reaction(level, 0.0, t);
            let (mut pull, mut friction) = (None, 0.0);
            if self.options.forces {
                let held = self.held_pull(s, level);
                match since {
                    Some(since) => pull = Some((held, device.adhesion(t - since).max(0.0))),
                    None => friction = -held - reaction,
                }
            }
            let sample = Sample {
                t,
                xp: level,
                vp: 0.0,
                xc: base + xc,
                vc,
                pull,
                friction,
                reaction,
                voltage: self.voltage_when_taken(t),
                z: states.as_ref().map_or(&[], |states| states.as_slice()),
            };
            sample.push(device, &self.segment, trace);
        }
        self.next_sample = sink.next_sample();
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
    let longest = options.fixed_step.unwrap_or(if structure.is_finite() {
        structure
    } else {
        64.0 / options.rate
    });
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
