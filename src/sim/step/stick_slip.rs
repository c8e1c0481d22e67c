//! Stick-slip: where within a step dry friction brings the sliding mass to a stop.

use super::Step;
use crate::sim::crossing::{first_below_seen, looks};
use crate::sim::device::Device;
use crate::sim::linear::{Swing, apply};
use crate::sim::nodes::{Dense, NODES, interpolant};

/// Largest value of a smooth course over a step, over the sum of the sizes of its polynomial's
/// coefficients.
const OVERSHOOT: f64 = 1.02;

/// Speed of the sliding mass over a step, positive in the direction in which it slides.
struct Sliding<'a, W> {
    step: &'a Step,
    /// Its motion but for the free motion of fast modes.
    smooth: &'a Dense,
    /// Shape of the structure at the mass.
    shape: &'a [f64],
    /// Those of the fast modes whose free motion counts.
    which: W,
    /// Bound on the speed of the other modes, which is subtracted \[m/s\].
    less: f64,
}

impl<W: Fn(&Swing) -> bool> Sliding<'_, W> {
    fn swings(&self) -> impl Iterator<Item = (f64, &Swing)> {
        let own = self.shape.iter().copied().zip(&self.step.swings);
        own.filter(|(_, swing)| swing.fast && (self.which)(swing))
    }

    fn speed_but_for_swings(&self, s: f64) -> f64 {
        self.step.sliding * self.smooth.value_and_slope(s, self.step.h).1 - self.less
    }

    /// Speed at fraction `s` \[m/s\].
    fn speed(&self, s: f64) -> f64 {
        let own = self.swings();
        let free: f64 = own
            .map(|(w, swing)| w * swing.free(s * self.step.h).1)
            .sum();
        self.speed_but_for_swings(s) + self.step.sliding * free
    }

    /// Speed at the step's start \[m/s\].
    fn start(&self) -> f64 {
        let free: f64 = self.swings().map(|(w, swing)| w * swing.start.1).sum();
        self.speed_but_for_swings(0.0) + self.step.sliding * free
    }

    /// First fraction up to `end` at which the speed has fallen from at least `-slack` \[m/s\] to
    /// below that.
    fn first_below(&self, end: f64, slack: f64) -> Option<f64> {
        let h = self.step.h;
        let (early, even) = looks(end);
        let apart = even[0];
        let mut speeds = even.map(|s| self.speed_but_for_swings(s));
        let (mut steepest, mut bend) = self.smooth.most_bend(h);
        for (weight, swing) in self.swings() {
            // From one even look to the next, free motion goes on in the same way.
            let motion = swing.oscillator.free_motion(apart * h);
            let mut free = swing.start;
            for speed in &mut speeds {
                free = apply(&motion, free);
                *speed += self.step.sliding * weight * free.1;
            }
            let (omega2, damping) = (swing.oscillator.omega2, swing.oscillator.damping);
            let most = weight.abs() * swing.most_speed() * h;
            let rate = damping + omega2.sqrt();
            steepest += most * rate;
            bend += most * h * (damping * rate + omega2);
        }
        let start = self.start();
        // Where it cannot come to a stop before the first even look, the last of the early ones
        // will do.
        let plain = start > steepest * apart;
        let early = &early[if plain { early.len() - 1 } else { 0 }..];
        let seen = early.iter().map(|&s| (s, self.speed(s)));
        let seen = seen.chain(even.into_iter().zip(speeds));
        let dip = bend * apart * apart / 8.0;
        first_below_seen(|s| self.speed(s), (start, seen), slack, dip)
    }
}

impl Step {
    /// Fraction of the step, up to `end`, at which the mass stops sliding in its direction;
    /// `shape` is the structure's at the mass, whose motion is `smooth` but for the free motion of
    /// fast modes.
    pub fn first_stop(&self, smooth: &Dense, shape: &[f64], end: f64) -> Option<f64> {
        if self.slides_on(smooth, shape) {
            return None;
        }
        let sliding = Sliding {
            step: self,
            smooth,
            shape,
            which: |_: &Swing| true,
            less: 0.0,
        };
        let fastest = self.vp.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        sliding.first_below(end, 1e-12 * fastest)
    }

    /// Most speed of a point of the structure in the free motion of `which` of the modes.
    fn most_speed(&self, shape: &[f64], which: impl Fn(&Swing) -> bool) -> f64 {
        let own = shape.iter().zip(&self.swings).filter(|(_, s)| which(s));
        own.map(|(weight, swing)| weight.abs() * swing.most_speed())
            .sum()
    }

    /// Whether a bound shows that the mass slides on over the whole step; `smooth` is its motion
    /// without the free motion of fast modes.
    fn slides_on(&self, smooth: &Dense, shape: &[f64]) -> bool {
        smooth.least_slope(self.sliding, self.h) > self.most_speed(shape, |swing| swing.fast)
    }

    /// Whether a bound shows that the pull on a held mass stays below `force` \[N\] over the whole
    /// step.
    pub fn stays_below(&self, device: &Device, force: f64) -> bool {
        let m = self.modes;
        // The pull at the points, but for the free motion of fast modes, which is at most `reach`.
        let (mut smooth, mut reach) = (self.force, 0.0);
        for (i, swing) in self.swings.iter().enumerate().filter(|(_, s)| s.fast) {
            let (per_x, per_v) = device.pull_per_motion(i);
            for (k, node) in NODES.iter().enumerate() {
                let (x, v) = swing.answer_to_force(*node, self.h);
                smooth[k] -= per_x * (self.q[k * m + i] - x) + per_v * (self.v[k * m + i] - v);
            }
            let omega = swing.oscillator.omega2.sqrt();
            reach += (per_x.abs() / omega + per_v.abs()) * swing.most_speed();
        }
        let most: f64 = interpolant(&smooth).iter().map(|c| c.abs()).sum();
        OVERSHOOT * most + reach < force
    }

    /// Whether the mass may stop sliding within the step, up to fraction `end`, whatever the phase
    /// of the modes that vibrate through more than a period in it.
    pub fn may_stop(&self, shape: &[f64], end: f64) -> bool {
        let smooth = &self.smooth(shape);
        if self.slides_on(smooth, shape) {
            return false;
        }
        let swings = |swing: &Swing| swing.fast && self.h > swing.oscillator.longest_step();
        let sliding = Sliding {
            step: self,
            smooth,
            shape,
            which: |swing: &Swing| !swings(swing),
            less: self.most_speed(shape, swings),
        };
        sliding.start() < 0.0 || sliding.first_below(end, 0.0).is_some()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::stick_slip::*;
    use crate::sim::crossing::first_below;
    use crate::sim::linear::Oscillator;
    use crate::sim::nodes::S;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The bounds that save looks do not change where the mass stops.
        #[test]
        fn the_stop_is_that_of_every_look(
            h in 1e-5..2e-4f64,
            end in 0.1..1.0f64,
            modes in prop::collection::vec((5e3..4e4f64, 0.0..0.1f64, -1.0..1.0f64, -1.0..1.0f64), 1..4),
            coast in 0.0..1.5f64,
            forces in prop::array::uniform5(-1.0..1.0f64),
        ) {
            let shape: Vec<f64> = modes.iter().map(|mode| mode.3.signum()).collect();
            let mut step = Step::new(modes.len(), &[]);
            (step.h, step.sliding) = (h, 1.0);
            for (swing, (f, zeta, share, x)) in step.swings.iter_mut().zip(&modes) {
                let omega = std::f64::consts::TAU * f;
                let oscillator = Oscillator { omega2: omega * omega, damping: 2.0 * zeta * omega };
                let force: [f64; S] = forces.map(|force| 0.1 * omega * force);
                *swing = Swing::new(oscillator, h, x / omega, share + coast, &force);
                swing.fast = true;
            }
            let smooth = step.smooth(&shape);
            let speed = |s: f64| {
                let own = shape.iter().zip(&step.swings);
                let free: f64 = own.map(|(w, swing)| w * swing.free(s * h).1).sum();
                smooth.value_and_slope(s, h).1 + free
            };
            let looked = first_below(speed, end, 0.0);
            let found = step.first_stop(&smooth, &shape, end);
            prop_assert_eq!(looked.is_some(), found.is_some());
            if let (Some(looked), Some(found)) = (looked, found) {
                prop_assert!((looked - found).abs() < 1e-9, "{} {}", looked, found);
            }
        }
    }
}
