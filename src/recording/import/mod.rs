//! The one door for recordings from files of any kind.
//!
//! A file is known by its first bytes, not by its name. Tables of numbers as text go to [`super::csv`];
//! binary and structured formats are read by [`super::formats`], unpacked where they are wrapped, and
//! their tables go the same way from there: the same names, units, questions and warnings. Where a file
//! holds several recordings, `trial` chooses one.

mod combined;
mod raw_text;
mod single;
mod source;
#[cfg(test)]
mod tests;

use std::path::Path;

pub use self::combined::{average_files, merge_files};
pub use self::single::{
    import_chosen, import_point, import_trials, import_voltage, preview, preview_chosen, trials,
};

use self::combined::import_combined;
use self::single::import_single;
use super::Recording;
use super::csv::{ImportSettings, Progress};
use super::error::ImportError;

/// Reads a file as `settings` say; where they say that it is an average or has its second point in
/// another file, that, too.
///
/// # Errors
/// [`ImportError`]; each names the file, the place and the remedy.
pub fn import(
    path: &Path,
    settings: &ImportSettings,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    match &settings.combine {
        None => import_single(path, settings, progress),
        Some(combination) => import_combined(path, settings, combination, progress),
    }
}
