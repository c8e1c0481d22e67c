//! What every trial has: a device that is not the preset, and instruments that are slightly
//! off. None of it is missing physics.

use serde::{Deserialize, Serialize};

use super::device::Device;
use super::device::beam::Beam;
use super::device::reference_device::{STATIC_PER_GC, table_device, table_modes};
use super::device::structure::Structure;
use super::rng::TrialRng;

/// Which structure a trial's device has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StructureKind {
    /// Two coordinates with mass, damping and stiffness matrices.
    Lumped,
    /// A distributed beam in its four lowest modes, bent by moments.
    Beam,
}

/// What the instruments do to the readings. SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Instruments {
    /// Samples per second.
    pub rate: f64,
    /// Rms of all noise on a reading.
    pub noise: f64,
    /// Share of the noise's variance that is coloured.
    pub coloured_share: f64,
    /// Correlation time of the coloured noise.
    pub coloured_time: f64,
    /// How much later than the voltage the readings are.
    pub skew: f64,
    /// Scale of the proof mass's reading.
    pub scale_p: f64,
    /// Scale of the cantilever's reading.
    pub scale_c: f64,
    /// Zero of the proof mass's and the cantilever's reading in each recording.
    pub zeros: Vec<[f64; 2]>,
    /// Whether the cantilever is read.
    pub cantilever: bool,
}

/// The device's parameters as drawn. SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub struct DeviceParameters {
    pub eta: f64,
    pub cs: f64,
    pub gp: f64,
    pub dp: f64,
    pub alpha: f64,
    pub ca: f64,
    pub ca0: f64,
    pub frequencies: Vec<f64>,
    pub zetas: Vec<f64>,
}

/// Draws a device near the table's; `None` if its structure could not be built.
pub fn device(kind: StructureKind, rng: &mut TrialRng) -> Option<(Device, DeviceParameters)> {
    // Up to 60 % up, or down by the same factor.
    let off = |rng: &mut TrialRng| rng.log_between(1.0 / 1.6, 1.6);
    let zetas: Vec<f64> = [0.0262, 0.0257, 0.02, 0.02]
        .iter()
        .map(|z| z * off(rng))
        .collect();
    let (mut structure, frequencies) = match kind {
        StructureKind::Lumped => {
            let mut modes = table_modes();
            for (mode, zeta) in modes.iter_mut().zip(&zetas) {
                mode.frequency *= 1.0 + 0.01 * rng.between(-1.0, 1.0);
                mode.phi_c *= 1.0 + 0.03 * rng.between(-1.0, 1.0);
                mode.phi_p *= 1.0 + 0.03 * rng.between(-1.0, 1.0);
                mode.zeta = *zeta;
            }
            let on_p = rng.between(-0.01, 0.01);
            let frequencies = modes.iter().map(|m| m.frequency).collect();
            (Structure::lumped(&modes, on_p)?, frequencies)
        }
        StructureKind::Beam => {
            let mut beam = Beam::default();
            beam.stiffness *= 1.0 + 0.02 * rng.between(-1.0, 1.0);
            beam.mass *= 1.0 + 0.02 * rng.between(-1.0, 1.0);
            beam.reading *= 1.0 + 0.01 * rng.between(-1.0, 1.0);
            // The film ends short of clamp and mass.
            beam.patch_from = rng.between(0.0, 30e-6);
            beam.patch_to = rng.between(680e-6, 750e-6);
            let modes = beam.modes(4, &zetas)?;
            let frequencies = modes.iter().map(|m| m.frequency).collect();
            (Structure::modal(&modes), frequencies)
        }
    };
    // A unit of eta moves the mass as far as the table's does.
    let (xp, _) = structure.static_gain()?;
    structure.scale_drive(STATIC_PER_GC / 3.819e-7 / xp);
    let mut device = table_device(structure);
    let gap = (device.gp - device.dp) * off(rng);
    device.dp *= 1.0 + 0.12 * rng.between(-1.0, 1.0);
    device.gp = device.dp + gap;
    device.cs *= off(rng);
    device.alpha *= off(rng);
    device.ca *= off(rng);
    device.ca0 *= off(rng);
    // The mass must reach the ground in every recording at 8 V, or little can be asked.
    let least = 1.08 * device.dp / 4.98 / STATIC_PER_GC;
    device.eta *= rng.log_between(least.max(1.0 / 1.6), 1.6);
    let parameters = DeviceParameters {
        eta: device.eta,
        cs: device.cs,
        gp: device.gp,
        dp: device.dp,
        alpha: device.alpha,
        ca: device.ca,
        ca0: device.ca0,
        frequencies,
        zetas: zetas[..device.structure.n.min(zetas.len())].to_vec(),
    };
    Some((device, parameters))
}

/// Draws instruments for `recordings` recordings.
pub fn instruments(
    rate: f64,
    noise: f64,
    cantilever: bool,
    recordings: usize,
    rng: &mut TrialRng,
) -> Instruments {
    Instruments {
        rate,
        noise,
        coloured_share: rng.between(0.05, 0.4),
        coloured_time: rng.log_between(3e-5, 1e-3),
        skew: rng.between(-8e-6, 8e-6),
        scale_p: 1.0 + 0.01 * rng.between(-1.0, 1.0),
        scale_c: 1.0 + 0.01 * rng.between(-1.0, 1.0),
        zeros: (0..recordings)
            .map(|_| [rng.between(-3e-6, 3e-6), rng.between(-2e-6, 2e-6)])
            .collect(),
        cantilever,
    }
}

impl Instruments {
    /// Turns a motion into a reading: scale, zero, noise from `rng`.
    pub fn read(&self, motion: &mut [f64], scale: f64, zero: f64, rng: &mut TrialRng) {
        let white = self.noise * (1.0 - self.coloured_share).sqrt();
        let coloured = self.noise * self.coloured_share.sqrt();
        let keep = (-1.0 / (self.rate * self.coloured_time)).exp();
        let fresh = (1.0 - keep * keep).sqrt();
        let mut slow = rng.normal();
        for x in motion {
            *x = scale * *x + zero + white * rng.normal() + coloured * slow;
            slow = keep * slow + fresh * rng.normal();
        }
    }
}
