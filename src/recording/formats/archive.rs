//! Entries of a zip archive, with bounds.

use std::io::Cursor;

use zip::ZipArchive;

use super::error::{FileContext, FormatError};
use super::unpack::{MAX_DEFLATE_RATIO, MAX_UNPACKED_BYTES, read_bounded};

/// Most entries of an archive that are looked at. A phyphox export has a dozen.
const MAX_ENTRIES: usize = 10_000;

/// An archive in memory.
pub(super) type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// First bytes of a zip archive: a file, or an empty archive.
pub(super) fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06")
}

/// Name of the first entry, from the head of the file.
pub(super) fn first_entry(head: &[u8]) -> Option<&[u8]> {
    let length = head.get(26..28)?.first_chunk::<2>()?;
    head.get(30..30 + usize::from(u16::from_le_bytes(*length)))
}

/// Opens an archive; its entries' sizes are plausible.
///
/// # Errors
/// [`FormatError`] if the directory cannot be read or promises too much.
pub(super) fn open<'a>(context: &FileContext, bytes: &'a [u8]) -> Result<Archive<'a>, FormatError> {
    let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| context.unreadable(error))?;
    if archive.len() > MAX_ENTRIES {
        return Err(context.unsupported(
            format!("the archive has {} files", archive.len()),
            format!("unpack it and open the recording (at most {MAX_ENTRIES} are looked at)"),
        ));
    }
    Ok(archive)
}

/// Fails if the entries together unpack to more than fits, by the directory or by what their bytes
/// can hold.
pub(super) fn check_size(
    context: &FileContext,
    archive: &mut Archive<'_>,
) -> Result<(), FormatError> {
    let mut total = 0_u64;
    for index in 0..archive.len() {
        let entry = archive
            .by_index_raw(index)
            .map_err(|error| context.unreadable(error))?;
        let possible = entry.compressed_size().saturating_mul(MAX_DEFLATE_RATIO);
        total = total.saturating_add(entry.size().min(possible));
    }
    if total > MAX_UNPACKED_BYTES {
        return Err(context.too_large(MAX_UNPACKED_BYTES));
    }
    Ok(())
}

/// Names of the entries, in the archive's order; folders have `None`.
pub(super) fn names(
    context: &FileContext,
    archive: &mut Archive<'_>,
) -> Result<Vec<Option<String>>, FormatError> {
    (0..archive.len())
        .map(|index| {
            let entry = archive
                .by_index_raw(index)
                .map_err(|error| context.unreadable(error))?;
            let name = entry.name().map_err(|error| context.unreadable(error))?;
            Ok(entry.is_file().then(|| name.into_owned()))
        })
        .collect()
}

/// One entry, unpacked.
pub(super) fn unpack(
    context: &FileContext,
    archive: &mut Archive<'_>,
    index: usize,
) -> Result<Vec<u8>, FormatError> {
    let entry = archive
        .by_index(index)
        .map_err(|error| context.unreadable(error))?;
    let packed = usize::try_from(entry.compressed_size()).unwrap_or(usize::MAX);
    read_bounded(context, entry, packed)
}
