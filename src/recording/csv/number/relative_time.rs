//! Times as digits, counted from the first row before anything is rounded.

use super::marks::Marks;
use super::plain_cell::PlainCell;
use super::{Mantissa, digit, sign, written_exponent};
use crate::recording::times::correct_rounding::rounded;
use crate::recording::times::exact_time::ExactTime;

/// Largest power of ten by which the digits of a `u64` are multiplied in an `i128`.
const MAX_QUICK_POWER: u32 = 18;

/// Where times count from, in the unit of the file.
#[derive(Debug, Clone)]
pub(in crate::recording::csv) struct Zero {
    exact: ExactTime,
    /// The same as integers times powers of ten, if it has at most 18 digits.
    quick: Option<QuickZero>,
}

/// A zero of at most 18 digits.
#[derive(Debug, Clone)]
struct QuickZero {
    /// Power of ten of the last digit.
    place: i32,
    /// The zero in units of `10^(place - i)`.
    at: [i128; MAX_QUICK_POWER as usize + 1],
}

impl Zero {
    /// Times count from `exact`.
    pub(in crate::recording::csv) fn new(exact: ExactTime) -> Self {
        let quick = exact.short().map(|(digits, place)| QuickZero {
            place,
            at: std::array::from_fn(|i| i128::from(digits) * 10i128.pow(i as u32)),
        });
        Self { exact, quick }
    }
}

/// A time that was read.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording::csv) struct RelativeTime {
    /// Time since the zero \[s\].
    pub value: f64,
    /// The digits of `value` as an integer, or the largest one if they do not fit. Digits of the
    /// difference, so that a file says the same whatever it counts from.
    pub digits: u64,
    /// Power of ten of the last of them, in the unit of the file.
    pub place: i32,
}

/// Reads the time at the start of `bytes`, in a unit of `10^shift` s; returns it with the number of
/// bytes it took. `None` if there is no finite number. `comma` as in [`super::prefix`].
#[inline]
pub(in crate::recording::csv) fn prefix(
    bytes: &[u8],
    comma: bool,
    shift: i32,
    zero: &Zero,
) -> Option<(RelativeTime, usize)> {
    let (negative, start) = sign(bytes, 0);
    let mantissa = Mantissa::read(bytes, start, comma)?;
    let (written, end) = written_exponent(bytes, mantissa.end);
    let place = mantissa.exponent.saturating_add(written);
    if !mantissa.overflow
        && let Some(origin) = &zero.quick
    {
        let digits = i128::from(mantissa.digits);
        let signed = if negative { -digits } else { digits };
        if let Some((value, power)) = difference((signed, place), origin)
            && let Ok(magnitude) = u64::try_from(value.unsigned_abs())
            && place.saturating_add(shift).unsigned_abs() < 250
        {
            let size = rounded(magnitude, power.saturating_add(shift));
            let time = RelativeTime {
                value: if value < 0 { -size } else { size },
                digits: magnitude,
                place: power,
            };
            return Some((time, end));
        }
    }
    let exact = exact(&bytes[..end], comma)?;
    let since = exact.minus(&zero.exact);
    // The place of the quick way, so that both say the same.
    let place = if zero.exact.is_zero() {
        place
    } else {
        place.min(zero.exact.exponent())
    };
    let digits = since.short().and_then(|(digits, exponent)| {
        let zeros = u32::try_from(exponent.checked_sub(place)?).ok()?;
        digits.unsigned_abs().checked_mul(10u64.checked_pow(zeros)?)
    });
    let time = RelativeTime {
        digits: digits.unwrap_or(u64::MAX),
        place,
        value: since.shifted(shift).seconds(),
    };
    let finite = exact.shifted(shift).seconds().is_finite() && time.value.is_finite();
    finite.then_some((time, end))
}

/// `a - zero` as an integer and its power of ten, as `a` is given, if their powers are near.
#[inline]
fn difference(a: (i128, i32), zero: &QuickZero) -> Option<(i128, i32)> {
    if zero.at[0] == 0 {
        return Some(a);
    }
    let apart = a.1.abs_diff(zero.place);
    // At most 2^64 times 10^18: below 2^124.
    if a.1 <= zero.place {
        let zero = zero.at.get(apart as usize)?;
        Some((a.0 - zero, a.1))
    } else {
        let power = (apart <= MAX_QUICK_POWER).then(|| 10i128.pow(apart))?;
        Some((a.0 * power - zero.at[0], zero.place))
    }
}

/// A whole cell as [`prefix`] reads it; `None` if it is not a finite number.
pub(in crate::recording::csv) fn cell(
    text: &[u8],
    comma: bool,
    shift: i32,
    zero: &Zero,
) -> Option<RelativeTime> {
    let cell = PlainCell::of(text, comma);
    if !cell.negative {
        let (time, taken) = prefix(&cell.text, cell.comma, shift, zero)?;
        return (taken == cell.text.len()).then_some(time);
    }
    let mut signed = b"-".to_vec();
    signed.extend_from_slice(&cell.text);
    let (time, taken) = prefix(&signed, cell.comma, shift, zero)?;
    (taken == signed.len()).then_some(time)
}

/// A time as decimal text with the marks of its column, without what surrounds it; `None` if the marks
/// are others.
pub(in crate::recording::csv) fn plain_text(text: &[u8], marks: Marks) -> Option<Vec<u8>> {
    let cell = PlainCell::of(text, false);
    let plain = marks.plain(&cell.text)?;
    let sign: &[u8] = if cell.negative { b"-" } else { b"" };
    Some([sign, &plain].concat())
}

/// A whole cell with all its digits, in the unit of the file; `None` if it is not a number that is
/// finite in a unit of `10^shift` s.
pub(in crate::recording::csv) fn exact_cell(
    text: &[u8],
    comma: bool,
    shift: i32,
) -> Option<ExactTime> {
    // What is no time as it stands is none here.
    cell(text, comma, shift, &Zero::new(ExactTime::default()))?;
    let cell = PlainCell::of(text, comma);
    let exact = exact(&cell.text, cell.comma)?;
    Some(if cell.negative {
        ExactTime::default().minus(&exact)
    } else {
        exact
    })
}

/// All digits of a number that fills `bytes`.
fn exact(bytes: &[u8], comma: bool) -> Option<ExactTime> {
    let (negative, start) = sign(bytes, 0);
    let mantissa = Mantissa::read(bytes, start, comma)?;
    let (written, _) = written_exponent(bytes, mantissa.end);
    let digits = (start..mantissa.end).filter_map(|p| digit(bytes, p));
    let exponent = mantissa.exponent.saturating_add(written);
    Some(ExactTime::new(negative, digits.collect(), exponent))
}

#[cfg(test)]
mod tests {
    use super::super::relative_time::*;
    use proptest::prelude::*;

    fn read(text: &str, zero: &str, shift: i32) -> f64 {
        let zero = Zero::new(exact_cell(zero.as_bytes(), true, shift).unwrap());
        cell(text.as_bytes(), true, shift, &zero).map_or(f64::NAN, |t| t.value)
    }

    #[test]
    fn digits_are_subtracted_before_they_are_rounded() {
        assert_eq!(read("1732752000.00002", "1732752000.00000", 0), 0.00002);
        assert_eq!(read("1732752000,00002", "1732752000", 0), 0.00002);
        assert_eq!(read("1732752000000.02", "1732752000000", -3), 0.00002);
        assert_eq!(read("-0.00998", "-1e-2", 0), 0.00002);
        assert_eq!(read("\u{2212}0.00998", "\u{2212}1e-2", 0), 0.00002);
        assert_eq!(read("1'732'752'000.00002", "1'732'752'000", 0), 0.00002);
        assert_eq!(read("0.1", "0", 0), 0.1);
        assert_eq!(read("-0", "0", 0), 0.0);
        // More digits than any integer holds.
        assert_eq!(
            read(
                "1234567890123456789012345678901234567890123456789.00002",
                "1234567890123456789012345678901234567890123456789",
                0
            ),
            0.00002
        );
        assert_eq!(read("1e300", "1e-300", 0), 1e300);
        assert_eq!(read("1e-100000", "0", 0), 0.0);
        for text in ["", "-", "1e999", "nan", "1.2.3", "\u{2212}-3"] {
            assert!(read(text, "0", 0).is_nan(), "{text}");
        }
    }

    proptest! {
        /// From zero, a time is the number that it is; from elsewhere, the same after a shift of
        /// both by any amount.
        #[test]
        fn a_shift_of_both_changes_no_bit(
            base in -4_000_000_000_000_000_000i64..4_000_000_000_000_000_000,
            steps in prop::collection::vec(0u32..2_000_000_000, 1..20),
            places in 0u32..15, shift in -9i32..1, exponent in any::<bool>(),
        ) {
            let written = |n: i128| {
                let ten = 10i128.pow(places);
                let (sign, n) = (if n < 0 { "-" } else { "" }, n.abs());
                if exponent { format!("{sign}{n}e-{places}") }
                else if places == 0 { format!("{sign}{n}") }
                else { format!("{sign}{}.{:0width$}", n / ten, n % ten, width = places as usize) }
            };
            let zero = written(i128::from(base));
            for step in steps {
                let plain = written(i128::from(step));
                let moved = written(i128::from(base) + i128::from(step));
                let expected = super::super::cell(plain.as_bytes(), true, shift);
                prop_assert_eq!(read(&plain, "0", shift).to_bits(), expected.to_bits());
                prop_assert_eq!(read(&moved, &zero, shift).to_bits(), expected.to_bits());
            }
        }

        #[test]
        fn the_quick_way_and_the_long_way_agree(
            a in any::<i64>(), b in any::<i64>(), place in -20i32..3, apart in -25i32..25, shift in -9i32..1,
        ) {
            let (a, b) = (format!("{a}e{place}"), format!("{b}e{}", place + apart));
            let exact = |text: &str| exact_cell(text.as_bytes(), false, shift).unwrap();
            let long = exact(&a).minus(&exact(&b)).shifted(shift).seconds();
            prop_assert_eq!(read(&a, &b, shift).to_bits(), (long + 0.0).to_bits());
        }

        #[test]
        fn never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..80), shift in -20..20) {
            let zero = Zero::new(ExactTime::from_seconds(1.5e9));
            let _ = cell(&bytes, true, shift, &zero);
            let _ = exact_cell(&bytes, false, shift);
        }
    }
}
