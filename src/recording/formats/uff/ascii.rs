//! Data of a function as text.

use super::super::error::{FileContext, FormatError};
use super::super::lines::Lines;
use super::function::{Function, Header};

/// Fewest bytes of a number in the file's formats (E13.5).
const MIN_BYTES: usize = 13;

/// Reads the numbers below a header. Numbers may touch each other: widths are fixed.
pub(super) fn read(
    context: &FileContext,
    header: &Header,
    lines: &mut Lines,
) -> Result<Function, FormatError> {
    let per_sample = header.numbers_per_sample();
    let short = |at: usize, have: usize| {
        context.truncated(
            at,
            format!("a function ({have} of {} samples)", header.count),
        )
    };
    let wanted = header
        .count
        .checked_mul(per_sample)
        .ok_or_else(|| short(lines.at(), 0))?;
    let room = lines.remaining() / MIN_BYTES + 1;
    let samples = header.count.min(room / per_sample + 1);
    let mut function = Function::default();
    if !header.is_even {
        function.abscissa = Some(Vec::with_capacity(samples));
    }
    function.ordinate.reserve(samples);
    let mut have = 0;
    while have < wanted {
        // A closing delimiter is left for the caller.
        let line = lines.peek().filter(|line| line.trim_ascii() != b"-1");
        let Some(line) = line else {
            return Err(short(lines.at(), have / per_sample));
        };
        lines.next();
        let mut rest = line;
        while have < wanted {
            rest = rest.trim_ascii_start();
            if rest.is_empty() {
                break;
            }
            let length = number_length(rest);
            let (text, after) = rest.split_at(length);
            let value = parse(text).ok_or_else(|| {
                context.malformed_line(
                    lines.number(),
                    format!(
                        "\"{}\" is not a number",
                        String::from_utf8_lossy(rest).trim()
                    ),
                )
            })?;
            rest = after;
            match &mut function.abscissa {
                Some(abscissa) if have % per_sample == 0 => abscissa.push(value),
                _ => function.ordinate.push(value),
            }
            have += 1;
        }
    }
    Ok(function)
}

/// Bytes of the number that `text` begins with: up to a space, or a sign that is no exponent's.
fn number_length(text: &[u8]) -> usize {
    let mut before = b' ';
    for (at, byte) in text.iter().enumerate() {
        let is_sign = matches!(byte, b'+' | b'-');
        if byte.is_ascii_whitespace()
            || (is_sign && at > 0 && !matches!(before, b'e' | b'E' | b'd' | b'D'))
        {
            return at;
        }
        before = *byte;
    }
    text.len()
}

/// A number with E or D before its exponent.
fn parse(text: &[u8]) -> Option<f64> {
    if text.iter().any(|b| matches!(b, b'd' | b'D')) {
        let mut copy = [0_u8; 40];
        let copy = copy.get_mut(..text.len())?;
        for (to, from) in copy.iter_mut().zip(text) {
            *to = if matches!(from, b'd' | b'D') {
                b'e'
            } else {
                *from
            };
        }
        return std::str::from_utf8(copy).ok()?.parse().ok();
    }
    std::str::from_utf8(text).ok()?.parse().ok()
}
