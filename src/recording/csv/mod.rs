//! Recordings as delimited text: `t [s], V [V], xp [um], xc [um]`.
//!
//! Columns in any order, any of s/ms/us, V/mV, m/cm/mm/um/nm; comma, semicolon or
//! tab; decimal comma; a UTF-8 mark; comments and free text before the header;
//! `V` and `xc` may be missing, and `x [m]` alone is the proof mass. What a file
//! says clearly needs no dialog ([`import_auto`]); otherwise [`preview`] shows what
//! was understood and [`import`] does what the user settled.

mod header;
mod header_line;
mod line;
mod names;
mod number;
mod rows;
mod settings;
pub(crate) mod sniff;
#[cfg(test)]
mod tests;
mod text;
mod truncated_line;
pub(crate) mod write;

pub use self::settings::{ColumnChoice, Decimal, Delimiter, ImportSettings, TimeZero};
pub use self::sniff::{Preview, preview, preview_bytes};
pub use self::text::Progress;
pub use self::write::{WriteError, write_csv, write_recording};

use std::path::Path;

use sha2::{Digest, Sha256};

use self::number::relative_time::Zero;
use self::rows::{Layout, Table, first_time};
use self::text::Text;
use super::assemble::{Columns, FileClock, Place, assemble};
use super::error::{ImportError, ImportWarning, WarningKind};
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
    let file = path.display().to_string();
    let bytes = text::read_file(path, None)?;
    let preview = preview_bytes(&file, &bytes)?;
    let mut settings = ImportSettings {
        time_zero: TimeZero::File,
        times_as_written: true,
        ..preview.settings
    };
    let no_voltage = || ImportError::NoVoltageColumn {
        file: file.clone().into(),
        line: settings.skip_lines.max(1),
    };
    let voltage = settings.voltage.clone().ok_or_else(no_voltage)?;
    if settings.proof_mass.is_none() {
        // A recording has a displacement: the voltage's numbers stand in for it, unread.
        settings.proof_mass = Some(ColumnChoice {
            unit: "m".to_owned(),
            ..voltage
        });
    } else if let Some(problem) = preview.problem {
        return Err(problem);
    }
    let recording = read(&file, &bytes, &settings, Vec::new(), None)?;
    recording.drive_table().ok_or_else(no_voltage)
}

fn read_auto(
    file: &str,
    bytes: &[u8],
    change: &dyn Fn(&mut ImportSettings),
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    let mut preview = preview_bytes(file, bytes)?;
    if let Some(problem) = preview.problem {
        return Err(problem);
    }
    change(&mut preview.settings);
    read(file, bytes, &preview.settings, preview.warnings, progress)
}

/// The whole import: text, rows in parallel, then the rules for time and gaps.
fn read(
    file: &str,
    bytes: &[u8],
    settings: &ImportSettings,
    mut warnings: Vec<ImportWarning>,
    progress: Option<&Progress>,
) -> Result<Recording, ImportError> {
    settings.check(file)?;
    let text = Text::new(file, bytes)?;
    let layout = Layout::new(file, settings)?;
    let (start, first_line) = text.skip_lines(settings.skip_lines);
    let cut = truncated_line::cut_last_line(&text.bytes[start..], &text, &layout);
    let end = cut.map_or(text.bytes.len(), |at| start + at);
    let keeps_zero = settings.time_zero == TimeZero::File;
    let first = match settings.time_zero {
        TimeZero::FirstRow => first_time(&text.bytes[start..end], &text, &layout),
        TimeZero::File => None,
    };
    let first = first.unwrap_or_default();
    let zero = Zero::new(first.clone());

    // The hash is of the same bytes but needs nothing of the parse: its own thread.
    let (table, hash) = std::thread::scope(|scope| {
        let hash = scope.spawn(|| hex(&Sha256::digest(bytes)));
        let range = start..end;
        let table = Table::parse(file, &text, range, first_line, &layout, &zero, progress);
        (table, hash.join().ok())
    });
    let mut table = table?;
    if cut.is_some() {
        let line = table.next_line;
        warnings.push(ImportWarning::new(
            WarningKind::CutLastLine,
            1,
            Some(line),
            &format!("the last line ({line}) was cut off in the middle and is left out"),
        ));
    }

    let [time, voltage, proof_mass, cantilever] = std::mem::take(&mut table.columns);
    let scaled = |channel: Channel, column: Option<Vec<f64>>| {
        let (scale, offset) = settings.scaling(channel);
        column.map(|mut values| {
            if scale != 1.0 || offset != 0.0 {
                values.iter_mut().for_each(|v| {
                    let scaled = *v * scale + offset;
                    // What leaves the range of numbers is missing, as it would be in the file.
                    *v = if scaled.is_finite() { scaled } else { f64::NAN };
                });
            }
            values
        })
    };
    let columns = Columns {
        time: time.unwrap_or_default(),
        voltage: scaled(Channel::Voltage, voltage),
        proof_mass: scaled(Channel::ProofMass, proof_mass).unwrap_or_default(),
        cantilever: scaled(Channel::Cantilever, cantilever),
    };
    let column_of = |channel: Option<Channel>| match channel {
        None => settings.time.as_ref().map_or(0, |c| c.index),
        Some(channel) => settings.choice(channel).map_or(0, |c| c.index),
    };
    let place = Place {
        file,
        line_of: &|row| table.line_of(&text, &layout, row),
        column_of: &|channel| column_of(channel).saturating_add(1),
        cell_of: &|row, channel| table.cell_of(&text, &layout, row, column_of(channel)),
        columns_at: &|row| {
            let before = text.split(&text.bytes[..start]);
            let named = before.map(|line| line::cells(line, layout.delimiter).count());
            let cells = table.cells_of(&text, &layout, row);
            named.max().unwrap_or(0).max(cells)
        },
    };
    let clock = FileClock {
        origin: first.shifted(layout.time_unit()),
        keeps_zero,
        printed: table.printed,
        as_written: settings.times_as_written,
        offset: settings.time_offset,
    };
    let mut recording = assemble(columns, clock, &place, warnings)?;
    recording.sha256 = hash;
    Ok(recording)
}

fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
