//! From a velocity or an acceleration to a displacement.
//!
//! The cumulative trapezoid (each step adds the mean of its ends times its length) is exact for readings
//! that are straight between samples. What an integral cannot know is its start: the displacement at the
//! first sample is 0. An offset of the instrument makes a line of it. Only the person who recorded it knows
//! whether the device really drifts: [`drift`] takes out what is chosen. Its size is returned, so that it
//! can be said.

pub mod drift;

/// A displacement and what it drifts by.
#[derive(Debug, Clone, PartialEq)]
pub struct Integral {
    /// The integral at each time; NaN where a reading is missing.
    pub values: Vec<f64>,
    /// From the first to the last value: what an offset, or a real motion, adds up to.
    pub net: f64,
    /// Mean of the integrand; times the duration it is `net`.
    pub mean: f64,
    /// Steps over missing readings, which are bridged by a straight line.
    pub bridged: usize,
}

/// The cumulative trapezoid of `rate` over `time`, 0 at the first reading.
#[must_use]
pub fn integrate(time: &[f64], rate: &[f64]) -> Integral {
    let mut values = Vec::with_capacity(rate.len());
    let mut before: Option<(f64, f64)> = None;
    // Compensated (W. Kahan, 1965): ten million steps must not add their rounding.
    let (mut sum, mut lost) = (0.0, 0.0);
    let (mut bridged, mut missing) = (0, false);
    let mut start = None;
    for (t, rate) in time.iter().zip(rate) {
        if !rate.is_finite() {
            values.push(f64::NAN);
            missing = before.is_some();
            continue;
        }
        if let Some((t_before, rate_before)) = before {
            bridged += usize::from(missing);
            let step = 0.5 * (rate + rate_before) * (t - t_before) - lost;
            let next = sum + step;
            lost = (next - sum) - step;
            sum = next;
        }
        missing = false;
        start.get_or_insert(*t);
        before = Some((*t, *rate));
        values.push(sum);
    }
    let span = match (start, before) {
        (Some(start), Some((end, _))) => end - start,
        _ => 0.0,
    };
    Integral {
        values,
        net: sum,
        mean: if span > 0.0 { sum / span } else { 0.0 },
        bridged,
    }
}

#[cfg(test)]
mod tests {
    use super::super::integrate::integrate;

    #[test]
    fn lines_are_integrated_exactly() {
        let time: Vec<f64> = (0..=1000).map(|i| f64::from(i) * 1e-3).collect();
        let rate: Vec<f64> = time.iter().map(|t| 3.0 - 2.0 * t).collect();
        let integral = integrate(&time, &rate);
        for (t, x) in time.iter().zip(&integral.values) {
            assert!((x - (3.0 * t - t * t)).abs() < 1e-14, "{t}: {x}");
        }
        assert!((integral.net - 2.0).abs() < 1e-14);
        assert!((integral.mean - 2.0).abs() < 1e-14);
    }

    /// The trapezoid of a sine is the integral times (w dt / 2) / tan(w dt / 2), exactly.
    #[test]
    fn a_sine_has_the_known_error() {
        let (w, dt) = (2.0 * std::f64::consts::PI * 15.0, 2.5e-4);
        let time: Vec<f64> = (0..4000).map(|i| f64::from(i) * dt).collect();
        let rate: Vec<f64> = time.iter().map(|t| (w * t).cos()).collect();
        let integral = integrate(&time, &rate);
        let factor = 0.5 * w * dt / (0.5 * w * dt).tan();
        for (t, x) in time.iter().zip(&integral.values) {
            assert!((x - factor * (w * t).sin() / w).abs() < 1e-14);
        }
    }

    #[test]
    fn uneven_times_and_missing_readings() {
        let integral = integrate(&[0.0, 1.0, 3.0, 4.0], &[1.0, 1.0, f64::NAN, 1.0]);
        assert_eq!(integral.values[1], 1.0);
        assert!(integral.values[2].is_nan());
        assert_eq!((integral.values[3], integral.bridged), (4.0, 1));
        let integral = integrate(&[0.0], &[f64::NAN]);
        assert_eq!((integral.net, integral.mean), (0.0, 0.0));
    }

    /// Ten million steps of an offset: the sum's rounding stays that of one addition.
    #[test]
    fn the_rounding_does_not_add_up() {
        let rows = 2_000_000;
        let time: Vec<f64> = (0..rows).map(|i| f64::from(i) * 1e-5).collect();
        let integral = integrate(&time, &vec![0.1; rows as usize]);
        let expected = 0.1 * f64::from(rows - 1) * 1e-5;
        assert!((integral.net / expected - 1.0).abs() < 1e-15);
    }
}
