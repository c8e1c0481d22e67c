//! `hysteresis_memory`: loops that remember the extremes of the voltage, at every amplitude.
//!
//! The law is a Preisach operator of a smooth density, which need not be known in detail:
//! relays of half width `h` whose centre lies at `c` volts have the weight `f(h) g(c)`,
//!
//! `f = exp(-(q h)^2 / 2) (1 + k h / v_ref)`,
//! `g = 1 + b1 (2 d'/d) c + b2 (c/v_ref)^2 + b4 (c/v_ref)^4`.
//!
//! With `q = k = b1 = b2 = b4 = 0` that is the Prandtl-Ishlinskii operator of uniform density:
//! play operators of all widths with the same weight. Of such an operator all that counts of
//! the past are the extremes of the voltage that no later extreme has overtaken, so those are
//! the memory, and between the extremes the law is smooth. A sweep from `b` up to `a` moves
//! all relays that lie between, by Everett's function
//!
//! `E(a, b) = int_0^((a-b)/2) f(h) (G(a - h) - G(b + h)) dh`,  `G' = g`,
//!
//! and the first one, from zero to `v`, by `E(v, -v) / 2`. Their sum `P`, with the middle line
//! of its own cycle between `+-v_ref` taken out and divided by half the height of that cycle
//! at 0 V, is `-H` in
//!
//! `gc = m(V) + w d H`,
//!
//! with the mean `m(V)` of the two branches and their half difference `d` at 0 V, whose slope
//! there is `d'`. A loop between `+-A` of the uniform operator has
//! `H = (2 V (v_ref - A) +- (A^2 - V^2)) / v_ref^2`: for `A = v_ref` and with `b1 = 1` it is that
//! of the branches (the paper's meet at 8 V), for a smaller amplitude the drive is weaker and
//! the loop narrower in proportion, and it closes. The piezo may have been driven before the
//! drive began: then the past begins with an extreme `v_past`.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::drive::Segment;
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::piezo::{Branch, Piezo};

/// Extremes that are remembered; of still more nested ones the innermost are forgotten.
const MEMORY: usize = 12;
/// Voltages that differ by less than this count as equal [V].
const EQUAL: f64 = 1e-9;
/// Moments of the density that `G`, of the fifth power, calls for.
const MOMENTS: usize = 6;
/// Distance of the half widths at which they are known \[V\].
const STEP: f64 = 0.05;
/// How many of those there are: sweeps of 60 V have all relays that count.
const CELLS: usize = 600;
/// Nodes and weights of Gauss and Legendre's rule of 4 points on -1 to 1.
static NODES: [(f64, f64); 4] = [
    (-0.8611363115940526, 0.34785484513745374),
    (-0.3399810435848563, 0.6521451548625464),
    (0.3399810435848563, 0.6521451548625464),
    (0.8611363115940526, 0.34785484513745374),
];
const DENSITY: &str =
    "f = exp(-(q h)^2/2) (1 + k h/Vr), g = 1 + b1 (2 d'/d) c + b2 (c/Vr)^2 + b4 (c/Vr)^4";
const LAW: &str = "gc = (1 - s) gc + s (m(V) + w d H[V])";

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "hysteresis_memory",
    name: "hysteresis with memory",
    sentence: "The drive remembers the extremes of the voltage: its loops close at every amplitude and are narrower at small ones.",
    law: LAW,
    source: "Prandtl-Ishlinskii and Preisach operators: Visintin, Differential Models of Hysteresis, 1994, chapters III and IV; Everett's function: Mayergoyz, Mathematical Models of Hysteresis, 1991; uniform density gives Rayleigh's loops",
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
        ParameterSpec {
            id: "q",
            symbol: "q",
            name: "narrowness of the loops",
            unit: "1/V",
            default: 0.0,
            range: (0.0, 2.0),
            limits: (0.0, 100.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "relays wider than this one over q count little; 0: all widths count alike",
            equation: DENSITY,
        },
        ParameterSpec {
            id: "k",
            symbol: "k",
            name: "share of wider loops",
            unit: "",
            default: 0.0,
            range: (0.0, 20.0),
            limits: (0.0, 1e3),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "growth of the weight of relays with their width",
            equation: DENSITY,
        },
        ParameterSpec {
            id: "b1",
            symbol: "b1",
            name: "asymmetry of the loops",
            unit: "",
            default: 1.0,
            range: (-2.0, 4.0),
            limits: (-100.0, 100.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "asymmetry of a loop over that between the branches; 0: none",
            equation: DENSITY,
        },
        ParameterSpec {
            id: "b2",
            symbol: "b2",
            name: "unevenness over voltage",
            unit: "",
            default: 0.0,
            range: (-2.0, 2.0),
            limits: (-100.0, 100.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "how the weight of relays changes with the voltage about which they lie; 0: it does not",
            equation: DENSITY,
        },
        ParameterSpec {
            id: "b4",
            symbol: "b4",
            name: "unevenness at large voltages",
            unit: "",
            default: 0.0,
            range: (-2.0, 2.0),
            limits: (-100.0, 100.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "the same, at large voltages",
            equation: DENSITY,
        },
        ParameterSpec {
            id: "v_past",
            symbol: "Vp",
            name: "last extreme before",
            unit: "V",
            default: 0.0,
            range: (-20.0, 20.0),
            limits: (-1e6, 1e6),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "voltage from which the piezo came to rest before the drive began; 0: it had never been driven",
            equation: "P = E(Vp, -Vp)/2 + E(0, Vp) at the start",
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
            relays: Relays::new(
                [values[2], values[3], values[4]],
                [
                    values[5] * slant(&around.piezo.unwrap_or_default()),
                    values[6],
                    values[7],
                ],
            ),
            before: values[8],
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
    relays: Relays,
    before: f64,
    piezo: Piezo,
    rates: [f64; 1 + MEMORY],
}

/// The relays, with what their cycle between plus and minus the reference comes to.
#[derive(Debug, Clone)]
struct Relays {
    reference: f64,
    narrow: f64,
    wider: f64,
    /// Coefficients of `g`, of `c`, its square and its fourth power.
    uneven: [f64; 3],
    /// Half the height of that cycle at 0 V.
    half_height: f64,
    /// `int_0^h f(h') h'^n dh'` at every `STEP` of `h`; empty where all widths count alike.
    moments: Vec<[f64; MOMENTS]>,
}

impl Relays {
    fn new([reference, narrow, wider]: [f64; 3], [slant, b2, b4]: [f64; 3]) -> Self {
        let mut relays = Self {
            reference,
            narrow,
            wider: wider / reference,
            uneven: [slant, b2 / reference.powi(2), b4 / reference.powi(4)],
            half_height: 1.0,
            moments: Vec::new(),
        };
        if narrow != 0.0 || wider != 0.0 || b2 != 0.0 || b4 != 0.0 {
            relays.moments = relays.integrate();
        }
        let e = |a: f64, b: f64| relays.everett(a, b);
        let half = 0.5 * (e(reference, -reference) - e(reference, 0.0) - e(0.0, -reference));
        // Weights that cancel have no loop.
        relays.half_height = if half.abs() > 1e-12 * reference * reference {
            half
        } else {
            f64::INFINITY
        };
        relays
    }

    /// Weight of relays of half width `h` \[V\].
    fn density(&self, h: f64) -> f64 {
        (-0.5 * (self.narrow * h).powi(2)).exp() * (1.0 + self.wider * h)
    }

    /// The moments over half widths that a sweep may reach.
    fn integrate(&self) -> Vec<[f64; MOMENTS]> {
        let mut sum = [0.0; MOMENTS];
        let mut all = vec![sum];
        for cell in 0..CELLS {
            for (x, weight) in NODES {
                let h = STEP * (cell as f64 + 0.5 + 0.5 * x);
                let mut term = 0.5 * STEP * weight * self.density(h);
                for moment in &mut sum {
                    *moment += term;
                    term *= h;
                }
            }
            all.push(sum);
        }
        all
    }

    /// The moments up to `h` \[V\]: between the points by value and slope.
    fn moments(&self, h: f64) -> [f64; MOMENTS] {
        let place = (h / STEP).min(CELLS as f64);
        let cell = (place as usize).min(CELLS - 1);
        let (low, high) = (&self.moments[cell], &self.moments[cell + 1]);
        let at = [STEP * cell as f64, STEP * (cell + 1) as f64];
        let mut slope = at.map(|h| STEP * self.density(h));
        let t = place - cell as f64;
        let r = 1.0 - t;
        let mut out = [0.0; MOMENTS];
        for n in 0..MOMENTS {
            out[n] = r * r * ((1.0 + 2.0 * t) * low[n] + t * slope[0])
                + t * t * ((1.0 + 2.0 * r) * high[n] - r * slope[1]);
            slope = [slope[0] * at[0], slope[1] * at[1]];
        }
        out
    }

    /// `G(c + h)` as a polynomial in `h`.
    fn around(&self, c: f64) -> [f64; MOMENTS] {
        let [slant, square, fourth] = self.uneven;
        let mut g = [0.0, 1.0, 0.5 * slant, square / 3.0, 0.0, 0.2 * fourth];
        // Horner's scheme, once for each power.
        for first in 0..MOMENTS {
            for n in (first..MOMENTS - 1).rev() {
                g[n] += c * g[n + 1];
            }
        }
        g
    }

    /// What a sweep from `b` to `a` \[V\] gains. Beyond what the moments reach, relays have
    /// no weight.
    fn everett(&self, a: f64, b: f64) -> f64 {
        let u = a - b;
        if self.moments.is_empty() {
            return 0.25 * u * u.abs() * (1.0 + 0.5 * self.uneven[0] * (a + b));
        }
        let (sign, a, b) = if u < 0.0 { (-1.0, b, a) } else { (1.0, a, b) };
        let (from, to) = (self.around(b), self.around(a));
        let moments = self.moments(0.5 * (a - b));
        let mut sum = 0.0;
        let mut odd = 1.0;
        for n in 0..MOMENTS {
            sum += (odd * to[n] - from[n]) * moments[n];
            odd = -odd;
        }
        sign * sum
    }

    /// `H` at `voltage` after `past`.
    fn loops(&self, past: &[f64], voltage: f64) -> f64 {
        let past = standing(past, voltage, 0.0);
        let mut all = past.iter().copied().chain([voltage]);
        let mut from = all.next().unwrap_or(voltage);
        let mut moved = 0.5 * self.everett(from, -from);
        for to in all {
            moved += self.everett(to, from);
            from = to;
        }
        let (up, down) = (-self.reference, self.reference);
        let middle = 0.5 * (self.everett(voltage, up) + self.everett(voltage, down));
        (middle - moved) / self.half_height
    }
}

/// Half the difference of the branches at 0 V, and its slope.
fn halves(piezo: &Piezo) -> [f64; 2] {
    [0, 1].map(|k| 0.5 * (piezo.rising[k] - piezo.falling[k]))
}

/// Slope of `g` over its value at 0 V \[1/V\] with which the cycle between the references
/// is as wide as the branches are apart, and as lopsided.
fn slant(piezo: &Piezo) -> f64 {
    let [half, slope] = halves(piezo);
    if half == 0.0 { 0.0 } else { 2.0 * slope / half }
}

/// Extremes of the past, first to last.
#[derive(Debug, Clone, Copy)]
struct Past {
    all: [f64; 1 + MEMORY],
    count: usize,
    /// Whether the first is that from before the drive began, which the states do not have.
    older: bool,
}

impl Past {
    fn new(before: f64, z: &[f64]) -> Self {
        let own = z.split_first().map_or(&[][..], |(count, rest)| {
            // Dense output may have left the count a rounding error off.
            &rest[..(count.round().max(0.0) as usize).min(rest.len())]
        });
        let mut all = [0.0; 1 + MEMORY];
        // Where the first was larger, it has overtaken that from before.
        let older = before != 0.0 && own.first().is_none_or(|v| v.abs() < before.abs() - EQUAL);
        all[0] = before;
        let at = usize::from(older);
        let kept = own.len().min(all.len() - at);
        all[at..at + kept].copy_from_slice(&own[..kept]);
        Self {
            all,
            count: at + kept,
            older,
        }
    }

    fn extremes(&self) -> &[f64] {
        &self.all[..self.count]
    }
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

impl Action for HysteresisMemory {
    fn does_nothing(&self) -> bool {
        self.share == 0.0
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn end_piece(&self, at: &Kinematics, z: &mut [f64]) {
        let past = Past::new(self.before, z);
        let still = standing(past.extremes(), at.voltage, EQUAL);
        let n = still.len().saturating_sub(usize::from(past.older));
        // A sweep too short to count changes nothing.
        let moved = |from: f64| (at.voltage - from).abs() > EQUAL;
        let from = still.last().copied().unwrap_or(0.0);
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
        let past = Past::new(self.before, z);
        let past = standing(past.extremes(), from, EQUAL);
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
        let past = Past::new(self.before, z);
        let loops = self.relays.loops(past.extremes(), voltage);
        let law = 0.5 * (rising + falling) + self.width * halves(&self.piezo)[0] * loops;
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
            relays: Relays::new([8.0, 0.0, 0.0], [slant(&Piezo::default()), 0.0, 0.0]),
            before: 0.0,
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

    #[test]
    fn everetts_function_is_the_integral_over_the_relays() {
        // Relays summed one by one, each switched up at c + h and down at c - h.
        let relays = Relays::new([8.0, 0.4, 3.0], [0.05, -0.8, 0.5]);
        let weight = |h: f64, c: f64| {
            let r: f64 = c / 8.0;
            let g = 1.0 + 0.05 * c - 0.8 * r * r + 0.5 * r.powi(4);
            (-0.5 * (0.4 * h).powi(2)).exp() * (1.0 + 3.0 * h / 8.0) * g
        };
        let by_relays = |a: f64, b: f64| {
            let n = 400;
            let mut sum = 0.0;
            let dh = 0.5 * (a - b) / f64::from(n);
            for i in 0..n {
                let h = dh * (f64::from(i) + 0.5);
                let dc = (a - b - 2.0 * h) / f64::from(n);
                for j in 0..n {
                    sum += dh * dc * weight(h, b + h + dc * (f64::from(j) + 0.5));
                }
            }
            sum
        };
        for (a, b) in [(8.0, -8.0), (3.0, -5.5), (0.31, 0.0), (6.0, 5.0)] {
            let (own, other) = (relays.everett(a, b), by_relays(a, b));
            assert!((own / other - 1.0).abs() < 1e-5, "{a} {b}: {own} {other}");
            assert!((relays.everett(b, a) + own).abs() < 1e-12 * own);
        }
    }

    #[test]
    fn a_past_counts_until_it_is_overtaken() {
        let mut older = law();
        older.before = -6.0;
        let (fresh, mut z, mut y) = (law(), [0.0; 1 + MEMORY], [0.0; 1 + MEMORY]);
        let gain = |law: &HysteresisMemory, z: &[f64]| law.hysteresis(0.0, 1.0, Branch::Falling, z);
        for extreme in [4.0, 7.0] {
            older.end_piece(&at(extreme), &mut z);
            fresh.end_piece(&at(extreme), &mut y);
            let apart = (gain(&older, &z) - gain(&fresh, &y)).abs();
            assert_eq!(apart > 1e-3, extreme < 6.0, "{extreme}: {apart}");
        }
    }
}
