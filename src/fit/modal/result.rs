//! What a sweep told.

use realfft::num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::frequency_domain::circle::CircleFit;
use super::frequency_domain::spectra::ResponsePoint;
use super::shapes::{Estimate, Normalisation, Shape, same_mode, set_modes};
use super::thresholds::MAX_RELIABLE_MISFIT_RATIO;
use super::time_domain::kernel::Pole;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::piezo::Piezo;
use crate::model::structure::Mode;

/// What counts as the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum InputChoice {
    /// `gc(V, V')` by the device's branches if it has a drive, else the voltage.
    #[default]
    Automatic,
    /// The voltage itself.
    Voltage,
}

/// What is asked of an identification.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModalOptions {
    /// The input.
    pub input: InputChoice,
    /// What fixes the scale of the shapes.
    pub normalisation: Normalisation,
    /// Most modes.
    pub max_modes: usize,
    /// Whether a skew between the clocks of voltage and readings is estimated.
    pub free_skew: bool,
    /// Whether the damping by the device's gas film is taken out, so that `zeta` is the structure's.
    pub film: bool,
}

impl Default for ModalOptions {
    fn default() -> Self {
        Self {
            input: InputChoice::Automatic,
            normalisation: Normalisation::Eta,
            max_modes: 8,
            free_skew: true,
            film: true,
        }
    }
}

/// How well a mode is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quality {
    /// Frequency, damping and shape are determined.
    Identified,
    /// It is seen, but too weakly excited to be determined.
    Weak,
    /// It lies outside the swept band: it stands for what modes there add.
    OutsideBand,
}

/// One mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IdentifiedMode {
    /// Undamped natural frequency \[Hz\].
    pub frequency: Estimate,
    /// Damping ratio.
    pub zeta: Estimate,
    /// Static displacement per unit of input of the proof mass and the cantilever \[m\]; `None` where
    /// not recorded.
    pub static_gain: [Option<Estimate>; 2],
    /// `phi_p / phi_c`, which needs no normalisation.
    pub ratio: Option<Estimate>,
    /// Mass-normalised shapes.
    pub shape: Option<Shape>,
    /// How well it is known.
    pub quality: Quality,
    /// Circle fits of the responses of proof mass and cantilever.
    pub circles: [Option<CircleFit>; 2],
}

/// Result of a modal identification. Two-element arrays are proof mass and cantilever.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModalFit {
    /// Names of the recordings that were used.
    pub recordings: Vec<String>,
    /// Whether the input is `gc` by these branches; `None` for the voltage.
    pub piezo: Option<Piezo>,
    /// Driven band \[Hz\].
    pub band: (f64, f64),
    /// Modes in order of frequency.
    pub modes: Vec<IdentifiedMode>,
    /// Static displacement per unit of input of all modes above the band \[m\].
    pub residual: [Option<Estimate>; 2],
    /// Drive gain that the shapes are for \[N\] per unit of input.
    pub eta: f64,
    /// What fixed it.
    pub normalisation: Normalisation,
    /// Lag of the readings behind the voltage \[s\], if it was estimated.
    pub skew: Option<Estimate>,
    /// Whether the damping by the gas film was taken out.
    pub film: bool,
    /// Noise of each reading \[m\], estimated without the model.
    pub noise: [Option<f64>; 2],
    /// Root mean square of what the model leaves \[m\].
    pub misfit: [Option<f64>; 2],
    /// Measured responses, by windowed spectra.
    pub responses: [Vec<ResponsePoint>; 2],
    /// Distance of their lines \[Hz\], and blocks averaged.
    pub resolution: (f64, usize),
    /// Samples used and left out.
    pub samples: (usize, usize),
    /// What a reader must know, as sentences.
    pub remarks: Vec<String>,
}

impl ModalFit {
    /// The modes that are determined.
    pub fn identified(&self) -> impl Iterator<Item = &IdentifiedMode> {
        self.modes
            .iter()
            .filter(|m| m.quality == Quality::Identified)
    }

    /// Whether a mode is determined, and the modes follow the sweep near enough for a device to take
    /// them.
    #[must_use]
    pub fn follows_sweep(&self) -> bool {
        let pairs = self.noise.iter().zip(&self.misfit);
        let follows = pairs
            .into_iter()
            .all(|(noise, misfit)| match (noise, misfit) {
                (Some(noise), Some(misfit)) => {
                    *noise <= 0.0 || *misfit <= MAX_RELIABLE_MISFIT_RATIO * noise
                }
                _ => true,
            });
        follows && self.identified().next().is_some()
    }

    /// Response of the fitted model at `frequency` \[Hz\] of reading `c` (0 proof mass, 1 cantilever)
    /// \[m per input\]: the curve of the Bode plot and of the Nyquist circles.
    #[must_use]
    pub fn response(&self, c: usize, frequency: f64) -> Option<[f64; 2]> {
        let mut sum = Complex::from(self.residual.get(c).copied()??.value);
        for mode in &self.modes {
            let gain = mode.static_gain.get(c).copied()??.value;
            let pole = Pole {
                omega: std::f64::consts::TAU * mode.frequency.value,
                zeta: mode.zeta.value,
            };
            sum += pole.receptance(frequency) * gain;
        }
        Some([sum.re, sum.im])
    }

    /// Modes that a device keeps besides those found: its own ones above the swept band, and those
    /// within it that are not determined. None if it has no mode in common with the sweep.
    fn kept_modes(&self, model: &Model) -> Vec<Mode> {
        let found: Vec<usize> = self
            .identified()
            .filter_map(|m| same_mode(model, m.frequency.value).map(|(i, _)| i))
            .collect();
        if found.is_empty() {
            return Vec::new();
        }
        let inside = |f: f64| f >= self.band.0 && f <= self.band.1;
        let own = model.structure().modes;
        let own_inside = own.iter().filter(|m| inside(m.frequency)).count();
        let found_inside = self.identified().map(|m| m.frequency.value);
        // As many in the band as the device has: these are its modes, however far they were off.
        let all_found = found_inside.filter(|f| inside(*f)).count() >= own_inside;
        own.into_iter()
            .enumerate()
            .filter(|(i, m)| !(found.contains(i) || all_found && inside(m.frequency)))
            .map(|(_, m)| m)
            .collect()
    }

    /// Gives a device the modes that are determined. It keeps those of its own that the sweep says
    /// nothing of, as the remarks say.
    pub fn apply(&self, model: &mut Model) {
        let mut modes = self.kept_modes(model);
        for mode in self.identified() {
            let Some(shape) = mode.shape else { continue };
            let known = same_mode(model, mode.frequency.value).map(|(_, m)| m.phi_c);
            modes.push(Mode {
                frequency: mode.frequency.value,
                zeta: mode.zeta.value,
                phi_c: shape.phi_c.map_or(known.unwrap_or(0.0), |e| e.value),
                phi_p: shape.phi_p.value,
                phi_drive: shape.phi_drive,
            });
        }
        if modes.is_empty() {
            return;
        }
        modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        modes.truncate(crate::model::MAX_MODES);
        set_modes(model, modes);
        model.parameters.set(ParameterId::Eta, self.eta);
        if model.piezo.is_none() || self.piezo.is_none() {
            model.piezo = Some(Piezo::without_hysteresis([0.0, 1.0, 0.0, 0.0]));
        }
        if self.modes.iter().any(|m| m.static_gain[1].is_some()) {
            model.has_cantilever = true;
        }
    }

    /// Remarks on modes of the device that the sweep does not tell.
    pub(super) fn remark_on_device(&mut self, model: &Model) {
        let write = |f: f64| crate::model::unit::format_quantity(f, "Hz", 4);
        let own: Vec<f64> = model
            .structure()
            .modes
            .iter()
            .map(|m| m.frequency)
            .collect();
        let kept = self.kept_modes(model);
        if kept.is_empty() && own.len() > self.identified().count() {
            self.remarks.push(format!(
                "None of the {} modes of the device {} is near one of the sweep, so it takes only those of the sweep.",
                own.len(),
                model.name
            ));
        }
        for mode in kept {
            let frequency = write(mode.frequency);
            let inside = mode.frequency <= self.band.1 && mode.frequency >= self.band.0;
            self.remarks.push(if inside {
                format!("The device's mode at {frequency} lies in the swept band but is not determined by it; the device keeps its values.")
            } else {
                format!("The device's mode at {frequency} lies outside the swept band; the device keeps its values.")
            });
        }
    }
}
