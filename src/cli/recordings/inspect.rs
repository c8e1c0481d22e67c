//! `inspect`: what recordings hold, as text and JSON, without a model.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::combine::Combine;
use super::options::ReadingArguments;
use crate::cli::{Failure, output, terminal, wrong_command};
use crate::model::drive::DriveReading;
use crate::model::unit::{counted, format_quantity};
use crate::recording::csv::{ColumnChoice, ImportSettings, Preview, ReadingChoices};
use crate::recording::events::{EventOptions, find_events};
use crate::recording::import;
use crate::recording::level::estimate_contact_level;
use crate::recording::{Channel, ImportError, Recording, extremes};

/// Arguments of the command.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Recordings, in any format that the program reads
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingArguments,
    /// File for the findings as JSON, in SI units; - for standard output, then without the text
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// Runs the command. A file that cannot be read is said, and the others are inspected all the same.
///
/// # Errors
/// [`Failure`] with the exit code; the work has failed if a file could not be read.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let choices = args.reading.choices()?;
    let (combine, which) = args.reading.combine()?;
    let groups = combine.groups(&args.files).map_err(wrong_command)?;
    let outputs = [("--json", args.json.as_deref())];
    let mut results = output::ready(&outputs, &args.files)?;
    let (mut found, mut unread) = (Vec::new(), 0);
    for group in &groups {
        let inspected = match &group[..] {
            [path] if combine == Combine::Separate && which.len() < 2 => {
                inspected(path, &choices).map_err(Into::into)
            }
            _ => put_together(&combine, group, &choices, which),
        };
        match inspected {
            Ok(all) => found.extend(all),
            Err(error) => {
                terminal::error(&format!("{error:#}"));
                unread += group.len();
            }
        }
    }
    for one in &found {
        results.say(&text(one));
    }
    if let Some(path) = &args.json {
        results.add_json(path, &found);
    }
    results.end()?;
    if unread == 0 {
        return Ok(());
    }
    Err(anyhow::anyhow!(
        "{} of {} could not be read",
        counted(unread, "file"),
        args.files.len()
    )
    .into())
}

/// What a recording holds; in SI units.
#[derive(Debug, Serialize)]
struct Inspected {
    file: String,
    trial: Option<String>,
    rows: usize,
    rate_hz: f64,
    start_s: f64,
    duration_s: f64,
    /// `xp`, `V`, `xc`, as far as recorded.
    channels: Map<String, Value>,
    drive: Option<Value>,
    warnings: Vec<String>,
    /// For the text alone.
    #[serde(skip)]
    lines: Vec<String>,
}

/// Every recording of a file.
fn inspected(path: &Path, choices: &ReadingChoices) -> Result<Vec<Inspected>, ImportError> {
    let names = match choices.trial {
        Some(_) => vec![String::new()],
        // A file that leaves something else open is explained by the import itself.
        None => import::trials(path).unwrap_or_else(|_| vec![String::new()]),
    };
    let several = names.len() > 1;
    let all = names.into_iter().enumerate().map(|(i, name)| {
        let choices = ReadingChoices {
            trial: if several { Some(i + 1) } else { choices.trial },
            ..choices.clone()
        };
        let recording = import::import_chosen(path, &choices, None)?;
        let preview = import::preview_chosen(path, &choices)?;
        let name = several.then(|| format!("{}: {name}", i + 1));
        let file = path.display().to_string();
        Ok(describe(file, name, &recording, Some(&preview)))
    });
    all.collect()
}

/// The recordings of files that are put together, or those of a file whose numbers are named.
fn put_together(
    combine: &Combine,
    group: &[PathBuf],
    choices: &ReadingChoices,
    which: &[usize],
) -> anyhow::Result<Vec<Inspected>> {
    let files: Vec<String> = group
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let all = combine.read(group, choices, which)?;
    let one = |recording: &Recording| {
        describe(
            files.join(", "),
            Some(recording.name.clone()),
            recording,
            None,
        )
    };
    Ok(all.iter().map(one).collect())
}

/// `preview` is that of the file, where it is one recording of one file.
fn describe(
    file: String,
    trial: Option<String>,
    recording: &Recording,
    preview: Option<&Preview>,
) -> Inspected {
    let (first, _) = recording.span();
    let mut channels = Map::new();
    let mut lines = Vec::new();
    for channel in [Channel::Voltage, Channel::ProofMass, Channel::Cantilever] {
        let Some(values) = recording.channel(channel) else {
            continue;
        };
        let choice = preview.and_then(|p| p.settings.choice(channel));
        let noise = recording.noise(channel).map(|noise| noise.sigma);
        let (low, high) = extremes(values);
        let column = match preview {
            Some(preview) => column_of(choice, preview),
            None => "put together".to_owned(),
        };
        let unit = choice.map_or(channel.base_unit(), |choice| choice.unit.as_str());
        let write = |value: f64| format_quantity(value, channel.base_unit(), 4);
        let noise_text = noise.map_or("noise not known".to_owned(), |n| {
            format!("noise {}", write(n))
        });
        let missing = values.iter().filter(|v| !v.is_finite()).count();
        let missing = if missing > 0 {
            format!(", {missing} missing")
        } else {
            String::new()
        };
        lines.push(format!(
            "{:<3} {column} in {unit}: {} to {}, {noise_text}{missing}{}",
            channel.symbol(),
            write(low),
            write(high),
            preview.map_or_else(String::new, |p| scaled(&p.settings, channel))
        ));
        channels.insert(
            channel.symbol().to_owned(),
            json!({ "column": column, "unit": unit, "min": low, "max": high, "noise": noise }),
        );
    }
    let drive = recording.drive(DriveReading::Recognised);
    let drive = match drive {
        None => {
            lines.push("drive not recorded".to_owned());
            None
        }
        Some(Err(error)) => {
            lines.push(format!("drive: {error}"));
            None
        }
        Some(Ok(drive)) => {
            lines.push(format!("drive {}", drive.text));
            let text = drive.command.clone().unwrap_or_else(|| drive.text.clone());
            Some(json!({ "text": text, "noise_v": drive.noise }))
        }
    };
    lines.push(events(recording));
    let faults = recording
        .instrument_faults()
        .faults
        .iter()
        .map(|fault| fault.sentence());
    let warnings = recording
        .warnings
        .iter()
        .map(|w| w.message.clone())
        .chain(faults);
    Inspected {
        file,
        trial,
        rows: recording.len(),
        rate_hz: recording.sampling_rate(),
        start_s: recording.origin.seconds() + first,
        duration_s: recording.duration(),
        channels,
        drive,
        warnings: warnings.collect(),
        lines,
    }
}

/// How the values of a channel are changed on their way in.
fn scaled(settings: &ImportSettings, channel: Channel) -> String {
    let (scale, _) = settings.scaling(channel);
    if scale == 1.0 {
        String::new()
    } else {
        format!(", multiplied by {scale}")
    }
}

/// Name of a column, or its number where it has none.
fn column_of(choice: Option<&ColumnChoice>, preview: &Preview) -> String {
    let Some(choice) = choice else {
        return "-".to_owned();
    };
    let name = preview.header.get(choice.index).map(|name| name.trim());
    let name = name.filter(|name| !name.is_empty());
    name.map_or_else(|| format!("column {}", choice.index + 1), str::to_owned)
}

/// Contacts and impacts at the level that the data show.
fn events(recording: &Recording) -> String {
    let (axis, xp) = (recording.axis(), &recording.proof_mass);
    let noise = recording.noise(Channel::ProofMass);
    let volts = recording.channel(Channel::Voltage);
    let level = match estimate_contact_level(axis, volts, xp, noise) {
        Ok(level) => level,
        Err(reason) => return format!("contact level not found: {reason}"),
    };
    let options = EventOptions::for_data(level, axis, xp);
    let events = find_events(recording.axis(), xp, &options);
    format!(
        "contact level {}: {}, {}",
        format_quantity(level, "m", 4),
        counted(events.contacts.len(), "contact"),
        counted(events.impacts.len(), "impact")
    )
}

fn text(one: &Inspected) -> String {
    let trial = one
        .trial
        .as_ref()
        .map_or(String::new(), |trial| format!(", recording {trial}"));
    let mut text = format!(
        "{}{trial}\n  {} at {} from {}, {} long\n",
        one.file,
        counted(one.rows, "row"),
        format_quantity(one.rate_hz, "Hz", 6),
        format_quantity(one.start_s, "s", 9),
        format_quantity(one.duration_s, "s", 6),
    );
    for line in &one.lines {
        text += &format!("  {line}\n");
    }
    for warning in &one.warnings {
        text += &format!("  note: {warning}\n");
    }
    text + "\n"
}
