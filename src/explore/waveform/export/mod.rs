//! One period of a drive as the file of a function generator.

mod keysight;
mod plain_csv;
mod siglent;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::error::{WaveformError, named};
use crate::atomic_write::write_atomically;
use crate::model::drive::Waveform;

/// Samples are taken this share of their distance late, so that one at a step is the value after
/// it however times are rounded.
const AFTER_STEP: f64 = 1e-9;

/// Who is to read the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GeneratorFormat {
    /// Time and voltage in two columns, with or without a line of headings.
    Csv { has_header: bool },
    /// `.csv` of Siglent's SDG series and EasyWave.
    Siglent,
    /// `.arb` of Keysight's and Agilent's 33500 and 33600 series (Trueform).
    Keysight,
}

impl GeneratorFormat {
    /// What a person reads.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Csv { has_header: true } => "CSV with headings",
            Self::Csv { has_header: false } => "CSV of numbers alone",
            Self::Siglent => "Siglent SDG (.csv)",
            Self::Keysight => "Keysight 33500/33600 (.arb)",
        }
    }

    /// Ending of the file's name.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Self::Keysight => "arb",
            Self::Csv { .. } | Self::Siglent => "csv",
        }
    }

    /// Fewest and most samples of a period.
    #[must_use]
    pub fn samples(self) -> (usize, usize) {
        match self {
            Self::Csv { .. } => plain_csv::SAMPLE_COUNTS,
            Self::Siglent => siglent::SAMPLE_COUNTS,
            Self::Keysight => keysight::SAMPLE_COUNTS,
        }
    }
}

/// One period as evenly spaced samples.
pub(super) struct Period {
    /// Voltages \[V\] from the start of the period on, its end left out.
    voltage: Vec<f64>,
    /// Periods per second \[Hz\].
    frequency: f64,
}

impl Period {
    fn of(waveform: &Waveform, samples: usize) -> Option<Self> {
        let period = waveform.period()?;
        // The second period: the first one of a table may be entered differently.
        let voltage = (0..samples)
            .map(|i| (i as f64 + AFTER_STEP) / samples as f64)
            .map(|share| waveform.voltage(period * (1.0 + share)))
            .collect();
        Some(Self {
            voltage,
            frequency: 1.0 / period,
        })
    }

    /// Lowest and highest sample \[V\].
    fn range(&self) -> (f64, f64) {
        let all = self.voltage.iter();
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        })
    }
}

/// The text of the file with `samples` of one period; of bursts, one pattern is the period.
///
/// # Errors
/// [`WaveformError::NoPeriod`]; [`WaveformError::Export`] for a number of samples or a voltage
/// that the generator does not take.
pub fn export(
    waveform: &Waveform,
    format: GeneratorFormat,
    samples: usize,
) -> Result<String, WaveformError> {
    let fail = |reason: String| WaveformError::Export {
        format: format.label(),
        reason,
    };
    let (fewest, most) = format.samples();
    if !(fewest..=most).contains(&samples) {
        return Err(fail(format!(
            "{samples} samples; a period takes {fewest} to {most}"
        )));
    }
    let Some(period) = Period::of(waveform, samples) else {
        return Err(WaveformError::NoPeriod {
            drive: named(waveform),
            action: "export",
        });
    };
    let text = match format {
        GeneratorFormat::Csv { has_header } => Ok(plain_csv::text(&period, has_header)),
        GeneratorFormat::Siglent => siglent::text(&period),
        GeneratorFormat::Keysight => keysight::text(&period),
    };
    text.map_err(fail)
}

/// Writes the file of [`export`] so that it is whole or as before.
///
/// # Errors
/// Those of [`export`], and [`WaveformError::Io`].
pub fn export_file(
    path: &Path,
    waveform: &Waveform,
    format: GeneratorFormat,
    samples: usize,
) -> Result<(), WaveformError> {
    let text = export(waveform, format, samples)?;
    write_atomically(path, text.as_bytes()).map_err(|source| WaveformError::Io {
        path: path.to_owned(),
        source,
    })
}
