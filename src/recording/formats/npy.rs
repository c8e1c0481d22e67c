//! NumPy's `.npy`: one array. The header is read by `npyz`, the numbers here, by column.
//!
//! Format: NEP 1 and `numpy.lib.format`, versions 1.0 to 3.0.

use npyz::{DType, Endianness, NpyHeader, Order, TimeUnits, TypeChar, TypeStr};

use super::arrays::{ArrayLabel, Arrays, stem};
use super::bytes::{ByteOrder, NumberType};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::matrix::{Matrix, MatrixContent};

/// Reads `.npy` files.
#[derive(Debug)]
pub struct Npy;

const NAME: &str = "NumPy";
/// First bytes of every `.npy` file.
const MAGIC: &[u8] = b"\x93NUMPY";
/// Longest header that is parsed \[bytes\]. NumPy refuses longer ones, too, unless told otherwise:
/// `numpy.lib.format` has 10000; structured types of some hundred fields need more.
const MAX_HEADER_BYTES: usize = 64 << 10;
/// Deepest nesting of brackets in a header, so that its parser's recursion stays bounded. A
/// structured type with arrays in it has four.
const MAX_NESTING: usize = 16;

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

/// One number in an element: its type, its first byte, its bytes apart, a scale.
struct Plain {
    number: NumberType,
    order: ByteOrder,
    /// Seconds of one unit, for times.
    scale: Option<f64>,
    complex: bool,
}

/// Adds the array in `bytes` to `arrays`; its columns are named after `label`, or by its fields.
pub(super) fn read_array(
    context: &FileContext,
    bytes: &[u8],
    label: &ArrayLabel,
    arrays: &mut Arrays,
) -> Result<(), FormatError> {
    check_header(context, bytes)?;
    let mut data = bytes;
    let header = NpyHeader::from_reader(&mut data).map_err(|e| context.unreadable(e))?;
    let data_at = bytes.len() - data.len();
    let dtype = header.dtype();
    if dtype.uses_pickled_array() {
        return Err(context.unsupported(
            format!("\"{}\" holds Python objects, not numbers", label.path()),
            "save it as an array of numbers (array.astype(float)), or as CSV",
        ));
    }
    let shape: Option<Vec<usize>> = header
        .shape()
        .iter()
        .map(|n| usize::try_from(*n).ok())
        .collect();
    let (Some(shape), Some(element)) = (shape, dtype.num_bytes()) else {
        return Err(context.malformed(data_at, "the shape"));
    };
    let array = Element {
        context,
        data,
        data_at,
        element,
        shape: &shape,
        column_major: header.order() == Order::Fortran,
    };
    match &dtype {
        DType::Plain(_) | DType::Array(..) => array.add(&dtype, 0, label, arrays),
        DType::Record(fields) => {
            let mut offset = 0_usize;
            for field in fields {
                // Unnamed fields are the padding of aligned structures.
                if !field.name.is_empty() {
                    let label = ArrayLabel {
                        parent: label.parent.clone(),
                        name: field.name.clone(),
                        ..ArrayLabel::default()
                    };
                    array.add(&field.dtype, offset, &label, arrays)?;
                }
                let size = field.dtype.num_bytes().unwrap_or(0);
                offset = offset.saturating_add(size);
            }
            Ok(())
        }
    }
}

/// Fails on a header that is not there, too long, or nested too deep for its parser.
fn check_header(context: &FileContext, bytes: &[u8]) -> Result<(), FormatError> {
    let short = || context.truncated(bytes.len(), "the header");
    let major = *bytes.get(6).ok_or_else(short)?;
    let (start, length) = if major == 1 {
        let length = bytes.get(8..10).and_then(|b| b.first_chunk::<2>());
        (10, usize::from(u16::from_le_bytes(*length.ok_or_else(short)?)))
    } else {
        let length = bytes.get(8..12).and_then(|b| b.first_chunk::<4>());
        let length = u32::from_le_bytes(*length.ok_or_else(short)?);
        (12, usize::try_from(length).unwrap_or(usize::MAX))
    };
    if length > MAX_HEADER_BYTES {
        return Err(context.malformed(8, "the length of the header"));
    }
    let header = bytes.get(start..start + length).ok_or_else(short)?;
    let mut depth = 0_usize;
    for byte in header {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_NESTING {
            return Err(context.malformed(start, "the nesting of the header"));
        }
    }
    Ok(())
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
        dtype: &DType,
        offset: usize,
        label: &ArrayLabel,
        arrays: &mut Arrays,
    ) -> Result<(), FormatError> {
        match dtype {
            DType::Plain(kind) => match plain(kind) {
                Some(plain) => self.add_plain(&plain, offset, label, arrays),
                None => {
                    let what = format!("{} (type {kind}, no numbers)", label.path());
                    arrays.left_out.push(what);
                    Ok(())
                }
            },
            DType::Array(count, inner) => {
                let size = inner.num_bytes().unwrap_or(0);
                let count = usize::try_from(*count).unwrap_or(usize::MAX);
                if count > super::matrix::MAX_COLUMNS {
                    let what = format!("{} ({count} numbers in each row)", label.path());
                    arrays.left_out.push(what);
                    return Ok(());
                }
                for index in 0..count {
                    let label = ArrayLabel {
                        name: format!("{} {}", label.name, index + 1),
                        ..label.clone()
                    };
                    let at = offset.saturating_add(index.saturating_mul(size));
                    self.add(inner, at, &label, arrays)?;
                }
                Ok(())
            }
            DType::Record(fields) => {
                let mut at = offset;
                for field in fields {
                    let label = ArrayLabel {
                        name: format!("{}.{}", label.name, field.name),
                        ..label.clone()
                    };
                    self.add(&field.dtype, at, &label, arrays)?;
                    at = at.saturating_add(field.dtype.num_bytes().unwrap_or(0));
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
        let parts: &[(&str, usize)] = if plain.complex {
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

/// A type of number; `None` for text and raw bytes.
fn plain(kind: &TypeStr) -> Option<Plain> {
    let size = usize::try_from(kind.size_field()).ok()?;
    let mut scale = None;
    let mut complex = false;
    let number = match kind.type_char() {
        TypeChar::Bool => NumberType::U8,
        TypeChar::Int => NumberType::integer(size, true)?,
        TypeChar::Uint => NumberType::integer(size, false)?,
        TypeChar::Float => NumberType::float(size)?,
        TypeChar::Complex => {
            complex = true;
            NumberType::float(size / 2)?
        }
        TypeChar::DateTime | TypeChar::TimeDelta => {
            scale = Some(seconds(kind.time_units()?)?);
            NumberType::I64
        }
        _ => return None,
    };
    let order = match kind.endianness() {
        Endianness::Big => ByteOrder::Big,
        _ => ByteOrder::Little,
    };
    Some(Plain {
        number,
        order,
        scale,
        complex,
    })
}

/// Seconds of a unit; `None` for those of no fixed length.
fn seconds(unit: TimeUnits) -> Option<f64> {
    Some(match unit {
        TimeUnits::Week => 604_800.0,
        TimeUnits::Day => 86400.0,
        TimeUnits::Hour => 3600.0,
        TimeUnits::Minute => 60.0,
        TimeUnits::Second => 1.0,
        TimeUnits::Millisecond => 1e-3,
        TimeUnits::Microsecond => 1e-6,
        TimeUnits::Nanosecond => 1e-9,
        TimeUnits::Picosecond => 1e-12,
        TimeUnits::Femtosecond => 1e-15,
        TimeUnits::Attosecond => 1e-18,
        _ => return None,
    })
}
