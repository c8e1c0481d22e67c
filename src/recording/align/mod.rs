//! Laying a recording over a simulation: shift, scale, offset, and the shift found
//! by correlation.
//!
//! The agreement is taken over the samples that both have at a shift, for all
//! shifts at once by FFT with masks (D. Padfield, "Masked object registration in the
//! Fourier domain", IEEE Trans. Image Process. 21, 2012), so that gaps, missing
//! samples and different lengths need no filling. The best shift is then refined
//! between samples on the recording's own times.

mod correlate;
mod error;
pub mod set_up;

pub use self::error::AlignError;

use serde::{Deserialize, Serialize};

use self::correlate::{Masked, correlate};
use self::error::MIN_CORRELATION;
use super::grid::Grid;
use super::{Channel, Recording};

/// Most points of the grid that is correlated; a longer one is made coarser.
const MAX_GRID: usize = 1 << 20;
/// Of peaks within this of the best agreement the smallest shift wins: a periodic
/// motion fits at every period.
const EQUAL_CORRELATION: f64 = 0.005;

/// Largest ratio of the amplitudes, either way.
const MAX_AMPLITUDE_RATIO: f64 = 10.0;
/// Samples used to refine the shift.
const REFINE_SAMPLES: usize = 100_000;

/// How a recording is laid over a simulation: `t + time_shift`,
/// `x * scale + offset`. Applied when comparing and drawing; the recording itself is
/// never changed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Alignment {
    /// Added to the recording's times \[s\].
    pub time_shift: f64,
    /// Multiplies the proof mass.
    pub xp_scale: f64,
    /// Added to the scaled proof mass \[m\].
    pub xp_offset: f64,
    /// Multiplies the cantilever.
    pub xc_scale: f64,
    /// Added to the scaled cantilever \[m\].
    pub xc_offset: f64,
    /// Multiplies the voltage.
    pub voltage_scale: f64,
}

impl Default for Alignment {
    fn default() -> Self {
        Self {
            time_shift: 0.0,
            xp_scale: 1.0,
            xp_offset: 0.0,
            xc_scale: 1.0,
            xc_offset: 0.0,
            voltage_scale: 1.0,
        }
    }
}

impl Alignment {
    /// Simulated time of a recorded time \[s\].
    #[must_use]
    pub fn time(&self, t: f64) -> f64 {
        t + self.time_shift
    }

    /// Value to compare of a recorded value.
    #[must_use]
    pub fn value(&self, channel: Channel, value: f64) -> f64 {
        match channel {
            Channel::Voltage => value * self.voltage_scale,
            Channel::ProofMass => value * self.xp_scale + self.xp_offset,
            Channel::Cantilever => value * self.xc_scale + self.xc_offset,
        }
    }
}

/// A shift found by correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aligned {
    /// To be added to the recording's times \[s\].
    pub time_shift: f64,
    /// Pearson's correlation at that shift, -1 to 1.
    pub correlation: f64,
    /// Factor and offset that then bring the recording closest to the simulation in
    /// the least-squares sense; a suggestion.
    pub scale: f64,
    /// See `scale`; in the unit of the channel.
    pub offset: f64,
    /// Samples of the recording that overlap.
    pub samples: usize,
    /// They as a share of all.
    pub share: f64,
}

/// Finds the shift of a recording against a simulated trace of the same channel. The
/// means are taken out, so an offset does not matter; `scale` is the factor that the
/// recording is drawn with, and amplitudes count: a decaying motion would otherwise fit
/// anywhere along its decay. `max_shift` \[s\] bounds the search, if given.
///
/// # Errors
/// [`AlignError`] if there is nothing to correlate, or no clear match.
///
/// # Examples
/// ```
/// use impactscope::recording::align::auto_align;
/// use impactscope::recording::{Channel, Grid, Recording};
///
/// // A chirp; the recording started 3 ms later than the simulation.
/// let chirp = |t: f64| 1e-6 * (2e3 * t + 1e5 * t * t).sin();
/// let time: Vec<f64> = (0..2000).map(|i| 2e-5 * f64::from(i)).collect();
/// let simulated: Vec<f64> = time.iter().map(|t| chirp(*t)).collect();
/// let xp = time.iter().map(|t| chirp(t + 3e-3)).collect();
/// let recording = Recording::new("chirp", time, None, xp, None)?;
/// let grid = Grid { t0: 0.0, dt: 2e-5, values: &simulated, slopes: None };
/// let aligned = auto_align(&recording, Channel::ProofMass, 1.0, grid, None)?;
/// assert!((aligned.time_shift - 3e-3).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn auto_align(
    recording: &Recording,
    channel: Channel,
    scale: f64,
    simulated: Grid,
    max_shift: Option<f64>,
) -> Result<Aligned, AlignError> {
    let values = recording
        .channel(channel)
        .ok_or(AlignError::NotRecorded(channel.symbol()))?;
    if simulated.values.len() < 2
        || simulated.dt.is_nan()
        || simulated.dt <= 0.0
        || !simulated.t0.is_finite()
    {
        return Err(AlignError::BadGrid);
    }
    // The finer of the two intervals, unless that makes too many samples.
    let (rec_span, sim_span) = (recording.duration(), simulated.end() - simulated.t0);
    let coarsest = rec_span.max(sim_span) / MAX_GRID as f64;
    let dt = recording.interval().min(simulated.dt).max(coarsest);
    let (first, _) = recording.span();
    let count = |span: f64| (span / dt + 1e-6) as usize + 1;
    let measured = recording
        .resampled(channel, first, dt, count(rec_span))
        .unwrap_or_default();
    let modelled: Vec<f64> = (0..count(sim_span))
        .map(|i| {
            simulated
                .value_at(simulated.t0 + i as f64 * dt)
                .unwrap_or(f64::NAN)
        })
        .collect();
    let measured = Masked::new(&measured, "recording")?;
    let modelled = Masked::new(&modelled, "simulation")?;

    let ratio = measured.spread * scale.abs() / modelled.spread;
    let lags = correlate(&modelled, &measured, ratio.copysign(scale));
    let shift_of = |lag: i64| simulated.t0 - first + lag as f64 * dt;
    let allowed = |lag: i64| max_shift.is_none_or(|most| shift_of(lag).abs() <= most + 0.5 * dt);
    let best = lags
        .iter()
        .filter(|(lag, _)| allowed(*lag))
        .map(|(_, c)| *c)
        .fold(f64::NEG_INFINITY, f64::max);
    if !best.is_finite() {
        return Err(AlignError::NoOverlap);
    }
    if !(1.0 / MAX_AMPLITUDE_RATIO..=MAX_AMPLITUDE_RATIO).contains(&ratio) {
        return Err(AlignError::Amplitude { ratio });
    }
    let is_peak = |i: usize| {
        let c = lags[i].1;
        let neighbour = |j: Option<usize>| {
            j.and_then(|j| lags.get(j))
                .map_or(f64::NEG_INFINITY, |l| l.1)
        };
        c >= neighbour(i.checked_sub(1)) && c >= neighbour(Some(i + 1))
    };
    let (lag, _) = (0..lags.len())
        .filter(|&i| allowed(lags[i].0) && lags[i].1 >= best - EQUAL_CORRELATION && is_peak(i))
        .map(|i| lags[i])
        .min_by(|a, b| shift_of(a.0).abs().total_cmp(&shift_of(b.0).abs()))
        .or_else(|| lags.iter().copied().find(|l| allowed(l.0) && l.1 == best))
        .ok_or(AlignError::NoOverlap)?;
    let start = (shift_of(lag), dt);
    let found = refine(&recording.time, values, scale.signum(), simulated, start)?;
    // A recording that is drawn turned over must match so.
    let correlation = found.correlation * scale.signum();
    if correlation < MIN_CORRELATION {
        return Err(AlignError::NoMatch {
            correlation,
            shift: found.time_shift,
        });
    }
    Ok(found)
}

/// Sums of a regression of simulated on recorded values at one shift.
fn regression(time: &[f64], values: &[f64], simulated: Grid, shift: f64) -> Option<Aligned> {
    let stride = (time.len() / REFINE_SAMPLES).max(1);
    let pairs = || {
        time.iter()
            .zip(values)
            .step_by(stride)
            .filter(|(_, x)| x.is_finite())
            .filter_map(|(t, x)| simulated.value_at(t + shift).map(|y| (*x, y)))
    };
    let (mut n, mut mx, mut my) = (0usize, 0.0, 0.0);
    for (x, y) in pairs() {
        n += 1;
        mx += x;
        my += y;
    }
    if n < 3 {
        return None;
    }
    mx /= n as f64;
    my /= n as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs() {
        xx += (x - mx) * (x - mx);
        xy += (x - mx) * (y - my);
        yy += (y - my) * (y - my);
    }
    if xx <= 0.0 || yy <= 0.0 {
        return None;
    }
    let scale = xy / xx;
    Some(Aligned {
        time_shift: shift,
        correlation: xy / (xx * yy).sqrt(),
        scale,
        offset: my - scale * mx,
        samples: n * stride,
        share: (n * stride) as f64 / time.len() as f64,
    })
}

/// Golden-section search for the best correlation of `sign` times the recording within
/// one interval `dt` of `start` \[s\].
fn refine(
    time: &[f64],
    values: &[f64],
    sign: f64,
    simulated: Grid,
    (start, dt): (f64, f64),
) -> Result<Aligned, AlignError> {
    let at = |shift: f64| regression(time, values, simulated, shift);
    let score = |shift: f64| at(shift).map_or(f64::NEG_INFINITY, |a| sign * a.correlation);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (start - dt, start + dt);
    let mut a = high - golden * (high - low);
    let mut b = low + golden * (high - low);
    let (mut at_a, mut at_b) = (score(a), score(b));
    for _ in 0..24 {
        if at_a >= at_b {
            high = b;
            (b, at_b) = (a, at_a);
            a = high - golden * (high - low);
            at_a = score(a);
        } else {
            low = a;
            (a, at_a) = (b, at_b);
            b = low + golden * (high - low);
            at_b = score(b);
        }
    }
    let found = at(0.5 * (low + high));
    // The search never ends worse than it began.
    [found, at(start)]
        .into_iter()
        .flatten()
        .max_by(|a, b| (sign * a.correlation).total_cmp(&(sign * b.correlation)))
        .ok_or(AlignError::NoOverlap)
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
