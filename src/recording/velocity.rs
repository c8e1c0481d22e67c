//! Velocity of a recorded displacement: at each sample the slope of the line of least squares
//! through its neighbours, as few as the noise allows (Savitzky-Golay, first order).

/// Half widths that are tried, in samples.
const HALF_WIDTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Largest noise of the slopes, as a share of their range.
const MAX_NOISE_SHARE: f64 = 0.01;
/// Most samples from which noise and range are estimated.
const MAX_INSPECTED: usize = 20_000;

/// Rate of change of `values` at each of the increasing `time` \[s\], in their unit per second.
/// As many as samples; NaN where a value is missing or has no neighbour.
#[must_use]
pub fn differentiate(time: &[f64], values: &[f64]) -> Vec<f64> {
    let half = half_width(time, values);
    (0..time.len().min(values.len()))
        .map(|i| velocity_at(time, values, i, half))
        .collect()
}

/// Half width of the narrowest window whose slopes are quiet enough, in samples.
fn half_width(time: &[f64], values: &[f64]) -> usize {
    let n = time.len().min(values.len());
    let sigma = third_differences(&values[..n]);
    let stride = n.div_ceil(MAX_INSPECTED).max(1);
    for half in HALF_WIDTHS {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in (0..n).step_by(stride) {
            let slope = velocity_at(time, values, i, half);
            if slope.is_finite() {
                (low, high) = (low.min(slope), high.max(slope));
            }
        }
        let interval = (time[n - 1] - time[0]) / (n - 1) as f64;
        let h = half as f64;
        let noise = sigma / (interval * (h * (h + 1.0) * (2.0 * h + 1.0) / 3.0).sqrt());
        if noise <= MAX_NOISE_SHARE * (high - low) || 8 * half > n {
            return half;
        }
    }
    HALF_WIDTHS[HALF_WIDTHS.len() - 1]
}

/// Noise of single samples, from third differences: what is smooth cancels in them.
fn third_differences(values: &[f64]) -> f64 {
    let stride = values.len().div_ceil(MAX_INSPECTED).max(1);
    let mut sizes: Vec<f64> = values
        .windows(4)
        .step_by(stride)
        .map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).abs())
        .filter(|d| d.is_finite())
        .collect();
    if sizes.is_empty() {
        return 0.0;
    }
    // The median of a normal spread is 0.6745 of its deviation; the weights' squares add
    // up to 20.
    super::median_in_place(&mut sizes) / (0.6745 * 20f64.sqrt())
}

/// Slope of the line of least squares through the samples `half` around `i`.
fn velocity_at(time: &[f64], values: &[f64], i: usize, half: usize) -> f64 {
    let last = time.len().min(values.len()).saturating_sub(1);
    let window = i.saturating_sub(half)..=(i + half).min(last);
    if !values[i].is_finite() {
        return f64::NAN;
    }
    let (mut n, mut st, mut sx, mut stt, mut stx) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for j in window {
        // Against the middle, so that large times cost no digits.
        let (t, x) = (time[j] - time[i], values[j] - values[i]);
        if x.is_finite() {
            n += 1.0;
            st += t;
            sx += x;
            stt += t * t;
            stx += t * x;
        }
    }
    let spread = n * stt - st * st;
    if n < 2.0 || spread <= 0.0 {
        return f64::NAN;
    }
    (n * stx - st * sx) / spread
}

#[cfg(test)]
mod tests {
    use super::super::velocity::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_sine_is_differentiated_with_noise_and_missing_samples() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let rate = std::f64::consts::TAU * 5.0;
        let time: Vec<f64> = (0..4000).map(|i| 1e3 + i as f64 * 5e-4).collect();
        let mut values: Vec<f64> = time
            .iter()
            .map(|t| (rate * t).sin() + 2e-3 * (rng.random::<f64>() - 0.5))
            .collect();
        values[100] = f64::NAN;
        let found = differentiate(&time, &values);
        assert!(found[100].is_nan());
        let worst = (10..3990)
            .filter(|i| *i != 100)
            .map(|i| (found[i] / rate - (rate * time[i]).cos()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.1, "{worst}");
        // Without noise the narrowest window does, and is all but exact.
        let clean: Vec<f64> = time.iter().map(|t| (rate * t).sin()).collect();
        assert_eq!(half_width(&time, &clean), 1);
    }

    #[test]
    fn two_samples_give_a_velocity() {
        assert_eq!(differentiate(&[0.0, 2.0], &[1.0, 5.0]), [2.0, 2.0]);
    }
}
