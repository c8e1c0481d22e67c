//! Arrays of one, two or more dimensions as columns.

use super::bytes::{ByteOrder, Layout, NumberType, decode};

/// Most columns taken from one array. A recording has a few; an array with more in its shorter
/// direction is an image or a spectrogram.
pub(crate) const MAX_COLUMNS: usize = 256;

/// An array in bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matrix<'a> {
    /// Bytes from its first element on.
    pub bytes: &'a [u8],
    /// How a number is stored.
    pub number: NumberType,
    /// Order of its bytes.
    pub order: ByteOrder,
    /// First byte of the number inside an element.
    pub offset: usize,
    /// Bytes of an element.
    pub element: usize,
    /// Extent of each dimension.
    pub shape: &'a [usize],
    /// Whether the first dimension runs fastest (Fortran, MATLAB).
    pub column_major: bool,
}

/// What an array gives.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum MatrixContent {
    /// One number.
    Scalar(f64),
    /// One column for each of several channels; `along_rows` if the file has them as rows.
    Columns {
        columns: Vec<Vec<f64>>,
        along_rows: bool,
    },
    /// Nothing in it.
    Empty,
    /// Not a table; the text says what it is.
    Other(String),
    /// The bytes end before the array does.
    Short,
}

impl Matrix<'_> {
    /// The array as columns: a dimension of 1 does not count, and the longer of two is time.
    pub fn read(&self) -> MatrixContent {
        if self.shape.contains(&0) {
            return MatrixContent::Empty;
        }
        let shape: Vec<usize> = self.shape.iter().copied().filter(|n| *n != 1).collect();
        let (rows, columns) = match *shape.as_slice() {
            [] => {
                return match self.column(0, 1, 1).as_deref() {
                    Some([value]) => MatrixContent::Scalar(*value),
                    _ => MatrixContent::Short,
                };
            }
            [rows] => (rows, 1),
            [rows, columns] => (rows, columns),
            _ => {
                let text: Vec<String> = shape.iter().map(usize::to_string).collect();
                return MatrixContent::Other(format!(
                    "an array of {} dimensions ({})",
                    shape.len(),
                    text.join(" x ")
                ));
            }
        };
        let along_rows = columns > rows;
        if rows.min(columns) > MAX_COLUMNS {
            return MatrixContent::Other(format!(
                "an array of {rows} x {columns} numbers, more than {MAX_COLUMNS} columns"
            ));
        }
        // Elements from one row to the next, and from one column to the next.
        let (row_step, column_step) = if self.column_major {
            (1, rows)
        } else {
            (columns, 1)
        };
        let (count, step, channels, channel_step) = if along_rows {
            (columns, column_step, rows, row_step)
        } else {
            (rows, row_step, columns, column_step)
        };
        let columns: Option<Vec<_>> = (0..channels)
            .map(|channel| self.column(channel.checked_mul(channel_step)?, step, count))
            .collect();
        columns.map_or(MatrixContent::Short, |columns| MatrixContent::Columns {
            columns,
            along_rows,
        })
    }

    /// `count` numbers from element `first` on, `step` elements apart.
    fn column(&self, first: usize, step: usize, count: usize) -> Option<Vec<f64>> {
        let layout = Layout {
            number: self.number,
            order: self.order,
            offset: first.checked_mul(self.element)?.checked_add(self.offset)?,
            stride: step.checked_mul(self.element)?,
            count,
        };
        decode(self.bytes, &layout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(shape: &[usize], column_major: bool) -> MatrixContent {
        Matrix {
            bytes: &[0, 1, 2, 3, 4, 5],
            number: NumberType::U8,
            order: ByteOrder::Little,
            offset: 0,
            element: 1,
            shape,
            column_major,
        }
        .read()
    }

    #[test]
    fn the_longer_direction_is_time_in_either_order() {
        let by = |columns: &[&[f64]], along_rows| MatrixContent::Columns {
            columns: columns.iter().map(|c| c.to_vec()).collect(),
            along_rows,
        };
        let even_odd: [&[f64]; 2] = [&[0.0, 2.0, 4.0], &[1.0, 3.0, 5.0]];
        let halves: [&[f64]; 2] = [&[0.0, 1.0, 2.0], &[3.0, 4.0, 5.0]];
        assert_eq!(read(&[3, 2], false), by(&even_odd, false));
        assert_eq!(read(&[3, 2], true), by(&halves, false));
        assert_eq!(read(&[2, 3], false), by(&halves, true));
        assert_eq!(read(&[2, 1, 3], true), by(&even_odd, true));
        assert_eq!(read(&[1, 6], true), read(&[6], false));
    }

    #[test]
    fn what_is_no_table() {
        assert_eq!(read(&[], false), MatrixContent::Scalar(0.0));
        assert_eq!(read(&[0, 4], false), MatrixContent::Empty);
        assert_eq!(read(&[4, 2], false), MatrixContent::Short);
        assert_eq!(read(&[usize::MAX, 2], true), MatrixContent::Short);
        assert!(matches!(read(&[2, 3, 2], false), MatrixContent::Other(_)));
        assert!(matches!(read(&[999, 999], false), MatrixContent::Other(_)));
    }
}
