//! Numbers that a spreadsheet holds as text, as when it was opened with another decimal mark.

use super::cell_with;
use super::marks::{Evidence, Marks, Verdict};
use crate::recording::csv::settings::Decimal;

/// The marks that the numbers of a column share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) struct TextMarks {
    marks: Marks,
    /// Whether each mark could be one between thousands, too.
    is_open: bool,
}

/// Whether `text` is a number in some notation.
pub(in crate::recording) fn is_number_in_text(text: &str) -> bool {
    let starts = |c: char| c.is_ascii_digit() || "+-.,\u{2212}".contains(c);
    let reads = |(decimal, thousands): (u8, u8)| {
        let thousands = Some(thousands);
        let marks = Marks { decimal, thousands };
        let grouped = cell_with(closed(text).as_bytes(), marks, 0);
        let thousands = None;
        let plain = Marks { decimal, thousands };
        grouped.is_finite() || cell_with(closed(text).as_bytes(), plain, 0).is_finite()
    };
    text.starts_with(starts) && [(b'.', b','), (b',', b'.')].into_iter().any(reads)
}

/// A blank in a cell of a sheet separates no cells: it groups digits, as a no-break space does.
fn closed(text: &str) -> String {
    text.trim().replace(' ', "\u{a0}")
}

impl TextMarks {
    /// The marks that all of `texts` share; `None` if they contradict each other.
    pub(in crate::recording) fn of<'a>(texts: impl Iterator<Item = &'a str>) -> Option<Self> {
        let mut evidence = Evidence::default();
        texts.for_each(|text| evidence.note(closed(text).as_bytes()));
        // A spreadsheet keeps a number as text because it does not know its mark; one with a grouping
        // comma it would know.
        let has = [Decimal::Point, Decimal::Comma].map(|mark| evidence.has(mark));
        let setting = match has {
            [false, true] => Decimal::Comma,
            _ => Decimal::Point,
        };
        let (marks, is_open) = match evidence.judge(None, setting) {
            Verdict::Clear(marks) => (marks, false),
            Verdict::Open(marks) => (marks, true),
            Verdict::Mixed => return None,
        };
        Some(Self { marks, is_open })
    }

    /// A number with these marks.
    pub(in crate::recording) fn parse(&self, text: &str) -> Option<f64> {
        let value = cell_with(closed(text).as_bytes(), self.marks, 0);
        value.is_finite().then_some(value)
    }

    /// How the numbers were read, after "they were read".
    pub(in crate::recording) fn words(&self) -> &'static str {
        match (self.marks.decimal, self.is_open) {
            (b',', false) => "with a decimal comma",
            (b',', true) => {
                "with a decimal comma, though each comma could separate thousands; check the values"
            }
            (_, false) => "with a decimal point",
            (_, true) => "with a decimal point, though other marks are possible; check the values",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::text_marks::*;

    fn read(texts: &[&str]) -> Option<(Vec<Option<f64>>, bool)> {
        let marks = TextMarks::of(texts.iter().copied())?;
        let values = texts.iter().map(|text| marks.parse(text)).collect();
        Some((values, marks.is_open))
    }

    #[test]
    fn marks_are_those_of_the_column() {
        let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
        for (texts, values, is_open) in [
            (&["1,5", "1,234"][..], &[1.5, 1.234][..], false),
            (&["0,250", "1,234"], &[0.25, 1.234], false),
            (&["1.234,5", "1.234"], &[1234.5, 1234.0], false),
            (&["1,234.5", "1,234"], &[1234.5, 1234.0], false),
            (&["1,234,567"], &[1_234_567.0], false),
            (&["1'234.5", "-2E-3"], &[1234.5, -0.002], false),
            (&["1 234,5", "\u{2212}3"], &[1234.5, -3.0], false),
            (&["1,234"], &[1.234], true),
        ] {
            assert_eq!(read(texts), Some((some(values), is_open)), "{texts:?}");
        }
        assert_eq!(read(&["1.234,5", "1,234.5"]), None);
    }

    #[test]
    fn what_is_a_number() {
        for text in ["1", "-1,5", ".5", "1e-3", "1 234,5", "\u{2212}3", "1,234.5"] {
            assert!(is_number_in_text(text), "{text}");
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
            assert!(!is_number_in_text(text), "{text}");
        }
    }
}
