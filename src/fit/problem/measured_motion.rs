//! The measured motion at any time. Effects with memory get their states from it, so that no
//! simulation over the whole recording is needed.

use std::cell::{Cell, RefCell};
use std::sync::OnceLock;

use crate::fit::residual::residual_rows::Nuisances;
use crate::fit::thresholds::VELOCITY_JUMP_FACTOR;
use crate::recording::{Channel, Recording};
use crate::sim::Points;

/// Samples on either side by which a velocity is read.
const VELOCITY_HALF_WINDOW: usize = 2;
/// Samples on either side of a jump that show it.
const JUMP_HALF_WINDOW: usize = 3;

/// The motion in a recording.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// How it was read.
    pub nuisances: Nuisances,
    /// Noise of the proof mass \[m\].
    pub noise: f64,
}

/// The measured motion at the times at which it was first evaluated. Devices that differ by little
/// ask for the same times.
#[derive(Debug, Default)]
pub struct MotionCache(OnceLock<Vec<(f64, Points)>>);

/// A motion that is evaluated in order of time, with cached values where there are some.
#[derive(Debug)]
pub struct Reading<'a> {
    motion: &'a Motion<'a>,
    seen: Option<&'a [(f64, Points)]>,
    next: Cell<usize>,
    own: RefCell<Vec<(f64, Points)>>,
}

impl MotionCache {
    /// A motion that is read from the beginning.
    pub fn reading<'a>(&'a self, motion: &'a Motion<'a>) -> Reading<'a> {
        Reading {
            motion,
            seen: self.0.get().map(Vec::as_slice),
            next: Cell::new(0),
            own: RefCell::default(),
        }
    }

    /// Keeps what a first one has read.
    pub fn keep(&self, reading: Reading<'_>) {
        if reading.seen.is_none() {
            self.0.get_or_init(|| reading.own.into_inner());
        }
    }
}

impl Reading<'_> {
    /// See [`Motion::at`]; seldom before what was asked for last.
    pub fn at(&self, t: f64) -> Points {
        let Some(seen) = self.seen else {
            let points = self.motion.at(t);
            self.own.borrow_mut().push((t, points));
            return points;
        };
        let mut next = self.next.get();
        next += seen[next..].iter().take_while(|(at, _)| *at < t).count();
        self.next.set(next);
        match seen.get(next) {
            Some((at, points)) if at.to_bits() == t.to_bits() => *points,
            _ => self.motion.at(t),
        }
    }
}

impl Motion<'_> {
    /// Displacements and velocities at `t` \[s\], by the clock of the readings; 0 where unknown.
    pub fn at(&self, t: f64) -> Points {
        let nuisances = &self.nuisances;
        let (xp, vp) = self
            .around_impact(t)
            .unwrap_or_else(|| self.smooth(Channel::ProofMass, t));
        let (xc, vc) = self.smooth(Channel::Cantilever, t);
        Points {
            xp: (xp - nuisances.offset_p) / nuisances.scale_p,
            vp: vp / nuisances.scale_p,
            xc: (xc - nuisances.offset_c) / nuisances.scale_c,
            vc: vc / nuisances.scale_c,
        }
    }

    /// Reading and slope over samples on both sides: less noise, and little delay.
    fn smooth(&self, channel: Channel, t: f64) -> (f64, f64) {
        let at = |t| self.recording.value_at(channel, t);
        let away = VELOCITY_HALF_WINDOW as f64 * self.recording.interval();
        let slope = || Some((at(t + away)? - at(t - away)?) / (2.0 * away));
        (at(t).unwrap_or(0.0), slope().unwrap_or(0.0))
    }

    /// Reading and slope of the proof mass from the side of an impact on which `t` lies, if an
    /// impact is so close that the slope over both sides would have no meaning.
    fn around_impact(&self, t: f64) -> Option<(f64, f64)> {
        let r = self.recording;
        let i = r.sample_before(t)?;
        let first = i.checked_sub(VELOCITY_HALF_WINDOW + JUMP_HALF_WINDOW - 1)?;
        let x = r
            .proof_mass
            .get(first..=i + VELOCITY_HALF_WINDOW + JUMP_HALF_WINDOW)?;
        let h = r.interval();
        let even = r.time[i + VELOCITY_HALF_WINDOW + JUMP_HALF_WINDOW] - r.time[first];
        if (even / h - (x.len() - 1) as f64).abs() > 0.5 {
            return None;
        }
        let slope = |k: usize| (x[k + 1] - x[k]) / h;
        let jump = |j: usize| slope(j + 1) - slope(j - 1);
        let struck = |j: &usize| {
            let usual = |k: usize| (slope(k + 1) - slope(k)).abs();
            let usual = usual(j - 2).max(usual(j + 1)) + 2.0 * self.noise / h;
            slope(j - 1) < 0.0 && jump(*j) > VELOCITY_JUMP_FACTOR * usual
        };
        // Sample `j` is the last one before it.
        let blows = (JUMP_HALF_WINDOW - 1..x.len() - JUMP_HALF_WINDOW).filter(struck);
        let j = blows.max_by(|a, b| jump(*a).total_cmp(&jump(*b)))?;
        let bend = |k: usize| (slope(k + 1) - slope(k)) / h;
        let (before, after) = (bend(j - 2), bend(j + 1));
        let (down, up) = (
            slope(j - 1) + 0.5 * h * before,
            slope(j + 1) - 0.5 * h * after,
        );
        let when = ((x[j + 1] - x[j] - up * h) / (down - up)).clamp(0.0, h);
        let since = t - r.time[first + j];
        Some(if since < when {
            let x = x[j] + since * (down + 0.5 * since * before);
            (x, down + since * before)
        } else {
            let since = since - h;
            (
                x[j + 1] + since * (up + 0.5 * since * after),
                up + since * after,
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::measured_motion::*;

    /// A fall from rest by `g`, thrown back at half its speed at 1.0037 ms.
    fn bounce(t: f64) -> (f64, f64) {
        const HIT: f64 = 1.0037e-3;
        const G: f64 = 300.0;
        let s = t - HIT;
        let speed = G * HIT;
        if s < 0.0 {
            (-speed * s - 0.5 * G * s * s, -speed - G * s)
        } else {
            (0.5 * speed * s - 0.5 * G * s * s, 0.5 * speed - G * s)
        }
    }

    #[test]
    fn a_velocity_is_read_from_its_own_side_of_an_impact() {
        let time: Vec<f64> = (0..100).map(|i| 2e-5 * f64::from(i)).collect();
        let nuisances = Nuisances {
            offset_p: 3e-6,
            scale_p: 1.01,
            ..Nuisances::default()
        };
        let read = |t: &f64| nuisances.offset_p + nuisances.scale_p * bounce(*t).0;
        let xp: Vec<f64> = time.iter().map(read).collect();
        let recording = Recording::new("blow", time, None, xp, None).unwrap();
        let motion = Motion {
            recording: &recording,
            nuisances,
            noise: 1e-9,
        };
        for k in 0..400 {
            let t = 8e-4 + 1e-6 * f64::from(k) + 3e-7;
            let (at, truth) = (motion.at(t), bounce(t));
            assert!((at.xp - truth.0).abs() < 2e-8, "{t}: {at:?} {truth:?}");
            assert!((at.vp - truth.1).abs() < 1e-6, "{t}: {at:?} {truth:?}");
        }
        // Unknown motion counts as rest.
        assert_eq!(motion.at(-1.0).vp, 0.0);
        assert_eq!(motion.at(5e-4).vc, 0.0);
    }

    #[test]
    fn a_cached_motion_is_the_same() {
        let time: Vec<f64> = (0..100).map(|i| 2e-5 * f64::from(i)).collect();
        let xp: Vec<f64> = time.iter().map(|t| bounce(*t).0).collect();
        let recording = Recording::new("blow", time, None, xp, None).unwrap();
        let motion = Motion {
            recording: &recording,
            nuisances: Nuisances::default(),
            noise: 1e-9,
        };
        let seen = MotionCache::default();
        let first = seen.reading(&motion);
        let times: Vec<f64> = (0..80).map(|k| 8e-4 + 5e-6 * f64::from(k)).collect();
        for t in &times {
            assert_eq!(first.at(*t), motion.at(*t));
        }
        seen.keep(first);
        // The same times, others between them, before and after, and some missing.
        let mut others: Vec<f64> = times.iter().step_by(3).copied().collect();
        others.extend(times.iter().map(|t| t + 1e-6));
        others.extend([2e-4, 1.7e-3]);
        others.sort_by(f64::total_cmp);
        let again = seen.reading(&motion);
        for t in others {
            assert_eq!(again.at(t), motion.at(t), "{t}");
        }
        assert!(again.own.borrow().is_empty(), "it kept what it need not");
    }
}
