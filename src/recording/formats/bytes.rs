//! Numbers in bytes: a cursor that cannot run over the end, and columns of numbers.

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ByteOrder {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// How one number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl NumberType {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// An integer of `size` bytes.
    pub fn integer(size: usize, signed: bool) -> Option<Self> {
        Some(match (size, signed) {
            (1, true) => Self::I8,
            (1, false) => Self::U8,
            (2, true) => Self::I16,
            (2, false) => Self::U16,
            (4, true) => Self::I32,
            (4, false) => Self::U32,
            (8, true) => Self::I64,
            (8, false) => Self::U64,
            _ => return None,
        })
    }

    /// An IEEE 754 number of `size` bytes.
    pub fn float(size: usize) -> Option<Self> {
        Some(match size {
            2 => Self::F16,
            4 => Self::F32,
            8 => Self::F64,
            _ => return None,
        })
    }
}

/// Where the numbers of one column lie.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    /// How a number is stored.
    pub number: NumberType,
    /// Order of its bytes.
    pub order: ByteOrder,
    /// First byte of the first number.
    pub offset: usize,
    /// Bytes from one number to the next, at least a number's size.
    pub stride: usize,
    /// How many.
    pub count: usize,
}

/// The nearest double: above 2^53 not all whole numbers are doubles.
fn signed(value: i64) -> f64 {
    value as f64
}

/// As [`signed`].
fn unsigned(value: u64) -> f64 {
    value as f64
}

/// A half-precision number (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let fraction = f64::from(bits & 0x3ff);
    let magnitude = match (bits >> 10) & 0x1f {
        0 => fraction * 2f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        exponent => (1.0 + fraction / 1024.0) * 2f64.powi(i32::from(exponent) - 15),
    };
    sign * magnitude
}

/// The numbers of a column; `None` if `bytes` do not hold all of them. Allocates at most eight bytes
/// for each byte of the file.
pub(crate) fn decode(bytes: &[u8], layout: &Layout) -> Option<Vec<f64>> {
    let mut values = Vec::new();
    decode_into(bytes, layout, &mut values).then_some(values)
}

/// Adds the numbers of a column to `values`; `false` and nothing added if `bytes` do not hold all.
pub(crate) fn decode_into(bytes: &[u8], layout: &Layout, values: &mut Vec<f64>) -> bool {
    let Some(bytes) = column_bytes(bytes, layout) else {
        return false;
    };
    macro_rules! numbers {
        ($type:ty, $to:expr) => {{
            const SIZE: usize = size_of::<$type>();
            let cells = bytes.chunks(layout.stride.max(1));
            let arrays = cells.map(|cell| cell.first_chunk::<SIZE>());
            match layout.order {
                ByteOrder::Little => values.extend(
                    arrays.map(|a| a.map_or(f64::NAN, |a| $to(<$type>::from_le_bytes(*a)))),
                ),
                ByteOrder::Big => values.extend(
                    arrays.map(|a| a.map_or(f64::NAN, |a| $to(<$type>::from_be_bytes(*a)))),
                ),
            }
        }};
    }
    match layout.number {
        NumberType::I8 => numbers!(i8, f64::from),
        NumberType::U8 => numbers!(u8, f64::from),
        NumberType::I16 => numbers!(i16, f64::from),
        NumberType::U16 => numbers!(u16, f64::from),
        NumberType::I32 => numbers!(i32, f64::from),
        NumberType::U32 => numbers!(u32, f64::from),
        NumberType::I64 => numbers!(i64, signed),
        NumberType::U64 => numbers!(u64, unsigned),
        NumberType::F16 => numbers!(u16, half),
        NumberType::F32 => numbers!(f32, f64::from),
        NumberType::F64 => numbers!(f64, f64::from),
    }
    true
}

/// The bytes from the first to the last number of a column; `None` if they are not all there.
fn column_bytes<'a>(bytes: &'a [u8], layout: &Layout) -> Option<&'a [u8]> {
    let size = layout.number.size();
    if layout.count == 0 {
        return Some(&[]);
    }
    if layout.stride < size {
        return None;
    }
    let span = (layout.count - 1)
        .checked_mul(layout.stride)?
        .checked_add(size)?;
    let end = layout.offset.checked_add(span)?;
    bytes.get(layout.offset..end)
}

/// Reads bytes one after the other; every step fails where the bytes end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
}

impl<'a> Cursor<'a> {
    /// At the start of `bytes`.
    pub fn new(bytes: &'a [u8], order: ByteOrder) -> Self {
        Self {
            bytes,
            at: 0,
            order,
        }
    }

    /// Position from the start \[bytes\].
    pub fn at(&self) -> usize {
        self.at
    }

    /// Bytes to the end.
    pub fn remaining(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// Moves to `at`; steps from beyond the end fail.
    pub fn seek(&mut self, at: usize) {
        self.at = at;
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.first_chunk::<N>().copied()
    }

    /// The next unsigned number of four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        let bytes = self.array()?;
        Some(match self.order {
            ByteOrder::Little => u32::from_le_bytes(bytes),
            ByteOrder::Big => u32::from_be_bytes(bytes),
        })
    }

    /// The next unsigned number of eight bytes.
    pub fn u64(&mut self) -> Option<u64> {
        let bytes = self.array()?;
        Some(match self.order {
            ByteOrder::Little => u64::from_le_bytes(bytes),
            ByteOrder::Big => u64::from_be_bytes(bytes),
        })
    }

    /// The next number of a type, as a double.
    pub fn number(&mut self, number: NumberType) -> Option<f64> {
        let bytes = self.take(number.size())?;
        let layout = Layout {
            number,
            order: self.order,
            offset: 0,
            stride: number.size(),
            count: 1,
        };
        decode(bytes, &layout)?.first().copied()
    }
}

/// `bytes` as text: UTF-8, or Latin-1 where they are not.
pub(crate) fn text(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision_numbers() {
        // Bit patterns of IEEE 754-2019, table of binary16 examples.
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 2f64.powi(-24)),
            (0x7c00, f64::INFINITY),
            (0x3555, 0.333_251_953_125),
        ] {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn columns_are_read_by_stride_and_never_over_the_end() {
        let bytes: Vec<u8> = (0..12).collect();
        let mut layout = Layout {
            number: NumberType::U16,
            order: ByteOrder::Big,
            offset: 1,
            stride: 5,
            count: 2,
        };
        assert_eq!(decode(&bytes, &layout), Some(vec![258.0, 1543.0]));
        layout.count = 3;
        assert_eq!(decode(&bytes, &layout), None);
        layout.count = usize::MAX;
        assert_eq!(decode(&bytes, &layout), None);
        layout.stride = 1;
        layout.count = 1;
        assert_eq!(decode(&bytes, &layout), None);
    }

    #[test]
    fn a_cursor_stops_at_the_end() {
        let mut cursor = Cursor::new(&[1, 2, 3], ByteOrder::Little);
        assert_eq!(cursor.take(2), Some(&[1u8, 2][..]));
        assert_eq!(cursor.take(2), None);
        assert_eq!(cursor.take(usize::MAX), None);
        assert_eq!(cursor.take(1), Some(&[3u8][..]));
    }
}
