//! How one recording lies over another in time, and how their voltages agree there.

use super::error::CombineError;
use super::interpolate::at_instants;
use crate::model::unit::format_quantity;
use crate::recording::align::{AlignError, auto_align};
use crate::recording::{Channel, Grid, Recording, extremes};

/// Least correlation of a clear match, that of [`crate::recording::align`].
const MIN_CORRELATION: f64 = 0.7;
/// Most points of the even grid on which the reference is correlated.
const MAX_GRID: usize = 1 << 20;
/// Largest rms difference of two voltages under one drive, as a share of what they move by: levels of
/// 7 V and 7.5 V differ by more, a monitor with steps of 1 % by less.
const MAX_VOLTAGE_SHARE: f64 = 0.05;
/// Noise of the voltages counts as agreement up to so many times what both have together.
const MAX_VOLTAGE_NOISE: f64 = 3.0;
/// A step between neighbours of more than this share of the range is an edge, at which a fraction of a
/// sample decides the difference.
const EDGE_SHARE: f64 = 0.05;
/// Fewest samples away from edges that are compared; with fewer all are.
const MIN_CALM_SAMPLES: usize = 16;
/// Clocks that drift apart by more than this many samples from half to half run at different rates.
const MIN_CLOCK_SAMPLES: f64 = 0.5;

/// How a recording lies over a reference.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overlay {
    /// To be added to the times of the recording \[s\].
    pub lag: f64,
    /// What they were laid over each other by; `None` if the lag was given.
    pub by: Option<Channel>,
    /// Correlation at this lag; 0 if the lag was given.
    pub correlation: f64,
    /// By how much the recording's clock is faster than the reference's, as a share, where it is.
    pub clock_difference: Option<f64>,
}

/// How two voltages agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltageAgreement {
    /// Root mean square of the difference away from edges \[V\].
    pub rms: f64,
    /// What is allowed \[V\].
    pub allowed: f64,
    /// Samples compared.
    pub samples: usize,
    /// The recording's voltage for each volt of the reference, by least squares.
    pub scale: f64,
    /// What the recording's voltage is beyond that \[V\].
    pub offset: f64,
}

impl VoltageAgreement {
    /// Whether it is one drive.
    #[must_use]
    pub fn is_one_drive(&self) -> bool {
        self.rms <= self.allowed
    }

    /// Scale and offset in words.
    fn relation(&self) -> String {
        format!(
            "the second is {:.4} times the first, plus {}",
            self.scale,
            format_quantity(self.offset, "V", 3)
        )
    }
}

/// Lays `other` over `reference` by their voltages, or by their motion where `by_motion` allows it and a
/// voltage is missing or constant.
///
/// # Errors
/// [`CombineError`]: nothing to go by, no clear match.
pub fn lay_over(
    reference: &Recording,
    other: &Recording,
    by_motion: bool,
) -> Result<Overlay, CombineError> {
    let by_voltage = match (voltage_of(reference), voltage_of(other)) {
        (Ok(()), Ok(())) => Ok(Channel::Voltage),
        (Err(error), _) | (_, Err(error)) => Err(error),
    };
    let channel = match by_voltage {
        Ok(channel) => channel,
        Err(_) if by_motion => Channel::ProofMass,
        Err(error) => return Err(error),
    };
    let values = grid_of(reference, channel);
    let (first, _) = reference.span();
    let grid = Grid {
        t0: first,
        dt: values.1,
        values: &values.0,
        slopes: None,
    };
    let found = auto_align(other, channel, 1.0, grid, None)
        .map_err(|error| explained(error, reference, other, channel))?;
    Ok(Overlay {
        lag: snapped(found.time_shift, reference, other),
        by: Some(channel),
        correlation: found.correlation,
        clock_difference: clock_difference(other, channel, grid, found.time_shift),
    })
}

/// Whether there is a voltage that moves.
fn voltage_of(recording: &Recording) -> Result<(), CombineError> {
    let name = || recording.name.clone().into();
    let Some(volts) = recording.channel(Channel::Voltage) else {
        return Err(CombineError::NoVoltage { name: name() });
    };
    let (low, high) = extremes(volts);
    let noise = recording.noise(Channel::Voltage).map_or(0.0, |n| n.sigma);
    // Noise alone has nothing to lay over each other.
    if high - low > 12.0 * noise && high > low {
        Ok(())
    } else {
        Err(CombineError::ConstantVoltage { name: name() })
    }
}

/// A channel on an even grid of its own interval, and that interval.
fn grid_of(recording: &Recording, channel: Channel) -> (Vec<f64>, f64) {
    let dt = recording
        .interval()
        .max(recording.duration() / MAX_GRID as f64);
    let count = (recording.duration() / dt + 1e-6) as usize + 1;
    let (first, _) = recording.span();
    let values = recording.resampled(channel, first, dt, count);
    (values.unwrap_or_default(), dt)
}

/// A lag within a thousandth of a sample of a whole number of samples is that number.
fn snapped(lag: f64, reference: &Recording, other: &Recording) -> f64 {
    let dt = reference.interval();
    let is_one_rate = (other.interval() / dt - 1.0).abs() < 1e-6;
    let whole = ((lag - reference.span().0 + other.span().0) / dt).round();
    let exact = whole * dt + reference.span().0 - other.span().0;
    if is_one_rate && (exact - lag).abs() < 1e-3 * dt {
        exact
    } else {
        lag
    }
}

fn explained(
    error: AlignError,
    reference: &Recording,
    other: &Recording,
    channel: Channel,
) -> CombineError {
    let (name, against) = (&other.name, &reference.name);
    let no_match = |correlation: f64| CombineError::NoMatch {
        name: name.clone().into(),
        reference: against.clone().into(),
        channel: match channel {
            Channel::Voltage => "the voltages",
            _ => "the displacements",
        },
        correlation,
        least: MIN_CORRELATION,
    };
    match error {
        AlignError::NoMatch { correlation, .. } => no_match(correlation),
        AlignError::Amplitude { .. } => no_match(0.0),
        AlignError::Constant { .. } | AlignError::NotRecorded(_) => CombineError::ConstantVoltage {
            name: name.clone().into(),
        },
        AlignError::NoOverlap | AlignError::BadGrid => CombineError::NoOverlap {
            name: name.clone().into(),
            reference: against.clone().into(),
        },
    }
}

/// The lags of both halves of a recording that lies at `lag` say how its clock runs.
fn clock_difference(other: &Recording, channel: Channel, grid: Grid, lag: f64) -> Option<f64> {
    let values = other.channel(channel)?;
    let middle = other.len() / 2;
    let most = 20.0 * grid.dt;
    let half = |range: std::ops::Range<usize>| {
        let time: Vec<f64> = other
            .time
            .get(range.clone())?
            .iter()
            .map(|t| t + lag)
            .collect();
        let own = values.get(range)?.to_vec();
        let centre = 0.5 * (time.first()? + time.last()?);
        let part = Recording::new("", time, None, own, None).ok()?;
        let found = auto_align(&part, Channel::ProofMass, 1.0, grid, Some(most)).ok()?;
        Some((centre, found.time_shift))
    };
    let (first, second) = (half(0..middle)?, half(middle..other.len())?);
    let moved = second.1 - first.1;
    let is_clear = moved.abs() > MIN_CLOCK_SAMPLES * grid.dt;
    is_clear.then(|| -moved / (second.0 - first.0))
}

/// How the voltage of `other`, shifted by `lag` \[s\], agrees with that of `reference`; `None` where one
/// has none or nothing overlaps.
pub fn compare_voltages(
    reference: &Recording,
    other: &Recording,
    lag: f64,
) -> Option<VoltageAgreement> {
    let volts = reference.channel(Channel::Voltage)?;
    let instants: Vec<f64> = reference.time.iter().map(|t| t - lag).collect();
    let own = at_instants(other, Channel::Voltage, &instants)?;
    let (low, high) = extremes(volts);
    let edge = EDGE_SHARE * (high - low);
    let is_calm = |values: &[f64], i: usize| {
        let from = i.saturating_sub(2);
        let near = values
            .get(from..(i + 3).min(values.len()))
            .unwrap_or_default();
        let (low, high) = extremes(near);
        high - low <= edge
    };
    let both = |i: &usize| volts[*i].is_finite() && own[*i].is_finite();
    let all: Vec<usize> = (0..volts.len()).filter(both).collect();
    let calm = |i: &&usize| is_calm(volts, **i) && is_calm(&own, **i);
    let calm: Vec<usize> = all.iter().filter(calm).copied().collect();
    // A sine of few samples a period is nowhere calm.
    let used = if calm.len() >= MIN_CALM_SAMPLES && calm.len() * 4 >= all.len() {
        calm
    } else {
        all
    };
    let n = used.len();
    if n < 2 {
        return None;
    }
    let mean = |of: &dyn Fn(usize) -> f64| used.iter().map(|i| of(*i)).sum::<f64>() / n as f64;
    let (a, b) = (mean(&|i| volts[i]), mean(&|i| own[i]));
    let variance = mean(&|i| (volts[i] - a).powi(2));
    let covariance = mean(&|i| (volts[i] - a) * (own[i] - b));
    let rms = mean(&|i| (own[i] - volts[i]).powi(2)).sqrt();
    let scale = if variance > 0.0 {
        covariance / variance
    } else {
        1.0
    };
    let noise = |r: &Recording| r.noise(Channel::Voltage).map_or(0.0, |n| n.sigma);
    let together = noise(reference).hypot(noise(other));
    // Of a constant voltage its size says what a share is.
    let size = variance
        .sqrt()
        .max(0.5 * (high - low))
        .max(if high > low { 0.0 } else { a.abs() });
    Some(VoltageAgreement {
        rms,
        allowed: (MAX_VOLTAGE_SHARE * size).max(MAX_VOLTAGE_NOISE * together),
        samples: n,
        scale,
        offset: b - scale * a,
    })
}

/// The error for voltages that differ.
pub(super) fn differ(
    reference: &Recording,
    other: &Recording,
    found: &VoltageAgreement,
) -> CombineError {
    CombineError::VoltagesDiffer {
        name: other.name.clone().into(),
        reference: reference.name.clone().into(),
        difference: format_quantity(found.rms, "V", 3),
        allowed: format_quantity(found.allowed, "V", 3),
        relation: found.relation(),
    }
}
