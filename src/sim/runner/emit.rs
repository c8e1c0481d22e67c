//! Samples of the steps, in flight and in held phases.

use super::Runner;
use crate::sim::device::dot;
use crate::sim::output::{FastModes, Sample, Sink};
use crate::sim::trace::Trace;

impl Runner {
    /// Voltage at the time of a sample that shows the device at `t`. The two times differ by the
    /// delay of the readings.
    #[inline]
    pub(super) fn voltage_when_taken(&self, t: f64) -> f64 {
        if self.delay > 0.0 {
            self.drive.voltage(t + self.delay)
        } else {
            self.segment.shape.voltage(t)
        }
    }

    /// Samples of a flight step up to fraction `s`.
    pub(super) fn emit_flight(&mut self, h: f64, s: f64, trace: &mut Trace) {
        let delay = self.delay;
        let mut sink = Sink::new(&self.options, self.t, h, s, self.samples, delay);
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
                // A late sample would show the device before the start: it shows the start.
                fast.restart();
            }
            let states = device.has_effects().then(|| self.flight.states_at(s));
            // The state at the start of a step is exact: a run begins at its initial state.
            let (xp, vp) = match s {
                0.0 => (dot(&device.phi_p, &self.q), dot(&device.phi_p, &self.v)),
                _ => fast.add(p.value_and_slope(s, h), &device.phi_p),
            };
            let (xc, vc) = match s {
                _ if !device.has_cantilever => (0.0, 0.0),
                0.0 => (dot(&device.phi_c, &self.q), dot(&device.phi_c, &self.v)),
                _ => fast.add(c.value_and_slope(s, h), &device.phi_c),
            };
            let sample = Sample {
                t,
                xp,
                vp,
                xc,
                vc,
                pull: None,
                friction: -device.friction(xp) * self.sliding,
                reaction: self.reaction(xp, vp, t),
                voltage: self.voltage_when_taken(t),
                z: states.as_ref().map_or(&[], |states| states.as_slice()),
            };
            sample.push(device, &self.segment, trace);
        }
        self.samples = sink.rest();
    }

    /// Samples of a held step up to fraction `s`. The mass is on the ground since `since` \[s\], or
    /// held by friction.
    pub(super) fn emit_held(
        &mut self,
        h: f64,
        s: f64,
        since: Option<f64>,
        level: f64,
        trace: &mut Trace,
    ) {
        let delay = self.delay;
        let mut sink = Sink::new(&self.options, self.t, h, s, self.samples, delay);
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
        self.samples = sink.rest();
    }
}
