//! Keysight's `.arb` text of an arbitrary waveform.
//!
//! Format 1.10 of the 33500 and 33600 series, with the keys of Agilent's own `convertToArb` (Neil
//! Forcier, MATLAB Central File Exchange 34840) and of the format in Keysight's manual as public
//! programs quote it: lines `Key:value`, then `Data:` and an integer a line. With the data
//! type `"short"`, -32767 to 32767 span the DAC. Programs differ on whether that is the span from
//! the low level to the high one, or the largest voltage by magnitude; here the levels are `-M`
//! and `+M`, `M` the largest voltage, so that both are the same: `V = M code / 32767`.
//! Not tried on an instrument.

use std::fmt::Write;

use super::Period;

/// Fewest and most samples of a 33500.
pub(super) const SAMPLE_COUNTS: (usize, usize) = (8, 1_000_000);

/// The largest code.
const FULL_SCALE: f64 = 32_767.0;

/// Fastest clock \[Sa/s\]: that of a 33500B with its filter off.
const MAX_SAMPLE_RATE: f64 = 62.5e6;

/// The level has this many decimals \[V\].
const LEVEL_DECIMALS: usize = 9;

pub(super) fn text(period: &Period) -> Result<String, String> {
    let (low, high) = period.range();
    if high <= low {
        return Err(format!(
            "{low} V throughout is no waveform; set this voltage as DC at the generator"
        ));
    }
    let count = period.voltage.len();
    let rate = count as f64 * period.frequency;
    if rate > MAX_SAMPLE_RATE {
        return Err(format!(
            "{count} samples of {} Hz are {rate:e} a second, and it makes up to {MAX_SAMPLE_RATE:e}; take fewer",
            period.frequency
        ));
    }
    let level = high.abs().max(low.abs());
    let mut text = String::new();
    let lines = [
        "File Format:1.10".to_owned(),
        "Checksum:0".to_owned(),
        "Channel Count:1".to_owned(),
        format!("Sample Rate:{rate}"),
        format!("High Level:{level:.LEVEL_DECIMALS$}"),
        format!("Low Level:{:.LEVEL_DECIMALS$}", -level),
        format!("Marker Point:{}", count / 2),
        "Data Type:\"short\"".to_owned(),
        "Filter:\"off\"".to_owned(),
        format!("Data Points:{count}"),
        "Data:".to_owned(),
    ];
    for line in lines {
        text.push_str(&line);
        text.push_str("\r\n");
    }
    for voltage in &period.voltage {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "{}\r\n",
            (FULL_SCALE * voltage / level).round() as i32
        );
    }
    Ok(text)
}
