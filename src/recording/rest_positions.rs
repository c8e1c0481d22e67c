//! Positions at which the mass rests above the ground while the voltage is steady, from the
//! data alone. The ring has decayed there: only the static deflection is left.

use super::{Recording, extremes};

/// A voltage that moves by less than this share of its range is steady.
const STEADY_VOLTAGE_SHARE: f64 = 0.005;
/// Shortest time that the voltage must be steady for the ring to decay \[s\].
const MIN_STEADY_TIME: f64 = 20e-3;
/// Share of that time, at its end, over which the position is averaged.
const AVERAGED_SHARE: f64 = 0.5;
/// Largest movement in it \[m\]: over many periods the rest of the ring averages out to a percent.
const MAX_RING: f64 = 60e-6;
/// Largest difference between the means of its two halves, noise aside \[m\].
const MAX_HALF_DIFFERENCE: f64 = 1e-6;
/// Smallest height that is not the ground \[m\].
const MIN_HEIGHT: f64 = 5e-6;

/// A position at rest above the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestPosition {
    /// Voltage meanwhile \[V\].
    pub voltage: f64,
    /// Height above the ground \[m\].
    pub height: f64,
}

/// The rest positions of a recording, in order of time; empty without a voltage. `xp` is its
/// proof mass after a lag and changes of the ground's level were removed, `level` the ground's
/// level, `noise` the standard deviation of a sample, all in \[m\].
#[must_use]
pub fn rest_positions(
    recording: &Recording,
    xp: &[f64],
    level: f64,
    noise: f64,
) -> Vec<RestPosition> {
    let Some(volts) = recording.voltage.as_deref() else {
        return Vec::new();
    };
    let (low, high) = extremes(volts);
    if low > high {
        return Vec::new();
    }
    let still = STEADY_VOLTAGE_SHARE * (high - low);
    let mut found = Vec::new();
    let mut begin = 0;
    for i in 1..=volts.len() {
        if i < volts.len() && (volts[i] - volts[begin]).abs() <= still && !recording.is_gap(i - 1) {
            continue;
        }
        let long = recording.time[i - 1] - recording.time[begin];
        if long >= MIN_STEADY_TIME {
            let from = i - ((AVERAGED_SHARE * (i - begin) as f64) as usize).max(1);
            let middle = (from + i) / 2;
            let halves = [from..middle, middle..i].map(|half| mean(&xp[half]));
            if let [Some((a, x)), Some((b, y))] = halves {
                let height = 0.5 * (a + b) - level;
                let spread = x.1.max(y.1) - x.0.min(y.0);
                let steady = (a - b).abs() < MAX_HALF_DIFFERENCE + noise;
                if height > MIN_HEIGHT && spread < MAX_RING + 8.0 * noise && steady {
                    found.push(RestPosition {
                        voltage: volts[begin],
                        height,
                    });
                }
            }
        }
        begin = i;
    }
    found
}

/// Mean, lowest and highest of the finite values; `None` if fewer than 20 are finite.
fn mean(values: &[f64]) -> Option<(f64, (f64, f64))> {
    let finite = || values.iter().copied().filter(|x| x.is_finite());
    let count = finite().count();
    (count >= 20).then(|| (finite().sum::<f64>() / count as f64, extremes(values)))
}

#[cfg(test)]
mod tests {
    use super::super::rest_positions::*;

    /// A voltage of 8 V and -8 V in turn, 30 ms each; the mass rests 40 um above zero at the
    /// one, after a ring, and on the ground 58 um below it at the other.
    fn tapping() -> Recording {
        let time: Vec<f64> = (0..6000).map(|i| 2e-5 * f64::from(i)).collect();
        let up = |t: f64| ((t / 30e-3) as usize).is_multiple_of(2);
        let volts = time
            .iter()
            .map(|t| if up(*t) { 8.0 } else { -8.0 })
            .collect();
        let xp = time.iter().map(|&t| {
            let since = t % 30e-3;
            let ring = 5e-6 * (-since / 2e-3).exp() * (4e3 * since).cos();
            if up(t) { 40e-6 + ring } else { -58e-6 }
        });
        Recording::new("tapping", time.clone(), Some(volts), xp.collect(), None).unwrap()
    }

    #[test]
    fn rest_positions_are_above_the_ground_after_the_ring_has_decayed() {
        let found = rest_positions(&tapping(), &tapping().proof_mass, -58e-6, 20e-9);
        assert_eq!(found.len(), 2, "{found:?}");
        for position in found {
            assert!((position.height - 98e-6).abs() < 0.1e-6, "{position:?}");
            assert_eq!(position.voltage, 8.0);
        }
    }

    #[test]
    fn no_rest_position_while_the_mass_moves_or_without_a_voltage() {
        let mut moving = tapping();
        for (x, t) in moving.proof_mass.iter_mut().zip(&moving.time) {
            *x += 40e-6 * (3e3 * t).sin();
        }
        assert!(rest_positions(&moving, &moving.proof_mass, -58e-6, 20e-9).is_empty());
        let mut blind = tapping();
        blind.voltage = None;
        assert!(rest_positions(&blind, &blind.proof_mass, -58e-6, 20e-9).is_empty());
    }
}
