//! The shortest decimal number in an interval: what a person would have set on the recorder.

use super::correct_rounding::rounded;

/// `digits * 10^exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ShortNumber {
    pub digits: u64,
    pub exponent: i32,
}

impl ShortNumber {
    /// The number with the fewest digits in `low..=high`, both positive; among equals the one
    /// nearest to the middle. `None` if the interval holds no positive number.
    pub(super) fn within(low: f64, high: f64) -> Option<Self> {
        if !(low > 0.0 && high >= low && high.is_finite()) {
            return None;
        }
        let middle = 0.5 * (low + high);
        let magnitude = middle.log10().floor() as i32;
        (0..17).find_map(|places| {
            let exponent = magnitude - places;
            // Scaled by two factors, because one may leave the range of an f64.
            let scale =
                |x: f64| x * 10f64.powi(-exponent / 2) * 10f64.powi(-exponent + exponent / 2);
            [scale(middle).round(), scale(high).floor()]
                .into_iter()
                .filter(|d| *d >= 1.0 && *d < 1e18)
                .map(|d| Self {
                    digits: d as u64,
                    exponent,
                })
                .find(|number| (low..=high).contains(&number.value()))
        })
    }

    /// The nearest `f64`.
    pub(super) fn value(self) -> f64 {
        rounded(self.digits, self.exponent)
    }

    /// Digits that a person would write.
    fn length(self) -> u32 {
        let mut digits = self.digits;
        while digits > 0 && digits.is_multiple_of(10) {
            digits /= 10;
        }
        digits.checked_ilog10().map_or(1, |d| d + 1)
    }
}

/// An interval between samples, by the number that a recorder was set to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Interval {
    /// The interval itself \[s\], such as 20 us.
    Period(ShortNumber),
    /// Its inverse \[Hz\], such as 48 kHz, where that has fewer digits.
    Rate(ShortNumber),
    /// Neither is short.
    Plain(f64),
}

impl Interval {
    /// The interval in `low..=high` \[s\] that takes the fewest digits.
    pub(super) fn within(low: f64, high: f64) -> Self {
        let period = ShortNumber::within(low, high);
        let rate = ShortNumber::within(1.0 / high, 1.0 / low);
        match (period, rate) {
            (Some(p), Some(r)) if r.length() < p.length() => Self::Rate(r),
            (Some(p), _) => Self::Period(p),
            _ => Self::Plain(0.5 * (low + high)),
        }
    }

    /// The interval \[s\].
    pub(super) fn seconds(self) -> f64 {
        self.times(1)
    }

    /// `count` intervals \[s\], rounded once.
    pub(super) fn times(self, count: u64) -> f64 {
        match self {
            Self::Period(p) => match p.digits.checked_mul(count) {
                Some(digits) => rounded(digits, p.exponent),
                None => count as f64 * p.value(),
            },
            Self::Rate(r) => {
                let power = r.exponent.unsigned_abs();
                let exact = 10u64.checked_pow(power);
                match (exact, r.exponent < 0) {
                    (Some(power), true) => (count as f64 * power as f64) / r.digits as f64,
                    (Some(power), false) => count as f64 / (r.digits as f64 * power as f64),
                    (None, _) => count as f64 / r.value(),
                }
            }
            Self::Plain(seconds) => count as f64 * seconds,
        }
    }
}
