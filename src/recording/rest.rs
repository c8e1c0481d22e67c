//! Where the mass comes to rest in flight while the voltage stands still, from data alone.

use super::{Recording, median_in_place, quantile_in_place};

/// A voltage that moves by less than this share of its range stands still.
const STILL: f64 = 0.005;
/// Shortest time that it must stand for the ring to die away \[s\].
const LONG: f64 = 10e-3;
/// The last of that time, in which the mass is looked at, as a share.
const LAST: f64 = 0.25;
/// What is left of the ring moves the mass less than this in it, noise aside \[m\]: the
/// middle of so many periods is where it will rest to within a few percent of it.
const AT_REST: f64 = 10e-6;
/// Lowest height that is not the ground \[m\].
const CLEAR: f64 = 5e-6;

/// A rest in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// Voltage meanwhile \[V\].
    pub voltage: f64,
    /// Height above the ground \[m\].
    pub height: f64,
}

/// The rests in a recording whose ground is at `level` and whose proof mass has this
/// `noise` \[m\], in order of time. Empty without a voltage.
#[must_use]
pub fn rests(recording: &Recording, level: f64, noise: f64) -> Vec<Rest> {
    let Some(volts) = recording.voltage.as_deref() else {
        return Vec::new();
    };
    let mut sorted: Vec<f64> = volts.iter().copied().filter(|v| v.is_finite()).collect();
    if sorted.is_empty() {
        return Vec::new();
    }
    let low = quantile_in_place(&mut sorted, 0.0);
    let still = STILL * (quantile_in_place(&mut sorted, 1.0) - low);
    let mut found = Vec::new();
    let mut begin = 0;
    for i in 1..=volts.len() {
        if i < volts.len() && (volts[i] - volts[begin]).abs() <= still && !recording.is_gap(i - 1) {
            continue;
        }
        let long = recording.time[i - 1] - recording.time[begin];
        if long >= LONG {
            let from = i - ((LAST * (i - begin) as f64) as usize).max(1);
            let seen = recording.proof_mass[from..i].iter().copied();
            let mut seen: Vec<f64> = seen.filter(|x| x.is_finite()).collect();
            if seen.len() >= 20 {
                let spread =
                    quantile_in_place(&mut seen, 0.95) - quantile_in_place(&mut seen, 0.05);
                let height = median_in_place(&mut seen) - level;
                if height > CLEAR && spread < AT_REST + 4.0 * noise {
                    found.push(Rest {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A voltage of 8 V and -8 V in turn, 20 ms each; the mass rests 40 um above zero at the
    /// one, after a ring, and on the ground 58 um below it at the other.
    fn tapping() -> Recording {
        let time: Vec<f64> = (0..6000).map(|i| 2e-5 * f64::from(i)).collect();
        let up = |t: f64| (t / 20e-3) as usize % 2 == 0;
        let volts = time
            .iter()
            .map(|t| if up(*t) { 8.0 } else { -8.0 })
            .collect();
        let xp = time.iter().map(|&t| {
            let since = t % 20e-3;
            let ring = 5e-6 * (-since / 2e-3).exp() * (4e3 * since).cos();
            if up(t) { 40e-6 + ring } else { -58e-6 }
        });
        Recording::new("tapping", time.clone(), Some(volts), xp.collect(), None).unwrap()
    }

    #[test]
    fn it_is_above_the_ground_where_the_ring_has_died_away() {
        let found = rests(&tapping(), -58e-6, 20e-9);
        assert_eq!(found.len(), 3, "{found:?}");
        for rest in found {
            assert!((rest.height - 98e-6).abs() < 0.1e-6, "{rest:?}");
            assert_eq!(rest.voltage, 8.0);
        }
    }

    #[test]
    fn there_is_none_while_the_mass_moves_or_without_a_voltage() {
        let mut moving = tapping();
        for (x, t) in moving.proof_mass.iter_mut().zip(&moving.time) {
            *x += 12e-6 * (3e3 * t).sin();
        }
        assert!(rests(&moving, -58e-6, 20e-9).is_empty());
        let mut blind = tapping();
        blind.voltage = None;
        assert!(rests(&blind, -58e-6, 20e-9).is_empty());
    }
}
