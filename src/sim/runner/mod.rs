//! The hybrid automaton: flight and held phases, the events between them, and the output.

mod budget;
mod change;
mod contact;
mod coordinates;
mod emit;
mod motion;
pub(crate) mod notes;
mod pace;
pub(crate) mod strobe;
mod watch;

use self::notes::Notes;
use self::pace::Pace;
use super::device::{Device, dot};
use super::error::{Options, SimError};
use super::output::{FastModes, SampleRange};
use super::step::tables::{Tables, phase_tables};
use super::step::{Step, Touch};
use super::stretch::StretchState;
use super::trace::{Event, EventKind, Trace};
use crate::model::Model;
use crate::model::drive::{Segment, Waveform};

/// Most samples by which a run without a last sample may be ahead of the time reached: as many as
/// the window keeps of it.
const MAX_SAMPLES_AHEAD: f64 = 2e6;

/// Phase of the proof mass.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Flight,
    /// On the ground since `since` \[s\], at `level` \[m\].
    Held {
        since: f64,
        level: f64,
    },
    /// Held by friction at `level` \[m\], away from a rigid ground.
    Stuck {
        level: f64,
    },
}

/// A device in motion. It can be advanced piece by piece and changed between pieces.
#[derive(Debug, Clone)]
pub struct Runner {
    options: Options,
    device: Device,
    drive: Waveform,
    index: usize,
    /// The drive's present segment, and the piece of it in progress.
    whole: Segment,
    segment: Segment,
    t: f64,
    phase: Phase,
    /// Direction in which the mass slides, for friction, and its contact with a compliant ground.
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
    /// Delay of the samples \[s\].
    delay: f64,
    samples: SampleRange,
    steps: u64,
    events: u64,
    pace: Pace,
    /// Instant at which the run stops though the drive goes on \[s\].
    stop: f64,
    watch: Option<Box<Notes>>,
}

impl Runner {
    /// A device at its initial state at t = 0.
    ///
    /// # Errors
    /// [`SimError`] if model, drive or options are invalid.
    pub fn new(model: &Model, drive: &Waveform, options: &Options) -> Result<Self, SimError> {
        options.check()?;
        drive.check()?;
        let device = Device::new(model)?;
        let index = drive.index_at(0.0);
        let (q, v) = initial_state(&device);
        // Before t = 0 the device rested in its initial position, without a voltage.
        let still = vec![0.0; v.len()];
        let z = device.settled_states(&device.flight_kinematics(0.0, 0.0, &q, &still));
        let m = device.held_modes.len();
        let [flight_tables, held_tables] =
            phase_tables(&device, options, [device.longest_step(); 2]);
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
            flight_sampling: FastModes::sampling(&device.flight, 1.0 / options.rate),
            held_sampling: FastModes::sampling(&device.held_modes, 1.0 / options.rate),
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
            samples: SampleRange {
                next: 0,
                end: u64::MAX,
            },
            steps: 0,
            events: 0,
            pace: Pace::of(&device, options, 0.0),
            device,
            stop: f64::INFINITY,
            watch: None,
        };
        runner.set_out();
        Ok(runner)
    }

    /// A device with a given state at `t` \[s\]; `held_since` if the mass is on the ground. Without
    /// extra states it begins as if it had stood there for long, under the voltage at `t`.
    ///
    /// # Errors
    /// As [`Runner::new`].
    pub fn from_state(
        model: &Model,
        drive: &Waveform,
        options: &Options,
        t: f64,
        state: &StretchState,
        held_since: Option<f64>,
    ) -> Result<Self, SimError> {
        let mut runner = Self::new(model, drive, options)?;
        runner.t = t;
        runner.pace = Pace::of(&runner.device, options, t);
        runner.index = runner.drive.index_at(t);
        runner.whole = runner.drive.segment(runner.index);
        runner.phase = Phase::Flight;
        runner.samples.next = (t * options.rate).ceil().max(0.0) as u64;
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
        if state.z.is_empty() {
            runner.settle();
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

    /// Extra states as if everything had stood where it is for long.
    fn settle(&mut self) {
        let device = &self.device;
        let voltage = self.whole.shape.voltage(self.t);
        let mut at = match self.phase {
            Phase::Held { level, .. } => {
                device.held_kinematics(self.t, voltage, level, &self.r, &self.dr)
            }
            Phase::Flight | Phase::Stuck { .. } => {
                device.flight_kinematics(self.t, voltage, &self.q, &self.v)
            }
        };
        let z = device.settled_states(&at);
        device.drive_force(&mut at, self.whole.branch, &z);
        self.z = device.settled_states(&at);
    }

    /// An empty trace to advance into. It begins with the next sample.
    pub fn new_trace(&self) -> Trace {
        let sensor = self.device.sensor;
        Trace {
            t0: self.samples.next as f64 / self.options.rate,
            dt: 1.0 / self.options.rate,
            ground_level: self.device.ground.map(|g| g.level + sensor.offset_p),
            forces: self.options.forces.then(Default::default),
            ..Trace::default()
        }
    }

    /// Time reached \[s\].
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Takes no more than `count` samples from t = 0 on, however long the last step is.
    pub(super) fn limit_samples(&mut self, count: usize) {
        self.samples.end = count as u64;
    }

    /// Advances beyond `until` \[s\]. Samples, events and contacts are appended to `trace`. Only
    /// whole steps are taken, so that the run may end a little later. The result is the same in one
    /// piece or in many.
    ///
    /// # Errors
    /// [`SimError`]; `trace` holds the results up to then.
    pub fn advance(&mut self, until: f64, trace: &mut Trace) -> Result<(), SimError> {
        self.check_delay()?;
        while self.t <= until {
            self.advance_by_step(trace)?;
        }
        Ok(())
    }

    fn advance_by_step(&mut self, trace: &mut Trace) -> Result<(), SimError> {
        self.enter_segment(trace)?;
        match self.phase {
            Phase::Flight => self.fly(trace),
            Phase::Held { since, level } => self.hold(since, level, trace),
            Phase::Stuck { level } => self.rest(level, trace),
        }
    }

    /// Late samples are taken ahead of the time reached, by the delay. Without a last sample
    /// nothing else limits how many.
    fn check_delay(&self) -> Result<(), SimError> {
        let ahead = self.delay * self.options.rate;
        if self.samples.end < u64::MAX || ahead <= MAX_SAMPLES_AHEAD {
            return Ok(());
        }
        Err(SimError::Options {
            what: "delay of the readings",
            reason: format!(
                "{} s are {ahead:.0} samples, more than the {MAX_SAMPLES_AHEAD} that a run without an end can be ahead; make the delay shorter or the sample rate lower",
                self.delay
            ),
        })
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
            self.pace.enter_piece();
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
            return Err(self.too_much("events", self.events));
        }
        Ok(())
    }
}

/// Modal state for the initial displacement and velocity. The structure is bent as by a static
/// force on the mass and moves as after an impulse on it.
pub(super) fn initial_state(device: &Device) -> (Vec<f64>, Vec<f64>) {
    state_at(device, device.initial)
}

/// The same for a displacement `x0` \[m\] and a velocity `v0` [m/s].
fn state_at(device: &Device, (x0, v0): (f64, f64)) -> (Vec<f64>, Vec<f64>) {
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
