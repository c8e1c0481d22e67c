//! Elements: a type, a length, bytes.

use super::super::bytes::{Cursor, NumberType};

/// Element types (table 1-1 of the format).
pub(super) const MATRIX: u32 = 14;
pub(super) const COMPRESSED: u32 = 15;

/// An element of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<'a> {
    pub kind: u32,
    pub bytes: &'a [u8],
}

impl Element<'_> {
    /// How its numbers are stored; `None` if it holds none.
    pub fn number(&self) -> Option<NumberType> {
        Some(match self.kind {
            1 => NumberType::I8,
            2 | 16 => NumberType::U8,
            3 => NumberType::I16,
            4 | 17 => NumberType::U16,
            5 => NumberType::I32,
            6 | 18 => NumberType::U32,
            7 => NumberType::F32,
            9 => NumberType::F64,
            12 => NumberType::I64,
            13 => NumberType::U64,
            _ => return None,
        })
    }
}

/// The next element, with the bytes that pad it; `None` where the bytes end in it.
pub(super) fn next_element<'a>(cursor: &mut Cursor<'a>) -> Option<Element<'a>> {
    let first = cursor.u32()?;
    // Small element: both numbers in four bytes, and four of data.
    if first >> 16 != 0 {
        let length = (first >> 16) as usize;
        let bytes = cursor.take(4)?.get(..length)?;
        return Some(Element {
            kind: first & 0xffff,
            bytes,
        });
    }
    let length = usize::try_from(cursor.u32()?).ok()?;
    let bytes = cursor.take(length)?;
    if first != COMPRESSED {
        // The last element of a file may lack its padding.
        let padding = (8 - length % 8) % 8;
        cursor.take(padding.min(cursor.remaining()));
    }
    Some(Element { kind: first, bytes })
}
