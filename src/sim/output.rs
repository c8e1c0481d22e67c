//! Uniform samples cut out of the steps.

use super::device::Device;
use super::error::Options;
use super::linear::{Oscillator, Swing, apply};
use super::trace::Trace;
use crate::model::MAX_MODES;
use crate::model::drive::Segment;
use crate::model::effects::Kinematics;
use crate::model::sensor::Point;

/// Which samples of a run come next.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleRange {
    /// Number of the next sample.
    pub next: u64,
    /// Number of the first sample that nobody asks for. A step may be far longer than the run, and
    /// hold any number of samples.
    pub end: u64,
}

/// Sample times that fall into a part of a step.
pub(super) struct Sink {
    start: f64,
    h: f64,
    end: f64,
    rate: f64,
    delay: f64,
    samples: SampleRange,
}

impl Sink {
    /// Those of `samples`, taken `delay` \[s\] late, that lie before fraction `s` of the step of
    /// `h` at `t`.
    pub fn new(
        options: &Options,
        t: f64,
        h: f64,
        s: f64,
        samples: SampleRange,
        delay: f64,
    ) -> Self {
        Self {
            start: t,
            h,
            end: t + s * h,
            rate: options.rate,
            delay,
            samples,
        }
    }

    /// Whether no sample falls into the part.
    pub fn is_empty(&self) -> bool {
        self.upcoming().is_none()
    }

    /// Time that the next sample shows, if it falls into the part and is asked for.
    fn upcoming(&self) -> Option<f64> {
        let t = self.samples.next as f64 / self.rate - self.delay;
        (t < self.end && self.samples.next < self.samples.end).then_some(t)
    }

    /// Time that the next sample shows, and its fraction of the step.
    pub fn next(&mut self) -> Option<(f64, f64)> {
        self.upcoming().map(|t| {
            self.samples.next += 1;
            (t, ((t - self.start) / self.h).max(0.0))
        })
    }

    /// The samples not taken yet.
    pub fn rest(&self) -> SampleRange {
        self.samples
    }

    /// Notes in the trace that a contact lasts from `since` until `t` at least.
    pub fn open_contact(trace: &mut Trace, since: f64, t: f64) {
        match trace.contacts.last_mut() {
            Some(last) if last.0 == since => last.1 = t,
            _ => trace.contacts.push((since, t)),
        }
    }
}

/// Free motion of a step's fast modes at one sample after the other.
pub(super) struct FastModes<'a> {
    swings: &'a [Swing],
    interval: &'a [[f64; 4]],
    now: [(f64, f64); MAX_MODES],
    started: bool,
}

impl<'a> FastModes<'a> {
    /// Each mode's free motion over an `interval` \[s\] between samples.
    pub fn sampling(modes: &[Oscillator], interval: f64) -> Vec<[f64; 4]> {
        modes.iter().map(|o| o.free_motion(interval)).collect()
    }

    /// `interval`: each mode's free motion over a sample interval.
    pub fn new(swings: &'a [Swing], interval: &'a [[f64; 4]]) -> Self {
        Self {
            swings,
            interval,
            now: [(0.0, 0.0); MAX_MODES],
            started: false,
        }
    }

    /// On to the next sample; the first is `t` \[s\] after the step's start.
    #[inline]
    pub fn advance(&mut self, t: f64) {
        for (i, swing) in self.swings.iter().enumerate() {
            if swing.fast {
                self.now[i] = if self.started {
                    apply(&self.interval[i], self.now[i])
                } else {
                    swing.free(t)
                };
            }
        }
        self.started = true;
    }

    /// The next sample is again given by its time, not an interval after this one.
    pub fn restart(&mut self) {
        self.started = false;
    }

    /// Their displacements and velocities now; none for others.
    pub fn now(&self) -> &[(f64, f64)] {
        &self.now[..self.swings.len()]
    }

    /// Adds their motion at a point of the structure to a displacement and velocity.
    #[inline]
    pub fn add(&self, (mut x, mut v): (f64, f64), shape: &[f64]) -> (f64, f64) {
        for (i, swing) in self.swings.iter().enumerate() {
            if swing.fast {
                x += shape[i] * self.now[i].0;
                v += shape[i] * self.now[i].1;
            }
        }
        (x, v)
    }
}

/// The device at one sample.
pub(super) struct Sample<'a> {
    pub t: f64,
    pub xp: f64,
    pub vp: f64,
    pub xc: f64,
    pub vc: f64,
    /// Pull-off force and adhesion while held, if forces are recorded.
    pub pull: Option<(f64, f64)>,
    /// Friction on the mass \[N\].
    pub friction: f64,
    /// Force of a compliant ground on the mass, adhesion included \[N\].
    pub reaction: f64,
    /// Voltage when the sample is taken, which a late one does not show \[V\].
    pub voltage: f64,
    /// Extra states, if there are any.
    pub z: &'a [f64],
}

impl Sample<'_> {
    /// Appends the sample to the trace.
    #[inline]
    pub fn push(&self, device: &Device, segment: &Segment, trace: &mut Trace) {
        let read = |x, point| device.reading(x, point, self.t, self.z);
        trace.voltage.push(self.voltage);
        trace.proof_mass.push(read(self.xp, Point::ProofMass));
        trace.proof_mass_velocity.push(self.vp);
        if device.has_cantilever {
            trace.cantilever.push(read(self.xc, Point::Cantilever));
            trace.cantilever_velocity.push(self.vc);
        }
        let Some(forces) = &mut trace.forces else {
            return;
        };
        let mut at = Kinematics {
            t: self.t,
            xp: self.xp,
            vp: self.vp,
            xc: self.xc,
            vc: self.vc,
            voltage: segment.shape.voltage(self.t),
            gain: 0.0,
            film: match self.pull {
                Some(_) => 0.0,
                None => device.film_force(self.xp, self.vp),
            },
        };
        let z = self.z;
        forces
            .drive
            .push(device.drive_force(&mut at, segment.branch, z));
        forces
            .effects
            .push(device.effect_force(&at, z) + self.friction);
        forces.film.push(device.altered_film_force(&at, z));
        let (pull, adhesion) = self.pull.unwrap_or((0.0, 0.0));
        forces.pull_off.push(pull);
        forces.adhesion.push(adhesion);
        let ground = if self.pull.is_some() {
            -pull
        } else {
            self.reaction
        };
        forces.ground.push(ground);
    }
}
