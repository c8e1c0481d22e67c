//! Displacement and velocity of a measured motion, from polynomials of least squares through the
//! samples around (Savitzky and Golay), never across an event at the ground.

use std::ops::Range;

use nalgebra::{SMatrix, SVector};

use crate::sim::Points;

/// Coefficients of the polynomials: of degree 4.
const COEFFICIENTS: usize = 5;
/// Fewest samples on either side.
const MIN_HALF_WINDOW: usize = 2;

/// The motion at each of the increasing `nodes` \[s\] from `readings` \[m\] of the proof mass and, if
/// read, of the cantilever, each over `smoothing` \[s\] on either side. `flights` are the runs of
/// samples without events, in order.
pub fn smooth_motion(
    time: &[f64],
    readings: &[Vec<f64>],
    flights: &[Range<usize>],
    smoothing: f64,
    nodes: &[f64],
) -> Vec<Points> {
    // What lies between flights is a run of its own.
    let mut runs: Vec<Range<usize>> = Vec::new();
    let mut begin = 0;
    for flight in flights {
        if begin < flight.start {
            runs.push(begin..flight.start);
        }
        runs.push(flight.clone());
        begin = flight.end;
    }
    if begin < time.len() {
        runs.push(begin..time.len());
    }
    let mut run = 0;
    let mut out = Vec::with_capacity(nodes.len());
    for &t in nodes {
        while run + 1 < runs.len() && time[runs[run + 1].start] <= t {
            run += 1;
        }
        let own = runs.get(run).cloned().unwrap_or(0..time.len());
        let at = |channel: usize| {
            let values = readings.get(channel);
            values.map_or((0.0, 0.0), |v| value_and_slope(time, v, &own, smoothing, t))
        };
        let ((xp, vp), (xc, vc)) = (at(0), at(1));
        out.push(Points { xp, vp, xc, vc });
    }
    out
}

/// Value and slope at `t` of the polynomial through the samples of `run` within `smoothing` of it.
fn value_and_slope(
    time: &[f64],
    values: &[f64],
    run: &Range<usize>,
    smoothing: f64,
    t: f64,
) -> (f64, f64) {
    let own = &time[run.clone()];
    let middle = run.start + own.partition_point(|s| *s < t);
    let mut first = run.start + own.partition_point(|s| *s < t - smoothing);
    let mut end = run.start + own.partition_point(|s| *s <= t + smoothing);
    first = first
        .min(middle.saturating_sub(MIN_HALF_WINDOW))
        .max(run.start);
    end = end.max(middle + MIN_HALF_WINDOW + 1).min(run.end);
    // Near an end the window reaches farther into the run.
    let least = (2 * MIN_HALF_WINDOW + 1).min(run.len());
    if end - first < least {
        if first == run.start {
            end = first + least;
        } else {
            first = end - least;
        }
    }
    let scale = (time[end - 1] - t).abs().max((t - time[first]).abs());
    let known = (first..end).filter(|&i| values[i].is_finite());
    let count = known.clone().count();
    let terms = COEFFICIENTS.min(count);
    if terms == 0 || scale <= 0.0 {
        return (values.get(middle.min(end - 1)).copied().unwrap_or(0.0), 0.0);
    }
    let mut gram = SMatrix::<f64, COEFFICIENTS, COEFFICIENTS>::zeros();
    let mut slope = SVector::<f64, COEFFICIENTS>::zeros();
    let origin = known.clone().next().map_or(0.0, |i| values[i]);
    for i in known {
        let s = (time[i] - t) / scale;
        let mut powers = SVector::<f64, COEFFICIENTS>::zeros();
        let mut power = 1.0;
        for p in powers.iter_mut().take(terms) {
            *p = power;
            power *= s;
        }
        gram += powers * powers.transpose();
        slope += powers * (values[i] - origin);
    }
    for k in terms..COEFFICIENTS {
        gram[(k, k)] = 1.0;
    }
    match gram.cholesky() {
        Some(root) => {
            let c = root.solve(&slope);
            (origin + c[0], c[1] / scale)
        }
        None => (origin, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::super::local_polynomial::*;

    #[test]
    fn a_quartic_is_met_and_an_impact_is_not_crossed() {
        let time: Vec<f64> = (0..60)
            .map(|i| 0.1 * f64::from(i) + 0.01 * f64::from(i % 3))
            .collect();
        let hit = time[30];
        let law = |t: f64| {
            if t < hit {
                (
                    1.0 - t + 0.3 * t * t - 0.02 * t.powi(4),
                    -1.0 + 0.6 * t - 0.08 * t.powi(3),
                )
            } else {
                (5.0 + 2.0 * (t - hit), 2.0)
            }
        };
        let readings = vec![time.iter().map(|t| law(*t).0).collect::<Vec<_>>()];
        let nodes: Vec<f64> = (1..110).map(|i| 0.053 * f64::from(i)).collect();
        let motion = smooth_motion(&time, &readings, &[0..30, 30..60], 0.5, &nodes);
        for (t, at) in nodes.iter().zip(motion) {
            if *t > time[29] && *t < hit {
                continue;
            }
            let (x, v) = law(*t);
            assert!((at.xp - x).abs() < 1e-8, "{t}: {at:?} {x}");
            assert!((at.vp - v).abs() < 1e-6, "{t}: {at:?} {v}");
            assert_eq!((at.xc, at.vc), (0.0, 0.0));
        }
    }
}
