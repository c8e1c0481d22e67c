//! A channel at instants between its samples.

use crate::recording::{Channel, Recording};

/// Readings of a channel of `recording` at increasing `instants` \[s\] of its own clock; NaN where it says
/// nothing.
///
/// A displacement is read by the cubic through four samples, which takes a ring of an eighth of the
/// sampling rate down by 1 % where straight lines take it down by 7 %; a voltage by straight lines, since
/// a cubic would shoot over its edges. At a sample it is the sample.
pub(super) fn at_instants(
    recording: &Recording,
    channel: Channel,
    instants: &[f64],
) -> Option<Vec<f64>> {
    let values = recording.channel(channel)?;
    let mut i = 0;
    let read = instants.iter().map(|t| {
        while recording.time.get(i + 1).is_some_and(|next| next <= t) {
            i += 1;
        }
        if channel == Channel::Voltage {
            return recording.value_at(channel, *t).unwrap_or(f64::NAN);
        }
        cubic(recording, values, i, *t)
            .or_else(|| recording.value_at(channel, *t))
            .unwrap_or(f64::NAN)
    });
    Some(read.collect())
}

/// Lagrange's cubic through the samples `i - 1` to `i + 2` at `t` between the middle ones; `None` where
/// one of them is missing or a gap lies between them.
fn cubic(recording: &Recording, values: &[f64], i: usize, t: f64) -> Option<f64> {
    let first = i.checked_sub(1)?;
    let times = recording.time.get(first..first + 4)?;
    let values = values.get(first..first + 4)?;
    if (first..first + 3).any(|k| recording.is_gap(k)) || *times.get(1)? > t {
        return None;
    }
    let weight = |k: usize| {
        let others = (0..4).filter(|j| *j != k);
        others.fold(1.0, |w, j| w * (t - times[j]) / (times[k] - times[j]))
    };
    let sum: f64 = (0..4).map(|k| weight(k) * values[k]).sum();
    sum.is_finite().then_some(sum)
}

#[cfg(test)]
mod tests {
    use super::super::interpolate::*;

    #[test]
    fn cubics_are_exact_and_missing_samples_are_not_bridged() {
        let time: Vec<f64> = (0..20)
            .map(|i| f64::from(i) + 0.1 * (f64::from(i)).sin())
            .collect();
        let law = |t: f64| 1.0 + t - 0.2 * t * t + 0.01 * t.powi(3);
        let mut x: Vec<f64> = time.iter().map(|t| law(*t)).collect();
        x[10] = f64::NAN;
        let r = Recording::new("r", time, None, x, None).unwrap();
        let at = [-1.0, 2.5, r.time[4], 7.3, 10.2, 12.4, 18.9, 25.0];
        let read = at_instants(&r, Channel::ProofMass, &at).unwrap();
        assert!(read[0].is_nan() && read[7].is_nan() && read[4].is_nan());
        for k in [1, 3, 5] {
            assert!((read[k] - law(at[k])).abs() < 1e-12, "{k}: {}", read[k]);
        }
        assert_eq!(read[2], law(r.time[4]));
        // A straight line at the end.
        assert!((read[6] - law(at[6])).abs() < 0.05);
    }
}
