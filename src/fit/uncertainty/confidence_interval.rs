//! Confidence interval of a parameter from its profile likelihood.

use super::profile_likelihood::ProfilePoint;
use crate::fit::thresholds::CHI2_95_ONE_DOF;

/// Lower and upper end of the 95 % interval: where the cost has risen by [`CHI2_95_ONE_DOF`] from
/// the lowest point of the profile. `None` for an end beyond the values tried. Between points the
/// root of the rise is interpolated linearly, which is exact for a parabola.
///
/// # Examples
/// ```
/// use impactscope::fit::ProfilePoint;
/// use impactscope::fit::uncertainty::confidence_interval::interval;
///
/// // A parabola around 5 with a standard error of 0.1.
/// let points: Vec<ProfilePoint> = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0]
///     .map(|k: f64| ProfilePoint { value: 5.0 + 0.1 * k, rise: k * k })
///     .to_vec();
/// let [low, high] = interval(&points).map(|end| end.expect("an end"));
/// assert!((low - 4.804).abs() < 1e-3 && (high - 5.196).abs() < 1e-3);
/// ```
pub fn interval(points: &[ProfilePoint]) -> [Option<f64>; 2] {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.value.total_cmp(&b.value));
    let best = (0..sorted.len()).min_by(|&a, &b| sorted[a].rise.total_cmp(&sorted[b].rise));
    let Some(best) = best else {
        return [None, None];
    };
    let mut down = sorted[..=best].to_vec();
    down.reverse();
    [crossing(&down), crossing(&sorted[best..])]
}

/// Where the rise first passes [`CHI2_95_ONE_DOF`] on the way along `points`.
fn crossing(points: &[ProfilePoint]) -> Option<f64> {
    let limit = CHI2_95_ONE_DOF.sqrt();
    points.windows(2).find_map(|pair| {
        let [a, b] = [pair[0], pair[1]].map(|p| p.rise.max(0.0).sqrt());
        let crosses = a < limit && b >= limit;
        crosses.then(|| {
            let share = (limit - a) / (b - a);
            pair[0].value + share * (pair[1].value - pair[0].value)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::confidence_interval::*;

    fn points(of: impl Fn(f64) -> f64) -> Vec<ProfilePoint> {
        // In no order, as they may come.
        [0.0, -1.0, 1.0, -2.0, 2.0, 3.0, -3.0]
            .map(|k| ProfilePoint {
                value: 5.0 + 0.1 * k,
                rise: of(k),
            })
            .to_vec()
    }

    #[test]
    fn a_parabola_gives_nearly_two_standard_errors() {
        let [low, high] = interval(&points(|k| k * k)).map(Option::unwrap);
        let half = 0.1 * CHI2_95_ONE_DOF.sqrt();
        assert!((low - 5.0 + half).abs() < 1e-12 && (high - 5.0 - half).abs() < 1e-12);
    }

    #[test]
    fn a_flat_side_has_no_end() {
        let [low, high] = interval(&points(|k| if k < 0.0 { k * k } else { 0.1 * k }));
        assert!(low.is_some());
        assert_eq!(high, None);
        assert_eq!(interval(&points(|_| 0.0)), [None, None]);
        assert_eq!(interval(&[]), [None, None]);
    }
}
