//! MATLAB's MAT files of version 5, 6 and 7: named arrays, structures and cells, maybe compressed.
//!
//! Source: MathWorks, "MAT-File Format", checked against SciPy's writer. Version 7.3 is HDF5.

mod element;
mod variable;

use flate2::read::ZlibDecoder;

use self::element::{COMPRESSED, Element, MATRIX, next_element};
use self::variable::read_variable;
use super::arrays::{Arrays, stem};
use super::bytes::{ByteOrder, Cursor};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::unpack::read_bounded;

/// Reads `.mat` files before version 7.3.
#[derive(Debug)]
pub struct Mat5;

const NAME: &str = "MATLAB";
/// Bytes of the file's header.
const HEADER_BYTES: usize = 128;
/// Bytes of the header of a variable in version 4.
const HEADER_4_BYTES: usize = 20;

impl Format for Mat5 {
    fn id(&self) -> &'static str {
        "mat"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["mat"]
    }

    fn recognises(&self, head: &[u8], file_name: &str) -> bool {
        order(head).is_some() || is_version_4(head, file_name)
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let Some(order) = order(bytes) else {
            return Err(context.unsupported(
                "this is a MAT file of version 4, or none at all",
                "save it in MATLAB with save(name, \"-v7\"), or as CSV",
            ));
        };
        let mut arrays = Arrays::default();
        let mut cursor = Cursor::new(bytes, order);
        cursor.seek(HEADER_BYTES);
        while cursor.remaining() > 0 {
            let at = cursor.at();
            let element = next_element(&mut cursor)
                .ok_or_else(|| context.truncated(bytes.len(), "a variable"))?;
            read_element(&context, &element, at, order, &mut arrays)?;
        }
        let tables = arrays.into_tables(&context, &stem(file))?;
        Ok(FormatContent::Tables(tables))
    }
}

/// One element of the file: a variable, or one that is compressed.
fn read_element(
    context: &FileContext,
    element: &Element,
    at: usize,
    order: ByteOrder,
    arrays: &mut Arrays,
) -> Result<(), FormatError> {
    let bad = || context.malformed(at, "a variable");
    match element.kind {
        MATRIX => read_variable(element.bytes, order, arrays).ok_or_else(bad),
        COMPRESSED => {
            let decoder = ZlibDecoder::new(element.bytes);
            let inner = read_bounded(context, decoder, element.bytes.len())?;
            let inner = next_element(&mut Cursor::new(&inner, order))
                .filter(|inner| inner.kind == MATRIX)
                .and_then(|inner| read_variable(inner.bytes, order, arrays));
            inner.ok_or_else(bad)
        }
        // Others do not stand at this level; a reader passes over them.
        _ => Ok(()),
    }
}

/// Byte order by the header of version 5; `None` for other files.
fn order(bytes: &[u8]) -> Option<ByteOrder> {
    match bytes.get(124..HEADER_BYTES)? {
        [0, 1, b'I', b'M'] => Some(ByteOrder::Little),
        [1, 0, b'M', b'I'] => Some(ByteOrder::Big),
        _ => None,
    }
}

/// Whether the file is named as a MAT file and begins with a variable of version 4.
fn is_version_4(head: &[u8], file_name: &str) -> bool {
    let named = file_name.to_ascii_lowercase().ends_with(".mat");
    let number = |at: usize| {
        let bytes = head.get(at..at + 4)?.first_chunk::<4>()?;
        // Both byte orders: small numbers either way.
        Some(u32::from_le_bytes(*bytes).min(u32::from_be_bytes(*bytes)))
    };
    // Type (MOPT, at most 4052), imaginary flag, length of the name.
    let plausible = number(0).is_some_and(|kind| kind <= 4052)
        && number(12).is_some_and(|flag| flag <= 1)
        && number(16).is_some_and(|length| (1..=64).contains(&length));
    named && head.len() > HEADER_4_BYTES && plausible
}
