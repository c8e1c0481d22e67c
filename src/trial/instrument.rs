//! What every trial has: a device that is not the preset, and instruments that are slightly
//! off. None of it is missing physics.

use serde::{Deserialize, Serialize};

use super::device::Device;
use super::device::beam::Beam;
use super::device::reference_device::{STATIC_PER_GC, table_device, table_modes};
use super::device::structure::Structure;
use super::rng::TrialRng;

/// By how much readings are later or earlier than the voltage at most \[s\].
pub const LARGEST_SKEW: f64 = 8e-6;
/// Standard deviations beyond which no stamp errs: neighbours must not change places.
const LARGEST_DEVIATE: f64 = 3.0;
/// Half the number of codes of a converter of 8 bits.
const CODES_OF_8_BITS: f64 = 128.0;

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
    /// Step to which the proof mass's reading is rounded \[m\]; zero for none.
    #[serde(default)]
    pub reading_step: f64,
    /// By how much the scales of both readings differ from their own in each recording, as a share;
    /// empty where they do not.
    #[serde(default)]
    pub scale_errors: Vec<[f64; 2]>,
    /// What else they do.
    #[serde(default)]
    pub imperfections: Imperfections,
}

/// How far instruments are from good ones. None of it is missing physics; zero is none of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Imperfections {
    /// Rms of the noise on the voltage as it is recorded \[V\]. The drive itself has none.
    pub voltage_noise: f64,
    /// Step of the converter of the voltage, of 8 bits \[V\]; zero for a continuous one.
    pub voltage_step: f64,
    /// Random walk of each reading's zero: rms distance from its start over the square root of the
    /// time \[m/s^(1/2)\].
    pub zero_walk: f64,
    /// Standard deviation of each reading's scale between recordings, as a share.
    pub scale_spread: f64,
    /// Rms error of the time written for a sample; the samples themselves are even \[s\].
    pub stamp_jitter: f64,
    /// Share by which the recorder samples faster than it says.
    pub clock_error: f64,
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
        skew: rng.between(-LARGEST_SKEW, LARGEST_SKEW),
        scale_p: 1.0 + 0.01 * rng.between(-1.0, 1.0),
        scale_c: 1.0 + 0.01 * rng.between(-1.0, 1.0),
        zeros: (0..recordings)
            .map(|_| [rng.between(-3e-6, 3e-6), rng.between(-2e-6, 2e-6)])
            .collect(),
        cantilever,
        reading_step: 0.0,
        scale_errors: Vec::new(),
        imperfections: Imperfections::default(),
    }
}

impl Instruments {
    /// The same with imperfections; `stretch` is by how much more their clocks may be apart.
    #[must_use]
    pub fn with(mut self, imperfections: Imperfections, stretch: f64, rng: &mut TrialRng) -> Self {
        self.skew *= stretch;
        self.imperfections = imperfections;
        let spread = imperfections.scale_spread;
        if spread > 0.0 {
            let recordings = self.zeros.len();
            self.scale_errors = (0..recordings)
                .map(|_| [spread * rng.normal(), spread * rng.normal()])
                .collect();
        }
        self
    }

    /// Scales of both readings in recording number `recording`.
    #[must_use]
    pub fn scales(&self, recording: usize) -> [f64; 2] {
        let [p, c] = self
            .scale_errors
            .get(recording)
            .copied()
            .unwrap_or([0.0; 2]);
        [self.scale_p * (1.0 + p), self.scale_c * (1.0 + c)]
    }

    /// When sample `i` is taken in the voltage's own time \[s\].
    #[must_use]
    pub fn instant(&self, i: usize) -> f64 {
        i as f64 / (self.rate * (1.0 + self.imperfections.clock_error))
    }

    /// The times that are written for `count` samples \[s\].
    #[must_use]
    pub fn stamps(&self, count: usize, rng: &mut TrialRng) -> Vec<f64> {
        let jitter = self.imperfections.stamp_jitter;
        let mut stamp = |i: usize| {
            let even = i as f64 / self.rate;
            if jitter == 0.0 {
                even
            } else {
                even + jitter * rng.normal().clamp(-LARGEST_DEVIATE, LARGEST_DEVIATE)
            }
        };
        (0..count).map(&mut stamp).collect()
    }

    /// Turns voltages into what the recorder shows of them.
    pub fn read_voltage(&self, voltages: &mut [f64], rng: &mut TrialRng) {
        let (noise, step) = (
            self.imperfections.voltage_noise,
            self.imperfections.voltage_step,
        );
        for v in voltages {
            if noise > 0.0 {
                *v += noise * rng.normal();
            }
            if step > 0.0 {
                *v = step
                    * (*v / step)
                        .round()
                        .clamp(-CODES_OF_8_BITS, CODES_OF_8_BITS - 1.0);
            }
        }
    }

    /// Adds the random walk of a reading's zero, which begins at zero.
    pub fn walk(&self, readings: &mut [f64], rng: &mut TrialRng) {
        let step = self.imperfections.zero_walk / self.rate.sqrt();
        if step == 0.0 {
            return;
        }
        let mut zero = 0.0;
        for x in readings {
            *x += zero;
            zero += step * rng.normal();
        }
    }

    /// Rounds readings to what the sensor resolves.
    pub fn round(&self, readings: &mut [f64]) {
        let step = self.reading_step;
        if step > 0.0 {
            readings
                .iter_mut()
                .for_each(|x| *x = step * (*x / step).round());
        }
    }

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
