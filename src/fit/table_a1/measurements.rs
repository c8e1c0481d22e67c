//! Table A.1 of the paper: 16 experiments, the only published measurements of the device.

use std::sync::OnceLock;

use crate::model::drive::Waveform;
use crate::recording::features::Features;

/// Frequencies \[Hz\], voltages \[V\], signals, bounces, peaks \[um\] and contacts \[ms\] of the
/// paper's simulation and of the experiment.
const TABLE_A1_CSV: &str = include_str!("../../../assets/table_a1.csv");

/// The features of the table, per period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// Bounces before the sustained contact.
    pub bounces: Option<f64>,
    /// Peak oscillation amplitude \[m\].
    pub peak: Option<f64>,
    /// Time in contact \[s\].
    pub contact: Option<f64>,
}

impl Figures {
    /// The figures of a run or a recording in its periodic steady state, as far as there
    /// are any.
    pub fn of(features: &Features) -> Self {
        let Ok(steady) = &features.steady else {
            return Self::default();
        };
        Self {
            bounces: steady.bounces.map(|spread| spread.mean),
            peak: steady.peak_amplitude.map(|spread| spread.mean),
            contact: steady.contact_duration.map(|spread| spread.mean),
        }
    }
}

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Drive frequency \[Hz\].
    pub frequency: f64,
    /// Drive amplitude \[V\].
    pub amplitude: f64,
    /// Square or sine.
    pub square: bool,
    /// The paper's simulation.
    pub simulation: Figures,
    /// The experiment.
    pub experiment: Figures,
}

impl Case {
    /// The drive of the experiment.
    pub fn waveform(&self) -> Waveform {
        let (frequency, amplitude) = (self.frequency, self.amplitude);
        if self.square {
            Waveform::Square {
                frequency,
                amplitude,
            }
        } else {
            Waveform::Sine {
                frequency,
                amplitude,
            }
        }
    }

    /// `square` or `sine`.
    pub fn signal(&self) -> &'static str {
        if self.square { "square" } else { "sine" }
    }

    /// `15 Hz, 8 V, square`.
    pub fn name(&self) -> String {
        format!(
            "{} Hz, {} V, {}",
            self.frequency,
            self.amplitude,
            self.signal()
        )
    }
}

/// The 16 cases in the order of the table.
pub fn cases() -> &'static [Case] {
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(|| TABLE_A1_CSV.lines().skip(1).filter_map(case).collect())
}

fn case(line: &str) -> Option<Case> {
    let mut cells = line.trim().split(',');
    let number = |cells: &mut std::str::Split<'_, char>| cells.next()?.parse::<f64>().ok();
    let (frequency, amplitude) = (number(&mut cells)?, number(&mut cells)?);
    let square = cells.next()? == "square";
    let mut pair = || Some((number(&mut cells)?, number(&mut cells)?));
    let (bounces, peak, contact) = (pair()?, pair()?, pair()?);
    let of = |bounces, peak_um: f64, contact_ms: f64| Figures {
        bounces: Some(bounces),
        peak: Some(1e-6 * peak_um),
        contact: Some(1e-3 * contact_ms),
    };
    Some(Case {
        frequency,
        amplitude,
        square,
        simulation: of(bounces.0, peak.0, contact.0),
        experiment: of(bounces.1, peak.1, contact.1),
    })
}

#[cfg(test)]
mod tests {
    use super::super::measurements::*;

    #[test]
    fn all_rows_are_read() {
        let cases = cases();
        assert_eq!(cases.len(), 16);
        assert_eq!(cases.iter().filter(|c| c.square).count(), 8);
        let last = cases[15];
        assert_eq!(last.name(), "100 Hz, 8 V, sine");
        assert_eq!(last.simulation.peak, Some(1e-6 * 142.0));
        assert_eq!(last.experiment.contact, Some(1e-3 * 2.3));
    }
}
