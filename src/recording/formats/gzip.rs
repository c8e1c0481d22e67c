//! Gzip: one file, compressed. What is inside is read by its own name.

use flate2::read::MultiGzDecoder;

use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::unpack::read_bounded;

/// Opens `.gz` files.
#[derive(Debug)]
pub struct Gzip;

const NAME: &str = "gzip";

impl Format for Gzip {
    fn id(&self) -> &'static str {
        "gz"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["gz"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        // RFC 1952: two magic bytes, then 8 for "deflate".
        head.starts_with(&[0x1f, 0x8b, 8])
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let inner = read_bounded(&context, MultiGzDecoder::new(bytes), bytes.len())?;
        let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
        let name = match name.rsplit_once('.') {
            Some((inner, "gz" | "GZ" | "gzip")) => inner,
            _ => name,
        };
        Ok(FormatContent::Inner {
            name: name.to_owned(),
            bytes: inner,
        })
    }
}
