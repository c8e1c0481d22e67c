//! Zip archives: phyphox exports, and any recording that was packed. What is inside is read by its
//! own name.

use super::archive::{check_size, is_zip, names, open, unpack};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::{npz, xlsx};

/// Opens `.zip` files.
#[derive(Debug)]
pub struct Zip;

const NAME: &str = "zip";

impl Format for Zip {
    fn id(&self) -> &'static str {
        "zip"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["zip"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        is_zip(head)
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let mut archive = open(&context, bytes)?;
        let names = names(&context, &mut archive)?;
        let files = || names.iter().flatten();
        // A workbook or an array archive whose first entry does not say so.
        if files().any(|name| name == "xl/workbook.xml") {
            return xlsx::read_workbook(&context, bytes);
        }
        if files().next().is_some() && files().all(|name| name.ends_with(".npy")) {
            return npz::read_archive(&context, &mut archive);
        }
        check_size(&context, &mut archive)?;
        let mut several = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let Some(name) = name.as_ref().filter(|name| is_recording(name)) else {
                continue;
            };
            several.push((name.clone(), unpack(&context, &mut archive, index)?));
        }
        if several.len() > 1 {
            return Ok(FormatContent::Several(several));
        }
        match several.pop() {
            Some((name, bytes)) => Ok(FormatContent::Inner { name, bytes }),
            None => Err(context.unsupported(
                "the archive has no file that could be a recording",
                "pack the recording itself, or open it unpacked",
            )),
        }
    }
}

/// Whether an entry may be a recording: not what an archiver or phyphox (`meta/`) adds about the
/// file itself.
fn is_recording(name: &str) -> bool {
    let mut parts = name.split(['/', '\\']);
    let about = name.starts_with("meta/");
    !about && !parts.any(|part| part.starts_with('.') || part == "__MACOSX")
}
