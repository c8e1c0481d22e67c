//! What is left of a recording when a simulation is taken away.

use thiserror::Error;

use super::align::Alignment;
use super::grid::Grid;
use super::{Channel, Recording};

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
    /// Recording (aligned) minus simulation at sample `first + i` of the recording, up
    /// to the end of the simulated span, in the unit of the channel; NaN where either
    /// has no value.
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

/// Compares a channel with a simulated trace, at the recording's own samples; the
/// simulation is interpolated as [`Grid::value_at`] does. Costs the samples on the
/// simulated span, however long the recording is.
///
/// # Errors
/// [`CompareError`] if the channel was not recorded or nothing overlaps.
pub fn compare(
    recording: &Recording,
    channel: Channel,
    alignment: &Alignment,
    simulated: Grid,
) -> Result<Comparison, CompareError> {
    let values = recording
        .channel(channel)
        .ok_or(CompareError::NotRecorded(channel.symbol()))?;
    if simulated.values.is_empty() || simulated.dt.is_nan() || simulated.dt <= 0.0 {
        return Err(CompareError::BadGrid);
    }
    let slack = 1e-6 * simulated.dt;
    let (from, to) = (simulated.t0 - slack, simulated.end() + slack);
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
    let residual: Vec<f64> = recording.time[inside.clone()]
        .iter()
        .zip(&values[inside.clone()])
        .map(|(&t, &raw)| {
            let t = alignment.time(t);
            let measured = alignment.value(channel, raw);
            let Some(value) = simulated.value_at(t).filter(|_| measured.is_finite()) else {
                missing += 1;
                return f64::NAN;
            };
            let r = measured - value;
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
            sim_from: simulated.t0,
            sim_to: simulated.end(),
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

    #[test]
    fn residual_at_the_recordings_samples() {
        let time = vec![-1.0, 0.0, 0.25, 0.5, 1.0, 3.0];
        let x = vec![9.0, 1.0, f64::NAN, 2.5, 3.0, 9.0];
        let recording = Recording::new("r", time, None, x, None).unwrap();
        let simulated = Grid {
            t0: 0.0,
            dt: 1.0,
            values: &[0.0, 2.0, 4.0],
            slopes: None,
        };
        let c = compare(
            &recording,
            Channel::ProofMass,
            &Alignment::default(),
            simulated,
        )
        .unwrap();
        assert_eq!((c.count, c.missing, c.outside), (3, 1, 2));
        assert_eq!((c.first, c.residual.len()), (1, 4));
        let left: Vec<f64> = c
            .residual
            .iter()
            .copied()
            .filter(|r| r.is_finite())
            .collect();
        assert_eq!(left, [1.0, 1.5, 1.0]);
        let rms = ((1.0 + 2.25 + 1.0) / 3.0f64).sqrt();
        assert!((c.rms - rms).abs() < 1e-12);
        assert!((c.nrmse_percent.unwrap() - 100.0 * rms / 2.0).abs() < 1e-9);
        // The alignment is applied before the comparison.
        let shifted = Alignment {
            time_shift: 1.0,
            xp_offset: 1.0,
            ..Alignment::default()
        };
        let c = compare(&recording, Channel::ProofMass, &shifted, simulated).unwrap();
        assert_eq!(c.residual[1], 1.0 + 1.0 - 2.0);
    }

    #[test]
    fn nothing_to_compare_is_an_error() {
        let recording = Recording::new("r", vec![0.0, 1.0], None, vec![0.0, 1.0], None).unwrap();
        let grid = Grid {
            t0: 5.0,
            dt: 1.0,
            values: &[0.0, 1.0],
            slopes: None,
        };
        let none = Alignment::default();
        assert!(matches!(
            compare(&recording, Channel::ProofMass, &none, grid),
            Err(CompareError::NoOverlap { .. })
        ));
        assert!(matches!(
            compare(&recording, Channel::Voltage, &none, grid),
            Err(CompareError::NotRecorded("V"))
        ));
        let empty = Grid {
            t0: 0.0,
            dt: 1.0,
            values: &[],
            slopes: None,
        };
        assert!(matches!(
            compare(&recording, Channel::ProofMass, &none, empty),
            Err(CompareError::BadGrid)
        ));
    }
}
