//! The cycle under which all samples together are likeliest, and what they leave open of it.

use nalgebra::{DMatrix, DVector};

use super::Cycle;
use super::likelihood::{Law, LevelSamples, Likelihood, levels_of, likelihood};
use super::numbers::{Numbers, STEP};
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{
    CONVERGED_LOG_LIKELIHOOD, FIRST_SOFTNESS, MAX_HARDENINGS, MAX_NEWTON_STEPS, NEWTON_STEP_SHARES,
    NOISE_SHOWN_LOG_LIKELIHOOD,
};

/// A cycle and the spread of its numbers.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// The likeliest.
    pub cycle: Cycle,
    /// Its numbers.
    pub numbers: Numbers,
    /// Their covariance.
    covariance: DMatrix<f64>,
    /// Which are free; the others were given.
    free: Vec<bool>,
}

/// Estimates the numbers of `cycle` that `is_free` allows from samples rounded to steps of `quantum`
/// \[V\], zero for samples with noise alone. `None` if the samples do not determine them.
pub fn estimate(
    samples: &Samples<'_>,
    cycle: &Cycle,
    quantum: f64,
    is_free: impl Fn(&Numbers, usize) -> bool,
) -> Option<Estimate> {
    let span = samples.in_time();
    let numbers = Numbers::of(cycle, 0.5 * (span.first + span.last));
    let free: Vec<bool> = (0..numbers.len()).map(|k| is_free(&numbers, k)).collect();
    let levels = levels_of(samples, cycle, &numbers, quantum);
    let search = Search {
        samples,
        numbers: &numbers,
        levels: &levels,
        free: &free,
    };
    let (cycle, at) = if quantum > 0.0 {
        search.within_cells(cycle, 0.5 * quantum)?
    } else {
        search.likeliest(
            cycle,
            Law::Normal {
                sigma: samples.sigma,
            },
        )?
    };
    let mut covariance = inverse(&held(at.bend, &free))?;
    for (k, _) in free.iter().enumerate().filter(|(_, free)| !**free) {
        covariance[(k, k)] = 0.0;
    }
    Some(Estimate {
        cycle,
        numbers,
        covariance,
        free,
    })
}

/// The matrix with the numbers that are not free taken out.
fn held(mut matrix: DMatrix<f64>, free: &[bool]) -> DMatrix<f64> {
    for (k, _) in free.iter().enumerate().filter(|(_, free)| !**free) {
        matrix.row_mut(k).fill(0.0);
        matrix.column_mut(k).fill(0.0);
        matrix[(k, k)] = 1.0;
    }
    matrix
}

/// Inverse of a matrix of positive numbers in very different units.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n)
        .map(|k| matrix[(k, k)].sqrt())
        .map(|s| if s > 0.0 { s } else { 1.0 })
        .collect();
    let mut scaled = DMatrix::from_fn(n, n, |a, b| matrix[(a, b)] / (scale[a] * scale[b]));
    // A trace of stiffness keeps what is hardly determined finite.
    (0..n).for_each(|k| scaled[(k, k)] += 1e-12);
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(n, n, |a, b| {
        inverse[(a, b)] / (scale[a] * scale[b])
    }))
}

/// What a search for the likeliest cycle needs.
struct Search<'a> {
    samples: &'a Samples<'a>,
    numbers: &'a Numbers,
    levels: &'a [LevelSamples],
    free: &'a [bool],
}

impl Search<'_> {
    fn at(&self, cycle: &Cycle, law: Law) -> Likelihood {
        likelihood(self.samples, cycle, self.numbers, law, self.levels)
    }

    /// Newton's steps from `start` on.
    fn likeliest(&self, start: &Cycle, law: Law) -> Option<(Cycle, Likelihood)> {
        let mut cycle = start.clone();
        let mut at = self.at(&cycle, law);
        for _ in 0..MAX_NEWTON_STEPS {
            let mut slope = at.slope.clone();
            for (k, free) in self.free.iter().enumerate() {
                slope[k] *= f64::from(u8::from(*free));
            }
            let step: DVector<f64> = inverse(&held(at.bend.clone(), self.free))? * slope;
            let better = NEWTON_STEP_SHARES.into_iter().find_map(|share| {
                let change: Vec<f64> = step.iter().map(|s| share * s).collect();
                let moved = self.numbers.moved(&cycle, &change);
                let there = moved.is_ordered().then(|| self.at(&moved, law))?;
                (there.log > at.log).then_some((moved, there))
            });
            let Some((moved, there)) = better else { break };
            let risen = there.log - at.log;
            (cycle, at) = (moved, there);
            if risen < CONVERGED_LOG_LIKELIHOOD {
                break;
            }
        }
        Some((cycle, at))
    }

    /// Under ever smaller noise in front of the digitiser, until the samples show it or the voltage
    /// is known no better.
    fn within_cells(&self, start: &Cycle, half: f64) -> Option<(Cycle, Likelihood)> {
        let law = |soft: f64| Law::Cell { half, soft };
        let mut soft = half / FIRST_SOFTNESS;
        let mut best = self.likeliest(start, law(soft))?;
        let mut sigma = self.sigma_on_slopes(&best.1).unwrap_or(0.0);
        for _ in 0..MAX_HARDENINGS {
            if soft <= sigma {
                break;
            }
            soft *= 0.5;
            let next = self.likeliest(&best.0, law(soft))?;
            let sharper = self.sigma_on_slopes(&next.1).unwrap_or(0.0);
            // Where no sample comes near a wall, harder walls say less.
            if next.1.log < best.1.log - NOISE_SHOWN_LOG_LIKELIHOOD || sharper > sigma {
                break;
            }
            (best, sigma) = (next, sharper);
        }
        Some(best)
    }

    /// Standard deviation of the voltage on sloped lines \[V\]; `None` if there are none.
    fn sigma_on_slopes(&self, at: &Likelihood) -> Option<f64> {
        let covariance = inverse(&held(at.bend.clone(), self.free))?;
        let variance = |entries: &[(usize, f64)]| -> f64 {
            let free = || entries.iter().filter(|e| self.free[e.0]);
            free()
                .flat_map(|&(a, x)| free().map(move |&(b, y)| (a, b, x * y)))
                .map(|(a, b, xy)| xy * covariance[(a, b)])
                .sum()
        };
        let mut sigmas: Vec<f64> = at
            .on_slopes
            .iter()
            .map(|d| variance(d.entries()).max(0.0).sqrt())
            .collect();
        sigmas.sort_by(f64::total_cmp);
        sigmas.get(sigmas.len() / 2).copied()
    }
}

impl Estimate {
    /// Standard deviation of number `k` while all that was given holds; zero if it was given.
    pub fn sigma(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }

    /// Standard deviation of the instant of knot `j` in repetition `turn` \[s\].
    pub fn sigma_at(&self, j: usize, turn: f64) -> f64 {
        let (k, far) = (self.numbers.time(j), turn - self.numbers.turn());
        let c = &self.covariance;
        let variance = c[(k, k)] + 2.0 * far * c[(k, STEP)] + far * far * c[(STEP, STEP)];
        variance.max(0.0).sqrt()
    }

    /// Covariance of the numbers, zero for those given.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Whether number `k` is free.
    pub fn is_free(&self, k: usize) -> bool {
        self.free[k]
    }

    /// Value of number `k`.
    pub fn value(&self, k: usize) -> f64 {
        self.numbers.value(&self.cycle, k)
    }

    /// The same with number `k` given, the others as likely as they are then; unchanged if the knots
    /// would lose their order.
    pub fn given(&self, k: usize, value: f64) -> Self {
        let n = self.numbers.len();
        let change = value - self.value(k);
        let variance = self.covariance[(k, k)];
        let mut all = vec![0.0; n];
        let mut given = self.clone();
        if self.free[k] && variance > 0.0 {
            let own = self.covariance.column(k).clone_owned();
            (0..n).for_each(|a| all[a] = own[a] / variance * change);
            given.covariance -= &own * own.transpose() / variance;
            given.covariance.row_mut(k).fill(0.0);
            given.covariance.column_mut(k).fill(0.0);
        }
        all[k] = change;
        given.cycle = self.numbers.moved(&self.cycle, &all);
        self.numbers.set_voltage(&mut given.cycle, k, value);
        given.free[k] = false;
        if given.cycle.is_ordered() {
            given
        } else {
            self.clone()
        }
    }

    /// Sets the bounds of period and knots at so many standard deviations.
    pub fn set_bounds(&mut self, sigmas: f64) {
        for j in 0..self.cycle.knots.len() {
            let k = self.numbers.time(j);
            if self.free[k] {
                let reach = sigmas * self.sigma(k);
                let knot = &mut self.cycle.knots[j];
                knot.bounds = (knot.time - reach, knot.time + reach);
            }
        }
        if self.free[STEP] {
            let reach = sigmas * self.cycle.factor() * self.sigma(STEP);
            self.cycle.period_bounds = (self.cycle.period - reach, self.cycle.period + reach);
        }
    }
}
