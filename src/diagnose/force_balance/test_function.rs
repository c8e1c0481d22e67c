//! The test function of the weak form: a smooth bump that vanishes at both ends with its
//! derivatives.
//!
//! `phi(s) = (1 - s^2)^10` over `s = (t - centre) / half_width` in [-1, 1]. An equation multiplied by
//! it and integrated needs no derivative of the readings: these move onto the bump by parts.

/// Power of the bump. Its spectrum falls off with one power more: what is ten times as fast as the
/// motion that it is made for, a second mode or the sampling, all but vanishes in the integrals.
const BUMP_POWER: usize = 10;

/// The bump and its first two derivatives with respect to time at a distance `u` \[s\] from its
/// centre, for a half width `w` \[s\].
pub fn bump(u: f64, w: f64) -> [f64; 3] {
    let s = u / w;
    let c = 1.0 - s * s;
    if c <= 0.0 {
        return [0.0; 3];
    }
    let p = BUMP_POWER as f64;
    let rest = c.powi(BUMP_POWER as i32 - 2);
    let value = rest * c * c;
    let slope = -2.0 * p * s * rest * c;
    let bend = -2.0 * p * rest * (c - 2.0 * (p - 1.0) * s * s);
    [value, slope / w, bend / (w * w)]
}

/// Integral of the bump from a distance `u` \[s\] from its centre to its end \[s\].
pub fn bump_after(u: f64, w: f64) -> f64 {
    let from_zero = |s: f64| {
        // Term by term: binomial coefficients with alternating signs.
        let (mut sum, mut term) = (0.0, s);
        for k in 0..=BUMP_POWER {
            sum += term / (2 * k + 1) as f64;
            term *= -s * s * (BUMP_POWER - k) as f64 / (k + 1) as f64;
        }
        sum
    };
    w * (from_zero(1.0) - from_zero((u / w).clamp(-1.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::super::test_function::*;

    #[test]
    fn derivatives_and_integral_are_those_of_the_bump() {
        let (w, h) = (0.3, 1e-5);
        for u in [-0.29, -0.17, -0.05, 0.0, 0.11, 0.26] {
            let value = |u: f64| bump(u, w)[0];
            let [_, slope, bend] = bump(u, w);
            let by_difference = (value(u + h) - value(u - h)) / (2.0 * h);
            assert!((slope - by_difference).abs() < 1e-6, "{u}");
            let by_difference = (value(u + h) - 2.0 * value(u) + value(u - h)) / (h * h);
            assert!((bend - by_difference).abs() < 3e-3, "{u}");
            let steps = 20_000;
            let dt = (w - u) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| value(u + (f64::from(i) + 0.5) * dt))
                .sum();
            assert!((bump_after(u, w) - sum * dt).abs() < 1e-9, "{u}");
        }
        assert!((bump_after(-w, w) - 2.0 * bump_after(0.0, w)).abs() < 1e-12);
        assert_eq!(bump_after(w, w), 0.0);
        assert_eq!(bump(w, w), [0.0; 3]);
    }
}
