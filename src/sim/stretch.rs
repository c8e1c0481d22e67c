//! Stretches of flight or of held motion from a given state, without looking for events:
//! what a fit compares with the data between the events that the data show.
//!
//! A [`StretchSimulator`] is a model made ready once; it is shared by all threads, and
//! its propagators are made once for all stretches. Each thread steps with a
//! [`Stretcher`] of its own, which allocates nothing per stretch.

use crate::model::drive::Segment;
use crate::model::effects::Kinematics;
use crate::model::sensor::Point;
use crate::model::structure::Held;
use crate::model::{MAX_MODES, Model};

use super::crossing::first_below;
use super::device::{Device, dot};
use super::error::{Burden, Options, SimError};
use super::nodes::S;
use super::runner::tables;
use super::step::{LEVELS, Step, Tables};

/// Time constants after which a decaying state is forgotten.
const FORGOTTEN: f64 = 35.0;
/// Steps after which a stretch is given up, to begin with: where the film is thought to be
/// all but singular, a fit must not crawl through it.
const MOST_STEPS: u64 = 20_000;
/// And so many more for each reading.
const STEPS_PER_READING: u64 = 200;

/// State of the structure and of the effects at one instant. In flight `q`, `v` are the
/// modal coordinates and their velocities (as many as modes); held, those of the
/// structure with the mass held (one fewer).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StretchState {
    /// Coordinates \[kg^1/2 m\].
    pub q: Vec<f64>,
    /// Their velocities \[kg^1/2 m/s\].
    pub v: Vec<f64>,
    /// Extra states of the effects.
    pub z: Vec<f64>,
}

/// Displacements and velocities of the two points, without the sensor's offsets.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Points {
    /// Proof mass \[m\].
    pub xp: f64,
    /// Its velocity \[m/s\].
    pub vp: f64,
    /// Cantilever \[m\].
    pub xc: f64,
    /// Its velocity \[m/s\].
    pub vc: f64,
}

/// A device made ready for stretches.
#[derive(Debug, Clone)]
pub struct StretchSimulator {
    device: Device,
    flight: Tables,
    held: Tables,
    tolerance: f64,
}

impl StretchSimulator {
    /// Compiles `model`; of `options` only the tolerance counts. Below the ground, where
    /// a stretch that no event stops may come, the film stays as thick as half of what
    /// it is at contact.
    ///
    /// # Errors
    /// [`SimError`] if model or options make no sense.
    pub fn new(model: &Model, options: &Options) -> Result<Self, SimError> {
        options.check()?;
        let mut device = Device::new(model)?;
        device.bound_film();
        let [flight, held] = tables(&device, options);
        Ok(Self {
            device,
            flight,
            held,
            tolerance: options.tolerance,
        })
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.device.flight.len()
    }

    /// Decay rates of the effects' extra states \[1/s\].
    pub fn state_rates(&self) -> &[f64] {
        &self.device.rates
    }

    /// Shapes of the modes in flight at the proof mass and at the cantilever.
    pub fn flight_shapes(&self) -> (&[f64], &[f64]) {
        (&self.device.phi_p, &self.device.phi_c)
    }

    /// The structure with the mass held.
    pub fn held_structure(&self) -> &Held {
        &self.device.held
    }

    /// Squared angular frequencies of the modes in flight \[1/s^2\].
    pub fn flight_omega2(&self) -> impl Iterator<Item = f64> + '_ {
        self.device.flight.iter().map(|o| o.omega2)
    }

    /// Where the extra states stand that are the readings of proof mass and cantilever.
    pub fn reading_states(&self) -> Option<usize> {
        self.device.reading_states()
    }

    /// Time by which readings are late \[s\].
    pub fn reading_delay(&self) -> f64 {
        self.device.reading_delay()
    }

    /// Level of the ground at `t` \[m\]; minus infinity without one.
    pub fn ground_level(&self, t: f64) -> f64 {
        self.device.ground_level(t)
    }

    /// Force that holds the mass on the ground after `contact_time` \[N\]: adhesion where
    /// it is not negative, and friction.
    pub fn adhesion(&self, contact_time: f64) -> f64 {
        self.device.adhesion(contact_time).max(0.0) + self.device.friction
    }

    /// Coefficient of restitution at an approach speed \[m/s\].
    pub fn restitution(&self, speed: f64) -> f64 {
        self.device.restitution(speed)
    }

    /// Displacements and velocities in flight.
    pub fn flight_points(&self, state: &StretchState) -> Points {
        let d = &self.device;
        Points {
            xp: dot(&d.phi_p, &state.q),
            vp: dot(&d.phi_p, &state.v),
            xc: dot(&d.phi_c, &state.q),
            vc: dot(&d.phi_c, &state.v),
        }
    }

    /// Displacements and velocities with the mass held at `level` \[m\].
    pub fn held_points(&self, level: f64, state: &StretchState) -> Points {
        let d = &self.device;
        Points {
            xp: level,
            vp: 0.0,
            xc: level * d.anchor_c + dot(&d.held.cantilever, &state.q),
            vc: dot(&d.held.cantilever, &state.v),
        }
    }

    /// Brings the proof mass to displacement `x` and velocity `v` by an impulse on it
    /// alone.
    pub fn kick(&self, x: f64, v: f64, state: &mut StretchState) {
        let now = self.flight_points(state);
        for (i, anchor) in self.device.held.anchor.iter().enumerate() {
            state.q[i] += anchor * (x - now.xp);
            state.v[i] += anchor * (v - now.vp);
        }
    }

    /// From flight to held at `level` \[m\]: what motion of the mass is left is taken out.
    pub fn land(&self, level: f64, state: &mut StretchState) {
        let held = &self.device.held;
        let (n, m) = (self.modes(), self.device.held_modes.len());
        let (mut r, mut dr) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        for k in 0..m {
            for i in 0..n {
                let z = held.basis[i * m + k];
                r[k] += z * (state.q[i] - level * held.anchor[i]);
                dr[k] += z * state.v[i];
            }
        }
        state.q.clear();
        state.v.clear();
        state.q.extend_from_slice(&r[..m]);
        state.v.extend_from_slice(&dr[..m]);
    }

    /// From held at `level` \[m\] to flight.
    pub fn lift(&self, level: f64, state: &mut StretchState) {
        let held = &self.device.held;
        let (n, m) = (self.modes(), self.device.held_modes.len());
        let (mut q, mut v) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        for i in 0..n {
            let row = &held.basis[i * m..(i + 1) * m];
            q[i] = level * held.anchor[i] + dot(row, &state.q);
            v[i] = dot(row, &state.v);
        }
        state.q.clear();
        state.v.clear();
        state.q.extend_from_slice(&q[..n]);
        state.v.extend_from_slice(&v[..n]);
    }

    /// The static state under the drive at `t`: where the modes come to rest, the extra
    /// states too. In flight, or held at a level \[m\]. A free mass stays at zero.
    pub fn rest_state(&self, drive: &[Segment], t: f64, held: Option<f64>) -> StretchState {
        let d = &self.device;
        let segment = segment_at(drive, t);
        let voltage = segment.shape.voltage(t);
        let mut z = vec![0.0; d.rates.len()];
        let mut input = vec![0.0; d.rates.len()];
        let mut at = Kinematics {
            t,
            voltage,
            ..Kinematics::default()
        };
        for _ in 0..3 {
            d.state_inputs(&at, &z, &mut input);
            for ((z, u), rate) in z.iter_mut().zip(&input).zip(&d.rates) {
                *z = if *rate > 0.0 { u / rate } else { 0.0 };
            }
        }
        let force = d.drive_force(&mut at, segment.branch, &z);
        let q: Vec<f64> = match held {
            None => (0..d.flight.len())
                .map(|i| (d.phi_d[i] * force, d.flight[i].omega2))
                .map(|(f, k)| if k > 0.0 { f / k } else { 0.0 })
                .collect(),
            Some(level) => (0..d.held_modes.len())
                .map(|k| {
                    (d.held.drive[k] * force + d.held.level_force[k] * level)
                        / d.held_modes[k].omega2
                })
                .collect(),
        };
        StretchState {
            v: vec![0.0; q.len()],
            q,
            z,
        }
    }

    /// Pull-off force, eq (13), of the mass held at `level` \[m\] at time `t` \[N\].
    pub fn pull_off(&self, drive: &[Segment], t: f64, level: f64, state: &StretchState) -> f64 {
        let d = &self.device;
        let segment = segment_at(drive, t);
        let voltage = segment.shape.voltage(t);
        let mut at = d.held_kinematics(t, voltage, level, &state.q, &state.v);
        let force = d.drive_force(&mut at, segment.branch, &state.z);
        let on_mass = d.force_on_held(&at, &state.z);
        d.pull_held(&state.q, &state.v, level, force, on_mass)
    }

    /// The effects' extra states over the whole drive, from its first instant on, at
    /// increasing `times` \[s\]; row-major `[time][state]`. `motion` gives the points'
    /// displacements and velocities where they matter, from the data or zero.
    pub fn states_from_drive(
        &self,
        drive: &[Segment],
        times: &[f64],
        motion: &dyn Fn(f64) -> Points,
    ) -> Vec<f64> {
        let d = &self.device;
        let count = d.rates.len();
        let mut out = Vec::with_capacity(times.len() * count);
        let Some(&first) = times.first().filter(|_| count > 0) else {
            return out;
        };
        let begin = drive
            .first()
            .map_or(first, |s| if s.start.is_finite() { s.start } else { s.end })
            .min(first);
        let mut t = begin;
        let mut z = self.rest_state(drive, begin, None).z;
        let mut u = vec![0.0; count];
        let fastest = d.rates.iter().fold(0.0f64, |a, &b| a.max(b));
        let longest = (0.2 / fastest.max(1.0)).min(2e-4);
        // What decays is forgotten, unless an effect keeps a memory of its own.
        let slowest = d.rates.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let memory = if slowest > 0.0 {
            FORGOTTEN / slowest
        } else {
            f64::INFINITY
        };
        for &target in times {
            if target - t > memory {
                t = target - memory;
            }
            while t < target {
                let segment = d.piece(segment_at(drive, t), t, &z);
                let end = target.min(segment.end).min(t + longest).max(t + 1e-12);
                let h = end - t;
                let middle = t + 0.5 * h;
                let p = motion(middle);
                let mut at = Kinematics {
                    t: middle,
                    xp: p.xp,
                    vp: p.vp,
                    xc: p.xc,
                    vc: p.vc,
                    voltage: segment.shape.voltage(middle),
                    gain: 0.0,
                    film: d.film_force(p.xp, p.vp),
                };
                d.drive_force(&mut at, segment.branch, &z);
                d.state_inputs(&at, &z, &mut u);
                for ((z, u), rate) in z.iter_mut().zip(&u).zip(&d.rates) {
                    let decay = (-rate * h).exp();
                    let gain = if *rate > 0.0 {
                        -(-rate * h).exp_m1() / rate
                    } else {
                        h
                    };
                    *z = *z * decay + u * gain;
                }
                t = end;
                if t >= segment.end {
                    d.end_piece(&segment, t, &mut z);
                }
            }
            out.extend_from_slice(&z);
        }
        out
    }
}

/// The segment that holds `t`; the first or last one beyond the drive's ends.
fn segment_at(drive: &[Segment], t: f64) -> Segment {
    let index = drive.partition_point(|s| s.end <= t);
    let segment = drive.get(index).or(drive.last());
    segment.copied().unwrap_or(Segment {
        start: f64::NEG_INFINITY,
        end: f64::INFINITY,
        shape: crate::model::drive::Shape::Constant { voltage: 0.0 },
        branch: crate::model::piezo::Branch::Poled,
    })
}

/// Steps through stretches of one simulator with scratch of its own.
#[derive(Debug)]
pub struct Stretcher<'a> {
    simulator: &'a StretchSimulator,
    flight: Step,
    held: Step,
    level: usize,
}

impl<'a> Stretcher<'a> {
    /// For stretches of `simulator`.
    pub fn new(simulator: &'a StretchSimulator) -> Self {
        Self {
            simulator,
            flight: Step::new(simulator.modes(), &simulator.device.rates),
            held: Step::new(simulator.device.held_modes.len(), &simulator.device.rates),
            level: 0,
        }
    }

    /// The simulator.
    pub fn simulator(&self) -> &'a StretchSimulator {
        self.simulator
    }

    /// Carries `state` from `from` to `to` \[s\], in flight (`held` is `None`) or with the
    /// mass held at a level \[m\]. At each of the increasing `times` within, `out` gets the
    /// number of the time, and the readings of `xp` and `xc` without the sensor's offsets
    /// \[m\].
    ///
    /// The drive is a list of segments in order of time; the first and last reach on.
    ///
    /// # Errors
    /// [`SimError`] if the motion diverges or no step is small enough.
    #[allow(clippy::too_many_arguments)]
    pub fn carry(
        &mut self,
        drive: &[Segment],
        held: Option<f64>,
        from: f64,
        to: f64,
        state: &mut StretchState,
        times: &[f64],
        mut out: impl FnMut(usize, f64, f64),
    ) -> Result<(), SimError> {
        let device = &self.simulator.device;
        let mut t = from;
        let mut next = 0;
        let mut steps = 0;
        let most = MOST_STEPS + STEPS_PER_READING * times.len() as u64;
        // Each stretch starts afresh, so that its answer does not depend on the one before.
        self.level = 0;
        self.flight.sliding = 0.0;
        let (on_ground, mut held) = (held.is_some(), held);
        while t < to {
            let mut segment = segment_at(drive, t);
            if device.has_effects() {
                segment = device.piece(segment, t, &state.z);
            }
            if device.friction > 0.0 && !on_ground {
                self.rub(&segment, t, &mut held, state);
            }
            let end = to.min(if segment.end > t { segment.end } else { to });
            let h = self.step(&segment, held, t, end, state, (&mut steps, most))?;
            let mut share = ((end - t) / h).min(1.0);
            let mut reached = if share < 1.0 { end } else { t + h };
            let step = if held.is_some() {
                &self.held
            } else {
                &self.flight
            };
            let mut turned = false;
            if device.friction > 0.0 && !on_ground {
                let turn = match held {
                    None => step.first_turn(&device.phi_p, share),
                    Some(x) => {
                        let pull = |s: f64| step.held_pull(device, &segment, t, s, x);
                        first_below(|s| device.friction - pull(s).abs(), share, 0.0)
                    }
                };
                if let Some(s) = turn {
                    (share, reached, turned) = (s, t + s * h, true);
                }
            }
            if times.get(next).is_some_and(|&s| s <= reached) {
                let none = [0.0; MAX_MODES];
                let (phi_p, phi_c, level_p, level_c) = match held {
                    None => (&device.phi_p[..], &device.phi_c[..], 0.0, 0.0),
                    Some(level) => (
                        &none[..device.held_modes.len()],
                        &device.held.cantilever[..],
                        level,
                        level * device.anchor_c,
                    ),
                };
                let (p, c) = (step.smooth(phi_p), step.smooth(phi_c));
                while let Some(&at) = times.get(next).filter(|&&s| s <= reached) {
                    let s = ((at - t) / h).max(0.0);
                    let (mut xp, mut xc) = (level_p + p.value(s), level_c + c.value(s));
                    for (i, swing) in step.swings.iter().enumerate() {
                        if swing.fast {
                            let (x, _) = swing.free(s * h);
                            xp += phi_p[i] * x;
                            xc += phi_c[i] * x;
                        }
                    }
                    if device.has_effects() {
                        let z = step.states_at(s);
                        xp = device.apparent(xp, Point::ProofMass, at, z.as_slice());
                        xc = device.apparent(xc, Point::Cantilever, at, z.as_slice());
                    }
                    out(next, xp, xc);
                    next += 1;
                }
            }
            if share >= 1.0 {
                state.q.copy_from_slice(step.q_at(S - 1));
                state.v.copy_from_slice(step.v_at(S - 1));
                state.z.copy_from_slice(step.z_at(S - 1));
            } else {
                step.modal_at(share, &mut state.q, &mut state.v);
                state.z.copy_from_slice(step.states_at(share).as_slice());
            }
            t = reached;
            if turned && held.is_none() {
                // At rest to the last bit, for what follows to be decided by the forces.
                let x = self.simulator.flight_points(state).xp;
                self.simulator.kick(x, 0.0, state);
                self.flight.sliding = 0.0;
            }
            if device.has_effects() && t >= segment.end {
                device.end_piece(&segment, t, &mut state.z);
            }
        }
        if let (Some(x), false) = (held, on_ground) {
            self.simulator.lift(x, state);
            held = None;
        }
        // What is asked for at the very start, of a stretch without length.
        while let Some(&at) = times.get(next).filter(|&&s| s <= to) {
            debug_assert!(at >= from - 1e-9);
            let points = match held {
                None => self.simulator.flight_points(state),
                Some(level) => self.simulator.held_points(level, state),
            };
            let xp = device.apparent(points.xp, Point::ProofMass, at, &state.z);
            let xc = device.apparent(points.xc, Point::Cantilever, at, &state.z);
            out(next, xp, xc);
            next += 1;
        }
        Ok(())
    }

    /// Friction away from the ground: a mass that does not slide yet sets out as it moves
    /// or as it is pulled, or is held at `held` until it is pulled hard enough.
    fn rub(&mut self, segment: &Segment, t: f64, held: &mut Option<f64>, state: &mut StretchState) {
        let sim = self.simulator;
        let device = &sim.device;
        if let Some(level) = *held {
            let pull = sim.pull_off(&[*segment], t, level, state);
            // What was freed at a root of the force is on the edge, and pulled outward.
            if pull.abs() < device.friction * (1.0 - 1e-12) {
                return;
            }
            sim.lift(level, state);
            *held = None;
            self.flight.sliding = pull.signum();
        } else if self.flight.sliding == 0.0 {
            let points = sim.flight_points(state);
            if points.vp.abs() > 1e-12 {
                self.flight.sliding = points.vp.signum();
                return;
            }
            sim.land(points.xp, state);
            let pull = sim.pull_off(&[*segment], t, points.xp, state);
            if pull.abs() > device.friction {
                sim.lift(points.xp, state);
                self.flight.sliding = pull.signum();
            } else {
                *held = Some(points.xp);
            }
        }
    }

    /// One step into the scratch; returns its length.
    fn step(
        &mut self,
        segment: &Segment,
        held: Option<f64>,
        t: f64,
        end: f64,
        state: &StretchState,
        (steps, most): (&mut u64, u64),
    ) -> Result<f64, SimError> {
        let sim = self.simulator;
        let longest = sim.flight.length(0);
        let remaining = end - t;
        // The first level whose step does not reach far beyond what is left.
        let covering = if remaining >= longest {
            0
        } else {
            (longest / remaining)
                .log2()
                .floor()
                .clamp(0.0, (LEVELS - 1) as f64) as usize
        };
        let mut level = self.level.max(covering);
        let mut rejected = false;
        loop {
            *steps += 1;
            if *steps > most {
                return Err(SimError::too_much(t, "steps", *steps, Burden::Film));
            }
            let from = (&state.q[..], &state.v[..], &state.z[..]);
            let (taken, step, length) = match held {
                Some(ground) => (
                    self.held.held(
                        &sim.device,
                        &sim.held,
                        level,
                        segment,
                        t,
                        from,
                        ground,
                        sim.tolerance,
                    ),
                    &self.held,
                    sim.held.length(level),
                ),
                None => (
                    self.flight.flight(
                        &sim.device,
                        &sim.flight,
                        level,
                        segment,
                        t,
                        from,
                        sim.tolerance,
                    ),
                    &self.flight,
                    sim.flight.length(level),
                ),
            };
            let tolerance = sim.tolerance + 16.0 * f64::EPSILON * step.xp[0].abs();
            if taken.is_ok() && step.error <= tolerance {
                if rejected {
                    self.level = level;
                } else if step.error < tolerance / 64.0 && level == self.level && level > 0 {
                    self.level -= 1;
                }
                return Ok(length);
            }
            rejected = true;
            level += 1;
            if level >= LEVELS {
                return Err(if state.q.iter().all(|q| q.is_finite()) {
                    SimError::step_too_small(t)
                } else {
                    SimError::diverged(t)
                });
            }
        }
    }
}

#[cfg(test)]
#[path = "stretch_tests.rs"]
mod tests;
