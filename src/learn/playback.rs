//! The moment of a run that is shown: it advances with the clock, and slowly at impacts.

use crate::sim::{EventKind, Trace};

/// Slow motion lasts this share of the span before an impact, and after it.
const SLOW_SHARE: f64 = 0.012;
/// How much slower the slow motion is.
const SLOW_FACTOR: f64 = 8.0;
/// Impacts that follow another one within this many slow stretches are one event: chatter would
/// never end.
const CHATTER_STRETCHES: f64 = 2.0;
/// Longest time between two pictures that counts \[s\]: after a pause of the computer the run
/// goes on where it was.
const MAX_FRAME_TIME: f64 = 0.1;

/// The moment shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    /// Time in the run \[s\].
    pub time: f64,
    /// Whether it advances.
    pub is_playing: bool,
    /// Simulated seconds per second, away from impacts.
    pub speed: f64,
    /// Whether it is slower at impacts.
    pub slows_at_impacts: bool,
    /// Whether it begins again at the end.
    pub loops: bool,
}

impl Playback {
    /// At the beginning, still.
    pub fn new(speed: f64) -> Self {
        Self {
            time: 0.0,
            is_playing: false,
            speed,
            slows_at_impacts: false,
            loops: false,
        }
    }

    /// At the beginning, running.
    pub fn start(&mut self) {
        self.time = 0.0;
        self.is_playing = true;
    }

    /// Runs, or stands still; from the beginning if it has come to the end of `duration` \[s\].
    pub fn toggle(&mut self, duration: f64) {
        self.is_playing = !self.is_playing;
        if self.is_playing && self.time >= duration {
            self.time = 0.0;
        }
    }

    /// Advances by a frame of `wall` \[s\] over a run of `duration` \[s\]. Returns whether the end was
    /// reached in this frame.
    pub fn advance(&mut self, wall: f64, duration: f64, slow: &SlowMoments) -> bool {
        if !self.is_playing {
            return false;
        }
        let mut factor = 1.0;
        if self.slows_at_impacts {
            factor -= (1.0 - 1.0 / SLOW_FACTOR) * slow.nearness(self.time);
        }
        self.time += wall.clamp(0.0, MAX_FRAME_TIME) * self.speed * factor;
        if self.time < duration {
            return false;
        }
        self.time = if self.loops { 0.0 } else { duration };
        self.is_playing = self.loops;
        true
    }

    /// If it runs, it is at the end of `duration` \[s\] at once.
    pub fn skip(&mut self, duration: f64) {
        if self.is_playing {
            self.time = duration;
        }
    }

    /// Goes by `by` \[s\], held within a run of `duration` \[s\].
    pub fn step(&mut self, by: f64, duration: f64) {
        self.is_playing = false;
        self.time = (self.time + by).clamp(0.0, duration);
    }
}

/// The moments of a run at which it is shown slowly.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SlowMoments {
    times: Vec<f64>,
    reach: f64,
}

impl SlowMoments {
    /// The impacts and releases of a run of `duration` \[s\], without chatter.
    pub fn of(trace: &Trace, duration: f64) -> Self {
        let reach = SLOW_SHARE * duration;
        let mut times: Vec<f64> = Vec::new();
        for event in trace
            .events
            .iter()
            .filter(|e| e.kind != EventKind::DriveStep)
        {
            let is_new = times
                .last()
                .is_none_or(|last| event.time - last > CHATTER_STRETCHES * reach);
            if is_new {
                times.push(event.time);
            }
        }
        Self { times, reach }
    }

    /// How near `t` \[s\] is to one of them: 1 at it, 0 away from it.
    pub fn nearness(&self, t: f64) -> f64 {
        let after = self.times.partition_point(|time| *time < t);
        let around = [after.checked_sub(1), Some(after)];
        let nearest = around
            .into_iter()
            .flatten()
            .filter_map(|i| self.times.get(i))
            .map(|time| (time - t).abs())
            .fold(f64::INFINITY, f64::min);
        if self.reach <= 0.0 || nearest >= self.reach {
            return 0.0;
        }
        // Smooth at both ends.
        let share = 1.0 - nearest / self.reach;
        share * share * (3.0 - 2.0 * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::Event;

    fn trace(times: &[f64]) -> Trace {
        let event = |time: &f64| Event {
            time: *time,
            kind: EventKind::Impact,
            velocity_before: -1.0,
            velocity_after: 0.5,
            pull_off_force: 0.0,
            contact_duration: 0.0,
        };
        Trace {
            events: times.iter().map(event).collect(),
            ..Trace::default()
        }
    }

    #[test]
    fn it_slows_down_at_an_impact_and_comes_to_the_end() {
        let slow = SlowMoments::of(&trace(&[0.5]), 1.0);
        assert_eq!(slow.nearness(0.5), 1.0);
        assert_eq!(slow.nearness(0.6), 0.0);
        let mut play = Playback::new(1.0);
        assert!(!play.advance(0.01, 1.0, &slow), "it stands still");
        assert_eq!(play.time, 0.0);
        play.start();
        play.time = 0.5;
        play.slows_at_impacts = true;
        play.advance(0.01, 1.0, &slow);
        assert!((play.time - 0.5 - 0.01 / SLOW_FACTOR).abs() < 1e-12);
        play.time = 0.995;
        assert!(play.advance(0.01, 1.0, &slow));
        assert_eq!((play.time, play.is_playing), (1.0, false));
        play.skip(1.0);
        assert_eq!(play.time, 1.0, "it stands still");
        play.toggle(1.0);
        assert_eq!((play.time, play.is_playing), (0.0, true));
        play.skip(1.0);
        assert!(play.advance(0.01, 1.0, &slow));
    }

    #[test]
    fn chatter_is_one_slow_moment() {
        let close: Vec<f64> = (0..1000).map(|i| 0.5 + 1e-6 * f64::from(i)).collect();
        assert_eq!(SlowMoments::of(&trace(&close), 1.0).times, [0.5]);
    }
}
