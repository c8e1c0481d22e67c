//! `hysteresis_memory`: loops that remember the extremes of the voltage, at every amplitude.
//!
//! Equation: `gc = (1 - s) gc + s (m(V) + w d H[V])`.
//! Source: Prandtl-Ishlinskii and Preisach operators: Visintin, Differential Models of
//! Hysteresis, 1994, chapters III and IV; Everett's function: Mayergoyz, Mathematical Models
//! of Hysteresis, 1991; uniform density gives Rayleigh's loops.
//!
//! The law is the Preisach operator of `model::preisach`, whose density need not be known in
//! detail: with `q = k = b1 = b2 = b4 = 0` it is the Prandtl-Ishlinskii operator of uniform
//! density, play operators of all widths with the same weight. What its relays have moved,
//! with the middle line of its own cycle between `+-v_ref` taken out and divided by half the
//! height of that cycle at 0 V, is `-H` in
//!
//! `gc = m(V) + w d H`,
//!
//! with the mean `m(V)` of the two branches, to which `m2 (V/v_ref)^2 + m3 (V/v_ref)^3` may come,
//! and their half difference `d` at 0 V, whose slope there is `d'`; the asymmetry of the density is `b1' = b1 (2 d'/d)`. A loop between `+-A` of
//! the uniform operator has `H = (2 V (v_ref - A) +- (A^2 - V^2)) / v_ref^2`: for `A = v_ref`
//! and with `b1 = 1` it is that of the branches (the paper's meet at 8 V), for a smaller
//! amplitude the drive is weaker and the loop narrower in proportion, and it closes. The
//! extremes of the voltage that no later extreme has overtaken are the memory, and between
//! them the law is smooth. The piezo may have been driven before the drive began: then the
//! past begins with an extreme `v_past`.

use super::{
    Action, ColdStart, EffectSpec, EvidenceFigure, Facts, FormError, FormTolerance, FoundBy,
    Kinematics, Motion, Need, Quantity, Search, Start,
};
use crate::model::bisection::bisect;
use crate::model::drive::Segment;
use crate::model::parameter::{ParameterSpec, Rank, Scale};
use crate::model::piezo::{Branch, LARGEST_GAIN, Piezo};
use crate::model::preisach::{EQUAL, MEMORY, Past, Relays, standing};

const DENSITY: &str =
    "f = exp(-(q h)^2/2) (1 + k h/Vr), g = 1 + b1 (2 d'/d) c + b2 (c/Vr)^2 + b4 (c/Vr)^4";
/// What most parameters have in common.
const PLAIN: ParameterSpec = ParameterSpec {
    id: "",
    symbol: "",
    name: "",
    unit: "",
    default: 0.0,
    range: (-2.0, 2.0),
    limits: (-100.0, 100.0),
    scale: Scale::Linear,
    rank: Rank::Advanced,
    meaning: "",
    equation: DENSITY,
};
const LAW: &str = "gc = (1 - s) gc + s (m(V) + w d H[V])";
const MIDDLE: &str = "m(V) = (gc rising + gc falling)/2 + m2 (V/Vr)^2 + m3 (V/Vr)^3";

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
            default: 1.0,
            range: (0.0, 1.0),
            limits: (0.0, 1.0),
            meaning: "0 is the two branches, 1 the loops with memory in their place",
            equation: LAW,
            ..PLAIN
        },
        ParameterSpec {
            id: "w",
            symbol: "w",
            name: "width of the loops",
            default: 1.0,
            range: (0.0, 2.0),
            meaning: "width of a loop over that between the branches; 0 leaves their mean",
            equation: LAW,
            ..PLAIN
        },
        ParameterSpec {
            id: "v_ref",
            symbol: "Vr",
            name: "reference amplitude",
            unit: "V",
            default: 8.0,
            range: (6.0, 20.0),
            limits: (1e-3, 1e6),
            meaning: "amplitude at which the loop has the width of the branches",
            equation: "H = (2 V (Vr - A) +- (A^2 - V^2)) / Vr^2",
            ..PLAIN
        },
        ParameterSpec {
            id: "q",
            symbol: "q",
            name: "narrowness of the loops",
            unit: "1/V",
            range: (0.0, 2.0),
            limits: (0.0, 100.0),
            meaning: "relays wider than this one over q count little; 0: all widths count alike",
            ..PLAIN
        },
        ParameterSpec {
            id: "k",
            symbol: "k",
            name: "share of wider loops",
            range: (-1.0, 20.0),
            limits: (-1.0, 1e3),
            meaning: "growth of the weight of relays with their width up to Vr; negative: wider ones count less",
            ..PLAIN
        },
        ParameterSpec {
            id: "b1",
            symbol: "b1",
            name: "asymmetry of the loops",
            default: 1.0,
            range: (-2.0, 4.0),
            meaning: "asymmetry of a loop over that between the branches; 0: none",
            ..PLAIN
        },
        ParameterSpec {
            id: "b2",
            symbol: "b2",
            name: "unevenness over voltage",
            meaning: "how the weight of relays changes with the voltage about which they lie; 0: it does not",
            ..PLAIN
        },
        ParameterSpec {
            id: "b4",
            symbol: "b4",
            name: "unevenness at large voltages",
            meaning: "the same, at large voltages",
            ..PLAIN
        },
        ParameterSpec {
            id: "v_past",
            symbol: "Vp",
            name: "last extreme before",
            unit: "V",
            range: (-20.0, 20.0),
            limits: (-1e6, 1e6),
            meaning: "voltage from which the piezo came to rest before the drive began; 0: it had never been driven",
            equation: "P = E(Vp, -Vp)/2 + E(0, Vp) at the start",
            ..PLAIN
        },
        ParameterSpec {
            id: "m2",
            symbol: "m2",
            name: "even correction of the mean curve",
            meaning: "what the mean curve of the loops has beyond that of the branches, even in V",
            equation: MIDDLE,
            ..PLAIN
        },
        ParameterSpec {
            id: "m3",
            symbol: "m3",
            name: "odd correction of the mean curve",
            meaning: "the same, odd in V",
            equation: MIDDLE,
            ..PLAIN
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
            middle: [values[9], values[10]],
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
    facts: Facts {
        strengths: &["s"],
        feature_strength: Some("s"),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        // A device has either the branches or the loops: between them there is nothing. At zero
        // the past would not show which way to go.
        cold_start: Some(ColdStart {
            set: &[(8, 1e-3)],
            free: &[1, 3, 4, 5, 6, 7, 8, 9, 10],
        }),
        deferred: &["q", "k", "b2", "b4", "v_past"],
        form_errors,
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Voltage),
};

/// Relays of all widths as in the branches, and rather narrow ones that lie evenly.
fn starts(motion: &Motion) -> Vec<Start> {
    let mut all = Vec::new();
    if !motion.is_driven {
        return all;
    }
    for width in [0.5, 1.2] {
        for (q, k, b1) in [(0.0, 0.0, 1.0), (0.4, 3.0, 0.0), (0.7, 6.0, 0.0)] {
            let values = [0.2, width, 8.0, q, k, b1, 0.0, 0.0, 0.0, 0.0, 0.0];
            let start = Start::positive(&values, 0, &[0, 1]);
            all.push(start.shaped_by(&[3, 4, 5, 6, 7, 9, 10]));
        }
    }
    all
}

/// Branches that are higher or lower at some voltages, and loops of another width at some
/// voltages than at others, as those of relays that do not lie evenly are; and none.
fn form_errors(values: &[f64], tolerance: &FormTolerance) -> Vec<FormError> {
    let size = tolerance.share * values[0] * LARGEST_GAIN;
    let loops = [values[1], 0.0].map(|width| {
        let mut values = tolerance.scaled(values, 0);
        values[1] = width;
        FormError::InWindows(values, Quantity::Voltage)
    });
    std::iter::once(FormError::DriveInWindows(size))
        .chain(loops)
        .collect()
}

/// States: how many extremes are remembered, and they, from the first to the last.
#[derive(Debug)]
struct HysteresisMemory {
    share: f64,
    width: f64,
    reference: f64,
    middle: [f64; 2],
    relays: Relays,
    before: f64,
    piezo: Piezo,
    rates: [f64; 1 + MEMORY],
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

impl Action for HysteresisMemory {
    fn acts_on_drive(&self) -> bool {
        true
    }

    fn does_nothing(&self) -> bool {
        self.share == 0.0
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn states_feel_motion(&self) -> bool {
        false
    }

    fn end_piece(&self, _at: &Kinematics, film: f64, z: &mut [f64]) {
        let past = Past::new(self.before, z);
        let still = standing(past.extremes(), film, EQUAL);
        let n = still.len().saturating_sub(usize::from(past.older));
        // A sweep too short to count changes nothing.
        let moved = |from: f64| (film - from).abs() > EQUAL;
        let from = still.last().copied().unwrap_or(0.0);
        let count = if moved(from) {
            let place = n.min(MEMORY - 1);
            z[1 + place] = film;
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
        // On from an extreme in the same direction, that one is overtaken at once.
        let way = (to - from).signum();
        let past = standing(past.extremes(), from + 2.0 * EQUAL * way, EQUAL);
        let limits = match *past {
            [] => return segment,
            [first] => [first, -first],
            [.., before, last] => [last, before],
        };
        // One of the two lies ahead; the other is where the voltage comes from. One that is
        // reached at the end only is not passed within the piece.
        let passed = |v: &f64| way * (v - from) > EQUAL && way * (to - v) > EQUAL;
        let Some(limit) = limits.into_iter().find(passed) else {
            return segment;
        };
        let end = bisect(t, segment.end, |t| {
            (segment.shape.voltage(t) - limit) * (to - from) >= 0.0
        });
        Segment { end, ..segment }
    }

    fn hysteresis(&self, gain: f64, voltage: f64, branch: Branch, z: &[f64]) -> f64 {
        if branch == Branch::Poled {
            return gain;
        }
        let [rising, falling] =
            [Branch::Rising, Branch::Falling].map(|branch| self.piezo.gain(voltage, branch));
        let past = Past::new(self.before, z);
        let loops = self.relays.loops(past.extremes(), voltage);
        let u = voltage / self.reference;
        let middle = 0.5 * (rising + falling) + u * u * (self.middle[0] + u * self.middle[1]);
        let law = middle + self.width * halves(&self.piezo)[0] * loops;
        gain + self.share * (law - gain)
    }
}

#[cfg(test)]
#[path = "hysteresis_memory_tests.rs"]
mod tests;
