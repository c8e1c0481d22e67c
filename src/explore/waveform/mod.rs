//! Drive waveforms that are drawn and varied.
//!
//! - [`EditableWaveform`]: one period drawn by handles, with a grid and limits;
//! - [`excesses`]: where a drive goes beyond limits of voltage and slew;
//! - [`parameters`], [`get`], [`set`]: the numbers of a drive that a map or a search can vary;
//! - [`load`], [`save`], [`read_drive_file`]: its own file;
//! - [`export`]: the files of function generators.

mod editable;
mod error;
pub mod export;
mod file;
mod from_waveform;
mod limits;
mod parameters;
#[cfg(test)]
mod tests;

pub use self::editable::{EditableWaveform, SnapGrid};
pub use self::error::WaveformError;
pub use self::file::{
    file_and_fields, is_waveform_file, load, parse, read_drive_file, save, to_text,
};
pub use self::limits::{DriveLimits, Excess, ExcessKind, excesses};
pub use self::parameters::{WaveformParameter, WaveformQuantity, get, parameters, set};
