//! The samples of one channel, as the kinds of faults read them.

use std::ops::Range;

use super::fault::{FaultKind, InstrumentFault};
use super::thresholds::{
    MAX_PLACES, MAX_UNNOTICED_SHARE, VOLTAGE_EDGE_SAMPLES, VOLTAGE_EDGE_SHARE,
};
use crate::recording::channel::Channel;
use crate::recording::grid::TimeAxis;
use crate::recording::noise::{NoiseEstimate, estimate_noise};
use crate::recording::statistics::extremes;

/// The columns of a recording, in the order of [`Channel::ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    /// Times \[s\], increasing.
    pub time: &'a [f64],
    /// The samples of each channel, one for each time, NaN where missing; `None` if it was not recorded.
    pub channels: [Option<&'a [f64]>; 3],
    /// Noise of each channel; `None` if too few samples follow one another.
    pub noise: [Option<NoiseEstimate>; 3],
}

/// A channel of a recording without the samples that were found unusable so far.
pub struct Signal<'a> {
    /// Which channel.
    pub channel: Channel,
    /// Times \[s\].
    pub time: &'a [f64],
    /// Readings; NaN where missing or unusable.
    pub values: Vec<f64>,
    /// The drive voltage \[V\], if it was recorded.
    pub voltage: Option<&'a [f64]>,
    /// Noise of the channel; `None` if too few samples follow one another.
    pub noise: Option<NoiseEstimate>,
    /// Whether the voltage steps within [`VOLTAGE_EDGE_SAMPLES`] of a sample: what happens in a
    /// reading then may follow from it. Always false in the voltage itself.
    pub near_edge: Vec<bool>,
}

/// A fault, and the samples that it makes unusable.
pub struct Found {
    /// The fault.
    pub fault: InstrumentFault,
    /// Samples to leave out, increasing.
    pub unusable: Vec<usize>,
}

impl<'a> Signal<'a> {
    /// A channel; `None` if it was not recorded.
    pub fn of(columns: &Columns<'a>, channel: Channel) -> Option<Self> {
        let values = columns.channels[channel as usize]?.to_vec();
        let voltage = columns.channels[Channel::Voltage as usize];
        let driving = voltage.filter(|_| channel != Channel::Voltage);
        Some(Self {
            channel,
            time: columns.time,
            voltage,
            noise: columns.noise[channel as usize],
            near_edge: driving.map_or_else(|| vec![false; values.len()], near_edges),
            values,
        })
    }

    /// Leaves samples out from now on.
    pub fn leave_out(&mut self, samples: &[usize]) {
        for &i in samples {
            self.values[i] = f64::NAN;
        }
        if samples.len() as f64 > MAX_UNNOTICED_SHARE * self.values.len() as f64 {
            self.noise = estimate_noise(TimeAxis::Samples(self.time), &self.values).ok();
        }
    }

    /// Standard deviation of the noise, 0 if it is unknown.
    pub fn sigma(&self) -> f64 {
        self.noise.map_or(0.0, |n| n.sigma)
    }

    /// Step of the lattice on which the readings lie, 0 if they lie on none.
    pub fn lattice(&self) -> f64 {
        self.noise.and_then(|n| n.step).unwrap_or(0.0)
    }

    /// Highest minus lowest reading, 0 if there is none.
    pub fn span(&self) -> f64 {
        let (low, high) = extremes(&self.values);
        (high - low).max(0.0)
    }

    /// The fault of these places, each a range of samples; `None` if there are none.
    pub fn fault(
        &self,
        kind: FaultKind,
        size: f64,
        places: &[Range<usize>],
    ) -> Option<InstrumentFault> {
        if places.is_empty() || !size.is_finite() {
            return None;
        }
        let at = |range: &Range<usize>| (self.time[range.start], self.time[range.end - 1]);
        Some(InstrumentFault {
            kind,
            channel: self.channel,
            count: places.len(),
            samples: places.iter().map(ExactSizeIterator::len).sum(),
            of_samples: self.values.len(),
            places: places.iter().take(MAX_PLACES).map(at).collect(),
            size,
        })
    }
}

/// Where the voltage steps, and [`VOLTAGE_EDGE_SAMPLES`] around.
fn near_edges(volts: &[f64]) -> Vec<bool> {
    let (low, high) = extremes(volts);
    let least = VOLTAGE_EDGE_SHARE * (high - low);
    let mut near = vec![false; volts.len()];
    for i in (1..volts.len()).filter(|&i| (volts[i] - volts[i - 1]).abs() > least) {
        let from = (i - 1).saturating_sub(VOLTAGE_EDGE_SAMPLES);
        let to = (i + 1 + VOLTAGE_EDGE_SAMPLES).min(volts.len());
        near[from..to].fill(true);
    }
    near
}

/// Runs of samples for which `belongs` holds.
pub fn runs_where(count: usize, belongs: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for i in (0..count).filter(|i| belongs(*i)) {
        match runs.last_mut() {
            Some(run) if run.end == i => run.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}
