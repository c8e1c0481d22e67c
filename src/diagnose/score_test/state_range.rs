//! Ranges of the motion in the recordings, over which windows are laid.

use crate::diagnose::shooting::fitted::Fitted;
use crate::recording::quantile_in_place;

/// Ranges of height \[m\], velocity \[m/s\] and voltage \[V\] in the recordings: from the 1 % to
/// the 99 % quantile, the voltage in full.
pub(crate) fn state_ranges(fitted: &Fitted) -> ((f64, f64), (f64, f64), (f64, f64)) {
    let (mut x, mut v, mut u) = (Vec::new(), Vec::new(), Vec::new());
    for data in &fitted.problem.data {
        let r = &data.recording;
        let xp = &r.proof_mass;
        let step = 4.0 * r.interval();
        for i in (2..xp.len().saturating_sub(2)).step_by(5) {
            if xp[i].is_finite() {
                x.push(xp[i]);
            }
            let slope = (xp[i + 2] - xp[i - 2]) / step;
            if slope.is_finite() {
                v.push(slope);
            }
        }
        if let Some(volts) = &r.voltage {
            u.extend(volts.iter().copied().filter(|v| v.is_finite()).step_by(5));
        }
    }
    let range = |values: &mut Vec<f64>, edge: f64| {
        if values.is_empty() {
            return (0.0, 0.0);
        }
        let low = quantile_in_place(values, edge);
        (low, quantile_in_place(values, 1.0 - edge))
    };
    (range(&mut x, 0.01), range(&mut v, 0.01), range(&mut u, 0.0))
}
