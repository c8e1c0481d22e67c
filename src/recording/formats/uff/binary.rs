//! Data of a function as bytes, dataset 58b.

use super::super::bytes::{ByteOrder, Layout, NumberType, decode};
use super::super::error::{FileContext, FormatError};
use super::super::lines::Lines;
use super::function::{Function, Header};

/// Reads the numbers below a header. Neither the header's number of bytes nor a newline before the
/// closing delimiter can be relied on: where the delimiter follows decides.
pub(super) fn read(
    context: &FileContext,
    header: &Header,
    bytes: &[u8],
    lines: &mut Lines,
) -> Result<Function, FormatError> {
    let at = lines.at();
    let data = bytes.get(at..).unwrap_or_default();
    let short = || {
        context.truncated(
            bytes.len(),
            format!("the {} samples of a function", header.count),
        )
    };
    let size = if header.is_double { 8 } else { 4 };
    let length = |sample: usize| header.count.checked_mul(sample);
    let full = length(size * header.numbers_per_sample()).ok_or_else(short)?;
    // Some writers store the abscissa of double precision data in single precision, as the text
    // format does.
    let mixed = (!header.is_even && header.is_double)
        .then(|| length(4 + size * (header.numbers_per_sample() - 1)))
        .flatten();
    let mut notes = Vec::new();
    let is_mixed = !ends_at(data, full) && mixed.is_some_and(|mixed| ends_at(data, mixed));
    let used = if is_mixed {
        mixed.unwrap_or(full)
    } else {
        full
    };
    if used > data.len() {
        return Err(short());
    }
    if !ends_at(data, used) {
        notes.push(format!(
            "\"{}\": {} bytes of data are expected, but no end of the dataset follows them.",
            header.name(),
            used
        ));
    }
    let said = header.binary.and_then(|binary| binary.bytes);
    if said.is_some_and(|said| said != used) && ends_at(data, used) {
        notes.push(format!(
            "\"{}\": the header says {} bytes of data, {used} are there; all {} samples were read.",
            header.name(),
            said.unwrap_or(0),
            header.count
        ));
    }
    let order = header
        .binary
        .map_or(ByteOrder::Little, |binary| binary.order);
    let number = if header.is_double {
        NumberType::F64
    } else {
        NumberType::F32
    };
    let abscissa_type = if is_mixed { NumberType::F32 } else { number };
    let abscissa_size = if header.is_even {
        0
    } else {
        abscissa_type.size()
    };
    let stride = abscissa_size + size * (1 + usize::from(header.is_complex));
    let column = |number: NumberType, offset: usize| {
        let layout = Layout {
            number,
            order,
            offset,
            stride,
            count: header.count,
        };
        decode(data, &layout).ok_or_else(short)
    };
    let function = Function {
        abscissa: if header.is_even {
            None
        } else {
            Some(column(abscissa_type, 0)?)
        },
        ordinate: column(number, abscissa_size)?,
        notes,
    };
    lines.seek(at + used + gap(data.get(used..).unwrap_or_default()));
    Ok(function)
}

/// Line ends before a delimiter.
fn gap(rest: &[u8]) -> usize {
    rest.iter()
        .take(2)
        .take_while(|b| matches!(b, b'\r' | b'\n'))
        .count()
}

/// Whether a closing delimiter stands at `at`, or the file ends there.
fn ends_at(data: &[u8], at: usize) -> bool {
    let Some(rest) = data.get(at..) else {
        return false;
    };
    let rest = rest.get(gap(rest)..).unwrap_or_default();
    let line = rest.get(..rest.len().min(82)).unwrap_or_default();
    let line = line.split(|b| *b == b'\n').next().unwrap_or_default();
    rest.is_empty() || line.trim_ascii() == b"-1"
}
