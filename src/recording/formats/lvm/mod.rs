//! LabVIEW measurement files (`.lvm`): text with a header for the file and one for each segment.
//!
//! Source: NI, "Specification for the LabVIEW Measurement File (.lvm)", and the sample files of
//! `lvm_read`. Times are a column of the file (`X_Columns` One or Multi), or follow from `X0` and
//! `Delta_X` (No). Segments that go on in time are joined.

mod header;
mod part;
mod rows;

use self::header::{FileHeader, SegmentHeader};
use self::part::{Part, join, parts};
use self::rows::{Rows, read_rows};
use super::arrays::{finish, listed, stem};
use super::bytes::text;
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::lines::Lines;

/// Reads `.lvm` files.
#[derive(Debug)]
pub struct Lvm;

const NAME: &str = "LabVIEW LVM";
/// First bytes of every file.
const MAGIC: &[u8] = b"LabVIEW Measurement";
/// Most comments that a note shows.
const MAX_COMMENTS: usize = 3;

impl Format for Lvm {
    fn id(&self) -> &'static str {
        "lvm"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["lvm"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        head.starts_with(MAGIC)
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let mut lines = Lines::new(bytes);
        let mut file_header = FileHeader::read(&context, &mut lines)?;
        let mut notes = file_header.notes();
        let mut joined: Vec<Vec<Part>> = Vec::new();
        let mut segments = 0_usize;
        let mut comments: Vec<String> = Vec::new();
        let mut commented = 0_usize;
        while let Some(header) = SegmentHeader::read(&context, &mut file_header, &mut lines)? {
            if header.columns.is_empty() {
                continue;
            }
            segments += 1;
            if header.is_spectrum() {
                return Err(context.unsupported(
                    format!("segment {segments} is over frequency: a spectrum"),
                    "record the signals over time",
                ));
            }
            let rows = read_rows(&file_header, &header, &mut lines);
            notes.extend(rows.notes(&header));
            notes.extend(header.notes.iter().cloned());
            commented += rows.comments;
            comments.extend(rows.first_comments.iter().map(|c| text(c)));
            comments.dedup();
            comments.truncate(MAX_COMMENTS);
            let Rows { columns, .. } = rows;
            join(&mut joined, parts(&header, columns, &mut notes));
        }
        if commented > 0 {
            notes.push(format!(
                "{commented} rows have a comment (\"{}\"); comments are not read.",
                comments.join("\", \"")
            ));
        }
        notes.dedup();
        if segments > 1 && joined.len() < segments {
            notes.push(format!(
                "{segments} segments go on in time and were joined to {}.",
                joined.len()
            ));
        }
        let several = joined.iter().map(Vec::len).sum::<usize>() > 1;
        let mut tables = Vec::new();
        let mut names = Vec::new();
        for (run, parts) in joined.into_iter().enumerate() {
            for part in parts {
                names.extend(part.names.iter().cloned());
                let name = if several {
                    format!("{} segment {} {}", stem(file), run + 1, listed(&part.names))
                } else {
                    stem(file)
                };
                tables.extend(part.table(name, &notes));
            }
        }
        if tables.is_empty() {
            return Err(context.no_numbers(if names.is_empty() {
                "no segment with data".to_owned()
            } else {
                listed(&names)
            }));
        }
        Ok(FormatContent::Tables(finish(tables)))
    }
}
