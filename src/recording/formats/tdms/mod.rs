//! NI's TDMS: groups of channels in segments, as LabVIEW and FlexLogger write it.
//!
//! Source: NI, "TDMS File Format Internal Structure", checked against npTDMS. Scales in the
//! properties are applied as LabVIEW applies them; raw data of DAQmx is refused.

mod channel;
mod metadata;
mod scaling;
mod segment;

use self::channel::Channel;
use self::metadata::Properties;
use self::segment::read_segments;
use super::arrays::{Arrays, NamedArray, stem};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use crate::recording::formats::raw_table::SampleClock;

/// Reads `.tdms` files.
#[derive(Debug)]
pub struct Tdms;

const NAME: &str = "TDMS";

impl Format for Tdms {
    fn id(&self) -> &'static str {
        "tdms"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["tdms"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        // An index file (TDSh) has no data; reading it says so.
        head.starts_with(b"TDSm") || head.starts_with(b"TDSh")
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        if bytes.starts_with(b"TDSh") {
            return Err(context.unsupported(
                "this is the index of a TDMS file, which holds no data",
                "open the .tdms file beside it",
            ));
        }
        let found = read_segments(&context, bytes)?;
        let mut arrays = Arrays {
            notes: found.notes,
            ..Arrays::default()
        };
        let none = Properties::new();
        let root = found.properties.get("/").unwrap_or(&none);
        for channel in found.channels {
            let group = found.properties.get(&channel.group_path()).unwrap_or(&none);
            add(&mut arrays, channel, [group, root]);
        }
        let tables = arrays.into_tables(&context, &stem(file))?;
        Ok(FormatContent::Tables(tables))
    }
}

/// Adds a channel with its scale, unit and clock; `above` are the properties of its group and file.
fn add(arrays: &mut Arrays, channel: Channel, above: [&Properties; 2]) {
    let path = channel.path.join("/");
    if channel.values.is_empty() {
        arrays
            .left_out
            .push(format!("{path} ({})", channel.emptiness()));
        return;
    }
    let (group, name) = match channel.path.as_slice() {
        [group, name] => (group.clone(), name.clone()),
        _ => (String::new(), path.clone()),
    };
    let Channel {
        properties,
        mut values,
        note,
        ..
    } = channel;
    arrays.notes.extend(note);
    let mut unit = properties
        .get("unit_string")
        .or_else(|| properties.get("NI_UnitDescription"))
        .and_then(|unit| unit.text())
        .filter(|unit| !unit.is_empty())
        .map(str::to_owned);
    let scaled = std::iter::once(&properties)
        .chain(above)
        .find_map(scaling::Scale::of);
    match scaled {
        None => {}
        Some(Ok(scale)) => {
            scale.apply(&mut values);
            arrays.notes.push(format!("\"{path}\": {}.", scale.words()));
        }
        Some(Err(kind)) => {
            unit = None;
            arrays.notes.push(format!(
                "\"{path}\" has a scale of kind \"{kind}\" that is not applied: its numbers are raw, without unit."
            ));
        }
    }
    let number = |key: &str| properties.get(key).and_then(|value| value.number());
    let clock = number("wf_increment")
        .and_then(|interval| SampleClock::new(number("wf_start_offset").unwrap_or(0.0), interval));
    if let Some(start) = properties.get("wf_start_time").and_then(|t| t.seconds()) {
        // The same for all channels of a measurement, normally.
        let note = format!("Recorded from {start:.6} s after 1904-01-01 (UTC).");
        if start > 0.0 && arrays.notes.last() != Some(&note) && !arrays.notes.contains(&note) {
            arrays.notes.push(note);
        }
    }
    arrays.arrays.push(NamedArray {
        parent: group,
        name,
        unit,
        values,
        clock,
    });
}
