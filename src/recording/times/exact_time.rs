//! Decimal numbers of any length, added and subtracted without rounding.

use std::cmp::Ordering;
use std::fmt;

/// Decimal places kept, counted from the highest. A double and the rounding to it are decided by
/// fewer than 800 (D. Goldberg's bound for 5e-324 is 767); a file of `1e-100000` must not cost
/// more.
const MAX_PLACES: i64 = 1600;

/// An instant, or the time between two, as exact decimal digits \[s\].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExactTime {
    negative: bool,
    /// Decimal digits, the highest first, without zeros at either end; empty for zero.
    digits: Vec<u8>,
    /// Power of ten of the last digit; 0 for zero.
    exponent: i32,
}

impl ExactTime {
    /// `digits * 10^exponent`, where `digits` are the values 0 to 9, the highest first.
    pub(in crate::recording) fn new(negative: bool, mut digits: Vec<u8>, exponent: i32) -> Self {
        let mut exponent = exponent;
        while digits.last() == Some(&0) {
            digits.pop();
            exponent = exponent.saturating_add(1);
        }
        let leading = digits.iter().take_while(|d| **d == 0).count();
        digits.drain(..leading);
        if digits.is_empty() {
            return Self::default();
        }
        Self {
            negative,
            digits,
            exponent,
        }
    }

    /// The shortest decimal number that reads back as `seconds`; zero if that is not finite.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        if !seconds.is_finite() {
            return Self::default();
        }
        let text = format!("{:e}", seconds.abs());
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let fraction = mantissa.split_once('.').map_or(0, |(_, f)| f.len()) as i32;
        let digits = mantissa.bytes().filter(u8::is_ascii_digit);
        let digits = digits.map(|b| b - b'0').collect();
        let exponent: i32 = exponent.parse().unwrap_or(0);
        Self::new(seconds < 0.0, digits, exponent - fraction)
    }

    /// The nearest `f64` \[s\].
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let mut text = String::with_capacity(self.digits.len() + 8);
        self.put_sign(&mut text);
        text.extend(self.digits.iter().map(|d| char::from(b'0' + d)));
        if self.is_zero() {
            text.push('0');
        }
        text.push_str(&format!("e{}", self.exponent));
        // The library reads every such text.
        text.parse().unwrap_or(f64::NAN)
    }

    /// Whether this is zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.digits.is_empty()
    }

    /// `self * 10^power`.
    pub(in crate::recording) fn shifted(mut self, power: i32) -> Self {
        if !self.is_zero() {
            self.exponent = self.exponent.saturating_add(power);
        }
        self
    }

    /// The digits with their sign as one integer and its power of ten, if it has at most 18.
    pub(in crate::recording) fn short(&self) -> Option<(i64, i32)> {
        if self.digits.len() > 18 {
            return None;
        }
        let magnitude = self.digits.iter().fold(0i64, |n, d| 10 * n + i64::from(*d));
        let signed = if self.negative { -magnitude } else { magnitude };
        Some((signed, self.exponent))
    }

    /// Power of ten of the last digit that is not zero; 0 for zero.
    pub(in crate::recording) fn exponent(&self) -> i32 {
        self.exponent
    }

    /// The sum, without rounding.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return if self.is_zero() { other } else { self }.clone();
        }
        let high = self.end().max(other.end());
        let low = i64::from(self.exponent.min(other.exponent)).max(high - MAX_PLACES);
        let (a, b) = (self.between(low, high), other.between(low, high));
        // `low` lies at or above the exponent of an `i32`.
        let exponent = i32::try_from(low).unwrap_or(i32::MAX);
        if self.negative == other.negative {
            return Self::new(self.negative, sum(&a, &b), exponent);
        }
        match a.cmp(&b) {
            Ordering::Equal => Self::default(),
            Ordering::Greater => Self::new(self.negative, difference(&a, &b), exponent),
            Ordering::Less => Self::new(other.negative, difference(&b, &a), exponent),
        }
    }

    /// The difference, without rounding.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        let mut negated = other.clone();
        negated.negative = !other.negative && !other.is_zero();
        self.plus(&negated)
    }

    /// Power of ten above the highest digit.
    fn end(&self) -> i64 {
        i64::from(self.exponent) + self.digits.len() as i64
    }

    /// The digits at the powers of ten `low..high`, the highest first. Digits below are cut.
    fn between(&self, low: i64, high: i64) -> Vec<u8> {
        let end = self.end();
        let at = |power: i64| {
            let place = usize::try_from(end - 1 - power).ok();
            place.and_then(|p| self.digits.get(p)).copied().unwrap_or(0)
        };
        (low..high).rev().map(at).collect()
    }

    fn put_sign(&self, text: &mut String) {
        if self.negative {
            text.push('-');
        }
    }
}

/// `a + b`, digit by digit; both equally long.
fn sum(a: &[u8], b: &[u8]) -> Vec<u8> {
    let mut carry = 0;
    let mut digits: Vec<u8> = a
        .iter()
        .zip(b)
        .rev()
        .fold(Vec::new(), |mut digits, (x, y)| {
            let all = x + y + carry;
            carry = all / 10;
            digits.push(all % 10);
            digits
        });
    digits.push(carry);
    digits.reverse();
    digits
}

/// `a - b`, digit by digit; both equally long, `a` the larger.
fn difference(a: &[u8], b: &[u8]) -> Vec<u8> {
    let mut borrow = 0;
    let mut digits: Vec<u8> = Vec::with_capacity(a.len());
    for (x, y) in a.iter().zip(b).rev() {
        let (own, taken) = (*x, y + borrow);
        borrow = u8::from(own < taken);
        digits.push(own + 10 * borrow - taken);
    }
    digits.reverse();
    digits
}

impl fmt::Display for ExactTime {
    /// All digits: `1732752000.00002`, `-0.01`, `2e-9`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_zero() {
            return f.write_str("0");
        }
        let mut text = String::new();
        self.put_sign(&mut text);
        let digits: String = self.digits.iter().map(|d| char::from(b'0' + d)).collect();
        match self.end() {
            point @ 1..=20 => {
                let point = point as usize;
                if point >= digits.len() {
                    text.push_str(&digits);
                    text.extend(std::iter::repeat_n('0', point - digits.len()));
                } else {
                    text.push_str(&digits[..point]);
                    text.push('.');
                    text.push_str(&digits[point..]);
                }
            }
            point @ -5..=0 => {
                text.push_str("0.");
                text.extend(std::iter::repeat_n('0', point.unsigned_abs() as usize));
                text.push_str(&digits);
            }
            point => {
                text.push_str(&digits[..1]);
                if digits.len() > 1 {
                    text.push('.');
                    text.push_str(&digits[1..]);
                }
                text.push_str(&format!("e{}", point - 1));
            }
        }
        f.write_str(&text)
    }
}
