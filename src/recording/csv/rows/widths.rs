//! How many cells the rows have: a column that is added midway shifts what stands behind it.

/// Different numbers of cells that are told apart.
const MAX_WIDTHS: usize = 8;
/// Share of the rows from which another number of cells is a change of the table. Below, it is a
/// damaged row or a remark.
const MIN_CHANGED_SHARE: f64 = 0.01;

/// Rows of one number of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Rows {
    width: usize,
    count: usize,
    first: usize,
    last: usize,
}

/// The numbers of cells that occur.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(in crate::recording::csv) struct Widths {
    rows: Vec<Rows>,
}

/// A change of the number of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording::csv) struct WidthChange {
    /// First row of the later part.
    pub row: usize,
    /// Cells before.
    pub before: usize,
    /// Cells from there on.
    pub after: usize,
}

impl Widths {
    /// Takes note of a row.
    #[inline]
    pub(in crate::recording::csv) fn note(&mut self, width: usize, row: usize) {
        let room = self.rows.len() < MAX_WIDTHS;
        match self.rows.iter_mut().find(|rows| rows.width == width) {
            Some(rows) => {
                rows.count += 1;
                rows.last = row;
            }
            None if room => self.rows.push(Rows {
                width,
                count: 1,
                first: row,
                last: row,
            }),
            None => {}
        }
    }

    /// Adds those of a later piece, whose first row is `from`.
    pub(in crate::recording::csv) fn join(&mut self, other: &Self, from: usize) {
        for own in &other.rows {
            let room = self.rows.len() < MAX_WIDTHS;
            match self.rows.iter_mut().find(|rows| rows.width == own.width) {
                Some(rows) => {
                    rows.count += own.count;
                    rows.last = from + own.last;
                }
                None if room => self.rows.push(Rows {
                    first: from + own.first,
                    last: from + own.last,
                    ..*own
                }),
                None => {}
            }
        }
    }

    /// The change from one number of cells to another for good, if there is one.
    pub(in crate::recording::csv) fn change(&self) -> Option<WidthChange> {
        let all: usize = self.rows.iter().map(|rows| rows.count).sum();
        let many =
            |rows: &&Rows| rows.count as f64 > MIN_CHANGED_SHARE * all as f64 && rows.count > 1;
        let many: Vec<&Rows> = self.rows.iter().filter(many).collect();
        let [a, b] = many.as_slice() else {
            return None;
        };
        let (a, b) = if a.first < b.first { (a, b) } else { (b, a) };
        (a.last < b.first).then_some(WidthChange {
            row: b.first,
            before: a.width,
            after: b.width,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::widths::*;

    #[test]
    fn a_change_for_good_is_told_from_remarks() {
        let mut widths = Widths::default();
        (0..50).for_each(|row| widths.note(3, row));
        let mut later = Widths::default();
        (0..50).for_each(|row| later.note(4, row));
        let mut joined = widths.clone();
        joined.join(&later, 50);
        assert_eq!(
            joined.change(),
            Some(WidthChange {
                row: 50,
                before: 3,
                after: 4
            })
        );
        let mut mixed = Widths::default();
        (0..50).for_each(|row| mixed.note(3 + row % 2, row));
        assert_eq!(mixed.change(), None);
        assert_eq!(widths.change(), None);
    }
}
