//! The number a person would have set.
//!
//! Function generators are set to round numbers. Where the samples leave an interval and a number
//! in it is so round that it would hardly lie there by accident, it is the better estimate; where
//! none is, nothing is lost.

use super::thresholds::MAX_ACCIDENT_SHARE;

/// The roundest number between `low` and `high`, if its being there is no accident. Round are
/// multiples of 1, 2 or 5 times a power of ten; zero is the roundest of all.
///
/// # Examples
/// ```ignore
/// assert_eq!(round_between(14.9997, 15.0004), Some(15.0));
/// assert_eq!(round_between(14.93, 14.97), None);
/// ```
pub fn round_between(low: f64, high: f64) -> Option<f64> {
    if !(low.is_finite() && high.is_finite() && low <= high) {
        return None;
    }
    if low <= 0.0 && high >= 0.0 {
        return Some(0.0);
    }
    let size = low.abs().max(high.abs());
    let top = size.log10().ceil() as i32;
    for decade in (top - 12..=top).rev() {
        for factor in [5.0, 2.0, 1.0] {
            // A power below one is divided by, so that 0.1 comes out as 0.1.
            let multiple = |k: f64| {
                if decade >= 0 {
                    k * factor * 10f64.powi(decade)
                } else {
                    k * factor / 10f64.powi(-decade)
                }
            };
            let step = multiple(1.0);
            if high - low > MAX_ACCIDENT_SHARE * step {
                return None;
            }
            let middle = 0.5 * (low + high);
            let found = multiple((middle / step).round());
            if found >= low && found <= high && found != 0.0 {
                return Some(found);
            }
        }
    }
    None
}

/// Whether a voltage is one of two digits, as people set them.
pub fn is_two_digit_setting(voltage: f64) -> bool {
    let two_digits: f64 = format!("{voltage:.1e}").parse().unwrap_or(f64::NAN);
    (two_digits - voltage).abs() < 1e-6 * voltage.abs()
}

#[cfg(test)]
mod tests {
    use super::round_between;

    #[test]
    fn a_setting_is_found_and_an_accident_is_not() {
        assert_eq!(round_between(14.9997, 15.0004), Some(15.0));
        assert_eq!(round_between(-1e-5, 0.0), Some(0.0));
        assert_eq!(round_between(0.099_98, 0.1), Some(0.1));
        assert_eq!(round_between(-8.001, -7.9994), Some(-8.0));
        assert_eq!(round_between(14.93, 14.97), None);
        assert_eq!(round_between(12.4999, 12.5001), Some(12.5));
        assert_eq!(round_between(f64::NAN, 1.0), None);
        // Nothing as round as a tenth is surprising within a tenth.
        assert_eq!(round_between(0.31, 0.39), None);
    }
}
