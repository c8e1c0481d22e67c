//! Windows of flight, each a test function with its quadrature: integrals of what was measured at
//! the samples, with jumps of the drive placed exactly.

use std::ops::Range;

use super::measured_run::MeasuredRun;
use super::test_function::{bump, bump_after};

/// Least half width of a test function \[samples\]: fewer samples do not integrate it.
const MIN_HALF_WIDTH_SAMPLES: f64 = 6.0;
/// Half width of a test function, in radians of the slowest mode. Narrower ones see more noise than
/// motion, and noise in a column lowers its coefficient.
const HALF_WIDTH_PHASE: f64 = 2.9;
/// Distance of neighbouring test functions as a share of their half width: together they see all
/// that is slower than one of them alone.
const WINDOW_HOP_SHARE: f64 = 0.3;
/// Largest distance of samples within a window, in usual ones: beyond is a gap.
const MAX_STEP_INTERVALS: f64 = 2.5;

/// One test function over the samples of a flight.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Its centre \[s\].
    pub centre: f64,
    /// Its half width \[s\].
    pub half_width: f64,
    /// Its samples.
    pub samples: Range<usize>,
    /// Weights of the samples for the integrals of a quantity times the test function and times its
    /// first and second derivative.
    pub weights: [Vec<f64>; 3],
    /// The nodes of its thinned samples, as positions among these, and the same weights for them.
    pub nodes: Range<usize>,
    /// See `nodes`.
    pub node_weights: [Vec<f64>; 3],
    /// Jumps of the drive in it: which, and by how much the sums of the weights per height of a jump
    /// fall short of the integrals.
    pub jumps: Vec<(usize, [f64; 3])>,
    /// Weight of its row, 0 to 1: little where an event was overlooked.
    pub trust: f64,
}

/// The windows of one flight.
pub type FlightWindows = Vec<Window>;

/// Half width of the test functions for readings every `interval` \[s\] of a device whose slowest
/// mode has the angular frequency `slowest` \[1/s\], or that has none and flies for `flight` \[s\].
pub fn half_width(interval: f64, slowest: Option<f64>, flight: f64) -> f64 {
    /// Share of a flight without a spring that a test function may cover on either side.
    const FREE_FLIGHT_SHARE: f64 = 0.1;
    let wanted = slowest.map_or(FREE_FLIGHT_SHARE * flight, |w| HALF_WIDTH_PHASE / w);
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
    let samples = inside(flight.clone(), |i| run.time[i], centre, w);
    let of_flight = run.thinned.partition_point(|i| *i < flight.start)
        ..run.thinned.partition_point(|i| *i < flight.end);
    let thinned = |k: usize| run.time[run.thinned[k]];
    let nodes = inside(of_flight.clone(), thinned, centre, w);
    let weights = quadrature(&samples, flight, |i| run.time[i], (centre, w));
    let node_weights = quadrature(&nodes, &of_flight, thinned, (centre, w));
    let edges = run.edges.iter().enumerate();
    let own = edges.filter(|(_, e)| (e.time - centre).abs() < w);
    let jumps = own.map(|(k, e)| {
        // The sums over nodes see the jump at the first one after it.
        let [value, slope, _] = bump(e.time - centre, w);
        let after = [bump_after(e.time - centre, w), -value, -slope];
        let first = nodes.clone().take_while(|k| thinned(*k) < e.time).count();
        let seen = |order: usize| -> f64 { node_weights[order][first..].iter().sum() };
        (k, std::array::from_fn(|order| after[order] - seen(order)))
    });
    let jumps: Vec<(usize, [f64; 3])> = jumps.collect();
    Window {
        centre,
        half_width: w,
        samples,
        nodes,
        node_weights,
        jumps,
        weights,
        trust: 1.0,
    }
}

/// Those of `all` whose times lie within `w` of `centre`.
fn inside(all: Range<usize>, time: impl Fn(usize) -> f64, centre: f64, w: f64) -> Range<usize> {
    let first = all.clone().take_while(|i| time(*i) <= centre - w).count();
    let before_end = all.clone().take_while(|i| time(*i) < centre + w).count();
    all.start + first..all.start + before_end
}

/// Weights of the trapezoidal rule at `points` of `all` for the test function and its derivatives.
fn quadrature(
    points: &Range<usize>,
    all: &Range<usize>,
    time: impl Fn(usize) -> f64,
    (centre, w): (f64, f64),
) -> [Vec<f64>; 3] {
    let mut weights: [Vec<f64>; 3] = Default::default();
    for i in points.clone() {
        let before = if i > all.start { time(i - 1) } else { time(i) };
        let after = if i + 1 < all.end {
            time(i + 1)
        } else {
            time(i)
        };
        let step = 0.5 * (after - before);
        for (of_order, value) in weights.iter_mut().zip(bump(time(i) - centre, w)) {
            of_order.push(step * value);
        }
    }
    weights
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
    /// `run`, with its jumps.
    pub fn of_nodes(&self, order: usize, run: &MeasuredRun, values: &[f64]) -> f64 {
        let nodes = &run.thinned_nodes[self.nodes.clone()];
        let weights = self.node_weights[order].iter();
        let mut sum: f64 = weights.zip(nodes).map(|(w, &n)| w * values[n]).sum();
        for (edge, short) in &self.jumps {
            sum += short[order] * run.jump(*edge, values);
        }
        sum
    }
}
