//! NumPy's `.npy`: one array.
//!
//! Format: NEP 1 and `numpy.lib.format`, versions 1.0 to 3.0.

use super::arrays::{ArrayLabel, Arrays, stem};
use super::bytes::text;
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::matrix::{MAX_COLUMNS, Matrix, MatrixContent};
use super::npy_header::{Dtype, Header, Plain, parse};

/// Reads `.npy` files.
#[derive(Debug)]
pub struct Npy;

const NAME: &str = "NumPy";
/// First bytes of every `.npy` file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// What to do about a file that is not as numpy writes it.
const SAVE_AGAIN: &str = "save the array again with numpy.save(\"name.npy\", array)";
/// Characters of a header in a message.
const MAX_SHOWN_CHARS: usize = 80;
/// Longest header that is parsed \[bytes\]. NumPy refuses longer ones, too, unless told otherwise:
/// `numpy.lib.format` has 10000; structured types of some hundred fields need more.
const MAX_HEADER_BYTES: usize = 64 << 10;

/// Most columns of a structured type.
const MAX_FIELDS: usize = 4096;

impl Format for Npy {
    fn id(&self) -> &'static str {
        "npy"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["npy"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        head.starts_with(MAGIC)
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let mut arrays = Arrays::default();
        let label = ArrayLabel {
            name: stem(file),
            ..ArrayLabel::default()
        };
        read_array(&context, bytes, &label, &mut arrays)?;
        let tables = arrays.into_tables(&context, &stem(file))?;
        Ok(FormatContent::Tables(tables))
    }
}

/// Adds the array in `bytes` to `arrays`; its columns are named after `label`, or by its fields.
pub(super) fn read_array(
    context: &FileContext,
    bytes: &[u8],
    label: &ArrayLabel,
    arrays: &mut Arrays,
) -> Result<(), FormatError> {
    let (header, data_at) = read_header(context, bytes)?;
    if header.dtype.has_objects() {
        return Err(context.unsupported(
            format!("\"{}\" holds Python objects, not numbers", label.path()),
            "save it as an array of numbers (array.astype(float)), or as CSV",
        ));
    }
    if header.dtype.columns() > MAX_FIELDS {
        return Err(context.unsupported(
            format!(
                "\"{}\" has {} numbers in each row",
                label.path(),
                header.dtype.columns()
            ),
            "save the columns of the recording alone",
        ));
    }
    let Some(element) = header.dtype.size() else {
        return Err(context.unsupported(
            format!(
                "the elements of \"{}\" have a type of unknown or endless size",
                label.path()
            ),
            SAVE_AGAIN,
        ));
    };
    let array = Element {
        context,
        data: bytes.get(data_at..).unwrap_or_default(),
        data_at,
        element,
        shape: &header.shape,
        column_major: header.is_fortran,
    };
    let Dtype::Record(fields) = &header.dtype else {
        return array.add(&header.dtype, 0, label, arrays);
    };
    let mut offset = 0_usize;
    for (name, dtype) in fields {
        // Unnamed fields are the padding of aligned structures.
        if !name.is_empty() {
            let label = ArrayLabel {
                parent: label.parent.clone(),
                name: name.clone(),
                ..ArrayLabel::default()
            };
            array.add(dtype, offset, &label, arrays)?;
        }
        offset = offset.saturating_add(dtype.size().unwrap_or(0));
    }
    Ok(())
}

/// The header, and where the data begin.
fn read_header(context: &FileContext, bytes: &[u8]) -> Result<(Header, usize), FormatError> {
    let short = || context.truncated(bytes.len(), "the header");
    let major = *bytes.get(6).ok_or_else(short)?;
    let (start, length) = if major == 1 {
        let length = bytes.get(8..10).and_then(|b| b.first_chunk::<2>());
        (
            10,
            usize::from(u16::from_le_bytes(*length.ok_or_else(short)?)),
        )
    } else {
        let length = bytes.get(8..12).and_then(|b| b.first_chunk::<4>());
        let length = u32::from_le_bytes(*length.ok_or_else(short)?);
        (12, usize::try_from(length).unwrap_or(usize::MAX))
    };
    if length > MAX_HEADER_BYTES {
        return Err(context.unsupported(
            format!("at byte 8 stands {length} as the length of the header, which is at most {MAX_HEADER_BYTES}"),
            SAVE_AGAIN,
        ));
    }
    let end = start + length;
    let header = bytes.get(start..end).ok_or_else(short)?;
    let written = text(header);
    let header = parse(&written).ok_or_else(|| {
        let shown: String = written.trim().chars().take(MAX_SHOWN_CHARS).collect();
        context.unsupported(
            format!("the header at byte {start}, {shown}, does not give a type, an order and a shape as numpy.save writes them"),
            SAVE_AGAIN,
        )
    })?;
    Ok((header, end))
}

/// The elements of an array.
struct Element<'a> {
    context: &'a FileContext<'a>,
    data: &'a [u8],
    data_at: usize,
    element: usize,
    shape: &'a [usize],
    column_major: bool,
}

impl Element<'_> {
    /// Adds what lies at `offset` in each element.
    fn add(
        &self,
        dtype: &Dtype,
        offset: usize,
        label: &ArrayLabel,
        arrays: &mut Arrays,
    ) -> Result<(), FormatError> {
        match dtype {
            Dtype::Plain(plain) => self.add_plain(plain, offset, label, arrays),
            Dtype::Objects => Ok(()),
            Dtype::Other { code, .. } => {
                let what = format!("{} (type {code}, no numbers)", label.path());
                arrays.left_out.push(what);
                Ok(())
            }
            Dtype::Array(count, _) if *count > MAX_COLUMNS => {
                let what = format!("{} ({count} numbers in each row)", label.path());
                arrays.left_out.push(what);
                Ok(())
            }
            Dtype::Array(count, inner) => {
                let size = inner.size().unwrap_or(0);
                for index in 0..*count {
                    let label = ArrayLabel {
                        name: format!("{} {}", label.name, index + 1),
                        ..label.clone()
                    };
                    let at = offset.saturating_add(index.saturating_mul(size));
                    self.add(inner, at, &label, arrays)?;
                }
                Ok(())
            }
            Dtype::Record(fields) => {
                let mut at = offset;
                for (name, dtype) in fields {
                    let label = ArrayLabel {
                        name: format!("{}.{name}", label.name),
                        ..label.clone()
                    };
                    self.add(dtype, at, &label, arrays)?;
                    at = at.saturating_add(dtype.size().unwrap_or(0));
                }
                Ok(())
            }
        }
    }

    /// Adds numbers, or both parts of complex ones.
    fn add_plain(
        &self,
        plain: &Plain,
        offset: usize,
        label: &ArrayLabel,
        arrays: &mut Arrays,
    ) -> Result<(), FormatError> {
        let parts: &[(&str, usize)] = if plain.is_complex {
            arrays.notes.push(format!(
                "\"{}\" is complex; its real and imaginary parts became two columns.",
                label.path()
            ));
            &[(".re", 0), (".im", 1)]
        } else {
            &[("", 0)]
        };
        for (suffix, part) in parts {
            let mut content = Matrix {
                bytes: self.data,
                number: plain.number,
                order: plain.order,
                offset: offset.saturating_add(part * plain.number.size()),
                element: self.element,
                shape: self.shape,
                column_major: self.column_major,
            }
            .read();
            let mut label = ArrayLabel {
                name: format!("{}{suffix}", label.name),
                ..label.clone()
            };
            if let Some(scale) = plain.scale {
                in_seconds(&mut content, scale);
                label.unit = Some("s".to_owned());
                arrays.notes.push(format!(
                    "\"{}\" holds dates or durations; they became seconds (dates: since 1970).",
                    label.path()
                ));
            }
            if !arrays.add(&label, content) {
                let end = self.data_at + self.data.len();
                return Err(self.context.truncated(end, label.path()));
            }
        }
        Ok(())
    }
}

/// NumPy's "not a time" is the least integer.
fn in_seconds(content: &mut MatrixContent, scale: f64) {
    let convert = |value: &mut f64| {
        *value = if *value <= i64::MIN as f64 {
            f64::NAN
        } else {
            *value * scale
        };
    };
    match content {
        MatrixContent::Scalar(value) => convert(value),
        MatrixContent::Columns { columns, .. } => {
            columns.iter_mut().flatten().for_each(convert);
        }
        _ => {}
    }
}
