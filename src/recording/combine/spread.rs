//! How far repeated trials differ: what is kept of it with their average.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::recording::channel::Channel;
use crate::recording::statistics::median_in_place;

/// Most samples of which the typical deviation is the median.
const MAX_INSPECTED: usize = 200_000;

/// Standard deviation between trials, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialSpread {
    /// Trials in the average.
    pub trials: usize,
    /// Deviation at each sample in the order of [`Channel::ALL`], as the trials are averaged.
    channels: [Option<Vec<f64>>; 3],
    /// Deviation that a single trial typically has once its zero is that of the average.
    typical: [Option<f64>; 3],
}

impl TrialSpread {
    /// The spread of `trials` trials. `around_zero` are the deviations between trials whose zeros are
    /// the same.
    pub(super) fn new(
        trials: usize,
        channels: [Option<Vec<f64>>; 3],
        around_zero: &[Option<Vec<f64>>; 3],
    ) -> Self {
        let typical = around_zero
            .each_ref()
            .map(|values| values.as_deref().and_then(|v| typical_deviation(v, trials)));
        Self {
            trials,
            channels,
            typical,
        }
    }

    /// Standard deviation between trials at each sample, in the unit of the channel; NaN where fewer
    /// than two trials have a reading.
    #[must_use]
    pub fn deviations(&self, channel: Channel) -> Option<&[f64]> {
        self.channels[channel as usize].as_deref()
    }

    /// Root mean square of [`Self::deviations`]: one number for the whole recording.
    #[must_use]
    pub fn mean_deviation(&self, channel: Channel) -> Option<f64> {
        let values = self.deviations(channel)?.iter().filter(|s| s.is_finite());
        let (sum, count) = values.fold((0.0, 0usize), |(sum, n), s| (sum + s * s, n + 1));
        (count > 0).then(|| (sum / count as f64).sqrt())
    }

    /// Standard deviation of the average itself: that of one trial, typical over the samples and with
    /// the zeros of the trials taken out, over the square root of their number.
    #[must_use]
    pub fn noise_of_average(&self, channel: Channel) -> Option<f64> {
        let typical = self.typical[channel as usize]?;
        Some(typical / (self.trials as f64).sqrt())
    }

    /// Keeps the samples for which `keep` is true.
    pub(in crate::recording) fn retain(&mut self, keep: &[bool]) {
        for values in self.channels.iter_mut().flatten() {
            let mut kept = keep.iter();
            values.retain(|_| kept.next().is_some_and(|k| *k));
        }
    }

    /// The spread of readings that are multiplied by `factor`.
    pub(in crate::recording) fn scale(&mut self, channel: Channel, factor: f64) {
        let factor = factor.abs();
        if let Some(values) = &mut self.channels[channel as usize] {
            values.iter_mut().for_each(|s| *s *= factor);
        }
        if let Some(typical) = &mut self.typical[channel as usize] {
            *typical *= factor;
        }
    }
}

/// The standard deviation of which most of `values`, each of `trials` readings, are estimates. By the
/// median of the variances, since impacts at slightly other instants spoil some of them: it lies at the
/// median of chi-squared.
fn typical_deviation(values: &[f64], trials: usize) -> Option<f64> {
    let freedom = trials.checked_sub(1).filter(|f| *f > 0)? as f64;
    let stride = values.len().div_ceil(MAX_INSPECTED).max(1);
    let picked = values.iter().step_by(stride).filter(|s| s.is_finite());
    let mut variances: Vec<f64> = picked.map(|s| s * s).collect();
    if variances.is_empty() {
        return None;
    }
    let median = median_in_place(&mut variances);
    let usual = ChiSquared::new(freedom).ok()?.inverse_cdf(0.5) / freedom;
    Some((median / usual).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::spread::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A normal number by twelve uniform ones.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    #[test]
    fn few_trials_give_the_deviation_without_bias() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for trials in [2usize, 3, 5, 20] {
            let deviations: Vec<f64> = (0..20_000)
                .map(|_| {
                    let x: Vec<f64> = (0..trials).map(|_| 2.0 * normal(&mut rng)).collect();
                    let mean = x.iter().sum::<f64>() / trials as f64;
                    let squares: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
                    (squares / (trials as f64 - 1.0)).sqrt()
                })
                .collect();
            let found = typical_deviation(&deviations, trials).unwrap();
            assert!((found / 2.0 - 1.0).abs() < 0.03, "{trials}: {found}");
            let channels = [None, Some(deviations), None];
            let spread = TrialSpread::new(trials, channels.clone(), &channels);
            let mean = spread.mean_deviation(Channel::ProofMass).unwrap();
            assert!((mean / 2.0 - 1.0).abs() < 0.03, "{trials}: {mean}");
            let noise = spread.noise_of_average(Channel::ProofMass).unwrap();
            assert!((noise * (trials as f64).sqrt() / found - 1.0).abs() < 1e-12);
        }
        assert_eq!(typical_deviation(&[f64::NAN], 3), None);
    }
}
