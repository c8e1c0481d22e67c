//! `cubic_stiffness`: a spring that hardens or softens with deflection, less or more so the
//! further it goes.
//!
//! Equation: `F = -k3 xp^3 - k5 xp^5`, or with a length `l` that is not 0
//! `F = -6 k3 l^2 (xp - l sin(xp/l)) - k5 xp^5`, whose leading term is `-k3 xp^3`.
//! Source: Duffing's oscillator, e.g. Nayfeh and Mook, Nonlinear Oscillations, 1979. A pendulum
//! on a spring `k` in its angle is the sine form with `l` of one radian and `k3 = -k/6`.

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Kinematics, Motion, Need,
    Quantity, Search, Start,
};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "cubic_stiffness",
    name: "cubic stiffness",
    sentence: "The spring hardens (or softens) with deflection, so that the frequency of a ring changes with its size.",
    law: "F = -k3 xp^3 - k5 xp^5; with l: F = -6 k3 l^2 (xp - l sin(xp/l)) - k5 xp^5",
    source: "Duffing's oscillator, e.g. Nayfeh and Mook, Nonlinear Oscillations, 1979",
    needs: Need::Nothing,
    parameters: &[
        ParameterSpec {
            id: "k3",
            symbol: "k3",
            name: "cubic stiffness",
            unit: "N/m^3",
            default: 2e4,
            range: (-1e5, 1e5),
            limits: (-1e15, 1e15),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "force per cubed displacement of the proof mass; negative softens",
            equation: "F = -k3 xp^3 - k5 xp^5",
        },
        ParameterSpec {
            id: "k5",
            symbol: "k5",
            name: "quintic stiffness",
            unit: "N/m^5",
            default: 0.0,
            range: (-1e12, 1e12),
            limits: (-1e25, 1e25),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "quintic term; opposite in sign to k3 if the spring levels off",
            equation: "F = -k3 xp^3 - k5 xp^5",
        },
        ParameterSpec {
            id: "l",
            symbol: "l",
            name: "length of the sine form",
            unit: "m",
            default: 0.0,
            range: (1e-6, 10.0),
            limits: (0.0, 1e9),
            scale: Scale::Log,
            rank: Rank::Advanced,
            meaning: "displacement over which the spring's force goes round as a sine; 0 or very long is the plain cubic, 1 rad for a pendulum",
            equation: "F = -6 k3 l^2 (xp - l sin(xp/l)) - k5 xp^5",
        },
    ],
    build: |values, _| {
        Box::new(CubicStiffness {
            k3: values[0],
            k5: values[1],
            length: values[2],
        })
    },
    facts: Facts {
        strengths: &["k3", "k5"],
        force_over_displacement: true,
        feature_strength: Some("k3"),
        // Without a cubic term its form is nothing, and a length of 0 is none.
        is_felt: |values, i| i != LENGTH_INDEX || (values[0] != 0.0 && values[LENGTH_INDEX] != 0.0),
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        // Both terms are one force; the length is none.
        form_errors: |values, tolerance| {
            let mut values = values.to_vec();
            values[..LENGTH_INDEX]
                .iter_mut()
                .for_each(|k| *k *= tolerance.share);
            vec![FormError::InWindows(values, Quantity::Displacement)]
        },
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Displacement),
};

/// Which parameter is the length of the sine form.
const LENGTH_INDEX: usize = 2;

/// Lengths of the sine form from which a fit begins, as shares of the largest displacement: half a
/// turn, and less than half of that. From a longer one on, it is the plain cubic to some percent.
const LENGTH_SHARES: [f64; 2] = [0.4, 1.0];

/// Below this angle \[rad\] the difference of the angle and its sine comes from its series.
const SMALL_ANGLE: f64 = 0.5;

/// A cubic term, and the sine form. The quintic term shapes the former, unless a fit's step of that
/// is too large for a device that moves by centimetres.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.is_sprung {
        return Vec::new();
    }
    let k3 = 1e-3 * motion.force / motion.length.powi(3);
    let plain = Start {
        shape: &[1],
        shape_force: Some(motion.length.powi(5)),
        ..Start::signed(&[k3, 0.0, 0.0], 0, &[0])
    };
    let sine = |share: f64| {
        let values = [k3, 0.0, share * motion.length];
        Start::signed(&values, 0, &[0, LENGTH_INDEX])
    };
    std::iter::once(plain)
        .chain(LENGTH_SHARES.map(sine))
        .collect()
}

#[derive(Debug)]
struct CubicStiffness {
    k3: f64,
    k5: f64,
    /// Of the sine form \[m\]; 0 for the plain cubic.
    length: f64,
}

impl CubicStiffness {
    /// What stands in place of `xp^3`: `6 l^2 (xp - l sin(xp/l))`.
    fn cube(&self, xp: f64) -> f64 {
        if self.length == 0.0 {
            return xp * xp * xp;
        }
        let angle = xp / self.length;
        let square = angle * angle;
        if square > SMALL_ANGLE * SMALL_ANGLE {
            return 6.0 * self.length.powi(3) * (angle - angle.sin());
        }
        // To the thirteenth power of the angle: exact to rounding for small ones.
        let series = [156.0, 110.0, 72.0, 42.0, 20.0];
        xp * xp
            * xp
            * series
                .iter()
                .fold(1.0, |sum, term| 1.0 - square / term * sum)
    }
}

impl Action for CubicStiffness {
    fn does_nothing(&self) -> bool {
        self.k3 == 0.0 && self.k5 == 0.0
    }

    fn force_on_proof_mass(&self, at: &Kinematics, _z: &[f64]) -> f64 {
        let square = at.xp * at.xp;
        -self.k3 * self.cube(at.xp) - self.k5 * square * square * at.xp
    }
}

#[cfg(test)]
mod tests {
    use super::super::cubic_stiffness::*;

    fn force(values: [f64; 3], xp: f64) -> f64 {
        let [k3, k5, length] = values;
        let at = Kinematics {
            xp,
            ..Kinematics::default()
        };
        CubicStiffness { k3, k5, length }.force_on_proof_mass(&at, &[])
    }

    #[test]
    fn a_pendulum_is_the_sine_form_on_a_linear_spring() {
        let k = 38.1;
        for angle in [1e-3, 0.3, 0.49, 0.51, 1.2, 2.5, -1.2] {
            let whole = -k * angle + force([-k / 6.0, 0.0, 1.0], angle);
            let pendulum = -k * f64::sin(angle);
            assert!((whole - pendulum).abs() < 1e-14 * k, "{angle}: {whole}");
        }
    }

    #[test]
    fn both_ways_of_computing_it_meet_and_it_ends_in_the_plain_cubic() {
        let l = 3e-5;
        let of = |angle: f64| force([2e4, 0.0, l], angle * l);
        let (below, above) = (of(SMALL_ANGLE), of(SMALL_ANGLE * (1.0 + 1e-15)));
        assert!((below / above - 1.0).abs() < 1e-13, "{below} {above}");
        let plain = force([2e4, -3e12, 0.0], 5e-5);
        let by_powers = -2e4 * 5e-5f64.powi(3) + 3e12 * 5e-5f64.powi(5);
        assert!(
            (plain / by_powers - 1.0).abs() < 1e-14,
            "{plain} {by_powers}"
        );
        for length in [1.0, 1e9] {
            let long = force([2e4, -3e12, length], 5e-5);
            assert!((long / plain - 1.0).abs() < 1e-8, "{length}: {long}");
        }
    }
}
