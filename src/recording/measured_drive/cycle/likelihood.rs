//! How likely the samples are under a cycle, and how that changes with its numbers.
//!
//! A sample with noise is normal around the voltage. A sample of a coarse digitiser says only that
//! the voltage was in its cell: its likelihood is the probability of the cell. A ramp's crossings of
//! the cells' walls are then known to a sampling interval each, and all together far better.

use nalgebra::{DMatrix, DVector};

use super::numbers::Dependence;
use super::open_numbers::Numbers;
use super::waveform::Cycle;
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CLOCK_INTERVALS, MAX_FIT_SAMPLES, MAX_PICKED_ON_SLOPES,
};

/// How a sample comes about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Normal noise of standard deviation `sigma` \[V\].
    Normal { sigma: f64 },
    /// The voltage with logistic noise of scale `soft` \[V\], rounded to cells of half the width
    /// `half` \[V\].
    Cell { half: f64, soft: f64 },
}

/// Logarithm of a probability, its derivative by the voltage and the negative of the second.
#[derive(Debug, Clone, Copy)]
struct Term {
    log: f64,
    slope: f64,
    bend: f64,
}

/// `ln(1 + e^x)`.
fn softplus(x: f64) -> f64 {
    x.max(0.0) + (-x.abs()).exp().ln_1p()
}

/// `1 / (1 + e^-x)`.
fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

impl Law {
    /// Of a sample `off` \[V\] above the voltage.
    fn term(self, off: f64) -> Term {
        match self {
            Law::Normal { sigma } => {
                let z = off / sigma;
                Term {
                    log: -0.5 * z * z,
                    slope: z / sigma,
                    bend: sigma.powi(-2),
                }
            }
            Law::Cell { half, soft } => {
                let (up, down) = ((half + off) / soft, (off - half) / soft);
                let (above, below) = (logistic(-up), logistic(down));
                Term {
                    log: (-(-2.0 * half / soft).exp()).ln_1p() - softplus(-up) - softplus(down),
                    slope: (below - above) / soft,
                    bend: (above * (1.0 - above) + below * (1.0 - below)) / (soft * soft),
                }
            }
        }
    }
}

/// A level, known beforehand from its own samples: however many there are, rounding has moved them
/// all alike.
#[derive(Debug, Clone, Copy)]
pub struct LevelSamples {
    /// Of the level's voltage.
    dependence: Dependence,
    /// Mean of its samples \[V\].
    mean: f64,
    /// Standard deviation of rounding \[V\].
    sigma: f64,
}

/// Logarithm of the probability of all samples and levels, with its derivatives.
#[derive(Debug, Clone)]
pub struct Likelihood {
    /// Logarithm.
    pub log: f64,
    /// Its derivatives by the numbers.
    pub slope: DVector<f64>,
    /// The negative of the second derivatives.
    pub bend: DMatrix<f64>,
    /// Voltages halfway up or down sloped lines, a few picked: where the law of samples must be as
    /// fine as the voltage is known.
    pub on_slopes: Vec<Dependence>,
}

/// Calls `of` for the samples that lie clearly on a line: sample, number of the knot before, and the
/// two knots' numbers' dependence.
fn for_samples(
    samples: &Samples<'_>,
    cycle: &Cycle,
    numbers: &Numbers,
    mut of: impl FnMut(usize, i64, Dependence),
) {
    let fuzz = CLOCK_INTERVALS * samples.interval;
    let mut k = cycle.knot_before(samples.time[0]);
    let (mut a, mut b) = (cycle.knot(k), cycle.knot(k + 1));
    for i in samples.thinned(MAX_FIT_SAMPLES) {
        let t = samples.time[i];
        while b.time <= t {
            k += 1;
            (a, b) = (b, cycle.knot(k + 1));
        }
        if a.jumps() && t - a.time <= fuzz || b.jumps() && b.time - t <= fuzz {
            continue;
        }
        of(i, k, numbers.dependence(k, &a, &b, t));
    }
}

/// What the levels' own samples say, where they are rounded to steps of `quantum` \[V\].
pub fn levels_of(
    samples: &Samples<'_>,
    cycle: &Cycle,
    numbers: &Numbers,
    quantum: f64,
) -> Vec<LevelSamples> {
    if quantum <= 0.0 {
        return Vec::new();
    }
    let lines = cycle.knots.len() as i64 * if cycle.mirrored { 2 } else { 1 };
    let mut sums: Vec<Option<(Dependence, f64, f64)>> = vec![None; lines as usize];
    for_samples(samples, cycle, numbers, |i, k, dependence| {
        let line = k.rem_euclid(lines);
        if cycle.knot(line).after == cycle.knot(line + 1).before {
            let sum = sums[line as usize].get_or_insert((dependence, 0.0, 0.0));
            (sum.1, sum.2) = (sum.1 + samples.volts[i], sum.2 + 1.0);
        }
    });
    let level = |(dependence, sum, count): (Dependence, f64, f64)| LevelSamples {
        dependence,
        mean: sum / count,
        sigma: quantum / 12f64.sqrt(),
    };
    sums.into_iter().flatten().map(level).collect()
}

/// The likelihood of `samples` and `levels` under `cycle`.
pub fn likelihood(
    samples: &Samples<'_>,
    cycle: &Cycle,
    numbers: &Numbers,
    law: Law,
    levels: &[LevelSamples],
) -> Likelihood {
    let n = numbers.len();
    let mut all = Likelihood {
        log: 0.0,
        slope: DVector::zeros(n),
        bend: DMatrix::zeros(n, n),
        on_slopes: Vec::new(),
    };
    let stride = samples
        .len()
        .min(MAX_FIT_SAMPLES)
        .div_ceil(MAX_PICKED_ON_SLOPES);
    let mut count = 0;
    for_samples(samples, cycle, numbers, |i, _, dependence| {
        all.add(law.term(samples.volts[i] - dependence.voltage), &dependence);
        count += 1;
        // Levels hang on no instant.
        if count % stride == 0
            && dependence
                .entries()
                .iter()
                .any(|e| e.0 == super::open_numbers::STEP)
        {
            all.on_slopes.push(dependence);
        }
    });
    for level in levels {
        // Of a level the voltage is linear in the numbers.
        let voltage: f64 = level
            .dependence
            .entries()
            .iter()
            .map(|&(k, d)| d * numbers.value(cycle, k))
            .sum();
        let law = Law::Normal { sigma: level.sigma };
        all.add(law.term(level.mean - voltage), &level.dependence);
    }
    all
}

impl Likelihood {
    fn add(&mut self, term: Term, dependence: &Dependence) {
        self.log += term.log;
        for &(a, x) in dependence.entries() {
            self.slope[a] += term.slope * x;
            for &(b, y) in dependence.entries() {
                self.bend[(a, b)] += term.bend * x * y;
            }
        }
    }
}
