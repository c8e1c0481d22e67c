//! What the vibrometer shows: the motion plus an offset, and noise where a
//! recording is made up.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::parameter::{ParameterId, Parameters};

/// A point of the device that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Point {
    /// Centre of the proof mass.
    ProofMass,
    /// Centre of the cantilever.
    Cantilever,
}

/// The two readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensor {
    /// Added to the reading of the proof mass \[m\].
    pub offset_p: f64,
    /// Added to the reading of the cantilever \[m\].
    pub offset_c: f64,
    /// Standard deviation of the white noise \[m\].
    pub noise: f64,
}

impl Sensor {
    /// Reads `offset_p`, `offset_c` and `noise`.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            offset_p: parameters[ParameterId::OffsetP],
            offset_c: parameters[ParameterId::OffsetC],
            noise: parameters[ParameterId::Noise],
        }
    }

    /// Adds white Gaussian noise to a channel. The same seed gives the same noise.
    pub fn add_noise(&self, channel: &mut [f64], seed: u64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for value in channel {
            *value += self.noise * gaussian(&mut rng);
        }
    }
}

/// A standard normal number (Box and Muller).
pub(crate) fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    // 1 - u lies in (0, 1], so that the logarithm is finite.
    let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * rng.random::<f64>()).cos()
}

#[cfg(test)]
mod tests {
    use super::super::sensor::*;

    #[test]
    fn noise_has_its_size_and_repeats() {
        let sensor = Sensor {
            noise: 2e-8,
            ..Sensor::default()
        };
        let mut a = vec![0.0; 50_000];
        let mut b = a.clone();
        sensor.add_noise(&mut a, 7);
        sensor.add_noise(&mut b, 7);
        assert_eq!(a, b);
        let rms = (a.iter().map(|x| x * x).sum::<f64>() / a.len() as f64).sqrt();
        assert!((rms / 2e-8 - 1.0).abs() < 0.02, "{rms}");
    }
}
