//! Unpacking with a bound: what a compressed file says of its size is not believed.

use std::io::Read;

use super::error::{FileContext, FormatError};

/// Most bytes that one compressed part may unpack to. A recording of 10^7 rows and four columns of
/// text has 0.6 GB.
pub(super) const MAX_UNPACKED_BYTES: u64 = 4 << 30;
/// Deflate cannot pack better than this (zlib's technical notes: 1032:1).
pub(super) const MAX_DEFLATE_RATIO: u64 = 1032;

/// All of `input`, which unpacks `packed` bytes.
///
/// # Errors
/// [`FormatError::TooLarge`], or [`FormatError::Unreadable`] with the reader's reason.
pub(super) fn read_bounded(
    context: &FileContext,
    input: impl Read,
    packed: usize,
) -> Result<Vec<u8>, FormatError> {
    let possible = (packed as u64).saturating_mul(MAX_DEFLATE_RATIO);
    let limit = possible.clamp(1 << 16, MAX_UNPACKED_BYTES);
    let mut bytes = Vec::new();
    input
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| context.unreadable(error))?;
    if bytes.len() as u64 > limit {
        return Err(context.too_large(limit));
    }
    Ok(bytes)
}
