//! Metadata of a segment: objects, their raw data and their properties.

use std::collections::HashMap;

use super::super::bytes::{ByteOrder, Cursor, NumberType, text};

/// Longest text of a property or path that is kept \[bytes\].
const MAX_TEXT_BYTES: usize = 4096;
/// Seconds in the unit of a time stamp's fraction: 2^-64.
pub(super) const STAMP_FRACTION: f64 = 1.0 / 18_446_744_073_709_551_616.0;

/// Value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Text(String),
    /// Seconds since 1904, and 2^-64 seconds.
    Stamp(i64, u64),
}

impl Value {
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            _ => None,
        }
    }

    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// A time stamp, seconds since 1904.
    pub fn seconds(&self) -> Option<f64> {
        match self {
            Self::Stamp(seconds, fraction) => {
                Some(*seconds as f64 + *fraction as f64 * STAMP_FRACTION)
            }
            _ => None,
        }
    }
}

/// Properties by name.
pub(super) type Properties = HashMap<String, Value>;

/// How the samples of a channel are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    Number(NumberType),
    /// Both parts of a complex number.
    Complex(NumberType),
    Stamp,
    /// Text and what cannot be read: its bytes in a chunk are skipped.
    Skipped(&'static str),
}

impl Stored {
    /// The type of a number in the file; `None` for an unknown one.
    pub fn of(code: u32) -> Option<Self> {
        use NumberType as N;
        Some(match code {
            1 => Self::Number(N::I8),
            2 => Self::Number(N::I16),
            3 => Self::Number(N::I32),
            4 => Self::Number(N::I64),
            5 | 0x21 => Self::Number(N::U8),
            6 => Self::Number(N::U16),
            7 => Self::Number(N::U32),
            8 => Self::Number(N::U64),
            9 | 0x19 => Self::Number(N::F32),
            10 | 0x1a => Self::Number(N::F64),
            0x08_000c => Self::Complex(N::F32),
            0x10_000d => Self::Complex(N::F64),
            0x20 => Self::Skipped("text"),
            0x44 => Self::Stamp,
            _ => return None,
        })
    }

    /// Bytes of a sample; `None` for text.
    pub fn size(self) -> Option<usize> {
        match self {
            Self::Number(number) => Some(number.size()),
            Self::Complex(number) => Some(2 * number.size()),
            Self::Stamp => Some(16),
            Self::Skipped(_) => None,
        }
    }
}

/// What a segment says of an object's raw data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RawIndex {
    /// It has none in this segment.
    None,
    /// As in the segment before.
    AsBefore,
    /// Raw data of DAQmx.
    Daqmx,
    /// A type, samples in a chunk, bytes in a chunk.
    Data {
        stored: Stored,
        count: usize,
        bytes: usize,
    },
    /// A type that is not known, by its code.
    Unknown(u32),
}

/// One object in the metadata of a segment.
#[derive(Debug)]
pub(super) struct Object {
    /// The path as in the file: `/'group'/'channel'`.
    pub path: String,
    pub index: RawIndex,
    pub properties: Vec<(String, Value)>,
}

/// A text with its length before it.
fn string(cursor: &mut Cursor) -> Option<String> {
    let length = usize::try_from(cursor.u32()?).ok()?;
    let bytes = cursor.take(length)?;
    Some(text(bytes.get(..MAX_TEXT_BYTES).unwrap_or(bytes)))
}

/// The next object; `None` if the bytes end in it or a property's type is not known.
pub(super) fn read_object(cursor: &mut Cursor, order: ByteOrder) -> Option<Object> {
    let path = string(cursor)?;
    let index = match cursor.u32()? {
        u32::MAX => RawIndex::None,
        0 => RawIndex::AsBefore,
        // Format changing scaler and digital line scaler.
        0x1269 | 0x126a | 0x1369 => RawIndex::Daqmx,
        _ => {
            let code = cursor.u32()?;
            let _dimension = cursor.u32()?;
            let count = usize::try_from(cursor.u64()?).ok()?;
            match Stored::of(code) {
                None => RawIndex::Unknown(code),
                Some(stored) => {
                    let bytes = match stored.size() {
                        Some(size) => count.checked_mul(size)?,
                        None => usize::try_from(cursor.u64()?).ok()?,
                    };
                    RawIndex::Data {
                        stored,
                        count,
                        bytes,
                    }
                }
            }
        }
    };
    if matches!(index, RawIndex::Daqmx | RawIndex::Unknown(_)) {
        // What follows has another layout; the caller refuses the file.
        return Some(Object {
            path,
            index,
            properties: Vec::new(),
        });
    }
    let count = cursor.u32()?;
    let mut properties = Vec::new();
    for _ in 0..count {
        let name = string(cursor)?;
        let code = cursor.u32()?;
        let value = value(cursor, code, order)?;
        properties.push((name, value));
    }
    Some(Object {
        path,
        index,
        properties,
    })
}

/// A property's value.
fn value(cursor: &mut Cursor, code: u32, order: ByteOrder) -> Option<Value> {
    if code == 0x20 {
        return string(cursor).map(Value::Text);
    }
    match Stored::of(code)? {
        Stored::Number(number) => cursor.number(number).map(Value::Number),
        Stored::Complex(number) => {
            cursor.take(2 * number.size())?;
            Some(Value::Text("complex".to_owned()))
        }
        Stored::Stamp => {
            let (seconds, fraction) = stamp(cursor, order)?;
            Some(Value::Stamp(seconds, fraction))
        }
        Stored::Skipped(_) => None,
    }
}

/// A time stamp: seconds since 1904, and 2^-64 seconds.
pub(super) fn stamp(cursor: &mut Cursor, order: ByteOrder) -> Option<(i64, u64)> {
    let (first, second) = (cursor.u64()?, cursor.u64()?);
    let (seconds, fraction) = match order {
        ByteOrder::Little => (second, first),
        ByteOrder::Big => (first, second),
    };
    Some((i64::from_ne_bytes(seconds.to_ne_bytes()), fraction))
}

/// The parts of a path: `/'a'/'b''c'` is `a`, `b'c`.
pub(super) fn path_parts(path: &str) -> Vec<String> {
    let mut parts = Vec::new();
    let mut chars = path.chars().peekable();
    while let Some(c) = chars.next() {
        if c != '\'' {
            continue;
        }
        let mut part = String::new();
        while let Some(c) = chars.next() {
            if c == '\'' && chars.next_if_eq(&'\'').is_none() {
                break;
            }
            part.push(c);
        }
        parts.push(part);
    }
    parts
}
