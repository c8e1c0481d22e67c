//! A whole number times a power of ten as the nearest `f64`.

/// Powers of ten that are exact in an `f64`.
const EXACT_POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// `digits * 10^exponent`, correctly rounded, or `None` where the quick ways do not decide.
///
/// Short numbers take Clinger's exact path: an integer up to 2^53 times or over an exact power
/// of ten rounds once, hence correctly.
#[inline]
pub(in crate::recording) fn quickly_rounded(digits: u64, exponent: i32) -> Option<f64> {
    match exponent {
        -22..=22 if digits <= 1 << 53 => {
            let power = EXACT_POWERS_OF_TEN[exponent.unsigned_abs() as usize];
            Some(if exponent < 0 {
                digits as f64 / power
            } else {
                digits as f64 * power
            })
        }
        -22..=-1 => long_quotient(
            digits,
            EXACT_POWERS_OF_TEN[exponent.unsigned_abs() as usize],
        ),
        _ => None,
    }
}

/// `digits * 10^exponent`, correctly rounded; infinite beyond the range of an `f64`.
#[inline]
pub(in crate::recording) fn rounded(digits: u64, exponent: i32) -> f64 {
    // The library reads every such text.
    quickly_rounded(digits, exponent)
        .or_else(|| format!("{digits}e{exponent}").parse().ok())
        .unwrap_or(f64::NAN)
}

/// `mantissa / power`, correctly rounded, or `None` where the rounding is in doubt.
///
/// The quotient is had to twice the precision from its remainder, which a fused
/// multiply-add gives exactly (T. J. Dekker, Numer. Math. 18, 1971). Its rounding is
/// in doubt only where it lies within a millionth of the middle between two numbers.
fn long_quotient(mantissa: u64, power: f64) -> Option<f64> {
    let head = mantissa as f64;
    // |tail| <= 2^10: exact. The cast back cannot wrap in 128 bits.
    let tail = (i128::from(mantissa) - head as i128) as f64;
    let quotient = head / power;
    let remainder = (-quotient).mul_add(power, head) + tail;
    let correction = remainder / power;
    let sum = quotient + correction;
    let lost = correction - (sum - quotient);
    let below = sum - f64::from_bits(sum.to_bits().checked_sub(1)?);
    (lost.abs() < 0.499_999 * below).then_some(sum)
}
