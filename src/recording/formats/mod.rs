//! Binary and structured formats, one file (or folder) each. Text tables are [`super::csv`]'s.
//!
//! A format is added by its file and one line in [`FORMATS`]. Reading gives tables of columns as the
//! file has them ([`crate::recording::formats::raw_table`]); which column is what is decided elsewhere.

mod archive;
mod arrays;
mod bytes;
mod error;
mod format;
mod gzip;
mod hdf5;
mod hdf5_attributes;
mod hdf5_lzf;
mod lines;
mod lvm;
mod mat5;
mod matrix;
mod npy;
mod npy_header;
mod npz;
pub mod raw_table;
mod refused;
mod sheet_header;
mod tdms;
mod uff;
mod unpack;
mod wav;
mod xlsx;
mod zip;

#[cfg(test)]
mod tests;

pub use self::error::FormatError;
pub use self::format::{Format, FormatContent};

/// How much of a file [`recognise`] needs at most \[bytes\]: HDF5 may begin after a block of 2048.
pub const HEAD_BYTES: usize = 4096;

/// All formats; the first that recognises a file reads it.
pub static FORMATS: &[&dyn Format] = &[
    &lvm::Lvm,
    &tdms::Tdms,
    &hdf5::Hdf5,
    &mat5::Mat5,
    &npy::Npy,
    &npz::Npz,
    &xlsx::Xlsx,
    &zip::Zip,
    &gzip::Gzip,
    &wav::Wav,
    &uff::Uff,
    &refused::PARQUET,
    &refused::XLS,
    &refused::ORIGIN,
];

/// The format of a file by its first bytes ([`HEAD_BYTES`] or all); `None` for text tables and what
/// is not known.
///
/// # Examples
/// ```
/// use impactscope::recording::formats::recognise;
/// let head = b"RIFF\x24\0\0\0WAVEfmt ";
/// assert_eq!(recognise(head, "a.wav").map(|format| format.id()), Some("wav"));
/// assert!(recognise(b"t [s], V [V]\n0, 1\n", "a.csv").is_none());
/// ```
#[must_use]
pub fn recognise(head: &[u8], file_name: &str) -> Option<&'static dyn Format> {
    FORMATS
        .iter()
        .copied()
        .find(|format| format.recognises(head, file_name))
}
