//! What is taken from a step of a stretch: the readings on the way, and the state at its end.

use super::StretchState;
use super::sample_clock::SampleClock;
use crate::model::MAX_MODES;
use crate::model::sensor::Point;
use crate::sim::device::Device;
use crate::sim::nodes::{Dense, S};
use crate::sim::output::FastModes;
use crate::sim::step::Step;

/// The state at fraction `share` of a step.
pub(super) fn end_state(step: &Step, share: f64, state: &mut StretchState) {
    if share >= 1.0 {
        state.q.copy_from_slice(step.q_at(S - 1));
        state.v.copy_from_slice(step.v_at(S - 1));
        state.z.copy_from_slice(step.z_at(S - 1));
    } else {
        step.modal_at(share, &mut state.q, &mut state.v);
        state.z.copy_from_slice(step.states_at(share).as_slice());
    }
}

/// A step of length `h` from `start` \[s\] that is read on the way.
pub(super) struct SampledStep<'a> {
    pub device: &'a Device,
    pub step: &'a Step,
    pub clock: &'a SampleClock,
    /// Level at which the mass is held \[m\]; `None` in flight.
    pub held: Option<f64>,
    pub start: f64,
    pub h: f64,
}

impl SampledStep<'_> {
    /// Gives `out` the readings at `times[next..]` up to `reached` \[s\]; returns the number of
    /// the first time beyond. `smooth` is the proof mass's motion, if it is at hand.
    pub fn read(
        &self,
        smooth: Option<Dense>,
        reached: f64,
        times: &[f64],
        mut next: usize,
        out: &mut impl FnMut(usize, f64, f64),
    ) -> usize {
        let Self {
            device, step, h, ..
        } = *self;
        let none = [0.0; MAX_MODES];
        let (phi_p, phi_c, level_p, level_c) = match self.held {
            None => (&device.phi_p[..], &device.phi_c[..], 0.0, 0.0),
            Some(level) => (
                &none[..device.held_modes.len()],
                &device.held.cantilever[..],
                level,
                level * device.anchor_c,
            ),
        };
        let p = smooth.unwrap_or_else(|| step.smooth(phi_p));
        let c = step.smooth(phi_c);
        let courses = step.courses(device);
        let mut fast = FastModes::new(&step.swings, self.clock.motions(self.held.is_some()));
        let mut before = self.start;
        while let Some(&at) = times.get(next).filter(|&&s| s <= reached) {
            let s = ((at - self.start) / h).max(0.0);
            let (mut xp, mut xc) = (level_p + p.value(s), level_c + c.value(s));
            if !self.clock.is_one(at - before) {
                fast.restart();
            }
            fast.advance(s * h);
            before = at;
            for ((x, _), (p, c)) in fast.now().iter().zip(phi_p.iter().zip(phi_c)) {
                xp += p * x;
                xc += c * x;
            }
            if device.alters_readings {
                let z = step.states_with_readings(&courses, s, fast.now());
                xp = device.apparent(xp, Point::ProofMass, at, z.as_slice());
                xc = device.apparent(xc, Point::Cantilever, at, z.as_slice());
            }
            out(next, xp, xc);
            next += 1;
        }
        next
    }
}
