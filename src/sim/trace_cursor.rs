//! Readings of a run between its samples.
//!
//! Between two samples the motion is a cubic by values and velocities, but not where the mass hits
//! the ground between them: its velocity jumps there. On either side of an event the motion
//! continues from its own sample, with the event's own velocity at the other end.

use super::trace::{Event, EventKind, Trace};

/// Readings at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Proof mass \[m\].
    pub xp: f64,
    /// Its velocity [m/s].
    pub vp: f64,
    /// Cantilever \[m\]; NaN for a device without that point, or between samples around an impact.
    pub xc: f64,
    /// Its velocity [m/s].
    pub vc: f64,
}

/// Reads a trace at times that increase; other times are slower.
#[derive(Debug, Clone)]
pub struct TraceCursor<'a> {
    trace: &'a Trace,
    /// Events with a jump of velocity, in order of time.
    jumps: Vec<&'a Event>,
    next: usize,
}

impl<'a> TraceCursor<'a> {
    /// At the start of `trace`.
    #[must_use]
    pub fn new(trace: &'a Trace) -> Self {
        let jumps =
            |e: &&Event| e.kind != EventKind::DriveStep && e.velocity_before != e.velocity_after;
        Self {
            trace,
            jumps: trace.events.iter().filter(jumps).collect(),
            next: 0,
        }
    }

    /// The readings at `t` \[s\]; `None` outside the trace.
    pub fn at(&mut self, t: f64) -> Option<Reading> {
        let trace = self.trace;
        let position = (t - trace.t0) / trace.dt;
        let last = trace.proof_mass.len().checked_sub(1)?;
        // t0 + n dt is rarely exact in binary.
        if position.is_nan() || position < -1e-6 || position > last as f64 + 1e-6 {
            return None;
        }
        let position = position.clamp(0.0, last as f64);
        let i = position.floor() as usize;
        let w = position - i as f64;
        if w < 1e-6 || i == last {
            return Some(self.sample(i));
        }
        if w > 1.0 - 1e-6 {
            return Some(self.sample(i + 1));
        }
        let start = trace.t0 + i as f64 * trace.dt;
        if self.next > 0 && self.jumps[self.next - 1].time >= start {
            self.next = 0;
        }
        while self.jumps.get(self.next).is_some_and(|e| e.time < start) {
            self.next += 1;
        }
        let jumped = self
            .jumps
            .get(self.next)
            .filter(|e| e.time < start + trace.dt);
        let (a, b) = (self.sample(i), self.sample(i + 1));
        let Some(first) = jumped else {
            let (xp, vp) = cubic((a.xp, a.vp), (b.xp, b.vp), trace.dt, w);
            let (xc, vc) = cubic((a.xc, a.vc), (b.xc, b.vc), trace.dt, w);
            return Some(Reading { xp, vp, xc, vc });
        };
        // Several events between two samples: the last one counts for what follows.
        let later = self.jumps[self.next..]
            .iter()
            .take_while(|e| e.time < start + trace.dt)
            .last()
            .unwrap_or(first);
        let (xp, vp) = if t <= first.time {
            let (span, s) = (first.time - start, t - start);
            towards((a.xp, a.vp), first.velocity_before, span, s)
        } else {
            let (span, s) = (start + trace.dt - later.time, start + trace.dt - t);
            let (x, v) = towards((b.xp, -b.vp), -later.velocity_after, span, s);
            (x, -v)
        };
        Some(Reading {
            xp,
            vp,
            xc: f64::NAN,
            vc: f64::NAN,
        })
    }

    fn sample(&self, i: usize) -> Reading {
        let trace = self.trace;
        let at = |values: &[f64]| values.get(i).copied().unwrap_or(f64::NAN);
        Reading {
            xp: at(&trace.proof_mass),
            vp: at(&trace.proof_mass_velocity),
            xc: at(&trace.cantilever),
            vc: at(&trace.cantilever_velocity),
        }
    }
}

/// Value and slope at the share `w` of an interval of length `h`, from those at its ends.
fn cubic((a, da): (f64, f64), (b, db): (f64, f64), h: f64, w: f64) -> (f64, f64) {
    let (u, da, db) = (1.0 - w, da * h, db * h);
    let value = u * u * ((1.0 + 2.0 * w) * a + w * da) + w * w * ((1.0 + 2.0 * u) * b - u * db);
    let slope = 6.0 * w * u * (b - a) + u * (1.0 - 3.0 * w) * da + w * (3.0 * w - 2.0) * db;
    (value, slope / h)
}

/// Value and slope after `s` of `span`, over which the slope goes evenly from `v` to `end`.
fn towards((x, v): (f64, f64), end: f64, span: f64, s: f64) -> (f64, f64) {
    let rate = if span > 0.0 { (end - v) / span } else { 0.0 };
    (x + s * (v + 0.5 * rate * s), v + rate * s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::drive::Waveform;
    use crate::model::preset::Preset;
    use crate::sim::{Options, simulate};

    #[test]
    fn between_samples_it_reads_what_finer_sampling_shows() {
        let model = Preset::embedded("paper").unwrap().model;
        let drive = Waveform::parse("square:15Hz:8V", 0.2).unwrap();
        let run = |rate: f64| {
            let options = Options {
                rate,
                ..Options::default()
            };
            simulate(&model, &drive, 0.2, &options).unwrap()
        };
        let (coarse, fine) = (run(50e3), run(500e3));
        assert!(coarse.events.len() > 3);
        let mut cursor = TraceCursor::new(&coarse);
        let (mut worst, mut at) = (0.0f64, 0.0);
        for (i, x) in fine.proof_mass.iter().enumerate() {
            let t = i as f64 * fine.dt;
            let Some(reading) = cursor.at(t) else {
                continue;
            };
            let off = (reading.xp - x).abs();
            if off > worst {
                (worst, at) = (off, t);
            }
            assert!((reading.vp - fine.proof_mass_velocity[i]).abs() < 0.2);
        }
        // A ring of 6.4 kHz, h w = 0.8, leaves (h w)^4 / 384 of its amplitude of some 30 um.
        assert!(worst < 50e-9, "{worst:e} m at {at}");
        // Going back is allowed.
        let again = cursor.at(0.05).unwrap();
        assert!((again.xp - fine.proof_mass[25_000]).abs() < 50e-9);
        assert!(cursor.at(-1.0).is_none() && cursor.at(0.3).is_none());
    }
}
