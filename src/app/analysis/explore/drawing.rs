//! What the waveform editor remembers, and a standard form to start from.

use super::latest::Latest;
use super::steady::SteadyWork;
use crate::explore::waveform::export::GeneratorFormat;
use crate::explore::waveform::{EditableWaveform, WaveformError};
use crate::model::drive::{Cycle, PeriodicDrive, Waveform};

/// Handles of a drawn sine.
const HANDLES_OF_CURVE: usize = 16;
/// Samples of an exported period before a person changes them.
const USUAL_SAMPLES: usize = 4096;

/// A standard form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FormKind {
    Sine,
    Square,
    Triangle,
    #[default]
    Ramped,
}

impl FormKind {
    /// All, in the order of the list.
    pub const ALL: [Self; 4] = [Self::Sine, Self::Square, Self::Triangle, Self::Ramped];

    /// What a person reads.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Sine => "sine",
            Self::Square => "square",
            Self::Triangle => "triangle",
            Self::Ramped => "ramped square",
        }
    }
}

/// A standard form with its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormChoice {
    /// Which.
    pub kind: FormKind,
    /// Amplitude \[V\].
    pub amplitude: f64,
    /// Share of the period that the voltage is high.
    pub duty: f64,
    /// Share of the period that the voltage rises.
    pub asymmetry: f64,
    /// Share of the period that each ramp takes.
    pub lambda: f64,
}

impl Default for FormChoice {
    fn default() -> Self {
        Self {
            kind: FormKind::default(),
            amplitude: 8.0,
            duty: 0.5,
            asymmetry: 0.5,
            lambda: 0.05,
        }
    }
}

impl FormChoice {
    fn cycle(self) -> Cycle {
        let amplitude = self.amplitude;
        match self.kind {
            FormKind::Sine => Cycle::Sine { amplitude },
            FormKind::Square => Cycle::Square {
                amplitude,
                duty: self.duty,
            },
            FormKind::Triangle => Cycle::Triangle {
                amplitude,
                asymmetry: self.asymmetry,
            },
            FormKind::Ramped => Cycle::Ramped {
                amplitude,
                lambda: self.lambda,
                duty: self.duty,
            },
        }
    }

    /// `drawn` with the handles of this form; all else stays.
    ///
    /// # Errors
    /// [`WaveformError`] naming the number that is out of range.
    pub fn drawn(self, drawn: &EditableWaveform) -> Result<EditableWaveform, WaveformError> {
        let drive = PeriodicDrive {
            cycle: self.cycle(),
            ..drawn.drive()
        };
        let mut new = from_drive(&drive.waveform()?, drawn)?;
        new.frequency = drawn.frequency;
        new.offset = drawn.offset;
        new.phase = drawn.phase;
        new.burst = drawn.burst;
        Ok(new)
    }
}

/// A standard drive as handles, with name, grid and limits of `old`.
///
/// # Errors
/// [`WaveformError`] for a drive that does not repeat.
pub fn from_drive(
    drive: &Waveform,
    old: &EditableWaveform,
) -> Result<EditableWaveform, WaveformError> {
    let mut new = EditableWaveform::from_waveform(drive, HANDLES_OF_CURVE)?;
    new.name.clone_from(&old.name);
    new.grid = old.grid;
    new.limits = old.limits;
    Ok(new)
}

/// State of the editor.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// The handle that keys and fields act on.
    pub selected: Option<usize>,
    /// The handle under a drag.
    pub dragged: Option<usize>,
    /// Voltages in view while a drag lasts \[V\].
    pub held_range: Option<(f64, f64)>,
    /// Where the context menu was opened: share of the period, voltage without offset \[V\].
    pub menu_at: Option<(f64, f64)>,
    /// Why the last change was refused.
    pub refusal: Option<String>,
    /// The form to start from.
    pub form: FormChoice,
    /// Format of an exported period.
    pub format: GeneratorFormat,
    /// Its samples.
    pub samples: usize,
    /// The steady response.
    pub steady: Latest<SteadyWork>,
}

impl Default for Drawing {
    fn default() -> Self {
        Self {
            selected: None,
            dragged: None,
            held_range: None,
            menu_at: None,
            refusal: None,
            form: FormChoice::default(),
            format: GeneratorFormat::Csv { has_header: true },
            samples: USUAL_SAMPLES,
            steady: Latest::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawing::*;
    use crate::app::setup::explore::ExploreChoices;

    #[test]
    fn a_form_replaces_the_handles_and_nothing_else() {
        let mut drawn = ExploreChoices::default().drawn;
        drawn.offset = 0.5;
        drawn.phase = 40.0;
        let form = FormChoice {
            kind: FormKind::Square,
            duty: 0.25,
            ..FormChoice::default()
        };
        let new = form.drawn(&drawn).unwrap();
        assert_eq!((new.offset, new.phase), (0.5, 40.0));
        assert_eq!(new.limits, drawn.limits);
        let high = new.handles().iter().filter(|h| h.voltage > 0.0);
        let last = high.map(|h| h.time).fold(0.0, f64::max);
        assert!((last - 0.25).abs() < 1e-9, "{last}");
        let wrong = FormChoice { duty: 1.5, ..form };
        assert!(
            wrong
                .drawn(&drawn)
                .unwrap_err()
                .to_string()
                .contains("duty")
        );
    }
}
