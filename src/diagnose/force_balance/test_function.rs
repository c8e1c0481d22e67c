//! The test function of the weak form: a smooth bump that vanishes at both ends with its
//! derivatives.
//!
//! `phi(s) = (1 - s^2)^5` over `s = (t - centre) / half_width` in [-1, 1]. An equation multiplied by
//! it and integrated needs no derivative of the readings: these move onto the bump by parts.

/// Power of the bump. Its spectrum falls off with one power more, so that sampling hardly aliases.
const BUMP_POWER: i32 = 5;

/// Integral of the bump over [-1, 1], `2 (2 4 6 8 10) / (3 5 7 9 11)`.
pub const BUMP_INTEGRAL: f64 = 2.0 * 3840.0 / 10395.0;

/// The bump and its first two derivatives with respect to time at a distance `u` \[s\] from its
/// centre, for a half width `w` \[s\].
pub fn bump(u: f64, w: f64) -> [f64; 3] {
    let s = u / w;
    let c = 1.0 - s * s;
    if c <= 0.0 {
        return [0.0; 3];
    }
    let p = f64::from(BUMP_POWER);
    let c3 = c.powi(BUMP_POWER - 2);
    let value = c3 * c * c;
    let slope = -2.0 * p * s * c3 * c;
    let bend = -2.0 * p * c3 * (c - 2.0 * (p - 1.0) * s * s);
    [value, slope / w, bend / (w * w)]
}

/// Integral of the bump from a distance `u` \[s\] from its centre to its end \[s\].
pub fn bump_after(u: f64, w: f64) -> f64 {
    let s = (u / w).clamp(-1.0, 1.0);
    // (1 - s^2)^5 integrated term by term.
    let q = s * s;
    let from_zero =
        s * (1.0 + q * (-5.0 / 3.0 + q * (2.0 + q * (-10.0 / 7.0 + q * (5.0 / 9.0 - q / 11.0)))));
    w * (0.5 * BUMP_INTEGRAL - from_zero)
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
            assert!((bend - by_difference).abs() < 1e-3, "{u}");
            let steps = 20_000;
            let dt = (w - u) / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| value(u + (f64::from(i) + 0.5) * dt))
                .sum();
            assert!((bump_after(u, w) - sum * dt).abs() < 1e-9, "{u}");
        }
        assert!((bump_after(-w, w) - w * BUMP_INTEGRAL).abs() < 1e-15);
        assert_eq!(bump_after(w, w), 0.0);
        assert_eq!(bump(w, w), [0.0; 3]);
    }
}
