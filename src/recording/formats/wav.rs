//! WAV sound files, by `hound`: each channel is a column, the header's rate the clock.

use std::io::Cursor;

use hound::{SampleFormat, WavReader};

use super::arrays::{finish, stem};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use crate::recording::formats::raw_table::{RawColumn, RawTable, SampleClock};

/// Reads `.wav` files.
#[derive(Debug)]
pub struct Wav;

const NAME: &str = "WAV";

impl Format for Wav {
    fn id(&self) -> &'static str {
        "wav"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["wav", "wave"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        let kind = head.get(..4);
        let riff = [&b"RIFF"[..], b"RIFX", b"RF64"];
        kind.is_some_and(|kind| riff.contains(&kind)) && head.get(8..12) == Some(b"WAVE")
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        if !bytes.starts_with(b"RIFF") {
            return Err(context.unsupported(
                "this is a big-endian (RIFX) or 64-bit (RF64) WAV file",
                "save it as an ordinary WAV file (RIFF, PCM or 32-bit float)",
            ));
        }
        let mut reader =
            WavReader::new(Cursor::new(bytes)).map_err(|error| context.unreadable(error))?;
        let spec = reader.spec();
        let promised = reader.duration() as usize;
        let bits = u32::from(spec.bits_per_sample);
        let channels = usize::from(spec.channels);
        let Some(clock) = SampleClock::new(0.0, 1.0 / f64::from(spec.sample_rate)) else {
            return Err(context.malformed(24, "the sampling rate (0)"));
        };
        if channels == 0 || !(1..=32).contains(&bits) {
            return Err(context.malformed(22, "the number of channels or bits"));
        }
        let mut notes = Vec::new();
        let columns = match spec.sample_format {
            SampleFormat::Float => deinterleave(
                reader.samples::<f32>().map_while(Result::ok).map(f64::from),
                channels,
                promised.min(bytes.len()),
            ),
            SampleFormat::Int => {
                let full_scale = 2f64.powi(bits as i32 - 1);
                notes.push(format!(
                    "Samples of {bits} bits were divided by 2^{}: full scale is 1.0. Give the volts or metres of full scale as a scale.",
                    bits - 1
                ));
                deinterleave(
                    reader
                        .samples::<i32>()
                        .map_while(Result::ok)
                        .map(|sample| f64::from(sample) / full_scale),
                    channels,
                    promised.min(bytes.len()),
                )
            }
        };
        let rows = columns.first().map_or(0, Vec::len);
        if rows == 0 {
            return Err(context.no_numbers("no samples"));
        }
        if rows < promised {
            notes.push(format!(
                "The file was cut off: its header names {promised} samples a channel, {rows} are there."
            ));
        }
        let columns = columns
            .into_iter()
            .enumerate()
            .map(|(index, values)| RawColumn {
                name: format!("Channel {}", index + 1),
                unit: None,
                values,
            })
            .collect();
        Ok(FormatContent::Tables(finish(vec![RawTable {
            name: stem(file),
            columns,
            clock: Some(clock),
            notes,
        }])))
    }
}

/// One column a channel; samples of an incomplete last row are dropped with it.
fn deinterleave(samples: impl Iterator<Item = f64>, channels: usize, rows: usize) -> Vec<Vec<f64>> {
    // Many channels of few samples: the rows are those that come.
    let room = if channels <= 8 { rows } else { 0 };
    let mut columns: Vec<Vec<f64>> = (0..channels).map(|_| Vec::with_capacity(room)).collect();
    let mut next = 0;
    for sample in samples {
        if let Some(column) = columns.get_mut(next) {
            column.push(sample);
        }
        next = (next + 1) % channels;
    }
    let rows = columns.last().map_or(0, Vec::len);
    columns.iter_mut().for_each(|column| column.truncate(rows));
    columns
}
