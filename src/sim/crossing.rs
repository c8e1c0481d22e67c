//! The first time within a step at which a function falls below zero.

/// Fractions of a step that are looked at: dense at its start, where the mass has just
/// left the ground, then even.
const EVEN_LOOKS: usize = 32;
const EARLY_LOOKS: [f64; 5] = [
    1.0 / 8192.0,
    1.0 / 2048.0,
    1.0 / 512.0,
    1.0 / 128.0,
    1.0 / 64.0,
];

/// The fractions up to `end` that are looked at: those at the start, and the even ones.
pub(super) fn looks(end: f64) -> ([f64; EARLY_LOOKS.len()], [f64; EVEN_LOOKS]) {
    let even = std::array::from_fn(|i| (i + 1) as f64 / EVEN_LOOKS as f64 * end);
    (EARLY_LOOKS.map(|s| s * end), even)
}

/// First fraction in `(0, end]` at which `gap` has fallen from at least `-slack` to
/// below it; `slack` > 0 keeps rounding at a start on the ground from counting.
///
/// A dip between two looks is found by the minimum search if the looks around it
/// show a turn. Returns a fraction at which the gap is zero to rounding.
pub(super) fn first_below(gap: impl Fn(f64) -> f64, end: f64, slack: f64) -> Option<f64> {
    let (early, even) = looks(end);
    let looks = early.into_iter().chain(even);
    let seen = looks.map(|s| (s, gap(s)));
    first_below_seen(&gap, (gap(0.0), seen), slack, f64::INFINITY)
}

/// The same for a gap that is known at the start and at the looks, these as fractions and gaps in
/// order, and that between two of them is nowhere lower by more than `dip` than the line through
/// both.
pub(super) fn first_below_seen(
    gap: impl Fn(f64) -> f64,
    (start, seen): (f64, impl IntoIterator<Item = (f64, f64)>),
    slack: f64,
    dip: f64,
) -> Option<f64> {
    let (mut s0, mut g0) = (0.0, start);
    let (mut s1, mut g1) = (0.0, g0);
    for (s, g) in seen {
        if g < -slack {
            return Some(fallen(&gap, (s1, g1), (s, g), slack));
        }
        if s1 > s0 && g1 < g0 && g1 < g && g1 - dip < -slack {
            // A minimum lies between: does it dip below?
            let low = minimum(&gap, s0, s);
            let least = gap(low);
            if least < -slack {
                return Some(fallen(&gap, (s0, g0), (low, least), slack));
            }
        }
        (s0, g0) = (s1, g1);
        (s1, g1) = (s, g);
    }
    None
}

/// The place between `low` and `high`, given with the gaps there, at which the gap falls below zero,
/// to rounding; it is below zero there (Illinois method with halvings). A gap of no more than
/// `slack` may be rounding: then what is beyond decides.
fn fallen(
    gap: &impl Fn(f64) -> f64,
    (mut low, mut above): (f64, f64),
    (mut high, mut below): (f64, f64),
    slack: f64,
) -> f64 {
    /// Steps at most: each third halves what is left.
    const MAX_ITERATIONS: usize = 200;
    let least = f64::EPSILON * high;
    let mut fell = None;
    for i in 0..MAX_ITERATIONS {
        let width = high - low;
        let middle = low + 0.5 * width;
        // A gap that is no number ends it, too.
        if !above.is_finite() || width <= 2.0 * least || middle <= low || middle >= high {
            break;
        }
        let at = if above <= slack || i % 3 == 2 {
            middle
        } else {
            let at = high - width * below / (below - above);
            at.clamp(low + least, high - least)
        };
        let now = gap(at);
        let falls = now < 0.0;
        // An end that stays has less of a say.
        let again = fell == Some(falls);
        if falls {
            (high, below) = (at, now);
            above *= if again { 0.5 } else { 1.0 };
        } else {
            (low, above) = (at, now);
            below *= if again { 0.5 } else { 1.0 };
        }
        fell = Some(falls);
    }
    high
}

/// Place of the minimum of `gap` between `low` and `high` (golden section).
fn minimum(gap: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (
        high - GOLDEN_RATIO * (high - low),
        low + GOLDEN_RATIO * (high - low),
    );
    let (mut ga, mut gb) = (gap(a), gap(b));
    for _ in 0..40 {
        if ga < gb {
            (high, b, gb) = (b, a, ga);
            a = high - GOLDEN_RATIO * (high - low);
            ga = gap(a);
        } else {
            (low, a, ga) = (a, b, gb);
            b = low + GOLDEN_RATIO * (high - low);
            gb = gap(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::super::crossing::*;

    #[test]
    fn finds_the_first_crossing_only() {
        let root = first_below(|s| (10.0 * s).cos() - 0.2, 1.0, 1e-14).unwrap();
        assert!((root - 0.2f64.acos() / 10.0).abs() < 1e-15);
        assert_eq!(first_below(|s| 1.0 - s, 0.9, 1e-14), None);
    }

    #[test]
    fn a_gap_that_jumps_or_hardly_falls_is_placed_to_rounding() {
        for at in [1e-6, 0.3, 0.77] {
            let gaps: [&dyn Fn(f64) -> f64; 4] = [
                &|s| if s < at { 1.0 } else { -1e-9 },
                &|s| at - s,
                &|s| (at - s).powi(5),
                &|s| 1.0 - (s / at).powi(40),
            ];
            for gap in gaps {
                let asked = std::cell::Cell::new(0);
                let counted = |s: f64| {
                    asked.set(asked.get() + 1);
                    gap(s)
                };
                let found = fallen(&counted, (0.0, gap(0.0)), (1.0, gap(1.0)), 0.0);
                assert!(gap(found) < 0.0);
                assert!((found - at).abs() < 1e-15, "{found} {at}");
                assert!(asked.get() < 170, "{}", asked.get());
            }
        }
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
