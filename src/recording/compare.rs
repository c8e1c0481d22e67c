//! What is left of a recording when a simulation is taken away.

use thiserror::Error;

use super::align::Alignment;
use super::{Channel, Recording};
use crate::sim::{Reading, Trace, TraceCursor};

/// Why there is nothing to compare.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CompareError {
    /// The channel was not recorded.
    #[error("channel {0} was not recorded")]
    NotRecorded(&'static str),
    /// No sample falls on the simulated span.
    #[error(
        "the recording ({from:.6} to {to:.6} s with its shift) and the simulation ({sim_from:.6} to {sim_to:.6} s) do not overlap; shift the recording, or simulate longer"
    )]
    NoOverlap {
        /// First shifted time of the recording \[s\].
        from: f64,
        /// Last shifted time of the recording \[s\].
        to: f64,
        /// First simulated time \[s\].
        sim_from: f64,
        /// Last simulated time \[s\].
        sim_to: f64,
    },
    /// The simulated grid is empty or its interval is not positive.
    #[error("the simulated trace is empty or has no positive interval; simulate first")]
    BadGrid,
}

/// Residual of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The first sample of the recording that lies on the simulated span.
    pub first: usize,
    /// Simulation minus recording (aligned) at sample `first + i` of the recording, up to the end
    /// of the simulated span, in the unit of the channel; NaN where either has no value.
    pub residual: Vec<f64>,
    /// Root mean square of the residual, in the unit of the channel.
    pub rms: f64,
    /// `rms` in percent of the range (highest minus lowest) of the aligned recording
    /// over the compared samples; `None` if that range is zero.
    pub nrmse_percent: Option<f64>,
    /// Mean of the residual: what an offset alone would take away.
    pub mean: f64,
    /// Number of samples compared.
    pub count: usize,
    /// Samples not compared because the recording or the simulation has no number there.
    pub missing: usize,
    /// Samples not compared because they lie before or after the simulation.
    pub outside: usize,
}

/// Compares a reading with a simulated run, at the recording's own samples; between its samples
/// the run is read as [`TraceCursor`] does. Costs the samples on the simulated span, however long
/// the recording is.
///
/// # Errors
/// [`CompareError`] if the channel is no reading or was not recorded, or nothing overlaps.
pub fn compare(
    recording: &Recording,
    channel: Channel,
    alignment: &Alignment,
    trace: &Trace,
) -> Result<Comparison, CompareError> {
    let reading: fn(&Reading) -> f64 = match channel {
        Channel::ProofMass => |r| r.xp,
        Channel::Cantilever => |r| r.xc,
        Channel::Voltage => return Err(CompareError::NotRecorded(channel.symbol())),
    };
    let values = recording
        .channel(channel)
        .ok_or(CompareError::NotRecorded(channel.symbol()))?;
    if trace.is_empty() || trace.dt.is_nan() || trace.dt <= 0.0 {
        return Err(CompareError::BadGrid);
    }
    let slack = 1e-6 * trace.dt;
    let (from, to) = (trace.t0 - slack, trace.end() + slack);
    // Recorded times increase.
    let start = recording
        .time
        .partition_point(|&t| alignment.time(t) < from);
    let end = recording.time.partition_point(|&t| alignment.time(t) <= to);
    let inside = start..end.max(start);
    let outside = recording.len() - inside.len();
    let mut missing = 0;
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0usize);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut cursor = TraceCursor::new(trace);
    let residual: Vec<f64> = recording.time[inside.clone()]
        .iter()
        .zip(&values[inside.clone()])
        .map(|(&t, &raw)| {
            let measured = alignment.value(channel, raw);
            let simulated = cursor
                .at(alignment.time(t))
                .map_or(f64::NAN, |r| reading(&r));
            let r = simulated - measured;
            if !r.is_finite() {
                missing += 1;
                return f64::NAN;
            }
            sum += r;
            squares += r * r;
            count += 1;
            low = low.min(measured);
            high = high.max(measured);
            r
        })
        .collect();
    if count == 0 {
        let (first, last) = recording.span();
        return Err(CompareError::NoOverlap {
            from: alignment.time(first),
            to: alignment.time(last),
            sim_from: trace.t0,
            sim_to: trace.end(),
        });
    }
    let rms = (squares / count as f64).sqrt();
    let range = high - low;
    Ok(Comparison {
        first: inside.start,
        residual,
        rms,
        nrmse_percent: (range > 0.0).then(|| 100.0 * rms / range),
        mean: sum / count as f64,
        count,
        missing,
        outside,
    })
}

#[cfg(test)]
mod tests {
    use super::super::compare::*;

    /// A run that rises evenly: 0, 2, 4 m at 0, 1, 2 s from `t0`.
    fn rising(t0: f64) -> Trace {
        Trace {
            t0,
            dt: 1.0,
            proof_mass: vec![0.0, 2.0, 4.0],
            proof_mass_velocity: vec![2.0; 3],
            ..Trace::default()
        }
    }

    #[test]
    fn residual_at_the_recordings_samples() {
        let time = vec![-1.0, 0.0, 0.25, 0.5, 1.0, 3.0];
        let x = vec![9.0, 1.0, f64::NAN, 2.5, 3.0, 9.0];
        let recording = Recording::new("r", time, None, x, None).unwrap();
        let trace = rising(0.0);
        let of = |alignment: &Alignment| {
            compare(&recording, Channel::ProofMass, alignment, &trace).unwrap()
        };
        let c = of(&Alignment::default());
        assert_eq!((c.count, c.missing, c.outside), (3, 1, 2));
        assert_eq!((c.first, c.residual.len()), (1, 4));
        let left: Vec<f64> = c
            .residual
            .iter()
            .copied()
            .filter(|r| r.is_finite())
            .collect();
        assert_eq!(left, [-1.0, -1.5, -1.0]);
        let rms = ((1.0 + 2.25 + 1.0) / 3.0f64).sqrt();
        assert!((c.rms - rms).abs() < 1e-12);
        assert!((c.nrmse_percent.unwrap() - 100.0 * rms / 2.0).abs() < 1e-9);
        // The alignment is applied before the comparison.
        let c = of(&Alignment {
            time_shift: 1.0,
            xp_offset: 1.0,
            ..Alignment::default()
        });
        assert_eq!(c.residual[1], 2.0 - (1.0 + 1.0));
    }

    #[test]
    fn nothing_to_compare_is_an_error() {
        let recording = Recording::new("r", vec![0.0, 1.0], None, vec![0.0, 1.0], None).unwrap();
        let none = Alignment::default();
        let of = |channel, trace: &Trace| compare(&recording, channel, &none, trace);
        assert!(matches!(
            of(Channel::ProofMass, &rising(5.0)),
            Err(CompareError::NoOverlap { .. })
        ));
        for channel in [Channel::Voltage, Channel::Cantilever] {
            assert!(matches!(
                of(channel, &rising(5.0)),
                Err(CompareError::NotRecorded(_))
            ));
        }
        assert!(matches!(
            of(Channel::ProofMass, &Trace::default()),
            Err(CompareError::BadGrid)
        ));
    }
}
