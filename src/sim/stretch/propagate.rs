//! A state propagated through a stretch, step by step, and read on the way.

use super::sample_clock::SampleClock;
use super::sampled_step::{SampledStep, end_state};
use super::{StretchSimulator, StretchState, segment_at};
use crate::model::drive::Segment;
use crate::model::sensor::Point;
use crate::sim::crossing::first_below;
use crate::sim::error::{Burden, SimError};
use crate::sim::nodes::Dense;
use crate::sim::step::Step;
use crate::sim::step::tables::LEVELS;

/// Steps after which a stretch is given up: a fit must not crawl through a film that its
/// parameters make nearly singular.
const MAX_STEPS: u64 = 20_000;
/// Further steps that are allowed for each reading.
const STEPS_PER_READING: u64 = 200;

/// A replayed step is accepted up to this error, over the tolerance.
const MAX_REPLAYED_ERROR: f64 = 100.0;

/// The lengths of the steps that were taken, stretch by stretch. Runs that
/// are differenced must use the same steps: each choice of steps has its own discretisation
/// error, which a finite difference would divide by its step (internal differentiation, Bock
/// 1981).
#[derive(Debug, Clone, Default)]
pub struct StepSequence(pub(super) Vec<Vec<usize>>);

/// Steps through stretches of one simulator with scratch of its own.
#[derive(Debug)]
pub struct Stretcher<'a> {
    simulator: &'a StretchSimulator,
    flight: Step,
    held: Step,
    level: usize,
    recorded: Option<StepSequence>,
    replayed: Option<(&'a StepSequence, usize)>,
}

impl<'a> Stretcher<'a> {
    /// For stretches of `simulator`.
    pub fn new(simulator: &'a StretchSimulator) -> Self {
        Self {
            simulator,
            flight: Step::new(simulator.modes(), &simulator.device.rates),
            held: Step::new(simulator.device.held_modes.len(), &simulator.device.rates),
            level: 0,
            recorded: None,
            replayed: None,
        }
    }

    /// Records the lengths of the steps from now on.
    pub fn record_steps(&mut self) {
        self.recorded = Some(StepSequence::default());
    }

    /// The lengths of the steps since [`Self::record_steps`]; ends the recording.
    pub fn recorded_steps(&mut self) -> StepSequence {
        self.recorded.take().unwrap_or_default()
    }

    /// Propagates the next stretches in steps as long as those of `steps`, as far as they go and do
    /// not err by far more than allowed.
    pub fn replay_steps(&mut self, steps: &'a StepSequence) {
        self.replayed = Some((steps, 0));
    }

    /// The simulator.
    pub fn simulator(&self) -> &'a StretchSimulator {
        self.simulator
    }

    /// Propagates `state` from `from` to `to` \[s\], in flight (`held` is `None`) or with the
    /// mass held at a level \[m\]. At each of the increasing `times` within, `out` gets the
    /// number of the time, and the readings of `xp` and `xc` without the sensor's offsets
    /// \[m\].
    ///
    /// The drive is a list of segments in order of time; the first and last reach on.
    ///
    /// # Errors
    /// [`SimError`] if the motion diverges or no step is small enough.
    #[allow(clippy::too_many_arguments)]
    pub fn propagate(
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
        let max_steps = MAX_STEPS + STEPS_PER_READING * times.len() as u64;
        let mut recorded = self.restart();
        let (on_ground, mut held) = (held.is_some(), held);
        let clock = SampleClock::new(device, times);
        while t < to {
            let mut segment = segment_at(drive, t);
            if device.has_effects() {
                segment = device.piece(segment, t, &state.z);
            }
            let has_friction = device.has_friction() && !on_ground;
            if has_friction {
                self.apply_friction(&segment, t, &mut held, state);
            }
            let end = to.min(if segment.end > t { segment.end } else { to });
            let h = match self.step_as(&mut recorded, &segment, held, t, state) {
                Some(h) => h,
                None => self.step(&segment, held, t, end, state, (&mut steps, max_steps))?,
            };
            let mut share = ((end - t) / h).min(1.0);
            let mut reached = if share < 1.0 { end } else { t + h };
            let (mut turned, mut smooth) = (false, None);
            if has_friction
                && let Some(s) = self.friction_event(&segment, held, t, share, &mut smooth)
            {
                (share, reached, turned) = (s, t + s * h, true);
            }
            let step = if held.is_some() {
                &self.held
            } else {
                &self.flight
            };
            if times.get(next).is_some_and(|&s| s <= reached) {
                let sampled = SampledStep {
                    device,
                    step,
                    clock: &clock,
                    held,
                    start: t,
                    h,
                };
                next = sampled.read(smooth, reached, times, next, &mut out);
            }
            end_state(step, share, state);
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

    /// Starts afresh, so that the answer of a stretch does not depend on the one before.
    /// Returns the lengths of the steps that it is to take, as far as they were recorded.
    fn restart(&mut self) -> &'a [usize] {
        self.level = 0;
        self.flight.sliding = 0.0;
        self.flight.forget();
        self.held.forget();
        if let Some(sequence) = &mut self.recorded {
            sequence.0.push(Vec::new());
        }
        let Some((sequence, stretch)) = &mut self.replayed else {
            return &[];
        };
        let levels = sequence.0.get(*stretch).map_or(&[][..], Vec::as_slice);
        *stretch += 1;
        levels
    }

    /// Fraction of the step just taken, up to `share`, at which friction brings the mass to a
    /// stop, or no longer holds it. `smooth` gets the mass's motion if that was needed.
    fn friction_event(
        &self,
        segment: &Segment,
        held: Option<f64>,
        t: f64,
        share: f64,
        smooth: &mut Option<Dense>,
    ) -> Option<f64> {
        let device = &self.simulator.device;
        match held {
            None => self.flight.first_stop(
                smooth.insert(self.flight.smooth(&device.phi_p)),
                &device.phi_p,
                share,
            ),
            Some(x) if self.held.stays_below(device, device.friction(x)) => None,
            Some(x) => {
                let pull = |s: f64| self.held.held_pull(device, segment, t, s, x);
                let friction = device.friction(x);
                first_below(|s| friction - pull(s).abs(), share, 0.0)
            }
        }
    }

    /// Friction away from the ground: a mass that does not slide yet sets out as it moves
    /// or as it is pulled, or is held at `held` until it is pulled hard enough.
    fn apply_friction(
        &mut self,
        segment: &Segment,
        t: f64,
        held: &mut Option<f64>,
        state: &mut StretchState,
    ) {
        let sim = self.simulator;
        let device = &sim.device;
        if let Some(level) = *held {
            let pull = sim.pull_off(&[*segment], t, level, state);
            // What was freed at a root of the force is on the edge, and pulled outward.
            if pull.abs() < device.friction(level) * (1.0 - 1e-12) {
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
            if pull.abs() > device.friction(points.xp) {
                sim.lift(points.xp, state);
                self.flight.sliding = pull.signum();
            } else {
                *held = Some(points.xp);
            }
        }
    }

    /// One step into the scratch as long as the next one of those `recorded`; returns
    /// its length, or `None` if there is none or it will not do, and then forgets the rest.
    fn step_as(
        &mut self,
        recorded: &mut &[usize],
        segment: &Segment,
        held: Option<f64>,
        t: f64,
        state: &StretchState,
    ) -> Option<f64> {
        let (&level, remaining) = recorded.split_first()?;
        *recorded = remaining;
        let taken = self.step_at(level, segment, held, t, state);
        if taken.is_none_or(|(_, excess)| excess.is_nan() || excess > MAX_REPLAYED_ERROR) {
            *recorded = &[];
            return None;
        }
        taken.map(|(length, _)| length)
    }

    /// One step of a level into the scratch; returns its length and its error over what is
    /// allowed, or `None` if it cannot be taken.
    fn step_at(
        &mut self,
        level: usize,
        segment: &Segment,
        held: Option<f64>,
        t: f64,
        state: &StretchState,
    ) -> Option<(f64, f64)> {
        let sim = self.simulator;
        let (device, tolerance) = (&sim.device, sim.tolerance);
        let from = (&state.q[..], &state.v[..], &state.z[..]);
        let (taken, step, length) = match held {
            Some(ground) => (
                self.held.held_step(
                    device, &sim.held, level, segment, t, from, ground, tolerance,
                ),
                &self.held,
                sim.held.length(level),
            ),
            None => (
                self.flight
                    .flight_step(device, &sim.flight, level, segment, t, from, tolerance),
                &self.flight,
                sim.flight.length(level),
            ),
        };
        let allowed = tolerance + 16.0 * f64::EPSILON * step.xp[0].abs();
        taken.is_ok().then_some((length, step.error / allowed))
    }

    /// One step into the scratch; returns its length.
    fn step(
        &mut self,
        segment: &Segment,
        held: Option<f64>,
        t: f64,
        end: f64,
        state: &StretchState,
        (steps, max_steps): (&mut u64, u64),
    ) -> Result<f64, SimError> {
        let sim = self.simulator;
        let tables = if held.is_some() {
            &sim.held
        } else {
            &sim.flight
        };
        let mut level = self.level.max(tables.covering(end - t));
        if held.is_some() {
            level = level.max(sim.coarsest);
        }
        let mut rejected = false;
        loop {
            *steps += 1;
            if *steps > max_steps {
                return Err(SimError::too_much(t, "steps", *steps, Burden::Film));
            }
            if let Some((length, excess)) = self.step_at(level, segment, held, t, state)
                && excess <= 1.0
            {
                let may_stop = || {
                    let share = ((end - t) / length).min(1.0);
                    self.flight.may_stop(&sim.device.phi_p, share)
                };
                if held.is_none() && level < sim.coarsest && may_stop() {
                    level = sim.coarsest;
                    continue;
                }
                if rejected {
                    self.level = level;
                } else if excess < 1.0 / 64.0 && level == self.level && level > 0 {
                    self.level -= 1;
                }
                if let Some(levels) = self
                    .recorded
                    .as_mut()
                    .and_then(|sequence| sequence.0.last_mut())
                {
                    levels.push(level);
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
