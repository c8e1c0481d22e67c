//! Bisection: the place where a condition becomes true.

/// Most halvings: enough to place a step of any size to rounding.
const MAX_HALVINGS: usize = 80;

/// The place between `low`, where `holds` is not true, and `high`, where it is, at which it
/// becomes so, to rounding; it is true there.
pub fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..MAX_HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::super::bisection::*;

    #[test]
    fn the_place_is_found_to_rounding_on_the_side_where_the_condition_holds() {
        for (low, high, at) in [
            (0.0, 1.0, 2f64.sqrt() / 2.0),
            (3.0, 5.0, 3.0),
            (-1e-9, 7.0, 0.0),
        ] {
            let found = bisect(low, high, |x| x > at);
            assert!(found > at, "{found} {at}");
            assert!(
                found - at <= 2.0 * f64::EPSILON * high.abs().max(low.abs()),
                "{found} {at}"
            );
        }
        assert_eq!(bisect(0.0, 1.0, |_| false), 1.0);
    }
}
