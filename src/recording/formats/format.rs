//! What a format is: how it is recognised, and what reading it gives.

use super::error::FormatError;
use crate::recording::formats::raw_table::RawTable;

/// A file format. One file of this folder implements each; [`super::FORMATS`] lists them.
pub trait Format: Sync {
    /// Short id for options and JSON, lower case.
    fn id(&self) -> &'static str;
    /// Name for messages and the file dialog.
    fn name(&self) -> &'static str;
    /// Extensions without the dot, lower case. For the file dialog: files are recognised by their
    /// content.
    fn extensions(&self) -> &'static [&'static str];
    /// Whether a file that begins with `head` (a few kB, or all of it) is of this format.
    /// `file_name` decides only between formats with the same first bytes.
    fn recognises(&self, head: &[u8], file_name: &str) -> bool;
    /// Reads a file; `file` stands for it in messages.
    ///
    /// # Errors
    /// [`FormatError`]; every one names the file, the place and the remedy.
    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError>;
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub enum FormatContent {
    /// Tables of numbers, at least one.
    Tables(Vec<RawTable>),
    /// One file in a wrapper (`.gz`, `.zip`), to be read by its own name and content.
    Inner {
        /// Name of the inner file.
        name: String,
        /// Its bytes, unpacked.
        bytes: Vec<u8>,
    },
    /// Several files in a wrapper, in its order.
    Several(Vec<(String, Vec<u8>)>),
}
