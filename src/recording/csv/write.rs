//! Writing `t [s],V [V],xp [um],xc [um]` so that it reads back bit for bit.

use std::io::Write;

use rayon::prelude::*;
use thiserror::Error;

use crate::recording::grid::TimeAxis;
use crate::recording::times::exact_time::ExactTime;
use crate::recording::{Channel, Recording};

/// Rows formatted by one thread at a time.
const BLOCK_ROWS: usize = 8192;

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

    // In batches, so that a long file does not stand in memory as text.
    let starts: Vec<usize> = (0..rows).step_by(BLOCK_ROWS).collect();
    for batch in starts.chunks(4 * rayon::current_num_threads().max(1)) {
        let texts: Vec<Vec<u8>> = batch
            .par_iter()
            .map(|&start| {
                let mut text = Vec::with_capacity(BLOCK_ROWS * 64);
                for i in start..(start + BLOCK_ROWS).min(rows) {
                    put_time(&mut text, origin, time.at(i));
                    if let Some(voltage) = voltage {
                        text.push(b',');
                        put(&mut text, voltage[i], 0);
                    }
                    text.push(b',');
                    put(&mut text, proof_mass[i], 6);
                    if let Some(cantilever) = cantilever {
                        text.push(b',');
                        put(&mut text, cantilever[i], 6);
                    }
                    text.push(b'\n');
                }
                text
            })
            .collect();
        for text in texts {
            out.write_all(&text)?;
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

/// Appends `value * 10^shift` exactly: the shortest digits of `value`, the point
/// placed by its own exponent plus `shift`.
fn put(text: &mut Vec<u8>, value: f64, shift: i32) {
    if !value.is_finite() {
        text.extend_from_slice(b"NaN");
        return;
    }
    if value == 0.0 {
        text.push(b'0');
        return;
    }
    let start = text.len();
    // Writing to a Vec cannot fail.
    let _ = write!(text, "{value:e}");
    let scientific = text.split_off(start);
    let (mantissa, exponent) = match scientific.iter().position(|b| *b == b'e') {
        Some(at) => (&scientific[..at], &scientific[at + 1..]),
        None => (&scientific[..], &b"0"[..]),
    };
    let exponent: i32 = std::str::from_utf8(exponent)
        .ok()
        .and_then(|e| e.parse().ok())
        .unwrap_or(0);
    if value < 0.0 {
        text.push(b'-');
    }
    let digits: Vec<u8> = mantissa
        .iter()
        .copied()
        .filter(u8::is_ascii_digit)
        .collect();
    let point = exponent + shift + 1; // digits before the decimal point
    let n = digits.len() as i32;
    if (1..=17).contains(&point) {
        if point >= n {
            text.extend_from_slice(&digits);
            text.resize(text.len() + (point - n) as usize, b'0');
        } else {
            text.extend_from_slice(&digits[..point as usize]);
            text.push(b'.');
            text.extend_from_slice(&digits[point as usize..]);
        }
    } else if (-5..=0).contains(&point) {
        text.extend_from_slice(b"0.");
        text.resize(text.len() + (-point) as usize, b'0');
        text.extend_from_slice(&digits);
    } else {
        text.push(digits.first().copied().unwrap_or(b'0'));
        if n > 1 {
            text.push(b'.');
            text.extend_from_slice(&digits[1..]);
        }
        let _ = write!(text, "e{}", point - 1);
    }
}

#[cfg(test)]
mod tests {
    use super::super::write::*;

    fn text(value: f64, shift: i32) -> String {
        let mut out = Vec::new();
        put(&mut out, value, shift);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn moves_the_point_without_rounding() {
        assert_eq!(text(58.1e-6, 6), "58.1");
        assert_eq!(text(-58e-6, 6), "-58");
        assert_eq!(text(2e-5, 0), "0.00002");
        assert_eq!(text(0.1, 0), "0.1");
        assert_eq!(text(1234.5, 0), "1234.5");
        assert_eq!(text(1e-9, 6), "0.001");
        assert_eq!(text(1e-20, 6), "1e-14");
        assert_eq!(text(1.5e-20, 6), "1.5e-14");
        assert_eq!(text(1e20, 6), "1e26");
        assert_eq!(text(100.0, 6), "100000000");
        assert_eq!(text(-0.0, 6), "0");
        assert_eq!(text(f64::NAN, 6), "NaN");
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
