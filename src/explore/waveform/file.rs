//! A drawn waveform as a small text file.
//!
//! ```toml
//! format = "impactscope waveform"
//! version = 1
//! name = "soft landing"
//! frequency_hz = 15.0
//! interpolation = "smooth"
//! # Share of the period, voltage [V].
//! handles = [[0.0, -8.0], [0.25, 8.0]]
//! ```
//! Further keys, all optional: `offset_v`, `phase_deg`, `burst = [on, of]`, `grid_share`,
//! `grid_v`, `limit_v`, `limit_v_per_s`.

use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::editable::{EditableWaveform, SnapGrid};
use super::error::WaveformError;
use super::limits::DriveLimits;
use crate::atomic_write::write_atomically;
use crate::model::drive::{Burst, Handle, Handles, Interpolation, Waveform};

/// What the first key says.
const FILE_FORMAT: &str = "impactscope waveform";
/// The version that is written, and the newest that is read.
const FILE_VERSION: u32 = 1;
/// Largest file that is read \[bytes\]: the longest list of handles takes 50 kB.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// The keys that say what a file is; the others depend on the version.
#[derive(Deserialize)]
struct Header {
    format: Option<String>,
    version: Option<u32>,
}

/// The file as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WaveformFile {
    format: String,
    version: u32,
    #[serde(default)]
    name: String,
    frequency_hz: f64,
    #[serde(default)]
    interpolation: Interpolation,
    #[serde(default, skip_serializing_if = "is_zero")]
    offset_v: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    phase_deg: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    burst: Option<(u32, u32)>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    grid_share: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    grid_v: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limit_v: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limit_v_per_s: Option<f64>,
    /// Share of the period and voltage of each handle.
    handles: Vec<(f64, f64)>,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Writes a waveform so that the file is whole or as before.
///
/// # Errors
/// [`WaveformError::Io`], and [`WaveformError::File`] for values that no file holds.
pub fn save(path: &Path, waveform: &EditableWaveform) -> Result<(), WaveformError> {
    // What cannot be a drive is not written either.
    waveform.waveform()?;
    let text = to_text(waveform).map_err(|reason| WaveformError::File {
        path: path.to_owned(),
        reason,
    })?;
    write_atomically(path, text.as_bytes()).map_err(|source| WaveformError::Io {
        path: path.to_owned(),
        source,
    })
}

/// The text of a waveform's file.
///
/// # Errors
/// A value that no file holds, in words.
pub fn to_text(waveform: &EditableWaveform) -> Result<String, String> {
    let file = WaveformFile {
        format: FILE_FORMAT.to_owned(),
        version: FILE_VERSION,
        name: waveform.name.clone(),
        frequency_hz: waveform.frequency,
        interpolation: waveform.interpolation(),
        offset_v: waveform.offset,
        phase_deg: waveform.phase,
        burst: waveform.burst.map(|burst| (burst.on, burst.of)),
        grid_share: waveform.grid.time,
        grid_v: waveform.grid.voltage,
        limit_v: waveform.limits.voltage,
        limit_v_per_s: waveform.limits.slew,
        handles: waveform
            .handles()
            .iter()
            .map(|p| (p.time, p.voltage))
            .collect(),
    };
    toml::to_string(&file).map_err(|error| error.to_string())
}

/// Whether a text says of itself that it is a drawn waveform.
#[must_use]
pub fn is_waveform_file(text: &str) -> bool {
    toml::from_str(text).is_ok_and(|header: Header| header.format.as_deref() == Some(FILE_FORMAT))
}

/// Reads a waveform's file.
///
/// # Errors
/// [`WaveformError::Io`]; [`WaveformError::File`] with the line if it is no waveform or of a newer
/// version.
pub fn load(path: &Path) -> Result<EditableWaveform, WaveformError> {
    let io = |source| WaveformError::Io {
        path: path.to_owned(),
        source,
    };
    let fail = |reason: String| WaveformError::File {
        path: path.to_owned(),
        reason,
    };
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(io)?;
    let mut part = file.take(MAX_FILE_BYTES + 1);
    part.read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(fail(format!(
            "longer than {MAX_FILE_BYTES} bytes, so no drawn waveform; a list of points is table:FILE"
        )));
    }
    let Ok(text) = String::from_utf8(bytes) else {
        return Err(fail("not a text file".to_owned()));
    };
    parse(&text).map_err(fail)
}

/// Reads the text of a waveform's file.
///
/// # Errors
/// What is wrong, with the line.
pub fn parse(text: &str) -> Result<EditableWaveform, String> {
    let in_words = |error: toml::de::Error| {
        let line = error
            .span()
            .map(|span| text.as_bytes()[..span.start.min(text.len())].iter())
            .map(|before| before.filter(|b| **b == b'\n').count() + 1);
        let message = error
            .message()
            .lines()
            .next()
            .unwrap_or_default()
            .to_owned();
        line.map_or(message.clone(), |line| format!("line {line}: {message}"))
    };
    let header: Header = toml::from_str(text).map_err(in_words)?;
    if header.format.as_deref() != Some(FILE_FORMAT) {
        return Err(format!(
            "no drawn waveform; its first line would be format = \"{FILE_FORMAT}\""
        ));
    }
    match header.version {
        Some(FILE_VERSION) => {}
        Some(newer) if newer > FILE_VERSION => {
            return Err(format!(
                "version {newer} of the format, and this program reads up to {FILE_VERSION}; use the newer program that wrote it"
            ));
        }
        _ => {
            return Err(format!(
                "no version that is known; write version = {FILE_VERSION}"
            ));
        }
    }
    let file: WaveformFile = toml::from_str(text).map_err(in_words)?;
    let points = file.handles.iter();
    let points = points.map(|&(time, voltage)| Handle { time, voltage });
    let handles = Handles::new(points.collect(), file.interpolation);
    let handles = handles.map_err(|error| error.to_string())?;
    for (key, step) in [
        ("grid_share", file.grid_share),
        ("grid_v", file.grid_v),
        ("limit_v", file.limit_v),
        ("limit_v_per_s", file.limit_v_per_s),
    ] {
        if let Some(value) = step.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(format!(
                "{key} = {value} must be a number above 0; leave it out for none"
            ));
        }
    }
    let mut waveform = EditableWaveform::new(file.name, handles, file.frequency_hz);
    waveform.offset = file.offset_v;
    waveform.phase = file.phase_deg;
    waveform.burst = file.burst.map(|(on, of)| Burst { on, of });
    waveform.grid = SnapGrid {
        time: file.grid_share,
        voltage: file.grid_v,
    };
    waveform.limits = DriveLimits {
        voltage: file.limit_v,
        slew: file.limit_v_per_s,
    };
    waveform.waveform().map_err(|error| error.to_string())?;
    Ok(waveform)
}

/// The drive `handles:FILE`, with named fields after it that stand for those of the file:
/// `handles:step.toml:frequency=20Hz:amplitude=4V`. `rest` is what follows `handles:`.
///
/// # Errors
/// Those of [`load`], and [`WaveformError::Drive`] for a field.
pub fn read_drive_file(rest: &str) -> Result<Waveform, WaveformError> {
    let (path, fields) = file_and_fields(rest);
    let drive = load(Path::new(path))?.drive();
    let text = format!("handles:{rest}");
    Ok(drive.with_fields(&text, &fields)?.waveform()?)
}

/// The file of `handles:FILE` and the named fields after it; `rest` is what follows `handles:`.
#[must_use]
pub fn file_and_fields(rest: &str) -> (&str, Vec<&str>) {
    const FIELDS_OF_FILE: [&str; 5] = ["frequency", "amplitude", "offset", "phase", "burst"];
    let (mut path, mut fields) = (rest, Vec::new());
    // From the end, as the name of a file may have colons and equals signs.
    while let Some((before, field)) = path.rsplit_once(':')
        && let Some((key, _)) = field.split_once('=')
        && FIELDS_OF_FILE.contains(&key.trim())
    {
        fields.insert(0, field);
        path = before;
    }
    (path, fields)
}
