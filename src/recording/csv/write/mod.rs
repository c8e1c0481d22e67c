//! Writing `t [s],V [V],xp [um],xc [um]` so that it reads back bit for bit.

mod digits;

use std::io::Write;
use std::ops::Range;

use rayon::prelude::*;
use thiserror::Error;

use self::digits::put;
use crate::recording::grid::TimeAxis;
use crate::recording::times::exact_time::ExactTime;
use crate::recording::{Channel, Recording};

/// Rows formatted by one thread at a time.
const BLOCK_ROWS: usize = 2048;
/// Such blocks for each thread before they are written: few enough to stay in the cache, enough for
/// threads that begin late.
const BLOCKS_PER_THREAD: usize = 4;
/// Length of a row \[bytes\], for the room that is made.
const ROW_LENGTH: usize = 72;

/// Why nothing, or not all, was written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// A column's length differs from the others'.
    #[error("{column} has {found} values where xp has {expected}; give one value for each row")]
    LengthMismatch {
        /// Symbol of the column.
        column: &'static str,
        /// Its values.
        found: usize,
        /// Values of the proof mass.
        expected: usize,
    },
    /// The output failed.
    #[error("cannot write the recording: {0}; check the disk and the permissions")]
    Io(#[from] std::io::Error),
}

/// Writes columns in SI as CSV: seconds, volts and micrometres. The shortest digits
/// that identify each number are written with the point moved by six places, so
/// nothing is rounded; a missing value is written `NaN`.
///
/// # Errors
/// [`WriteError`] if lengths differ or the output fails.
pub fn write_csv(
    out: &mut dyn Write,
    time: TimeAxis,
    voltage: Option<&[f64]>,
    proof_mass: &[f64],
    cantilever: Option<&[f64]>,
) -> Result<(), WriteError> {
    let origin = ExactTime::default();
    write_from(out, &origin, time, voltage, proof_mass, cantilever)
}

/// [`write_csv`] with times that count from `origin`, which is added to them without rounding.
fn write_from(
    out: &mut dyn Write,
    origin: &ExactTime,
    time: TimeAxis,
    voltage: Option<&[f64]>,
    proof_mass: &[f64],
    cantilever: Option<&[f64]>,
) -> Result<(), WriteError> {
    let rows = proof_mass.len();
    if !time.covers(rows) {
        return Err(WriteError::LengthMismatch {
            column: "t",
            found: match time {
                TimeAxis::Samples(times) => times.len(),
                TimeAxis::Uniform { .. } => 0,
            },
            expected: rows,
        });
    }
    for (column, values) in [("V", voltage), ("xc", cantilever)] {
        if let Some(found) = values.map(<[f64]>::len).filter(|n| *n != rows) {
            return Err(WriteError::LengthMismatch {
                column,
                found,
                expected: rows,
            });
        }
    }
    let mut header = String::from("t [s]");
    if voltage.is_some() {
        header.push_str(",V [V]");
    }
    header.push_str(",xp [um]");
    if cantilever.is_some() {
        header.push_str(",xc [um]");
    }
    header.push('\n');
    out.write_all(header.as_bytes())?;

    // In batches, so that a long file does not stand in memory as text; the room of one batch
    // serves the next.
    let put_row = |text: &mut Vec<u8>, [volts, mass, beam]: &mut [Column; 3], i: usize| {
        put_time(text, origin, time.at(i));
        if let Some(voltage) = voltage {
            text.push(b',');
            volts.put(text, voltage[i]);
        }
        text.push(b',');
        mass.put(text, proof_mass[i]);
        if let Some(cantilever) = cantilever {
            text.push(b',');
            beam.put(text, cantilever[i]);
        }
        text.push(b'\n');
    };
    let batch = BLOCKS_PER_THREAD * rayon::current_num_threads().max(1);
    let mut texts = vec![Vec::new(); batch.min(rows.div_ceil(BLOCK_ROWS))];
    for first in (0..rows).step_by(batch * BLOCK_ROWS) {
        texts.par_iter_mut().enumerate().for_each(|(block, text)| {
            let start = (first + block * BLOCK_ROWS).min(rows);
            let end = (start + BLOCK_ROWS).min(rows);
            text.clear();
            text.reserve((end - start) * ROW_LENGTH);
            let mut columns = [0, 6, 6].map(Column::new);
            (start..end).for_each(|i| put_row(text, &mut columns, i));
        });
        for text in &texts {
            out.write_all(text)?;
        }
    }
    Ok(())
}

/// Writes a recording as [`write_csv`] does, with the times of its file.
///
/// # Errors
/// [`WriteError::Io`] if the output fails.
pub fn write_recording(out: &mut dyn Write, recording: &Recording) -> Result<(), WriteError> {
    write_from(
        out,
        &recording.origin,
        recording.axis(),
        recording.channel(Channel::Voltage),
        &recording.proof_mass,
        recording.channel(Channel::Cantilever),
    )
}

/// A column within a block. A voltage that stands and a mass at rest are formatted once.
struct Column {
    shift: i32,
    /// Bits of the value written last, and where its text is.
    last: Option<(u64, Range<usize>)>,
}

impl Column {
    fn new(shift: i32) -> Self {
        Self { shift, last: None }
    }

    fn put(&mut self, text: &mut Vec<u8>, value: f64) {
        let bits = value.to_bits();
        match &self.last {
            Some((last, cell)) if *last == bits => text.extend_from_within(cell.clone()),
            _ => {
                let start = text.len();
                put(text, value, self.shift);
                self.last = Some((bits, start..text.len()));
            }
        }
    }
}

/// Appends `origin + time` exactly.
fn put_time(text: &mut Vec<u8>, origin: &ExactTime, time: f64) {
    if origin.is_zero() || !time.is_finite() {
        put(text, time, 0);
    } else {
        let sum = origin.plus(&ExactTime::from_seconds(time));
        // Writing to a Vec cannot fail.
        let _ = write!(text, "{sum}");
    }
}

#[cfg(test)]
mod tests {
    use super::super::write::*;

    #[test]
    fn values_that_stand_are_written_as_often_as_they_stand() {
        let mut out = Vec::new();
        let axis = TimeAxis::Uniform { t0: 0.0, dt: 1.0 };
        let (v, x) = ([8.0, 8.0, -8.0], [0.0, -0.0, 1e-6]);
        write_csv(&mut out, axis, Some(&v), &x, Some(&x)).unwrap();
        let text = String::from_utf8(out).unwrap();
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows, ["0,8,0,0", "1,8,0,0", "2,-8,1,1"]);
    }

    #[test]
    fn lengths_must_agree() {
        let mut out = Vec::new();
        let axis = TimeAxis::Uniform { t0: 0.0, dt: 1e-5 };
        let error = write_csv(&mut out, axis, Some(&[1.0]), &[1.0, 2.0], None).unwrap_err();
        assert!(error.to_string().contains("V has 1 values where xp has 2"));
        let error = write_csv(&mut out, TimeAxis::Samples(&[0.0]), None, &[1.0, 2.0], None);
        assert!(error.is_err());
    }
}
