//! The first time within a step at which a function falls below zero.

use crate::model::halving::halved;

/// Fractions of a step that are looked at: dense at its start, where the mass has just
/// left the ground, then even.
const EVEN: usize = 32;
const EARLY: [f64; 5] = [
    1.0 / 8192.0,
    1.0 / 2048.0,
    1.0 / 512.0,
    1.0 / 128.0,
    1.0 / 64.0,
];

/// First fraction in `(0, end]` at which `gap` has fallen from at least `-slack` to
/// below it; `slack` > 0 keeps rounding at a start on the ground from counting.
///
/// A dip between two looks is found by the minimum search if the looks around it
/// show a turn. Returns a fraction at which the gap is zero to rounding.
pub(super) fn first_below(gap: impl Fn(f64) -> f64, end: f64, slack: f64) -> Option<f64> {
    let looks = EARLY
        .iter()
        .copied()
        .chain((1..=EVEN).map(|i| i as f64 / EVEN as f64))
        .map(|s| s * end);
    let (mut s0, mut g0) = (0.0, gap(0.0));
    let (mut s1, mut g1) = (0.0, g0);
    for s in looks {
        let g = gap(s);
        if g < -slack {
            return Some(halved(s1, s, |s| gap(s) < 0.0));
        }
        if s1 > s0 && g1 < g0 && g1 < g {
            // A minimum lies between: does it dip below?
            let low = minimum(&gap, s0, s);
            if gap(low) < -slack {
                return Some(halved(s0, low, |s| gap(s) < 0.0));
            }
        }
        (s0, g0) = (s1, g1);
        (s1, g1) = (s, g);
    }
    None
}

/// Place of the minimum of `gap` between `low` and `high` (golden section).
fn minimum(gap: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (high - RATIO * (high - low), low + RATIO * (high - low));
    let (mut ga, mut gb) = (gap(a), gap(b));
    for _ in 0..40 {
        if ga < gb {
            (high, b, gb) = (b, a, ga);
            a = high - RATIO * (high - low);
            ga = gap(a);
        } else {
            (low, a, ga) = (a, b, gb);
            b = low + RATIO * (high - low);
            gb = gap(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_first_crossing_only() {
        let root = first_below(|s| (10.0 * s).cos() - 0.2, 1.0, 1e-14).unwrap();
        assert!((root - 0.2f64.acos() / 10.0).abs() < 1e-15);
        assert_eq!(first_below(|s| 1.0 - s, 0.9, 1e-14), None);
    }

    #[test]
    fn finds_a_shallow_dip_between_looks() {
        // Below zero for a hundredth of the distance between two looks.
        let half = 1e-2 / 64.0;
        let dip = |s: f64| (s - 0.508).powi(2) - half * half;
        let root = first_below(dip, 1.0, 1e-14).unwrap();
        assert!((root - (0.508 - half)).abs() < 1e-9, "{root}");
    }

    #[test]
    fn leaves_the_ground_and_comes_back() {
        // Starts at zero, up, and back at s = 0.01.
        let root = first_below(|s| s * (0.01 - s), 1.0, 1e-14).unwrap();
        assert!((root - 0.01).abs() < 1e-12, "{root}");
    }
}
