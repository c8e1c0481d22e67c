//! Decimal text to `f64`, correctly rounded, with the unit's power of ten applied
//! to the text: `58.1` in um is read as `58.1e-6`, not as `58.1 * 1e-6`, so that a
//! written file comes back bit for bit.

pub(super) mod calendar;
pub(super) mod kinds;
pub(super) mod marks;
mod plain_cell;
pub(super) mod relative_time;
pub(super) mod text_marks;

use self::marks::Marks;
use self::plain_cell::PlainCell;
use crate::recording::times::correct_rounding::quickly_rounded;

/// Largest mantissa that takes another digit without leaving a `u64`.
const MAX_EXTENDABLE_MANTISSA: u64 = (u64::MAX - 9) / 10;

/// Reads the number at the start of `bytes`, times `10^shift`; returns it with the
/// number of bytes it took. `None` if there is no number. With `comma` the decimal
/// mark may be a comma or a point, else a point only.
#[inline]
pub(super) fn prefix(bytes: &[u8], comma: bool, shift: i32) -> Option<(f64, usize)> {
    let (negative, start) = sign(bytes, 0);
    let mantissa = Mantissa::read(bytes, start, comma)?;
    let (written, end) = written_exponent(bytes, mantissa.end);
    let Mantissa {
        digits,
        overflow,
        mark,
        exponent,
        ..
    } = mantissa;
    let total = exponent.saturating_add(written).saturating_add(shift);
    let quick = if overflow {
        None
    } else {
        quickly_rounded(digits, total)
    };
    let magnitude = match quick {
        Some(value) => value,
        None => by_library(
            &bytes[start..mantissa.end],
            mark.map(|m| m - start),
            written.saturating_add(shift),
        )?,
    };
    Some((if negative { -magnitude } else { magnitude }, end))
}

/// Whether there is a minus at `at`, and where the number goes on after a sign.
#[inline]
fn sign(bytes: &[u8], at: usize) -> (bool, usize) {
    match bytes.get(at) {
        Some(b'-') => (true, at + 1),
        Some(b'+') => (false, at + 1),
        _ => (false, at),
    }
}

/// The value of the decimal digit at `at`, if there is one.
#[inline]
fn digit(bytes: &[u8], at: usize) -> Option<u8> {
    bytes
        .get(at)
        .map(|b| b.wrapping_sub(b'0'))
        .filter(|d| *d < 10)
}

/// The digits of a number before its written exponent.
struct Mantissa {
    /// All digits as one integer, without the decimal mark.
    digits: u64,
    /// Whether the integer does not fit into a `u64`.
    overflow: bool,
    /// Index of the decimal mark.
    mark: Option<usize>,
    /// Minus the number of digits after the mark.
    exponent: i32,
    /// Index after the last digit.
    end: usize,
}

impl Mantissa {
    /// Reads the digits from `start` on; `None` if there are none.
    #[inline]
    fn read(bytes: &[u8], start: usize, comma: bool) -> Option<Self> {
        let mut p = start;
        let mut value: u64 = 0;
        let mut overflow = false;
        let mut count = 0usize;
        let mut exponent: i32 = 0;
        while let Some(d) = digit(bytes, p) {
            overflow |= value > MAX_EXTENDABLE_MANTISSA;
            value = value.wrapping_mul(10).wrapping_add(u64::from(d));
            count += 1;
            p += 1;
        }
        let mut mark = None;
        if let Some(&b) = bytes.get(p)
            && (b == b'.' || (comma && b == b','))
        {
            mark = Some(p);
            p += 1;
            let fraction = p;
            while let Some(d) = digit(bytes, p) {
                overflow |= value > MAX_EXTENDABLE_MANTISSA;
                value = value.wrapping_mul(10).wrapping_add(u64::from(d));
                p += 1;
            }
            count += p - fraction;
            exponent = -i32::try_from(p - fraction).ok()?;
        }
        (count > 0).then_some(Self {
            digits: value,
            overflow,
            mark,
            exponent,
            end: p,
        })
    }
}

/// The exponent written as `e-3` or `D-3` at `at` (0 if there is none), and where the number ends.
#[inline]
fn written_exponent(bytes: &[u8], at: usize) -> (i32, usize) {
    // D: double precision in Fortran.
    let Some(b'e' | b'E' | b'd' | b'D') = bytes.get(at) else {
        return (0, at);
    };
    let (down, first) = sign(bytes, at + 1);
    let mut written: i32 = 0;
    let mut q = first;
    while let Some(d) = digit(bytes, q) {
        // Beyond this everything is zero or infinite anyway.
        written = (written * 10 + i32::from(d)).min(100_000);
        q += 1;
    }
    if q > first {
        (if down { -written } else { written }, q)
    } else {
        (0, at)
    }
}

/// The general case: the digits with a plain decimal point and the shifted exponent
/// appended, parsed by the standard library.
fn by_library(mantissa: &[u8], mark: Option<usize>, exponent: i32) -> Option<f64> {
    let mut buffer = [0u8; 64];
    let parse = |text: &[u8]| std::str::from_utf8(text).ok()?.parse::<f64>().ok();
    let n = mantissa.len();
    if n + 8 > buffer.len() {
        let mut text: Vec<u8> = mantissa.to_vec();
        if let Some(m) = mark {
            text[m] = b'.';
        }
        text.extend_from_slice(format!("e{exponent}").as_bytes());
        return parse(&text);
    }
    buffer[..n].copy_from_slice(mantissa);
    if let Some(m) = mark {
        buffer[m] = b'.';
    }
    let mut end = n;
    if exponent != 0 {
        buffer[end] = b'e';
        end += 1;
        if exponent < 0 {
            buffer[end] = b'-';
            end += 1;
        }
        // At most six digits: `exponent` is bounded by its reader.
        let mut remaining = exponent.unsigned_abs().min(999_999);
        let mut reversed = [0u8; 6];
        let mut k = 0;
        while remaining > 0 {
            reversed[k] = b'0' + (remaining % 10) as u8;
            remaining /= 10;
            k += 1;
        }
        while k > 0 {
            k -= 1;
            buffer[end] = reversed[k];
            end += 1;
        }
    }
    parse(&buffer[..end])
}

/// A whole cell as a number times `10^shift`; NaN if it is anything else (text,
/// empty, infinite). Quotes, a typographic minus and marks between thousands are understood.
pub(super) fn cell(text: &[u8], comma: bool, shift: i32) -> f64 {
    let cell = PlainCell::of(text, comma);
    match prefix(&cell.text, cell.comma, shift) {
        Some((value, taken)) if taken == cell.text.len() && value.is_finite() => {
            if cell.negative {
                -value
            } else {
                value
            }
        }
        _ => f64::NAN,
    }
}

/// A whole cell as a number times `10^shift` with the marks of its column; NaN if it is anything else.
pub(super) fn cell_with(text: &[u8], marks: Marks, shift: i32) -> f64 {
    let cell = PlainCell::of(text, false);
    let Some(plain) = marks.plain(&cell.text) else {
        return f64::NAN;
    };
    match prefix(&plain, false, shift) {
        Some((value, taken)) if taken == plain.len() && value.is_finite() => {
            if cell.negative {
                -value
            } else {
                value
            }
        }
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::super::number::*;
    use proptest::prelude::*;

    fn read(text: &str, shift: i32) -> f64 {
        cell(text.as_bytes(), false, shift)
    }

    #[test]
    fn reads_the_usual_forms() {
        assert_eq!(read("58.1", -6), 58.1e-6);
        assert_eq!(read("-0.5", 0), -0.5);
        assert_eq!(read("+.5", 0), 0.5);
        assert_eq!(read("5.", 0), 5.0);
        assert_eq!(read(" 1e-3 ", -3), 1e-6);
        assert_eq!(read("1E+05", 0), 1e5);
        assert_eq!(read("1.5D-03", 0), 1.5e-3);
        assert_eq!(read("\u{2212}3", 0), -3.0);
        assert_eq!(read("\"1,5\"", 0), 1.5);
        assert_eq!(cell(b"1,5", true, 0), 1.5);
        assert_eq!(
            read(
                "0.1234567890123456789012345678901234567890123456789012345678901234567890",
                0
            ),
            0.12345678901234568
        );
        assert_eq!(
            read("123456789012345678901234567890", -6),
            1.234_567_890_123_456_8e23
        );
        assert_eq!(read("18446744073709551616", 0), 18446744073709551616.0);
    }

    #[test]
    fn thousands_are_marked_without_doubt_or_not_at_all() {
        assert_eq!(read("1'732'752'000.5", 0), 1_732_752_000.5);
        assert_eq!(read("-12\u{202f}345", -3), -12.345);
        assert_eq!(cell("1\u{a0}000,25".as_bytes(), true, 0), 1000.25);
        for text in ["1'7", "1'7320", "'100", "1234'567", "1''000", "1'000'"] {
            assert!(read(text, 0).is_nan(), "{text}");
        }
    }

    #[test]
    fn anything_else_is_missing() {
        for text in [
            "",
            "-",
            ".",
            "e5",
            "1.2.3",
            "1,5",
            "abc",
            "1e999",
            "nan",
            "inf",
            "--1",
            "0x10",
            "1e",
            "\u{2212}-3",
        ] {
            assert!(read(text, 0).is_nan(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn agrees_with_the_library(value in proptest::num::f64::NORMAL | proptest::num::f64::ZERO | proptest::num::f64::SUBNORMAL) {
            let text = format!("{value}");
            prop_assert_eq!(read(&text, 0), value);
            let text = format!("{value:e}");
            prop_assert_eq!(read(&text, 0), value);
            // Every digit and a unit, as a simulation writes them.
            let shifted = format!("{value:e}").replace('e', " ");
            let (digits, exponent) = shifted.split_once(' ').unwrap();
            let exponent: i32 = exponent.parse().unwrap();
            let plain = digits.replace(['.', '-'], "");
            let sign = if value < 0.0 { "-" } else { "" };
            let text = format!("{sign}{plain}");
            prop_assert_eq!(read(&text, exponent - plain.len() as i32 + 1), value);
            let short = format!("{value:.6e}");
            prop_assert_eq!(read(&short, 0), short.parse::<f64>().unwrap());
        }

        /// Long mantissas over small powers of ten: the double-length division.
        #[test]
        fn long_mantissas_round_correctly(mantissa in (1u64 << 53)..u64::MAX, shift in -25i32..3) {
            let expected: f64 = format!("{mantissa}e{shift}").parse().unwrap();
            prop_assert_eq!(read(&mantissa.to_string(), shift), expected);
        }

        #[test]
        fn never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..80), shift in -20..20) {
            let _ = cell(&bytes, true, shift);
            let _ = prefix(&bytes, false, shift);
        }
    }
}
