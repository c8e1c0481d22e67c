//! A slew rate limiter: its output follows the voltage, but no faster than one volt per `pace`
//! seconds. The output is exact over each piece of the drive. While it is more than `slack`
//! behind, it is a straight line. Once it is nearer, it is the voltage itself if there is no
//! slack; otherwise the owner integrates what happens within the slack.

use super::bisection::bisect;
use super::drive::{Segment, Shape};

/// Numbers that the limiter remembers: where it was \[V\] when the piece began, and when \[s\].
pub const MEMORY: usize = 2;

/// Voltages that differ by less than this share of them are equal.
const EQUAL_VOLTAGE_SHARE: f64 = 1e-12;
/// The same as a share of the slack: where the owner integrates, it comes to the end of its
/// slack no more exactly.
const SLACK_TOLERANCE: f64 = 1e-6;
/// Parts of a piece by which the instants are bracketed at which the output begins to lag
/// behind or has caught up.
const BRACKETING_PARTS: usize = 256;
/// Longest piece that is searched \[s\].
const MAX_PIECE: f64 = 1.0;

/// A follower.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlewRateLimiter {
    /// Time that it takes for a volt \[s/V\], above 0.
    pub pace: f64,
    /// How far behind the pace no longer binds it \[V\], 0 or more.
    pub slack: f64,
}

/// What a follower does over a piece of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// 1 or -1 while it goes up or down as fast as it can; 0 while it is free to follow.
    pub direction: f64,
    /// When that ends \[s\], or the piece does.
    pub end: f64,
}

impl SlewRateLimiter {
    /// Where the follower is \[V\] at full pace while the voltage is `voltage` at `t`, in the
    /// piece whose start `memory` tells. Without slack that is where it is.
    pub fn follow(&self, voltage: f64, t: f64, memory: &[f64]) -> f64 {
        match *memory {
            [level, since] => {
                let reach = (t - since).max(0.0) / self.pace;
                voltage.max(level - reach).min(level + reach)
            }
            _ => voltage,
        }
    }

    /// Where it is \[V\] and its rate of change \[V/s\] while the pace binds it; `None` once it
    /// is near the voltage, in the piece whose start `memory` tells.
    pub fn bound(&self, voltage: f64, t: f64, memory: &[f64]) -> Option<(f64, f64)> {
        let own = self.follow(voltage, t, memory);
        let behind = voltage - own;
        (behind.abs() >= (1.0 - SLACK_TOLERANCE) * self.slack)
            .then(|| (own, behind.signum() / self.pace))
    }

    /// Brings the memory up to date at the end of a piece, where the follower is at `level`.
    pub fn remember(&self, level: f64, t: f64, memory: &mut [f64]) {
        memory.copy_from_slice(&[level, t]);
    }

    /// What the follower does from `t` on in `segment`.
    pub fn course(&self, segment: &Segment, t: f64, memory: &[f64]) -> Course {
        let shape = &segment.shape;
        let voltage = shape.voltage(t);
        let own = self.follow(voltage, t, memory);
        let behind = voltage - own;
        let until = segment.end.min(t + MAX_PIECE);
        let fastest = 1.0 / self.pace;
        let equal =
            (EQUAL_VOLTAGE_SHARE * voltage.abs().max(own.abs())).max(SLACK_TOLERANCE * self.slack);
        let lags = behind.abs() > self.slack + equal;
        let slope = shape.slope(t);
        // At the end of its slack it is outrun by what goes away from it.
        let outrun = behind.abs() >= self.slack - equal
            && slope.abs() > fastest
            && (self.slack <= equal || slope * behind > 0.0);
        if lags || outrun {
            let direction = if lags { behind } else { slope }.signum();
            if matches!(shape, Shape::Constant { .. }) {
                let end = segment.end.min(t + (behind.abs() - self.slack) * self.pace);
                return Course { direction, end };
            }
            let ahead = |s: f64| direction * (shape.voltage(s) - own) - (s - t) * fastest;
            let end = first(t, until, |s| ahead(s) <= self.slack - equal).unwrap_or(until);
            return Course { direction, end };
        }
        let mut end = segment.end;
        // What is slower never gets away.
        if slope.abs() <= fastest && shape.steepest(t, until) > fastest {
            end = first(t, until, |s| shape.slope(s).abs() > fastest).unwrap_or(until);
        }
        let direction = 0.0;
        Course { direction, end }
    }
}

/// First instant after `start` at which `holds` becomes true, to within a small share of the
/// time looked through; `None` if it does not by `end`.
fn first(start: f64, end: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    let at = |k: usize| start + (end - start) * k as f64 / BRACKETING_PARTS as f64;
    let k = (1..=BRACKETING_PARTS).find(|&k| holds(at(k)))?;
    Some(bisect(at(k - 1), at(k), holds))
}

#[cfg(test)]
mod tests {
    use super::super::drive::Waveform;
    use super::super::slew_rate_limiter::*;

    /// The follower of a waveform at `times`, piece by piece.
    fn followed(slew: &SlewRateLimiter, waveform: &Waveform, times: &[f64]) -> Vec<f64> {
        let (mut t, mut memory) = (0.0, [0.0; MEMORY]);
        let mut next = times.iter().peekable();
        let mut out = Vec::new();
        while next.peek().is_some() {
            let segment = waveform.segment(waveform.index_at(t));
            let course = slew.course(&segment, t, &memory);
            assert!(course.end > t, "{course:?} at {t}");
            while let Some(&at) = next.next_if(|&&at| at < course.end) {
                out.push(slew.follow(segment.shape.voltage(at), at, &memory));
            }
            let level = slew.follow(segment.shape.voltage(course.end), course.end, &memory);
            slew.remember(level, course.end, &mut memory);
            t = course.end;
        }
        out
    }

    /// The same by small steps, each no longer than the pace lets it be.
    fn stepped(slew: &SlewRateLimiter, waveform: &Waveform, times: &[f64]) -> Vec<f64> {
        const STEP: f64 = 1e-7;
        let (mut steps, mut u) = (0u32, 0.0f64);
        let mut out = Vec::new();
        for &at in times {
            while STEP * f64::from(steps) < at - 0.5 * STEP {
                let middle = STEP * (f64::from(steps) + 0.5);
                let most = STEP / slew.pace;
                u += (waveform.voltage(middle) - u).clamp(-most, most);
                steps += 1;
            }
            out.push(u);
        }
        out
    }

    #[test]
    fn the_output_is_no_faster_than_the_pace() {
        // A square wave that it never reaches, one that it does, a sine faster than it in
        // places, a chirp and a triangle.
        for (text, pace) in [
            ("square:250Hz:8V", 2e-4),
            ("square:50Hz:7V", 4e-5),
            ("sine:50Hz:8V", 1.0 / 1500.0),
            ("sine:200Hz:6V", 1.0 / 200.0),
            ("triangle:40Hz:5V", 2e-3),
            ("chirp:10Hz:300Hz:6V", 3e-4),
            ("square:50Hz:7V:duty=30%:offset=1V:phase=200deg", 4e-5),
            ("triangle:40Hz:5V:asymmetry=100%:burst=1/2", 1e-3),
            (
                "drawn:60Hz:smooth:0.1/-2,0.25/1,0.3/5,0.55/5.5,0.6/-1,0.9/-6",
                1e-3,
            ),
        ] {
            let waveform = Waveform::parse(text, 0.05).unwrap();
            let slew = SlewRateLimiter { pace, slack: 0.0 };
            let times: Vec<f64> = (1..1000).map(|i| 5e-5 * f64::from(i)).collect();
            let pieces = followed(&slew, &waveform, &times);
            let steps = stepped(&slew, &waveform, &times);
            let mut lags = 0;
            for ((t, a), b) in times.iter().zip(&pieces).zip(&steps) {
                // The comparison is off by a step of its own.
                assert!((a - b).abs() < 2.5e-7 / pace, "{text} at {t}: {a} {b}");
                lags += usize::from((a - waveform.voltage(*t)).abs() > 0.01);
            }
            assert!(lags > 30, "{text}: {lags}");
        }
    }

    #[test]
    fn a_slow_voltage_is_followed_exactly() {
        let waveform = Waveform::parse("sine:15Hz:8V", 0.1).unwrap();
        let times: Vec<f64> = (0..900).map(|i| 1e-4 * f64::from(i)).collect();
        let slew = SlewRateLimiter {
            pace: 5e-5,
            slack: 0.0,
        };
        let own = followed(&slew, &waveform, &times);
        for (t, v) in times.iter().zip(own) {
            assert!((v - waveform.voltage(*t)).abs() < 1e-12, "{t}");
        }
    }
}
