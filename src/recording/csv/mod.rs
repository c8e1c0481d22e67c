//! Recordings as delimited text: `t [s], V [V], xp [um], xc [um]`, and what laboratories have instead.
//!
//! Columns in any order and unit, with names in several languages; comma, semicolon, tab, pipe, blanks,
//! cells of a fixed width or `label:value`; decimal and thousands marks; UTF-8, UTF-16 or an older
//! encoding; comments and free text before the header; the headers of oscilloscopes ([`Preview::written_by`]);
//! a sampling rate in place of a time column. `V` and `xc` may be missing, and `x [m]` alone is the proof
//! mass. What a file says clearly needs no dialog ([`import_auto`]); otherwise [`preview`] shows what
//! was understood, [`ReadingChoices`] answers what is open, and [`import`] does what was settled. What has
//! more than one reading is never guessed in silence.

mod choices;
mod columns;
mod finish;
mod in_order;
pub mod integrate;
mod line;
mod number;
mod open_preview;
mod preview;
mod read;
mod rows;
mod scopes;
mod settings;
mod shown;
pub(crate) mod sniff;
#[cfg(test)]
mod tests;
mod text;
pub(crate) mod write;

pub use self::choices::ReadingChoices;
pub(super) use self::columns::several;
pub(super) use self::number::text_marks::{TextMarks, is_number_in_text};
pub use self::open_preview::{preview, preview_bytes, trials};
pub use self::preview::{Preview, Trial};
pub(super) use self::read::hex;
pub use self::settings::{
    ColumnChoice, Decimal, Delimiter, DriftRemoval, Encoding, ImportSettings, Quantity,
    SampleClock, TimeZero,
};
pub use self::shown::{ShownRows, shown_rows};
pub use self::text::Progress;
pub(super) use self::text::{read_file, short_name};
pub use self::write::{WriteError, write_csv, write_recording};

use std::path::Path;

use self::columns::Topic;
use self::columns::names::Role;
use self::open_preview::preview_head;
use self::read::read;
use super::error::ImportError;
use super::{Channel, Recording};

/// Reads a file as `settings` say.
///
/// # Errors
/// [`ImportError`]; every one names the file, the place and the remedy.
pub fn import(
    path: &Path,
    settings: &ImportSettings,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let file = path.display().to_string();
    let bytes = text::read_file(path, progress)?;
    let mut recording = read(&file, &bytes, settings, Vec::new(), progress)?;
    recording.name = text::short_name(path);
    recording.path = Some(path.to_owned());
    Ok(recording)
}

/// [`import`] from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`import`].
pub fn import_bytes(
    name: &str,
    bytes: &[u8],
    settings: &ImportSettings,
) -> Result<Recording, ImportError> {
    read(name, bytes, settings, Vec::new(), None)
}

/// Reads a file as its header says; guesses are among the recording's warnings.
///
/// # Errors
/// As [`import`], and if the time or position column cannot be recognised.
pub fn import_auto(path: &Path, progress: Option<&Progress>) -> Result<Recording, ImportError> {
    import_auto_with(path, &|_| {}, progress)
}

/// [`import_auto`] with the settings that the header gives changed before they are used: a sign, a scale.
///
/// # Errors
/// As [`import_auto`].
pub fn import_auto_with(
    path: &Path,
    change: &dyn Fn(&mut ImportSettings),
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let file = path.display().to_string();
    let bytes = text::read_file(path, progress)?;
    let mut recording = read_auto(&file, &bytes, change, progress)?;
    recording.name = text::short_name(path);
    recording.path = Some(path.to_owned());
    Ok(recording)
}

/// [`import_auto`] from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`import_auto`].
///
/// # Examples
/// ```
/// use impactscope::recording::csv::import_bytes_auto;
///
/// let text = b"t [ms],V [V],xp [um]\n0.0,7,1.5\n0.1,7,1.25\n0.2,-7,1.0\n";
/// let recording = import_bytes_auto("example.csv", text)?;
/// assert_eq!(recording.len(), 3);
/// assert_eq!(recording.proof_mass[0], 1.5e-6); // metres
/// assert!(recording.cantilever.is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn import_bytes_auto(name: &str, bytes: &[u8]) -> Result<Recording, ImportError> {
    read_auto(name, bytes, &|_| {}, None)
}

/// The voltage of a file whose header names time and voltage; it needs no displacement.
/// `(times [s], volts [V])` without missing samples. Times are those of the file: a table says when
/// a voltage acts.
///
/// # Errors
/// As [`import_auto`], and if there is no voltage.
pub fn import_voltage(path: &Path) -> Result<(Vec<f64>, Vec<f64>), ImportError> {
    let bytes = text::read_file(path, None)?;
    import_voltage_bytes(&path.display().to_string(), &bytes)
}

/// [`import_voltage`] from memory; `file` stands for the file in messages.
///
/// # Errors
/// As [`import_voltage`].
pub fn import_voltage_bytes(file: &str, bytes: &[u8]) -> Result<(Vec<f64>, Vec<f64>), ImportError> {
    let preview = preview_head(file, bytes)?;
    let mut settings = ImportSettings {
        time_zero: TimeZero::File,
        times_as_written: true,
        cantilever: None,
        ..preview.settings
    };
    let no_voltage = || ImportError::NoVoltageColumn {
        file: file.into(),
        line: settings.skip_lines.max(1),
    };
    // A single channel in volts is the drive here.
    let in_volts = |choice: &ColumnChoice| columns::units::unit_shift(&choice.unit, "V").is_some();
    let voltage = settings.voltage.clone();
    let voltage = voltage.or_else(|| settings.proof_mass.clone().filter(in_volts));
    let voltage = voltage.ok_or_else(no_voltage)?;
    let about_motion = |topic: Topic| {
        let roles = [Role::ProofMass, Role::Cantilever];
        roles
            .iter()
            .any(|r| [Topic::Column(*r), Topic::Unit(*r), Topic::Scale(*r)].contains(&topic))
    };
    let mut open = preview.questions.into_iter();
    if let Some(question) = open.find(|question| !about_motion(question.topic)) {
        return Err(question.error);
    }
    // A recording has a displacement: the voltage's numbers stand in for it, unread.
    settings.proof_mass = Some(ColumnChoice::new(voltage.index, "m"));
    settings.voltage = Some(voltage);
    let recording = read(file, bytes, &settings, Vec::new(), None)?;
    recording.drive_table().ok_or_else(no_voltage)
}

fn read_auto(
    file: &str,
    bytes: &[u8],
    change: &dyn Fn(&mut ImportSettings),
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let mut preview = preview_head(file, bytes)?;
    if let Some(problem) = preview.problem() {
        return Err(problem.clone());
    }
    change(&mut preview.settings);
    read(file, bytes, &preview.settings, preview.warnings, progress)
}

/// [`import_auto`] with answers to what the file leaves open.
///
/// # Errors
/// As [`import_auto`]; what the answers do not decide; an answer that does not fit the file.
pub fn import_chosen(
    path: &Path,
    choices: &ReadingChoices,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let file = path.display().to_string();
    let bytes = text::read_file(path, progress)?;
    let mut recording = import_bytes_chosen(&file, &bytes, choices)?;
    recording.name = text::short_name(path);
    recording.path = Some(path.to_owned());
    Ok(recording)
}

/// [`import_chosen`] from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`import_chosen`].
pub fn import_bytes_chosen(
    name: &str,
    bytes: &[u8],
    choices: &ReadingChoices,
) -> Result<Recording, ImportError> {
    let mut preview = preview_chosen(name, bytes, choices)?;
    if let Some(problem) = preview.problem() {
        return Err(problem.clone());
    }
    let warnings = std::mem::take(&mut preview.warnings);
    read(name, bytes, &preview.settings, warnings, None)
}

/// [`import_bytes_chosen`] of a recording with one displacement, whichever point of the device it is of:
/// it is in [`Recording::proof_mass`], and the channel says what the file calls it. A recording with both
/// points has both.
///
/// # Errors
/// As [`import_chosen`].
pub fn import_bytes_point(
    name: &str,
    bytes: &[u8],
    choices: &ReadingChoices,
) -> Result<(Recording, Channel), ImportError> {
    let mut preview = preview_chosen(name, bytes, choices)?;
    let channel = preview.take_single_point();
    if let Some(problem) = preview.problem() {
        return Err(problem.clone());
    }
    let warnings = std::mem::take(&mut preview.warnings);
    let recording = read(name, bytes, &preview.settings, warnings, None)?;
    Ok((recording, channel))
}

/// What is understood of a file with the answers given: its settings, and what is still open.
///
/// # Errors
/// As [`preview`]; an answer that does not fit the file.
pub fn preview_chosen(
    name: &str,
    bytes: &[u8],
    choices: &ReadingChoices,
) -> Result<Preview, ImportError> {
    let decoded = choices
        .encoding
        .map(|e| text::encoding::decode(bytes, Some(e), false).bytes);
    let mut preview = preview_head(name, decoded.as_deref().unwrap_or(bytes))?;
    preview.settings.encoding = choices.encoding.or(preview.settings.encoding);
    choices.apply(&mut preview)?;
    Ok(preview)
}
