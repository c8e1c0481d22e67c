//! Numbers that a spreadsheet holds as text, as when it was opened with another decimal mark.

/// The marks of a column's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Marks {
    /// `.` or `,`.
    decimal: char,
    /// Whether another reading is possible: each comma stands before three digits.
    ambiguous: bool,
}

/// Spaces that group digits: the plain one, the no-break ones, the apostrophe of Switzerland.
const GROUPING: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];

impl Marks {
    /// Whether `text` is a number in some notation.
    pub fn is_number(text: &str) -> bool {
        let digits = text.bytes().any(|b| b.is_ascii_digit());
        let starts = text.starts_with(|c: char| c.is_ascii_digit() || "+-.,\u{2212}".contains(c));
        digits
            && starts
            && [',', '.'].iter().any(|decimal| {
                let marks = Self {
                    decimal: *decimal,
                    ambiguous: false,
                };
                marks.parse(text).is_some()
            })
    }

    /// The marks that all of `texts` share.
    pub fn of<'a>(texts: impl Iterator<Item = &'a str>) -> Self {
        // What was seen: a comma or point that must be decimal, or must group digits.
        let (mut comma, mut point, mut only_groups) = (false, false, true);
        let (mut comma_decimal, mut point_decimal) = (false, false);
        for text in texts {
            let last = text.rfind([',', '.']);
            let commas = text.matches(',').count();
            let points = text.matches('.').count();
            comma |= commas > 0;
            point |= points > 0;
            let Some(last) = last else { continue };
            let mark_is_comma = text[last..].starts_with(',');
            let (same, other) = if mark_is_comma {
                (commas, points)
            } else {
                (points, commas)
            };
            let decimal = if other > 0 {
                true
            } else if same > 1 {
                false
            } else {
                let before = text[..last].trim_start_matches(['+', '-', '\u{2212}']);
                let after = text[last + 1..]
                    .bytes()
                    .take_while(u8::is_ascii_digit)
                    .count();
                let rest = text.len() - last - 1;
                let group =
                    after == 3 && rest == 3 && (1..=3).contains(&before.len()) && before != "0";
                if group {
                    continue;
                }
                true
            };
            only_groups = false;
            match (mark_is_comma, decimal) {
                (true, true) | (false, false) => comma_decimal = true,
                (false, true) | (true, false) => point_decimal = true,
            }
        }
        if comma_decimal && !point_decimal {
            return Self {
                decimal: ',',
                ambiguous: false,
            };
        }
        if point_decimal {
            return Self {
                decimal: '.',
                ambiguous: comma_decimal,
            };
        }
        // No number decides. A spreadsheet keeps a number as text because it does not know its
        // mark; one with a grouping comma it would know.
        Self {
            decimal: if comma && !point { ',' } else { '.' },
            ambiguous: (comma || point) && only_groups,
        }
    }

    /// A number with these marks.
    pub fn parse(&self, text: &str) -> Option<f64> {
        let group = if self.decimal == ',' { '.' } else { ',' };
        let mut plain = String::with_capacity(text.len());
        for c in text.chars() {
            match c {
                c if c == self.decimal => plain.push('.'),
                c if c == group || GROUPING.contains(&c) => {}
                '\u{2212}' => plain.push('-'),
                c if c.is_ascii_digit() || "+-eE".contains(c) => plain.push(c),
                _ => return None,
            }
        }
        plain.parse().ok().filter(|v: &f64| v.is_finite())
    }

    /// How the numbers were read, after "they were read".
    pub fn words(&self) -> &'static str {
        match (self.decimal, self.ambiguous) {
            (',', false) => "with a decimal comma",
            (',', true) => {
                "with a decimal comma, though each comma could separate thousands; check the values"
            }
            (_, false) => "with a decimal point",
            (_, true) => "with a decimal point, though other marks are possible; check the values",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(texts: &[&str]) -> (Vec<Option<f64>>, bool) {
        let marks = Marks::of(texts.iter().copied());
        let values = texts.iter().map(|text| marks.parse(text)).collect();
        (values, marks.ambiguous)
    }

    #[test]
    fn marks_are_those_of_the_column() {
        let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        assert_eq!(read(&["1,5", "1,234"]), (some(&[1.5, 1.234]), false));
        assert_eq!(read(&["0,250", "1,234"]), (some(&[0.25, 1.234]), false));
        assert_eq!(
            read(&["1.234,5", "1.234"]),
            (some(&[1234.5, 1234.0]), false)
        );
        assert_eq!(
            read(&["1,234.5", "1,234"]),
            (some(&[1234.5, 1234.0]), false)
        );
        assert_eq!(read(&["1,234,567"]), (some(&[1_234_567.0]), false));
        assert_eq!(
            read(&["1'234.5", "-2E-3"]),
            (some(&[1234.5, -0.002]), false)
        );
        assert_eq!(read(&["1,234"]), (some(&[1.234]), true));
    }

    #[test]
    fn what_is_a_number() {
        for text in ["1", "-1,5", ".5", "1e-3", "1 234,5", "\u{2212}3"] {
            assert!(Marks::is_number(text), "{text}");
        }
        for text in [
            "",
            "-",
            "OL",
            "1 V",
            "e5",
            "12:00:00",
            "2026-01-01",
            "inf",
            "nan",
        ] {
            assert!(!Marks::is_number(text), "{text}");
        }
    }
}
