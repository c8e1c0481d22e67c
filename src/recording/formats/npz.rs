//! NumPy's `.npz`: a zip archive of arrays, by name.

use super::archive::{Archive, first_entry, is_zip, names, open, unpack};
use super::arrays::{ArrayLabel, Arrays, stem};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::npy::read_array;
use super::unpack::MAX_UNPACKED_BYTES;

/// Reads `.npz` files.
#[derive(Debug)]
pub struct Npz;

const NAME: &str = "NumPy archive";

impl Format for Npz {
    fn id(&self) -> &'static str {
        "npz"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["npz"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        is_zip(head) && first_entry(head).is_some_and(|name| name.ends_with(b".npy"))
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        read_archive(&context, &mut open(&context, bytes)?)
    }
}

/// All arrays of an archive.
pub(super) fn read_archive(
    context: &FileContext,
    archive: &mut Archive<'_>,
) -> Result<FormatContent, FormatError> {
    let mut arrays = Arrays::default();
    let mut total = 0_u64;
    for (index, name) in names(context, archive)?.into_iter().enumerate() {
        let Some(name) = name else { continue };
        let Some(path) = name.strip_suffix(".npy") else {
            arrays.left_out.push(format!("{name} (no array)"));
            continue;
        };
        let (parent, name) = path.rsplit_once('/').unwrap_or(("", path));
        let label = ArrayLabel {
            parent: parent.to_owned(),
            name: name.to_owned(),
            ..ArrayLabel::default()
        };
        let inner = unpack(context, archive, index)?;
        total = total.saturating_add(inner.len() as u64);
        if total > MAX_UNPACKED_BYTES {
            return Err(context.too_large(MAX_UNPACKED_BYTES));
        }
        match read_array(context, &inner, &label, &mut arrays) {
            // Names and settings are often saved beside the signals.
            Err(FormatError::Unsupported { .. }) => {
                arrays
                    .left_out
                    .push(format!("{path} (Python objects, no numbers)"));
            }
            other => other?,
        }
    }
    let tables = arrays.into_tables(context, &stem(context.file))?;
    Ok(FormatContent::Tables(tables))
}
