//! Medians, quantiles and extremes of samples.

/// Median of the steps of `time`; NaN below two samples. Long axes are judged by
/// about 200 000 evenly picked steps, which is as good and does not wait.
pub fn median_interval(time: &[f64]) -> f64 {
    let stride = (time.len() / 200_000).max(1);
    let mut steps: Vec<f64> = time
        .windows(2)
        .step_by(stride)
        .map(|w| w[1] - w[0])
        .collect();
    median_in_place(&mut steps)
}

/// Median of `values` (the lower of the middle two), reordering them; NaN if empty.
pub fn median_in_place(values: &mut [f64]) -> f64 {
    quantile_in_place(values, 0.5)
}

/// Lowest and highest of the finite `values`; infinite and the wrong way round if there are
/// none.
pub fn extremes(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(*v), h.max(*v))
    })
}

/// The value below which the share `q` of `values` lies, reordering them; NaN if
/// empty.
pub fn quantile_in_place(values: &mut [f64], q: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let k = (q * (values.len() - 1) as f64) as usize;
    let k = k.min(values.len() - 1);
    *values.select_nth_unstable_by(k, f64::total_cmp).1
}
