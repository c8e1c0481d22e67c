//! The motion of a one-mode device, with dry friction followed from turn to turn.

use super::apparatus::{Apparatus, Run};
use super::law::OneModeLaw;
use crate::trial::hybrid::integrator::{MAX_STATE, State, Stepper};

/// Local error of positions over the largest swing.
const RELATIVE_TOLERANCE: f64 = 1e-11;
/// Longest step over the period, or over the run of a free mass: no gust is stepped over.
const LONGEST_STEP: f64 = 0.02;
/// Steps after which a run is given up.
const MAX_STEPS: u64 = 4_000_000;
/// Steps of a hold by friction within the interval between two samples.
const HOLDS_PER_SAMPLE: f64 = 4.0;

/// What dry friction does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Friction {
    /// Acts against a motion of this sign; zero without friction.
    Slides(f64),
    /// Holds.
    Holds,
}

/// A run on its way.
struct Follower<'a> {
    apparatus: &'a Apparatus,
    laws: &'a [&'a OneModeLaw],
    run: usize,
    rubs: bool,
}

impl Follower<'_> {
    /// Acceleration without dry friction \[m/s^2\].
    fn free(&self, t: f64, x: f64, v: f64) -> f64 {
        let device = &self.apparatus.device;
        let omega = self.apparatus.omega();
        let own = -omega * omega * x - 2.0 * device.zeta * omega * v - device.gravity;
        let laws = self.laws.iter();
        own + laws
            .map(|law| law.acceleration(self.run, t, x, v))
            .sum::<f64>()
    }

    /// Dry friction \[m/s^2\].
    fn friction(&self, x: f64) -> f64 {
        self.laws.iter().map(|law| law.friction(x)).sum()
    }

    /// What friction does to a mass that rests at this instant.
    fn at_rest(&self, t: f64, x: f64) -> Friction {
        let pull = self.free(t, x, 0.0);
        if pull.abs() <= self.friction(x) {
            Friction::Holds
        } else {
            Friction::Slides(pull.signum())
        }
    }

    fn begin(&self, run: &Run) -> Friction {
        if !self.rubs {
            Friction::Slides(0.0)
        } else if run.v == 0.0 {
            self.at_rest(0.0, run.x)
        } else {
            Friction::Slides(run.v.signum())
        }
    }
}

/// Displacement \[m\] of run number `run` at `times` (rising from zero); `None` if it cannot be
/// followed.
#[must_use]
pub fn motion(
    apparatus: &Apparatus,
    laws: &[&OneModeLaw],
    run: usize,
    times: &[f64],
) -> Option<Vec<f64>> {
    let start = apparatus.runs.get(run)?;
    let end = *times.last()?;
    let follower = Follower {
        apparatus,
        laws,
        run,
        rubs: laws.iter().any(|law| law.is_friction()),
    };
    let reach = apparatus.amplitude().max(1e-12);
    let mut tolerance = [1.0; MAX_STATE];
    tolerance[0] = RELATIVE_TOLERANCE * reach;
    tolerance[1] = tolerance[0] * apparatus.omega().max(1.0 / start.duration);
    let longest = LONGEST_STEP / apparatus.device.frequency.max(1.0 / start.duration);
    let mut friction = follower.begin(start);
    let mut y: State = [0.0; MAX_STATE];
    (y[0], y[1]) = (start.x, start.v);
    let (mut t, mut h) = (0.0, 1e-3 * longest);
    let mut out = Vec::with_capacity(times.len());
    let mut stepper = Stepper::new(2);
    let mut fresh = true;
    for _ in 0..MAX_STEPS {
        if t >= end || out.len() == times.len() {
            out.resize(times.len(), y[0]);
            return Some(out);
        }
        let Friction::Slides(direction) = friction else {
            // At rest until the pull exceeds the friction.
            t += 1.0 / (HOLDS_PER_SAMPLE * apparatus.reading.rate);
            while times.get(out.len()).is_some_and(|time| *time <= t) {
                out.push(y[0]);
            }
            friction = follower.at_rest(t, y[0]);
            fresh = true;
            continue;
        };
        let mut rhs = |t: f64, y: &State, rate: &mut State| {
            rate[0] = y[1];
            rate[1] = follower.free(t, y[0], y[1]) - follower.friction(y[0]) * direction;
        };
        if fresh {
            stepper.restart(t, &y, &mut rhs);
            fresh = false;
        }
        let step = h.min(end - t);
        let error = stepper.attempt(t, &y, step, &tolerance, &mut rhs);
        if !error.is_finite() || error > 1.0 {
            h = step * (0.9 * error.powf(-0.2)).clamp(0.1, 0.9);
            if !(h > 1e-12 * longest) {
                return None;
            }
            continue;
        }
        stepper.prepare(&y, step);
        let turns = direction != 0.0 && stepper.end[1] * direction < 0.0;
        let share = if turns {
            turn(&stepper, direction)
        } else {
            1.0
        };
        let to = t + share * step;
        while let Some(time) = times.get(out.len()).filter(|time| **time <= to) {
            out.push(stepper.at(((time - t) / step).clamp(0.0, 1.0))[0]);
        }
        t = to;
        if turns {
            y = stepper.at(share);
            y[1] = 0.0;
            friction = follower.at_rest(t, y[0]);
            fresh = true;
            h = 1e-3 * longest;
        } else {
            y = stepper.end;
            stepper.go_on();
            h = (step * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.3, 4.0)).min(longest);
        }
    }
    None
}

/// Share of the prepared step at which the velocity turns.
fn turn(stepper: &Stepper, direction: f64) -> f64 {
    let (mut a, mut b) = (0.0, 1.0);
    while b - a > 1e-12 {
        let middle = 0.5 * (a + b);
        if stepper.at(middle)[1] * direction < 0.0 {
            b = middle;
        } else {
            a = middle;
        }
    }
    b
}
