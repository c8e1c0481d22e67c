//! The contact level from data alone: the low height at which the mass rests.
//!
//! Resting low is not enough, for a driven mass also settles where it touches
//! nothing, and a slow one lingers where it turns. The ground is recognised by four signs:
//! the mass spends time there standing still (the mode of the histogram of slow, low
//! samples), nothing is found below it, the time spent near it does not grow as it
//! does at a turning point, and it is met suddenly or held while the voltage moves.

use super::events::{EventOptions, find_events, hop_height};
use super::features::missing::Missing;
use super::grid::TimeAxis;
use super::noise::NoiseEstimate;
use super::{extremes, median_in_place, quantile_in_place};

/// Shortest stay that shows a rest \[s\] (the sustained contact of Table A.1).
const MIN_STAY: f64 = 2e-4;
/// Only this lower share of the travel is searched.
const SEARCHED_SHARE: f64 = 0.3;
/// Samples at each end of a contact in which the voltage is not used.
const GUARD_SAMPLES: usize = 20;
/// A voltage that changes by this share of its range from one sample to the next jumps.
const JUMP_SHARE: f64 = 0.02;
/// Largest share of the samples below the ground: spikes of a sensor.
const MAX_SHARE_BELOW: f64 = 2e-3;

/// The level \[m\] at which the mass rests on the ground.
///
/// # Errors
/// [`Missing`] with the reason why there is no such level.
pub fn estimate_contact_level(
    time: TimeAxis,
    voltage: Option<&[f64]>,
    xp: &[f64],
    noise: Option<NoiseEstimate>,
) -> Result<f64, Missing> {
    let mut finite: Vec<f64> = xp.iter().copied().filter(|x| x.is_finite()).collect();
    if finite.len() < 50 || !time.covers(xp.len()) {
        return Err(Missing::TooShort {
            samples: finite.len(),
        });
    }
    let sigma = noise.map_or(0.0, |n| n.sigma);
    let step = noise
        .filter(|n| n.quantised)
        .and_then(|n| n.step)
        .unwrap_or(0.0);
    let bottom = quantile_in_place(&mut finite, 1e-3);
    let range = quantile_in_place(&mut finite, 0.999) - bottom;
    if range.is_nan() || range <= (20.0 * sigma).max(4.0 * step) {
        return Err(Missing::NoMotion);
    }

    // Slow and low samples.
    let interval = time.interval(xp.len());
    let rest = ((MIN_STAY / interval).ceil() as usize).max(3);
    let still = (6.0 * sigma).max(1.5 * step).max(1e-3 * range);
    let low = bottom + SEARCHED_SHARE * range;
    let slow: Vec<f64> = (0..xp.len().saturating_sub(rest))
        .filter(|&i| {
            let same = |j: usize| (xp[j] - xp[i]).abs() <= still;
            xp[i] <= low && same(i + rest / 2) && same(i + rest) && same(i + 1)
        })
        .map(|i| xp[i])
        .collect();
    if slow.len() < rest {
        return Err(Missing::NoRest);
    }

    // Mode of their histogram.
    let bin = (2.0 * sigma).max(step).max(5e-4 * range);
    let index = |x: f64| ((x - bottom) / bin).floor() as i64;
    let mut bins: Vec<i64> = slow.iter().map(|x| index(*x)).collect();
    bins.sort_unstable();
    let within = |b: i64| {
        let from = bins.partition_point(|v| *v < b - 1);
        bins.partition_point(|v| *v <= b + 1) - from
    };
    let (_, mode) = bins
        .chunk_by(|a, b| a == b)
        .map(|run| (within(run[0]), run[0]))
        .max()
        .ok_or(Missing::NoRest)?;
    let mut resting: Vec<f64> = slow
        .into_iter()
        .filter(|x| (index(*x) - mode).abs() <= 1)
        .collect();
    let level = median_in_place(&mut resting);

    // Nothing below it.
    let margin = (5.0 * sigma).max(2.0 * bin);
    let below = finite.iter().filter(|x| **x < level - margin).count();
    if below as f64 > MAX_SHARE_BELOW * finite.len() as f64 {
        return Err(Missing::NotAFloor { level });
    }
    // At a turning point the time below a height grows with its square root: twice
    // as much for four times the height. At rest it hardly grows.
    let near = (4.0 * sigma).max(bin);
    let time_within = |h: f64| finite.iter().filter(|x| **x <= level + h).count() as f64;
    if time_within(4.0 * near) > 1.5 * time_within(near) {
        return Err(Missing::NoRest);
    }
    let options = EventOptions {
        contact_level: level,
        noise: sigma,
        hop: hop_height(range),
    };
    let events = find_events(time, xp, &options);
    let sudden = !events.impacts.is_empty();
    if sudden || voltage.is_some_and(|v| held_against(time, v, &events.contacts)) {
        Ok(level)
    } else {
        Err(Missing::NoArrival { level })
    }
}

/// Whether the voltage moves steadily by a twentieth of its range during most of the
/// contacts. What it jumps does not count: a mass at rest anywhere needs some time to
/// follow a jump.
fn held_against(time: TimeAxis, voltage: &[f64], contacts: &[super::events::Contact]) -> bool {
    let (low, high) = extremes(voltage);
    let all = (high - low).max(0.0);
    let clear = GUARD_SAMPLES as f64 * time.interval(voltage.len());
    let mut i = 0;
    let mut moved = 0;
    for contact in contacts {
        // Well inside, for its ends are known no better.
        let margin = clear.min(0.1 * contact.duration());
        while i < voltage.len() && time.at(i) < contact.start + margin {
            i += 1;
        }
        let from = i;
        while i < voltage.len() && time.at(i) <= contact.end - margin {
            i += 1;
        }
        let (mut place, mut least, mut most) = (0.0, 0.0f64, 0.0f64);
        let steps = voltage[from..i].windows(2).map(|w| w[1] - w[0]);
        // A missing voltage makes a step that is none of either.
        for step in steps.filter(|step| step.abs() <= JUMP_SHARE * all) {
            place += step;
            least = least.min(place);
            most = most.max(place);
        }
        if most - least > 0.05 * all {
            moved += 1;
        }
    }
    all > 0.0 && moved > 0 && 2 * moved >= contacts.len()
}
