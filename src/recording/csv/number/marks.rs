//! Decimal and thousands marks: what all cells of a column show together.
//!
//! `58.052` alone is 58 and a fraction, or fifty-eight thousand. A column is written by one program
//! in one way, so that its other cells, and the other columns, decide.

use std::borrow::Cow;

use super::plain_cell::PlainCell;
use crate::recording::csv::settings::Decimal;

/// Cells of one form below which a column may have it by chance.
const MIN_GROUPED_CELLS: u32 = 3;

/// The marks of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) struct Marks {
    /// The decimal mark.
    pub decimal: u8,
    /// The mark between thousands, if there is one.
    pub thousands: Option<u8>,
}

impl Marks {
    /// `1234.5`
    pub(in crate::recording::csv) const PLAIN: Self = Self {
        decimal: b'.',
        thousands: None,
    };

    /// `1.5` and `1,5`.
    const EITHER: Self = Self {
        decimal: 0,
        thousands: None,
    };

    /// The usual name of a mark.
    pub(in crate::recording::csv) fn name(mark: u8) -> &'static str {
        match mark {
            b'.' => "point",
            b',' => "comma",
            _ => "mark",
        }
    }

    /// The text of a number without thousands marks and with its decimal mark as a point; `None` if its
    /// marks are not these.
    pub(super) fn plain<'t>(self, text: &'t [u8]) -> Option<Cow<'t, [u8]>> {
        if self == Self::PLAIN {
            return (!text.contains(&b',')).then_some(Cow::Borrowed(text));
        }
        if self == Self::EITHER {
            let own = text.iter().find(|b| matches!(b, b'.' | b',')).copied();
            let decimal = own.unwrap_or(b'.');
            return Self { decimal, ..self }.plain(text);
        }
        let end = text
            .iter()
            .position(|b| matches!(b, b'e' | b'E' | b'd' | b'D'))
            .unwrap_or(text.len());
        let (number, exponent) = text.split_at(end);
        let at = number.iter().rposition(|b| *b == self.decimal);
        let (whole, fraction) = match at {
            Some(p) => (number.get(..p)?, number.get(p + 1..)?),
            None => (number, &[][..]),
        };
        let is_mark = |b: &u8| matches!(b, b'.' | b',');
        if fraction.iter().any(is_mark) {
            return None;
        }
        let mut plain = Vec::with_capacity(text.len());
        match self.thousands.filter(|mark| whole.contains(mark)) {
            Some(mark) => {
                if !is_grouped(whole, mark) {
                    return None;
                }
                plain.extend(whole.iter().copied().filter(|b| *b != mark));
            }
            None => plain.extend_from_slice(whole),
        }
        if plain.iter().any(is_mark) {
            return None;
        }
        if at.is_some() {
            plain.push(b'.');
            plain.extend_from_slice(fraction);
        }
        plain.extend_from_slice(exponent);
        Some(Cow::Owned(plain))
    }
}

/// Whether `whole` is digits in groups of three by `mark`, such as `-1,234,567`.
fn is_grouped(whole: &[u8], mark: u8) -> bool {
    let unsigned = whole.strip_prefix(b"-").or(whole.strip_prefix(b"+"));
    let unsigned = unsigned.unwrap_or(whole);
    unsigned
        .split(|b| *b == mark)
        .enumerate()
        .all(|(i, group)| {
            let fits = if i == 0 {
                (1..=3).contains(&group.len()) && group != b"0" && !group.starts_with(b"00")
            } else {
                group.len() == 3
            };
            fits && group.iter().all(u8::is_ascii_digit)
        })
}

/// Numbers of the forms in which one mark can stand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Forms {
    /// One mark that groups three digits, or is a decimal mark before three: `58.052`.
    either: u32,
    /// A mark that can only be decimal: `0.5`, `1234.567`, `1.25`.
    decimal: u32,
    /// Several marks that group digits: `1.234.567`.
    grouped: u32,
    /// This mark groups, and the other one is decimal: `1.234,5`.
    before_other: u32,
    /// Of `either`, those whose last digit is zero: `1.250`.
    round: u32,
}

/// What the cells of one column show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(in crate::recording::csv) struct Evidence {
    point: Forms,
    comma: Forms,
    /// Numbers without a mark, other than zero.
    unmarked: u32,
}

/// What is known of a column's marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) enum Verdict {
    /// The cells say it, or there are no marks.
    Clear(Marks),
    /// The cells allow both; these are the usual ones with the file's decimal mark.
    Open(Marks),
    /// Some cells say one thing, some the other.
    Mixed,
}

impl Evidence {
    /// Takes note of a cell.
    pub(in crate::recording::csv) fn note(&mut self, cell: &[u8]) {
        let cell = PlainCell::of(cell, false);
        let text: &[u8] = &cell.text;
        let text = text
            .strip_prefix(b"-")
            .or(text.strip_prefix(b"+"))
            .unwrap_or(text);
        let end = text
            .iter()
            .position(|b| !matches!(b, b'0'..=b'9' | b'.' | b','))
            .unwrap_or(text.len());
        let (number, rest) = text.split_at(end);
        let has_exponent = matches!(rest.first(), Some(b'e' | b'E' | b'd' | b'D'));
        if !number.iter().any(u8::is_ascii_digit) || !(rest.is_empty() || has_exponent) {
            return;
        }
        let count = |mark: u8| number.iter().filter(|b| **b == mark).count();
        let (points, commas) = (count(b'.'), count(b','));
        match (points, commas) {
            (0, 0) if number.iter().all(|b| *b == b'0') => {}
            (0, 0) => self.unmarked = self.unmarked.saturating_add(1),
            (_, 0) => self.point.note_alone(number, b'.', points, has_exponent),
            (0, _) => self.comma.note_alone(number, b',', commas, has_exponent),
            _ => {
                let last = |mark: u8| number.iter().rposition(|b| *b == mark);
                let (before, mark) = if last(b'.') < last(b',') {
                    (&mut self.point, b'.')
                } else {
                    (&mut self.comma, b',')
                };
                let whole = number
                    .split(|b| matches!(b, b'.' | b',') && *b != mark)
                    .next();
                if whole.is_some_and(|w| is_grouped(w, mark)) {
                    before.before_other = before.before_other.saturating_add(1);
                }
            }
        }
    }

    /// What two parts of a column show together.
    pub(in crate::recording::csv) fn join(&mut self, other: &Self) {
        self.point.join(&other.point);
        self.comma.join(&other.comma);
        self.unmarked = self.unmarked.saturating_add(other.unmarked);
    }

    /// Whether the cells say that this mark is decimal.
    pub(in crate::recording::csv) fn shows_decimal(&self, mark: Decimal) -> bool {
        let (own, other) = self.forms(mark);
        own.decimal > 0 || other.before_other > 0
    }

    /// Whether the mark stands in a cell at all.
    pub(in crate::recording::csv) fn has(&self, mark: Decimal) -> bool {
        let (own, other) = self.forms(mark);
        *own != Forms::default() || other.before_other > 0
    }

    fn forms(&self, mark: Decimal) -> (&Forms, &Forms) {
        match mark {
            Decimal::Point => (&self.point, &self.comma),
            Decimal::Comma => (&self.comma, &self.point),
        }
    }

    /// The marks of this column. `others` says what decimal mark other columns certainly have, and
    /// `setting` that of the import settings.
    pub(in crate::recording::csv) fn judge(
        &self,
        others: Option<Decimal>,
        setting: Decimal,
    ) -> Verdict {
        let groups = |mark: Decimal| {
            let own = self.forms(mark).0;
            own.grouped > 0 || own.before_other > 0
        };
        let [point, comma] = [Decimal::Point, Decimal::Comma].map(|m| self.shows_decimal(m));
        let with = |decimal: Decimal, grouped: bool| {
            let (decimal, other) = match decimal {
                Decimal::Point => (b'.', b','),
                Decimal::Comma => (b',', b'.'),
            };
            Marks {
                decimal,
                thousands: grouped.then_some(other),
            }
        };
        match (point, comma) {
            (true, true) => {
                let each_is_clear = self.point.either + self.comma.either == 0
                    && !groups(Decimal::Point)
                    && !groups(Decimal::Comma);
                return if each_is_clear {
                    Verdict::Clear(Marks::EITHER)
                } else {
                    Verdict::Mixed
                };
            }
            (true, false) if groups(Decimal::Point) => return Verdict::Mixed,
            (false, true) if groups(Decimal::Comma) => return Verdict::Mixed,
            (true, false) => {
                return Verdict::Clear(with(Decimal::Point, self.has(Decimal::Comma)));
            }
            (false, true) => {
                return Verdict::Clear(with(Decimal::Comma, self.has(Decimal::Point)));
            }
            (false, false) => {}
        }
        // No cell has a mark that is certainly decimal.
        match (groups(Decimal::Point), groups(Decimal::Comma)) {
            (true, true) => return Verdict::Mixed,
            (true, false) => return Verdict::Clear(with(Decimal::Comma, true)),
            (false, true) => return Verdict::Clear(with(Decimal::Point, true)),
            (false, false) => {}
        }
        match (self.point.either > 0, self.comma.either > 0) {
            (false, false) => Verdict::Clear(with(setting, false)),
            (true, true) => Verdict::Mixed,
            (has_point, _) => self.judge_one(has_point, others, setting, &with),
        }
    }

    /// The marks where all cells have one that can be both, or none.
    fn judge_one(
        &self,
        is_point: bool,
        others: Option<Decimal>,
        setting: Decimal,
        with: &dyn Fn(Decimal, bool) -> Marks,
    ) -> Verdict {
        let (own, other, count) = if is_point {
            (Decimal::Point, Decimal::Comma, self.point.either)
        } else {
            (Decimal::Comma, Decimal::Point, self.comma.either)
        };
        let (decimal, grouped) = (with(own, false), with(other, true));
        let round = self.forms(own).0.round;
        match others {
            Some(mark) if mark == own => Verdict::Clear(decimal),
            Some(_) => Verdict::Clear(grouped),
            // Who leaves out zeros after the decimal mark writes no 1.250; who does not, writes no 1.
            None if self.unmarked > 0 && round > 0 && count >= MIN_GROUPED_CELLS => {
                Verdict::Clear(grouped)
            }
            // Three decimals in each cell are a printed precision, and a point is the usual mark.
            None if is_point && (self.unmarked == 0 || count < MIN_GROUPED_CELLS) => {
                Verdict::Clear(if setting == own { decimal } else { grouped })
            }
            None => Verdict::Open(if setting == own { decimal } else { grouped }),
        }
    }
}

impl Forms {
    /// Takes note of a number with this mark only.
    fn note_alone(&mut self, number: &[u8], mark: u8, count: usize, has_exponent: bool) {
        let form = if count > 1 {
            if !is_grouped(number, mark) {
                return;
            }
            &mut self.grouped
        } else if !has_exponent && is_grouped(number, mark) {
            &mut self.either
        } else {
            &mut self.decimal
        };
        *form = form.saturating_add(1);
        if count == 1 && !has_exponent && number.ends_with(b"0") && is_grouped(number, mark) {
            self.round = self.round.saturating_add(1);
        }
    }

    fn join(&mut self, other: &Self) {
        self.either = self.either.saturating_add(other.either);
        self.round = self.round.saturating_add(other.round);
        self.decimal = self.decimal.saturating_add(other.decimal);
        self.grouped = self.grouped.saturating_add(other.grouped);
        self.before_other = self.before_other.saturating_add(other.before_other);
    }
}

#[cfg(test)]
mod tests {
    use super::super::marks::*;

    fn judge(cells: &[&str], others: Option<Decimal>) -> Verdict {
        let mut evidence = Evidence::default();
        cells.iter().for_each(|c| evidence.note(c.as_bytes()));
        evidence.judge(others, Decimal::Point)
    }

    fn marks(decimal: u8, thousands: Option<u8>) -> Verdict {
        Verdict::Clear(Marks { decimal, thousands })
    }

    #[test]
    fn a_column_is_judged_by_all_its_cells() {
        assert_eq!(judge(&["1.5", "58.052"], None), marks(b'.', None));
        assert_eq!(
            judge(&["\"1,234.5\"", "2.0"], None),
            marks(b'.', Some(b','))
        );
        assert_eq!(judge(&["1.234,5", "2,0"], None), marks(b',', Some(b'.')));
        assert_eq!(judge(&["1.234.567", "8"], None), marks(b',', Some(b'.')));
        let comma = Some(Decimal::Comma);
        assert_eq!(judge(&["58.052", "-1"], comma), marks(b',', Some(b'.')));
        assert_eq!(judge(&["58,052", "57,001"], comma), marks(b',', None));
        assert_eq!(
            judge(&["58,052", "1"], Some(Decimal::Point)),
            marks(b'.', Some(b','))
        );
        assert_eq!(judge(&["1,5", "1.5", "2,345"], None), Verdict::Mixed);
        assert_eq!(judge(&["1,5", ".25"], None), Verdict::Clear(Marks::EITHER));
        // 1.250 beside 7: three digits are a group.
        let grouped = judge(&["7", "1.250", "12.345", "13.001"], None);
        assert_eq!(grouped, marks(b',', Some(b'.')));
        let zeros = judge(&["0", "8.120", "-8.120", "8.120"], None);
        assert_eq!(zeros, marks(b'.', None));
        assert_eq!(judge(&["58.052", "57.001"], None), marks(b'.', None));
        assert!(matches!(
            judge(&["58,052", "57,001"], None),
            Verdict::Open(_)
        ));
        let many = [&["1"][..], &["1.234"; 40]].concat();
        assert!(matches!(judge(&many, None), Verdict::Open(_)));
    }

    #[test]
    fn marks_are_taken_out() {
        let read = |marks: Marks, text: &str| {
            let plain = marks.plain(text.as_bytes());
            plain.map(|p| String::from_utf8(p.into_owned()).unwrap())
        };
        let european = Marks {
            decimal: b',',
            thousands: Some(b'.'),
        };
        assert_eq!(read(european, "-1.234,5e3").as_deref(), Some("-1234.5e3"));
        assert_eq!(read(european, "58.052").as_deref(), Some("58052"));
        assert_eq!(read(european, "58.05"), None);
        assert_eq!(read(european, "1,5,5"), None);
        assert_eq!(read(Marks::PLAIN, "1,5"), None);
    }
}
