//! Numbers in their shortest digits, with the point where a unit puts it.

use std::io::Write;

/// Room for the shortest digits of any number, with leading and trailing zeros.
const MAX_DIGITS: usize = 40;
/// Zeros between the point and the digits of a number in plain notation.
const PLAIN_ZEROS: [u8; 17] = [b'0'; 17];

/// Appends `value * 10^shift` exactly: the shortest digits of `value`, the point
/// placed by its own exponent plus `shift`.
pub(super) fn put(text: &mut Vec<u8>, value: f64, shift: i32) {
    if !value.is_finite() {
        text.extend_from_slice(b"NaN");
        return;
    }
    if value == 0.0 {
        text.push(b'0');
        return;
    }
    if value < 0.0 {
        text.push(b'-');
    }
    let between;
    let mut buffer = zmij::Buffer::new();
    let decimal = if may_lie_between(value) {
        between = format!("{:e}", value.abs());
        between.as_str()
    } else {
        buffer.format_finite(value.abs())
    };
    let mut room = [0; MAX_DIGITS];
    let (first, rest, point) = digits_of(decimal.as_bytes(), &mut room);
    place(text, first, rest, point + shift);
}

/// Appends a first digit and the rest of them, `point` of all of which stand before the point.
fn place(text: &mut Vec<u8>, first: u8, rest: &[u8], point: i32) {
    let n = rest.len() as i32 + 1;
    if (1..=17).contains(&point) {
        text.push(first);
        if point >= n {
            text.extend_from_slice(rest);
            text.extend_from_slice(&PLAIN_ZEROS[..(point - n) as usize]);
        } else {
            let (whole, part) = rest.split_at(point as usize - 1);
            text.extend_from_slice(whole);
            text.push(b'.');
            text.extend_from_slice(part);
        }
    } else if (-5..=0).contains(&point) {
        text.extend_from_slice(b"0.");
        text.extend_from_slice(&PLAIN_ZEROS[..(-point) as usize]);
        text.push(first);
        text.extend_from_slice(rest);
    } else {
        text.push(first);
        if n > 1 {
            text.push(b'.');
            text.extend_from_slice(rest);
        }
        // Writing to a Vec cannot fail.
        let _ = write!(text, "e{}", point - 1);
    }
}

/// The first digit of a shortest decimal, the rest of them without zeros around them, and how many
/// of all stand before the point. What is below 1 in SI, as most is, needs no copy.
fn digits_of<'a>(decimal: &'a [u8], room: &'a mut [u8; MAX_DIGITS]) -> (u8, &'a [u8], i32) {
    let figure = |b: &u8| i32::from(b - b'0');
    match decimal {
        [first, b'.', rest @ .., b'e', b'-', one @ b'0'..=b'9'] => (*first, rest, 1 - figure(one)),
        [
            first,
            b'.',
            rest @ ..,
            b'e',
            b'-',
            ten @ b'0'..=b'9',
            one @ b'0'..=b'9',
        ] => (*first, rest, 1 - 10 * figure(ten) - figure(one)),
        // Nothing shortest ends in a zero after the point.
        [b'0', b'.', part @ ..] => {
            let zeros = part.iter().take_while(|b| **b == b'0').count();
            let (first, rest) = part[zeros..].split_first().unwrap_or((&b'0', &[]));
            (*first, rest, -(zeros as i32))
        }
        _ => {
            let (digits, point) = split(decimal, room);
            let (first, rest) = digits.split_first().unwrap_or((&b'0', &[]));
            (*first, rest, point)
        }
    }
}

/// Whether a number may lie in the very middle between two of its shortest decimals. There the
/// standard library takes the upper one, `zmij` the even one; files keep the standard's digits.
///
/// Then the number has one digit more, a 5: it is `m 2^e` with an odd `m` and `m 5^-e < 10^18`, or
/// a whole number with `5^(e+1)` in `m < 2^53`.
fn may_lie_between(value: f64) -> bool {
    /// Exponents `e` with which that is possible.
    const TIE_EXPONENTS: std::ops::RangeInclusive<i32> = -25..=21;
    /// Bits of a number's mantissa, and of its exponent; the exponent of a mantissa read as a
    /// whole number, in the form in which it is stored.
    const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    const EXPONENT_MASK: u64 = 0x7ff;
    const WHOLE_EXPONENT: i32 = f64::MAX_EXP - 1 + MANTISSA_BITS as i32;
    let bits = value.to_bits();
    let stored = ((bits >> MANTISSA_BITS) & EXPONENT_MASK) as i32;
    // Of the leading bit, which is not stored, it matters only that it is there.
    let mantissa = bits | (1 << MANTISSA_BITS);
    TIE_EXPONENTS.contains(&(stored - WHOLE_EXPONENT + mantissa.trailing_zeros() as i32))
}

/// The digits of a shortest decimal such as `1.25e-7`, `1e+21`, `0.00125` or `1250.0`, without
/// zeros around them, and how many of them stand before the point.
fn split<'a>(decimal: &'a [u8], room: &'a mut [u8; MAX_DIGITS]) -> (&'a [u8], i32) {
    let (mantissa, exponent) = match decimal.iter().rposition(|b| *b == b'e') {
        Some(at) => (&decimal[..at], &decimal[at + 1..]),
        None => (decimal, &b"0"[..]),
    };
    let (sign, size) = match exponent {
        [b'-', size @ ..] => (-1, size),
        [b'+', size @ ..] | size => (1, size),
    };
    let size = size.iter().fold(0, |n, b| 10 * n + i32::from(b - b'0'));
    let (whole, part) = match mantissa.iter().position(|b| *b == b'.') {
        Some(at) => (&mantissa[..at], &mantissa[at + 1..]),
        None => (mantissa, &[][..]),
    };
    let count = whole.len() + part.len();
    room[..whole.len()].copy_from_slice(whole);
    room[whole.len()..count].copy_from_slice(part);
    let zeros = room[..count].iter().take_while(|b| **b == b'0').count();
    let last = room[..count].iter().rposition(|b| *b != b'0');
    let end = last.map_or(zeros, |at| at + 1);
    let point = whole.len() as i32 + sign * size - zeros as i32;
    (&room[zeros..end], point)
}

#[cfg(test)]
mod tests {
    use super::super::digits::*;

    fn text(value: f64, shift: i32) -> String {
        let mut out = Vec::new();
        put(&mut out, value, shift);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn moves_the_point_without_rounding() {
        assert_eq!(text(58.1e-6, 6), "58.1");
        assert_eq!(text(-58e-6, 6), "-58");
        assert_eq!(text(2e-5, 0), "0.00002");
        assert_eq!(text(0.1, 0), "0.1");
        assert_eq!(text(1234.5, 0), "1234.5");
        assert_eq!(text(1e-9, 6), "0.001");
        assert_eq!(text(1e-20, 6), "1e-14");
        assert_eq!(text(1.5e-20, 6), "1.5e-14");
        assert_eq!(text(1e20, 6), "1e26");
        assert_eq!(text(100.0, 6), "100000000");
        assert_eq!(text(-0.0, 6), "0");
        assert_eq!(text(f64::NAN, 6), "NaN");
    }

    /// The standard library's digits, with the point moved by rewriting its exponent.
    fn by_the_standard(value: f64, shift: i32) -> String {
        let scientific = format!("{value:e}");
        let (mantissa, exponent) = scientific.split_once('e').unwrap();
        let exponent: i32 = exponent.parse().unwrap();
        format!("{mantissa}e{}", exponent + shift)
    }

    /// The same text with the point behind the first digit.
    fn scientific(text: &str) -> String {
        let (text, exponent) = text.split_once('e').unwrap_or((text, "0"));
        let (sign, text) = text
            .strip_prefix('-')
            .map_or(("", text), |rest| ("-", rest));
        let (whole, part) = text.split_once('.').unwrap_or((text, ""));
        let all = format!("{whole}{part}");
        let digits = all.trim_start_matches('0');
        let skipped = all.len() - digits.len();
        let exponent = exponent.parse::<i32>().unwrap() + whole.len() as i32 - skipped as i32 - 1;
        let digits = digits.trim_end_matches('0');
        let (first, rest) = digits.split_at(1);
        let point = if rest.is_empty() { "" } else { "." };
        format!("{sign}{first}{point}{rest}e{exponent}")
    }

    #[test]
    fn digits_are_those_of_the_standard_library() {
        let check = |value: f64| {
            for shift in [0, 6] {
                let own = text(value, shift);
                assert_eq!(scientific(&own), by_the_standard(value, shift), "{own}");
            }
        };
        // In the middle between two decimals of 17 digits.
        for value in [
            2f64.powi(-25),
            2f64.powi(50),
            -3_616_678_665_934_105.0 / 4.0,
        ] {
            check(value);
        }
        for exponent in -1074..1024 {
            let power = 2f64.powi(exponent);
            [power, power.next_up(), power.next_down()]
                .into_iter()
                .filter(|v| *v != 0.0)
                .for_each(check);
        }
        for i in 1..20_000 {
            check(f64::from(i) / 50e3);
            check(f64::from(i));
            check(1e-4 * (f64::from(i) * 1.7e-3).sin());
            // Bits without a pattern.
            let bits = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let value = f64::from_bits(bits);
            if value.is_finite() {
                check(value);
            }
            check((bits >> 11) as f64 / 8.0);
        }
    }
}
