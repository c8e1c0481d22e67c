//! Agreement of two signals at all shifts at once, by FFT with masks.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::error::AlignError;

/// Smallest overlap, as a share of the shorter of the two: over a short stretch anything
/// periodic can be made to agree with anything of about the same frequency.
const MIN_OVERLAP: f64 = 0.7;
/// Up to this ratio the amplitudes do not count against a shift: the model may still have to be
/// tuned.
const FREE_AMPLITUDE_RATIO: f64 = 2.0;

/// A signal with its mean taken out, zero where it is missing, and where it is not.
pub(super) struct Masked {
    values: Vec<f64>,
    mask: Vec<f64>,
    count: usize,
    /// Standard deviation of what was there.
    pub(super) spread: f64,
}

impl Masked {
    pub(super) fn new(raw: &[f64], which: &'static str) -> Result<Self, AlignError> {
        let present = || raw.iter().copied().filter(|v| v.is_finite());
        let count = present().count();
        let mean = present().sum::<f64>() / count.max(1) as f64;
        let spread = present().map(|v| (v - mean).powi(2)).sum::<f64>() / count.max(1) as f64;
        let scale = spread.sqrt();
        let size = present().fold(0.0, |m: f64, v| m.max(v.abs()));
        if count < 2 || scale.is_nan() || scale <= 1e-12 * size {
            return Err(AlignError::Constant { which });
        }
        // Unit variance keeps the sums below near one, where the FFT is exact enough.
        let values = raw.iter().map(|v| {
            if v.is_finite() {
                (v - mean) / scale
            } else {
                0.0
            }
        });
        Ok(Self {
            values: values.collect(),
            mask: raw
                .iter()
                .map(|v| f64::from(u8::from(v.is_finite())))
                .collect(),
            count,
            spread: scale,
        })
    }
}

/// Agreement for each lag of `b` against `a` (`b[i]` on `a[i + lag]`), lags in increasing
/// order, those with enough overlap only: Pearson's correlation, taken down where one
/// moves more than twice as much as the other. `ratio` is the size of `b` against `a`,
/// negative if `b` is to be turned over.
pub(super) fn correlate(a: &Masked, b: &Masked, ratio: f64) -> Vec<(i64, f64)> {
    let (na, nb) = (a.values.len(), b.values.len());
    let n = (na + nb).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(n);
    let inverse = planner.plan_fft_inverse(n);
    let spectrum = |values: &mut dyn Iterator<Item = f64>| {
        let mut input = forward.make_input_vec();
        input.iter_mut().zip(values).for_each(|(slot, v)| *slot = v);
        let mut output = forward.make_output_vec();
        // Lengths are the planner's own: this cannot fail.
        let _ = forward.process(&mut input, &mut output);
        output
    };
    let product = |x: &[Complex<f64>], y: &[Complex<f64>]| {
        let mut both: Vec<Complex<f64>> = x.iter().zip(y).map(|(x, y)| x * y.conj()).collect();
        // The inverse wants these exactly real; rounding leaves them nearly so.
        if let Some(first) = both.first_mut() {
            first.im = 0.0;
        }
        if let Some(last) = both.last_mut() {
            last.im = 0.0;
        }
        let mut output = inverse.make_output_vec();
        let _ = inverse.process(&mut both, &mut output);
        output.iter_mut().for_each(|v| *v /= n as f64);
        output
    };
    let (a0, a1, a2) = (
        spectrum(&mut a.mask.iter().copied()),
        spectrum(&mut a.values.iter().copied()),
        spectrum(&mut a.values.iter().map(|v| v * v)),
    );
    let (b0, b1, b2) = (
        spectrum(&mut b.mask.iter().copied()),
        spectrum(&mut b.values.iter().copied()),
        spectrum(&mut b.values.iter().map(|v| v * v)),
    );
    let overlap = product(&a0, &b0);
    let (sum_a, sum_b) = (product(&a1, &b0), product(&a0, &b1));
    let (squares_a, squares_b) = (product(&a2, &b0), product(&a0, &b2));
    let cross = product(&a1, &b1);

    let least = (MIN_OVERLAP * a.count.min(b.count) as f64).max(3.0);
    (-(nb as i64 - 1)..na as i64)
        .filter_map(|lag| {
            let i = if lag < 0 {
                n - lag.unsigned_abs() as usize
            } else {
                lag as usize
            };
            let m = overlap[i];
            if m < least - 0.5 {
                return None;
            }
            let covariance = cross[i] - sum_a[i] * sum_b[i] / m;
            let variance_a = squares_a[i] - sum_a[i] * sum_a[i] / m;
            let variance_b = squares_b[i] - sum_b[i] * sum_b[i] / m;
            // Where one of them stands still there is nothing to correlate.
            let flat = variance_a <= 1e-6 * m || variance_b <= 1e-6 * m;
            (!flat).then(|| {
                let size = ratio.abs() * (variance_b / variance_a).sqrt();
                let alike = (FREE_AMPLITUDE_RATIO / size.max(1.0 / size)).min(1.0);
                let correlation = covariance / (variance_a * variance_b).sqrt();
                (lag, ratio.signum() * correlation * alike)
            })
        })
        .collect()
}
