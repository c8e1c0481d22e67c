//! `hysteresis_memory`: loops that remember the extremes of the voltage, at every amplitude.
//!
//! The law is a Prandtl-Ishlinskii operator of uniform density: play operators of all
//! widths with the same weight. Of such an operator all that counts of the past are the
//! extremes of the voltage that no later extreme has overtaken, so those are the memory,
//! and between the extremes the law is smooth. With the mean `m(V)` and the half
//! difference `d(V)` of the two branches, of which `d` is here its value and slope at 0 V,
//!
//! `gc = m(V) + w d(V) H`,  `H = (2 V v_ref + 4 Q) / v_ref^2`,
//!
//! where a sweep over `u` volts from an extreme changes `Q` by `-sign(u) u^2 / 4`, and the
//! first one, from zero, by twice that. A loop between `+-A` has
//! `H = (2 V (v_ref - A) +- (A^2 - V^2)) / v_ref^2`: for `A = v_ref` it is that of the
//! branches (the paper's meet at 8 V), for a smaller amplitude the drive is weaker and the
//! loop narrower in proportion, and it closes.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::drive::Segment;
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::piezo::{Branch, Piezo};

/// Extremes that are remembered; of still more nested ones the innermost are forgotten.
const MEMORY: usize = 12;
/// Voltages that differ by less than this count as equal [V].
const EQUAL: f64 = 1e-9;
const LAW: &str = "gc = (1 - s) gc + s (m(V) + w d(V) H[V])";

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "hysteresis_memory",
    name: "hysteresis with memory",
    sentence: "The drive remembers the extremes of the voltage: its loops close at every amplitude and are narrower at small ones.",
    law: LAW,
    source: "Prandtl-Ishlinskii operators: Visintin, Differential Models of Hysteresis, 1994, chapter III; uniform density gives Rayleigh's loops",
    needs: Need::Drive,
    parameters: &[
        ParameterSpec {
            id: "s",
            symbol: "s",
            name: "share of the memory",
            unit: "",
            default: 1.0,
            range: (0.0, 1.0),
            limits: (0.0, 1.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "0 is the two branches, 1 the loops with memory in their place",
            equation: LAW,
        },
        ParameterSpec {
            id: "w",
            symbol: "w",
            name: "width of the loops",
            unit: "",
            default: 1.0,
            range: (0.0, 2.0),
            limits: (-100.0, 100.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "width of a loop over that between the branches; 0 leaves their mean",
            equation: LAW,
        },
        ParameterSpec {
            id: "v_ref",
            symbol: "Vr",
            name: "reference amplitude",
            unit: "V",
            default: 8.0,
            range: (6.0, 20.0),
            limits: (1e-3, 1e6),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "amplitude at which the loop has the width of the branches",
            equation: "H = (2 V (Vr - A) +- (A^2 - V^2)) / Vr^2",
        },
    ],
    build: |values, around| {
        Box::new(HysteresisMemory {
            share: if around.piezo.is_some() {
                values[0]
            } else {
                0.0
            },
            width: values[1],
            reference: values[2],
            piezo: around.piezo.unwrap_or_default(),
            rates: [0.0; 1 + MEMORY],
        })
    },
};

/// States: how many extremes are remembered, and they, from the first to the last.
#[derive(Debug)]
struct HysteresisMemory {
    share: f64,
    width: f64,
    reference: f64,
    piezo: Piezo,
    rates: [f64; 1 + MEMORY],
}

/// The extremes in `z`.
fn extremes(z: &[f64]) -> &[f64] {
    let Some((count, rest)) = z.split_first() else {
        return &[];
    };
    // Dense output may have left the count a rounding error off.
    &rest[..(count.round().max(0.0) as usize).min(rest.len())]
}

/// Those of the extremes that `voltage` has not overtaken; coming within `slack` [V] of
/// one overtakes it. The last one is overtaken only by going on beyond it.
fn standing(mut past: &[f64], voltage: f64, slack: f64) -> &[f64] {
    // How far the voltage is past `a`, as seen from `b`.
    let past_by = |a: f64, b: f64| (voltage - a) * if a > b { 1.0 } else { -1.0 };
    loop {
        let n = past.len();
        // Before the first extreme there was its mirror image.
        let (before, last) = match *past {
            [] => return past,
            [first] => (-first, first),
            [.., before, last] => (before, last),
        };
        let overtaken = if past_by(before, last) >= -slack {
            2
        } else if past_by(last, before) > 0.0 {
            1
        } else {
            return past;
        };
        past = &past[..n.saturating_sub(overtaken)];
    }
}

/// `Q` at `voltage` after `past`.
fn curvature(past: &[f64], voltage: f64) -> f64 {
    let sweep = |u: f64| -0.25 * u * u.abs();
    let past = standing(past, voltage, 0.0);
    let mut all = past.iter().copied().chain([voltage]);
    let mut from = all.next().unwrap_or(voltage);
    let mut q = 2.0 * sweep(from);
    for to in all {
        q += sweep(to - from);
        from = to;
    }
    q
}

impl Action for HysteresisMemory {
    fn does_nothing(&self) -> bool {
        self.share == 0.0
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn end_piece(&self, at: &Kinematics, z: &mut [f64]) {
        let n = standing(extremes(z), at.voltage, EQUAL).len();
        // A sweep too short to count changes nothing.
        let moved = |from: f64| (at.voltage - from).abs() > EQUAL;
        let from = if n > 0 { z[n] } else { 0.0 };
        let count = if moved(from) {
            let place = n.min(MEMORY - 1);
            z[1 + place] = at.voltage;
            place + 1
        } else {
            n
        };
        z[0] = count as f64;
    }

    /// A sweep's law changes where it overtakes an extreme.
    fn piece(&self, segment: Segment, t: f64, z: &[f64]) -> Segment {
        if !segment.end.is_finite() || segment.branch == Branch::Poled {
            return segment;
        }
        let (from, to) = (segment.shape.voltage(t), segment.shape.voltage(segment.end));
        let past = standing(extremes(z), from, EQUAL);
        let limits = match *past {
            [] => return segment,
            [first] => [first, -first],
            [.., before, last] => [last, before],
        };
        // One of the two lies ahead; the other is where the voltage comes from.
        let ahead = limits
            .into_iter()
            .find(|v| (v - from) * (to - from) > 0.0 && (v - from).abs() > EQUAL);
        let Some(limit) = ahead.filter(|v| (to - v) * (to - from) > 0.0) else {
            return segment;
        };
        let (mut low, mut high) = (t, segment.end);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if (segment.shape.voltage(middle) - limit) * (to - from) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Segment {
            end: high,
            ..segment
        }
    }

    fn hysteresis(&self, gain: f64, voltage: f64, branch: Branch, z: &[f64]) -> f64 {
        if branch == Branch::Poled {
            return gain;
        }
        let [rising, falling] =
            [Branch::Rising, Branch::Falling].map(|branch| self.piezo.gain(voltage, branch));
        let half = |k: usize| 0.5 * (self.piezo.rising[k] - self.piezo.falling[k]);
        let q = curvature(extremes(z), voltage);
        let loops = (2.0 * voltage * self.reference + 4.0 * q) / (self.reference * self.reference);
        let law = 0.5 * (rising + falling) + self.width * (half(0) + half(1) * voltage) * loops;
        gain + self.share * (law - gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(voltage: f64) -> Kinematics {
        Kinematics {
            voltage,
            ..Kinematics::default()
        }
    }

    fn law() -> HysteresisMemory {
        HysteresisMemory {
            share: 1.0,
            width: 1.0,
            reference: 8.0,
            piezo: Piezo::default(),
            rates: [0.0; 1 + MEMORY],
        }
    }

    #[test]
    fn at_the_reference_amplitude_the_loop_is_that_of_the_branches() {
        let (law, mut z) = (law(), [0.0; 1 + MEMORY]);
        for extreme in [8.0, -8.0] {
            law.end_piece(&at(extreme), &mut z);
        }
        for branch in [Branch::Rising, Branch::Falling] {
            for step in 0..=16 {
                let up = -8.0 + f64::from(step);
                let voltage = if branch == Branch::Rising { up } else { -up };
                let expected = law.piezo.gain(voltage, branch);
                let gain = law.hysteresis(0.0, voltage, branch, &z);
                // The branches of the paper meet at +-8 V but for 0.02.
                assert!(
                    (gain - expected).abs() < 0.03,
                    "{voltage}: {gain} {expected}"
                );
            }
            law.end_piece(
                &at(if branch == Branch::Rising { 8.0 } else { -8.0 }),
                &mut z,
            );
        }
    }

    #[test]
    fn loops_close_at_every_amplitude() {
        let (law, mut z) = (law(), [0.0; 1 + MEMORY]);
        for extreme in [8.0, -8.0, 3.0] {
            law.end_piece(&at(extreme), &mut z);
        }
        let before = law.hysteresis(0.0, 5.0, Branch::Rising, &z);
        // A minor loop leaves no trace, nor do a hundred nested ones more than a small one.
        for extreme in [-1.0, 3.0] {
            law.end_piece(&at(extreme), &mut z);
        }
        assert_eq!(law.hysteresis(0.0, 5.0, Branch::Rising, &z), before);
        for i in 0..100 {
            let size = 3.0 / (1.0 + f64::from(i));
            law.end_piece(&at(if i % 2 == 0 { -size } else { size }), &mut z);
        }
        assert_eq!(law.hysteresis(0.0, 5.0, Branch::Rising, &z), before);
    }
}
