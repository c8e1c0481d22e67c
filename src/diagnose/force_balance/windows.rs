//! Windows of flight, each a test function with its quadrature: integrals of what was measured at
//! the samples, with jumps of the drive placed exactly.

use std::ops::Range;

use super::measured_run::MeasuredRun;
use super::test_function::{bump, bump_after};

/// Least half width of a test function \[samples\]: fewer samples do not integrate it.
const MIN_HALF_WIDTH_SAMPLES: f64 = 6.0;
/// Half width of a test function, in radians of the fastest mode: it then sees that mode.
const HALF_WIDTH_PHASE: f64 = 3.5;
/// Distance of neighbouring test functions as a share of their half width: together they see all
/// that is slower than one of them alone.
const WINDOW_HOP_SHARE: f64 = 0.4;
/// Largest distance of samples within a window, in usual ones: beyond is a gap.
const MAX_STEP_INTERVALS: f64 = 2.5;

/// One test function over the samples of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Its centre \[s\].
    pub centre: f64,
    /// Its samples.
    pub samples: Range<usize>,
    /// Weights of the samples for the integrals of a quantity times the test function and times its
    /// first and second derivative.
    pub weights: [Vec<f64>; 3],
    /// Jumps of the drive in it: which, and the correction of the integral per height of a jump.
    pub jumps: Vec<(usize, f64)>,
}

/// The windows of one flight.
pub type FlightWindows = Vec<Window>;

/// Half width of the test functions for readings every `interval` \[s\] of a device whose fastest
/// mode has the angular frequency `fastest` \[1/s\], or that has none and flies for `flight` \[s\].
pub fn half_width(interval: f64, fastest: Option<f64>, flight: f64) -> f64 {
    /// Share of a flight without a spring that a test function may cover on either side.
    const FREE_FLIGHT_SHARE: f64 = 0.1;
    let wanted = fastest.map_or(FREE_FLIGHT_SHARE * flight, |w| HALF_WIDTH_PHASE / w);
    wanted.max(MIN_HALF_WIDTH_SAMPLES * interval)
}

/// The windows of half width `w` \[s\] of each flight of `run`.
pub fn windows(run: &MeasuredRun, w: f64) -> Vec<FlightWindows> {
    let flights = run.flights.iter();
    flights
        .map(|flight| windows_of_flight(run, flight, w))
        .collect()
}

fn windows_of_flight(run: &MeasuredRun, flight: &Range<usize>, w: f64) -> FlightWindows {
    let time = &run.time;
    let (begin, end) = (time[flight.start], time[flight.end - 1]);
    let room = end - begin - 2.0 * w;
    if room < 0.0 {
        return Vec::new();
    }
    let count = (room / (WINDOW_HOP_SHARE * w)).floor() as usize + 1;
    // Spread evenly, so that both ends of the flight are reached.
    let hop = if count > 1 {
        room / (count - 1) as f64
    } else {
        0.0
    };
    let usual = (end - begin) / (flight.len() - 1) as f64;
    let all = (0..count).map(|k| {
        let centre = begin + w + k as f64 * hop;
        window(run, flight, centre, w)
    });
    all.filter(|window| {
        let steps = time[window.samples.clone()].windows(2);
        window.samples.len() as f64 >= MIN_HALF_WIDTH_SAMPLES
            && steps.fold(0.0f64, |most, p| most.max(p[1] - p[0])) < MAX_STEP_INTERVALS * usual
    })
    .collect()
}

fn window(run: &MeasuredRun, flight: &Range<usize>, centre: f64, w: f64) -> Window {
    let time = &run.time;
    let own = &time[flight.clone()];
    let first = flight.start + own.partition_point(|t| *t <= centre - w);
    let end = flight.start + own.partition_point(|t| *t < centre + w);
    let mut weights: [Vec<f64>; 3] = Default::default();
    for i in first..end {
        let before = if i > 0 { time[i - 1] } else { time[i] };
        let after = time.get(i + 1).copied().unwrap_or(time[i]);
        let step = 0.5 * (after - before);
        for (all, value) in weights.iter_mut().zip(bump(time[i] - centre, w)) {
            all.push(step * value);
        }
    }
    let inside = |t: f64| (t - centre).abs() < w;
    let jumps = run.edges.iter().enumerate();
    let jumps = jumps.filter(|(_, e)| inside(e.time)).map(|(k, e)| {
        // The sum over samples sees the jump at the first one after it.
        let seen: f64 = (e.sample.max(first)..end)
            .map(|i| weights[0][i - first])
            .sum();
        (k, bump_after(e.time - centre, w) - seen)
    });
    Window {
        centre,
        samples: first..end,
        jumps: jumps.collect(),
        weights,
    }
}

impl Window {
    /// Integral of `order` derivatives of the test function times a reading, given at the samples.
    pub fn of_reading(&self, order: usize, values: &[f64]) -> f64 {
        let own = &values[self.samples.clone()];
        self.weights[order]
            .iter()
            .zip(own)
            .map(|(w, x)| w * x)
            .sum()
    }

    /// Integral of `order` derivatives of the test function times a quantity, given at the nodes of
    /// `run`. Jumps are placed exactly for the test function itself.
    pub fn of_nodes(&self, order: usize, run: &MeasuredRun, values: &[f64]) -> f64 {
        let nodes = &run.sample_nodes[self.samples.clone()];
        let weights = self.weights[order].iter();
        let mut sum: f64 = weights.zip(nodes).map(|(w, &n)| w * values[n]).sum();
        if order == 0 {
            for &(edge, correction) in &self.jumps {
                let before = run.edges[edge].before;
                sum += correction * (values[before + 1] - values[before]);
            }
        }
        sum
    }
}
