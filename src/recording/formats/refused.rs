//! Formats that are known and not read: a clear refusal with the way out.

use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};

/// A format that is recognised in order to say what to do instead.
#[derive(Debug)]
pub struct Refused {
    id: &'static str,
    name: &'static str,
    extensions: &'static [&'static str],
    /// First bytes of each of its files.
    magic: &'static [u8],
    what: &'static str,
    remedy: &'static str,
}

/// Apache Parquet: columns in blocks of several compressions, of which some have no decoder in Rust.
pub static PARQUET: Refused = Refused {
    id: "parquet",
    name: "Parquet",
    extensions: &["parquet"],
    magic: b"PAR1",
    what: "this is a Parquet file",
    remedy: "save the table as CSV, as Excel or as a NumPy array (in pandas: table.to_csv(\"recording.csv\", index=False))",
};

/// Excel before 2007 and other files of OLE streams.
pub static XLS: Refused = Refused {
    id: "xls",
    name: "Excel 97",
    extensions: &["xls"],
    magic: &[0xd0, 0xcf, 0x11, 0xe0, 0xa1, 0xb1, 0x1a, 0xe1],
    what: "this is a workbook of Excel 97 to 2003 (.xls), or another file of that kind",
    remedy: "open it and save it as .xlsx or as CSV UTF-8",
};

/// Origin's projects.
pub static ORIGIN: Refused = Refused {
    id: "origin",
    name: "Origin",
    extensions: &["opj", "opju"],
    magic: b"CPY",
    what: "this is a project of Origin",
    remedy: "export the worksheet as CSV or as Excel",
};

impl Format for Refused {
    fn id(&self) -> &'static str {
        self.id
    }

    fn name(&self) -> &'static str {
        self.name
    }

    fn extensions(&self) -> &'static [&'static str] {
        self.extensions
    }

    fn recognises(&self, head: &[u8], file_name: &str) -> bool {
        // Three letters alone may begin a text.
        let name = file_name.to_ascii_lowercase();
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        head.starts_with(self.magic)
            && (self.magic.len() > 3 || self.extensions.contains(&extension))
    }

    fn read(&self, file: &str, _bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext {
            file,
            format: self.name,
        };
        Err(context.unsupported(self.what, self.remedy))
    }
}
