//! A reading without its slow part: behind a high-pass filter it decays to zero wherever the mass
//! rests, whatever the voltage, with one time constant.

use crate::recording::channel::Channel;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::kinds::quiet::{Block, stays};
use crate::recording::instrument_faults::signal::{Found, Signal};
use crate::recording::instrument_faults::thresholds::{
    AC_MAX_ZERO_SHARE, AC_MIN_BLOCKS, AC_MIN_EXPLAINED, AC_MIN_LEVEL_SPREAD_SHARE, AC_MIN_STOPS,
    AC_MIN_VOLTAGE_SPREAD_SHARE, AC_STOP_SPEED_RATIO, QUIET_BLOCK_SAMPLES,
};
use crate::recording::statistics::extremes;

/// The time constant, if slopes at rest are proportional to the reading. A reading that drifts
/// to an end does that as well, but to a level near its own, and creep of the drive follows the voltage.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    let volts = signal
        .voltage
        .filter(|_| signal.channel != Channel::Voltage)?;
    let stays = stays(signal);
    let stops = stays
        .iter()
        .filter(|stay| is_sudden_stop(signal, &stay[0]))
        .count();
    let blocks: Vec<Block> = stays.into_iter().flatten().collect();
    if blocks.len() < AC_MIN_BLOCKS {
        return None;
    }
    let span = signal.span();
    let spread = |of: fn(&Block) -> f64| {
        let (low, high) = extremes(&blocks.iter().map(of).collect::<Vec<f64>>());
        high - low
    };
    let (low, high) = extremes(volts);
    let several_voltages = spread(|b| b.voltage) >= AC_MIN_VOLTAGE_SPREAD_SHARE * (high - low);
    let at_rest = several_voltages || stops >= AC_MIN_STOPS;
    if !at_rest || spread(|b| b.mean) < AC_MIN_LEVEL_SPREAD_SHARE * span {
        return None;
    }
    let n = blocks.len() as f64;
    let mean = blocks.iter().map(|b| b.mean).sum::<f64>() / n;
    let slope = blocks.iter().map(|b| b.slope).sum::<f64>() / n;
    let (mut xx, mut xs, mut ss) = (0.0, 0.0, 0.0);
    for block in &blocks {
        let (x, s) = (block.mean - mean, block.slope - slope);
        xx += x * x;
        xs += x * s;
        ss += s * s;
    }
    let rate = -xs / xx;
    let zero = mean + slope / rate;
    let explained = xs * xs / (xx * ss);
    // False where the slopes are no numbers.
    let decays =
        rate > 0.0 && explained >= AC_MIN_EXPLAINED && zero.abs() <= AC_MAX_ZERO_SHARE * span;
    if !decays {
        return None;
    }
    let whole = 0..signal.values.len();
    Some(Found {
        fault: signal.fault(
            FaultKind::AcCoupling,
            1.0 / rate,
            std::slice::from_ref(&whole),
        )?,
        unusable: Vec::new(),
    })
}

/// Whether the mass moved fast before the first block of a stay, with no step of the voltage near:
/// the ground has stopped it.
fn is_sudden_stop(signal: &Signal<'_>, first: &Block) -> bool {
    let start = first.samples.start;
    let from = start.saturating_sub(2 * QUIET_BLOCK_SAMPLES);
    let beyond = QUIET_BLOCK_SAMPLES / 4;
    if start - from < 2 * beyond || signal.near_edge[from..start].contains(&true) {
        return false;
    }
    let speeds = (from..start - beyond).map(|i| {
        let gone = signal.values[i + beyond] - signal.values[i];
        gone.abs() / (signal.time[i + beyond] - signal.time[i])
    });
    speeds.fold(0.0, f64::max) > AC_STOP_SPEED_RATIO * first.slope.abs()
}
