//! What a cell is: a number, a reading out of range, a missing value, or text.

use super::marks::Marks;
use super::{cell, cell_with};

/// What instruments write for an overrange (`9.9E+37`) and for no reading (`9.91E+37`) lies between
/// these (IEEE 488.2 and SCPI-99, volume 1, 7.2.1).
pub(in crate::recording::csv) const OVERRANGE: std::ops::Range<f64> = 9.895e37..9.915e37;

/// Whether a cell says that the reading was out of range.
pub(in crate::recording::csv) fn is_overrange(text: &[u8]) -> bool {
    const WORDS: [&str; 13] = [
        "inf",
        "infinity",
        "\u{221e}",
        "ol",
        "o.l",
        "o.l.",
        "ovl",
        "ovld",
        "over",
        "overload",
        "overflow",
        "overrange",
        "1.#inf",
    ];
    let word = String::from_utf8_lossy(text.trim_ascii()).to_lowercase();
    let word = word.trim_matches('"').trim();
    let unsigned = word.trim_start_matches(['-', '+', '\u{2212}', '>', '<']);
    if unsigned.is_empty() {
        // Dashes fill the display; one alone is a missing value.
        return word.len() >= 2 && word.bytes().all(|b| b == b'-');
    }
    let stars = unsigned.len() >= 2 && unsigned.bytes().all(|b| b == b'*');
    let number = cell(unsigned.as_bytes(), false, 0);
    stars || WORDS.contains(&unsigned) || OVERRANGE.contains(&number)
}

/// Whether a cell is a number, with any marks.
pub(in crate::recording::csv) fn is_number(text: &[u8]) -> bool {
    let convention = |decimal, thousands| {
        let marks = Marks { decimal, thousands };
        cell_with(text, marks, 0).is_finite()
    };
    convention(b'.', Some(b',')) || convention(b',', Some(b'.'))
}

/// Whether a cell is a number (`Some(true)`), one of the ways to say that there is none
/// (`Some(false)`), or other text (`None`).
pub(in crate::recording::csv) fn looks_numeric(text: &[u8]) -> Option<bool> {
    const MISSING_VALUES: [&[u8]; 14] = [
        b"",
        b"\"\"",
        b"nan",
        b"n/a",
        b"na",
        b"null",
        b"none",
        b"-",
        b"#n/a",
        b"#value!",
        b"?",
        b"1.#qnan",
        b"-1.#ind",
        b"nan(ind)",
    ];
    if is_number(text) {
        return Some(true);
    }
    let word = text.trim_ascii();
    let missing = MISSING_VALUES.iter().any(|m| word.eq_ignore_ascii_case(m));
    (missing || is_overrange(word)).then_some(false)
}

#[cfg(test)]
mod tests {
    use super::super::kinds::*;

    #[test]
    fn overrange_marks_are_known() {
        for text in [
            "9.9E+37",
            "-9.91e37",
            "OL",
            "-OL",
            "----",
            "inf",
            "-\u{221e}",
            "***",
            "\"Over\"",
        ] {
            assert!(is_overrange(text.as_bytes()), "{text}");
            assert!(looks_numeric(text.as_bytes()).is_some(), "{text}");
        }
        for text in ["", "-", "nan", "1e30", "12", "overall"] {
            assert!(!is_overrange(text.as_bytes()), "{text}");
        }
    }
}
