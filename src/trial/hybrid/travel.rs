//! Integration through one piece of the drive, step by step from event to event.

use super::integrator::{State, Stepper};
use super::{LONGEST_STEP, RunError, SHORTEST_STEP, Traveller};
use crate::trial::device::{Ground, Phase};
use crate::trial::voltage::Piece;

/// Events after which a run is given up.
const MAX_EVENTS: usize = 200_000;
/// Steps after which a run is given up.
const MAX_STEPS: u64 = 20_000_000;
/// First step after a discontinuity \[s\].
const FIRST_STEP: f64 = 1e-7;
/// Longest stretch that is noted as one \[s\].
const LONGEST_STRETCH: f64 = 3e-3;

impl Traveller<'_> {
    fn sample(&mut self, stepper: &Stepper, from: f64, h: f64, until: f64) {
        while let Some(time) = self.times.get(self.run.proof_mass.len()) {
            if *time > until {
                break;
            }
            let y = stepper.at(((time - from) / h).clamp(0.0, 1.0));
            let (xp, xc) = self.device.readings(&y);
            self.run.proof_mass.push(xp);
            self.run.cantilever.push(xc);
        }
    }

    /// Goes on to `end` within one piece of the drive.
    pub(crate) fn travel(
        &mut self,
        piece: &Piece,
        end: f64,
        tolerance: &State,
    ) -> Result<(), RunError> {
        let device = self.device;
        // The ground may have stepped, or the drive with it.
        let level = device.level(self.t);
        let [xp, vp, ..] = device.points(&self.y);
        if matches!(self.phase, Phase::Held { .. }) || (xp < level && self.phase == Phase::Jammed) {
            device.shift(&mut self.y, level - xp);
        } else if matches!(self.phase, Phase::Flight { .. })
            && xp < level
            && device.ground == Ground::Rigid
        {
            device.shift(&mut self.y, level - xp);
            device.kick(&mut self.y, vp.max(0.0) - vp);
        }
        if !matches!(self.phase, Phase::Flight { .. })
            && self.guard(self.t, &self.y, piece)[0] < 0.0
        {
            self.switch(0, piece, true);
        }
        let mut stepper = Stepper::new(device.dimension());
        let mut h = FIRST_STEP;
        let mut fresh = true;
        while end - self.t > 1e-15 {
            self.run.steps += 1;
            if self.run.steps > MAX_STEPS || self.run.events.len() > MAX_EVENTS {
                return Err(RunError::TooMuchWork { time: self.t });
            }
            let phase = self.phase;
            let mut rhs = |t: f64, y: &State, out: &mut State| device.flow(t, y, piece, phase, out);
            if fresh {
                stepper.restart(self.t, &self.y, &mut rhs);
                fresh = false;
            }
            let left = end - self.t;
            let last = h >= left;
            let step = if last { left } else { h };
            let error = stepper.attempt(self.t, &self.y, step, tolerance, &mut rhs);
            // A NaN counts as too large.
            if !(error <= 1.0) {
                let factor = if error.is_finite() {
                    (0.9 * error.powf(-0.2)).clamp(0.1, 0.9)
                } else {
                    0.1
                };
                h = step * factor;
                if h < SHORTEST_STEP {
                    return Err(RunError::Stalled { time: self.t });
                }
                continue;
            }
            stepper.prepare(&self.y, step);
            let from = self.t;
            if let Some((share, which)) = self.first_event(&stepper, from, step, piece) {
                let at = from + share * step;
                self.sample(&stepper, from, step, at);
                self.y = stepper.at(share);
                self.t = at;
                self.switch(which, piece, false);
                fresh = true;
                h = FIRST_STEP;
                continue;
            }
            let to = if last { end } else { from + step };
            self.sample(&stepper, from, step, to);
            self.y = stepper.end;
            self.t = to;
            if to - self.stretch.0 > LONGEST_STRETCH {
                self.close_stretch();
            }
            if matches!(self.phase, Phase::Held { .. } | Phase::Jammed) {
                // Rounding must not let the held mass creep.
                let drift = device.points(&self.y)[1];
                device.kick(&mut self.y, -drift);
            }
            stepper.go_on();
            h = (step * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.3, 4.0)).min(LONGEST_STEP);
            if last {
                h = h.max(FIRST_STEP);
            }
        }
        self.t = end;
        Ok(())
    }

    /// The first root of a guard within the prepared step.
    fn first_event(
        &self,
        stepper: &Stepper,
        from: f64,
        step: f64,
        piece: &Piece,
    ) -> Option<(f64, usize)> {
        let value = |s: f64| self.guard(from + s * step, &stepper.at(s), piece);
        let mut low = 0.0;
        for high in [0.25, 0.5, 0.75, 1.0] {
            let g = value(high);
            if g[0] < 0.0 || g[1] < 0.0 {
                let mut best: Option<(f64, usize)> = None;
                for which in 0..2 {
                    if g[which] >= 0.0 {
                        continue;
                    }
                    let (mut a, mut b) = (low, high);
                    while (b - a) * step > 1e-14 && b - a > 1e-13 {
                        let middle = 0.5 * (a + b);
                        if value(middle)[which] < 0.0 {
                            b = middle;
                        } else {
                            a = middle;
                        }
                    }
                    if best.is_none_or(|(s, _)| b < s) {
                        best = Some((b, which));
                    }
                }
                return best;
            }
            low = high;
        }
        None
    }
}
