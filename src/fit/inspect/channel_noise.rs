//! Noise of a channel with missing samples.

use crate::model::sensor::Sensor;
use crate::recording::noise::{NoiseError, NoiseEstimate, estimate_noise};
use crate::recording::{Channel, Recording};

/// Noise of a channel. If missing samples leave no run that is long enough, single missing samples
/// are interpolated by the cubic through their neighbours. That changes white noise by a known
/// factor, which is corrected.
///
/// # Errors
/// [`NoiseError`] if the channel was not recorded or is too short or broken even so.
pub(crate) fn noise_of(r: &Recording, channel: Channel) -> Result<NoiseEstimate, NoiseError> {
    r.estimate_noise(channel).or_else(|error| {
        let values = r.channel(channel).ok_or(error)?;
        let unit = Sensor {
            noise: 1.0,
            ..Sensor::default()
        };
        let mut noise = vec![0.0; values.len()];
        unit.add_noise(&mut noise, 0);
        for (n, _) in noise.iter_mut().zip(values).filter(|(_, v)| !v.is_finite()) {
            *n = f64::NAN;
        }
        let found = estimate_noise(r.axis(), &bridged(values))?;
        let of_one = estimate_noise(r.axis(), &bridged(&noise))?;
        Ok(NoiseEstimate {
            sigma: found.sigma / of_one.sigma,
            ..found
        })
    })
}

/// Missing samples that stand alone filled in.
fn bridged(values: &[f64]) -> Vec<f64> {
    let mut out = values.to_vec();
    for i in (2..values.len().saturating_sub(2)).filter(|&i| !values[i].is_finite()) {
        let near = values[i - 1] + values[i + 1];
        let far = values[i - 2] + values[i + 2];
        out[i] = (4.0 * near - far) / 6.0;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::channel_noise::*;

    fn swinging(noise: f64, missing: impl Fn(usize) -> bool) -> Recording {
        let time: Vec<f64> = (0..4000).map(|i| i as f64 / 50e3).collect();
        let swing = |t: &f64| 100e-6 * (std::f64::consts::TAU * 50.0 * t).sin();
        let mut xp: Vec<f64> = time.iter().map(swing).collect();
        let sensor = Sensor {
            noise,
            ..Sensor::default()
        };
        sensor.add_noise(&mut xp, 5);
        for (_, x) in xp.iter_mut().enumerate().filter(|(i, _)| missing(*i)) {
            *x = f64::NAN;
        }
        Recording::new("swing", time, None, xp, None).unwrap()
    }

    #[test]
    fn missing_samples_do_not_hide_the_noise() {
        for every in [3, 7, 12] {
            let r = swinging(20e-9, |i| i % every == 1);
            let found = noise_of(&r, Channel::ProofMass).unwrap();
            let error = found.sigma / 20e-9 - 1.0;
            assert!(
                error.abs() < 0.25,
                "every {every}th: {:+.1} %",
                100.0 * error
            );
        }
        let r = swinging(20e-9, |i| i % 7 < 2);
        assert!(noise_of(&r, Channel::ProofMass).is_err());
    }
}
