//! How noisy a channel is, from its own highest frequencies.
//!
//! A difference of order `p` multiplies white noise by `sqrt(C(2p, p))` and a motion
//! of frequency `f`, sampled at `fs`, by `(2 sin(pi f / fs))^p`. At order 12 the
//! 6.4 kHz ring of the device, sampled at 50 kHz, is thirty thousand times weaker
//! against noise than it was. Steps and impacts spoil `p + 1` differences each; short
//! windows keep that damage apart, and medians ignore what is left of it.
//!
//! The noise is taken to be white up to half the sampling rate. Behind a low-pass
//! filter the estimate is too small; [`NoiseEstimate::white`] says so.

use thiserror::Error;

use super::grid::TimeAxis;
use super::statistics::{extremes, median_in_place, quantile_in_place};

/// Orders of differences that are tried, highest first; a short record cannot afford a high one.
const DIFFERENCE_ORDERS: [usize; 5] = [12, 8, 6, 4, 3];
/// Differences in a window.
const WINDOW_DIFFERENCES: usize = 64;
/// Windows rougher than this times the quiet ones contain an impact and are not used.
const MAX_ROUGHNESS: f64 = 2.0;
/// Median of the absolute value of a unit normal variable.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Gaps between levels from which the step is made where it is none of them.
const MAX_COMMON_GAPS: usize = 500;
/// Samples of a block whose scatter tells rounding from noise: so short that a parabola follows the
/// signal.
const SCATTER_BLOCK: usize = 11;
/// Rounding of the numbers themselves and least step, as shares of the largest value: of numbers with
/// seven digits, and of longer ones.
const COMMON_STEPS: [(f64, f64); 2] = [(1e-7, 1e-5), (1e-10, 1e-7)];
/// Samples whose levels are sorted in search of a lattice.
const MAX_LATTICE_LEVELS: usize = 50_000;
/// Steps of one size from which a slow signal on a lattice is told from a few levels.
const MIN_STAIRCASE_STEPS: usize = 40;
/// Steps of the lattice over which such a signal must go.
const MIN_STAIRCASE_LEVELS: f64 = 8.0;
/// Windows looked at in a very long record, evenly picked.
const MOST_WINDOWS: usize = 20_000;

/// Why there is no estimate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum NoiseError {
    /// The channel was not recorded.
    #[error("channel {0} was not recorded")]
    NotRecorded(&'static str),
    /// Too few consecutive samples.
    #[error(
        "{found} consecutive samples are too few to tell noise from motion; {needed} are needed"
    )]
    TooShort {
        /// Longest run of consecutive samples.
        found: usize,
        /// Samples needed.
        needed: usize,
    },
}

/// Noise of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseEstimate {
    /// Standard deviation, in the unit of the channel. Where the channel is
    /// quantised more coarsely than it is noisy, at least the step over `sqrt(12)`.
    pub sigma: f64,
    /// Order of the differences used.
    pub order: usize,
    /// Step of the lattice on which all values lie, if they do.
    pub step: Option<f64>,
    /// Whether that step is the larger part of the noise: it is then not normally
    /// distributed, and neighbouring errors may be equal.
    pub quantised: bool,
    /// Whether half the order gives the same noise within a third. If not, motion
    /// reaches to the highest frequencies or a filter has removed the noise there.
    pub white: bool,
}

/// Noise of evenly or nearly evenly sampled `values`; missing samples (NaN) and gaps
/// in time are stepped over.
///
/// # Errors
/// [`NoiseError::TooShort`] below 15 consecutive samples.
///
/// # Examples
/// ```
/// use impactscope::recording::TimeAxis;
/// use impactscope::recording::noise::estimate_noise;
///
/// // A slow sine, and 10 nm of alternating error on it.
/// let time = TimeAxis::Uniform { t0: 0.0, dt: 2e-5 };
/// let values: Vec<f64> = (0..2000)
///     .map(|i| 1e-6 * (0.001 * f64::from(i)).sin() + if i % 2 == 0 { 1e-8 } else { -1e-8 })
///     .collect();
/// let noise = estimate_noise(time, &values)?;
/// assert!(noise.sigma > 1e-9 && noise.sigma < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn estimate_noise(time: TimeAxis, values: &[f64]) -> Result<NoiseEstimate, NoiseError> {
    let runs = consecutive_runs(time, values);
    let longest = runs.iter().map(|run| run.len()).max().unwrap_or(0);
    let Some(order) = DIFFERENCE_ORDERS.into_iter().find(|p| longest >= 5 * p) else {
        return Err(NoiseError::TooShort {
            found: longest,
            needed: 5 * DIFFERENCE_ORDERS[DIFFERENCE_ORDERS.len() - 1],
        });
    };
    let of_order = |p: usize| sigma_of_order(values, &runs, p);
    let raw = of_order(order);
    let lower = of_order(order / 2);
    let step = lattice_step(values, &runs);
    // Uniform rounding alone has the standard deviation step / sqrt(12). Where the
    // signal stands still between steps the differences are zero and show none of it.
    let rounding = step.map_or(0.0, |q| q / 12f64.sqrt());
    // A ramp that rises by half a step from sample to sample is rounded up and down in turn: high
    // differences take that for the loudest noise there is.
    let scatter = step.map_or(raw, |_| raw.min(scatter_of_blocks(values, &runs)));
    let quantised = rounding > 0.5 * scatter;
    Ok(NoiseEstimate {
        sigma: if quantised {
            scatter.max(rounding)
        } else {
            raw
        },
        order,
        step,
        quantised,
        white: (lower - raw).abs() <= raw.max(lower) / 3.0,
    })
}

/// Ranges of consecutive finite samples without a gap.
fn consecutive_runs(time: TimeAxis, values: &[f64]) -> Vec<std::ops::Range<usize>> {
    let interval = time.interval(values.len());
    let mut runs = Vec::new();
    let mut start = 0;
    for (i, value) in values.iter().enumerate() {
        let broken = i > start && time.at(i) - time.at(i - 1) > 1.5 * interval;
        if broken {
            runs.push(start..i);
            start = i;
        }
        if !value.is_finite() {
            runs.push(start..i);
            start = i + 1;
        }
    }
    runs.push(start..values.len());
    runs.retain(|run| !run.is_empty());
    runs
}

/// Standard deviation of white noise from differences of order `p`.
fn sigma_of_order(values: &[f64], runs: &[std::ops::Range<usize>], p: usize) -> f64 {
    let mut windows: Vec<std::ops::Range<usize>> = Vec::new();
    for run in runs {
        let mut start = run.start;
        while start + 2 * p < run.end {
            let end = (start + WINDOW_DIFFERENCES + p).min(run.end);
            windows.push(start..end);
            start = end - p;
        }
    }
    let stride = windows.len().div_ceil(MOST_WINDOWS).max(1);
    let mut differences: Vec<Vec<f64>> = Vec::new();
    let mut levels = Vec::new();
    for window in windows.into_iter().step_by(stride) {
        let mut d = values[window].to_vec();
        for _ in 0..p {
            for i in 0..d.len() - 1 {
                d[i] = d[i + 1] - d[i];
            }
            d.pop();
        }
        d.iter_mut().for_each(|v| *v = v.abs());
        levels.push(median_in_place(&mut d));
        differences.push(d);
    }
    // The quieter windows show the noise; the pool of all that are like them tells
    // its size without the bias of having picked the quietest.
    let quiet = quantile_in_place(&mut levels.clone(), 0.25);
    let mut pool: Vec<f64> = differences
        .iter()
        .zip(&levels)
        .filter(|(_, level)| **level <= MAX_ROUGHNESS * quiet)
        .flat_map(|(d, _)| d.iter().copied())
        .collect();
    if pool.is_empty() {
        return 0.0;
    }
    median_in_place(&mut pool) / NORMAL_MEDIAN / binomial_root(p)
}

/// Median over short blocks of the standard deviation about a parabola; infinite where no run has
/// a block.
fn scatter_of_blocks(values: &[f64], runs: &[std::ops::Range<usize>]) -> f64 {
    let blocks = || {
        let of_run = |run: &std::ops::Range<usize>| values[run.clone()].chunks_exact(SCATTER_BLOCK);
        runs.iter().flat_map(of_run)
    };
    let stride = blocks().count().div_ceil(MOST_WINDOWS).max(1);
    let scatter = blocks().step_by(stride).map(scatter_about_parabola);
    quantile_in_place(&mut scatter.collect::<Vec<_>>(), 0.5)
}

/// Standard deviation of evenly spaced values about the parabola of least squares.
fn scatter_about_parabola(block: &[f64]) -> f64 {
    let n = block.len() as f64;
    let mean = block.iter().sum::<f64>() / n;
    let middle = 0.5 * (n - 1.0);
    let at = |i: usize| i as f64 - middle;
    let bend = |i: usize| at(i).powi(2) - (n * n - 1.0) / 12.0;
    let along = |basis: &dyn Fn(usize) -> f64| {
        let (mut dot, mut norm) = (0.0, 0.0);
        for (i, v) in block.iter().enumerate() {
            dot += basis(i) * (v - mean);
            norm += basis(i).powi(2);
        }
        dot / norm
    };
    let (slope, curvature) = (along(&at), along(&bend));
    let left = block.iter().enumerate().map(|(i, v)| {
        let off = v - mean - slope * at(i) - curvature * bend(i);
        off * off
    });
    (left.sum::<f64>() / (n - 3.0)).sqrt()
}

/// `sqrt(C(2p, p))`: what differencing `p` times does to white noise.
fn binomial_root(p: usize) -> f64 {
    (1..=p)
        .map(|k| (p + k) as f64 / k as f64)
        .product::<f64>()
        .sqrt()
}

/// The step of the lattice on which the values lie: the smallest difference between
/// neighbours, if nearly all differences are whole multiples of it.
fn lattice_step(values: &[f64], runs: &[std::ops::Range<usize>]) -> Option<f64> {
    let scale = values
        .iter()
        .filter(|v| v.is_finite())
        .fold(0.0, |m: f64, v| m.max(v.abs()));
    // Below this a difference is the rounding of the decimal text.
    let fuzz = 1e-11 * scale;
    let differences: Vec<f64> = runs
        .iter()
        .flat_map(|run| values[run.clone()].windows(2))
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| *d > fuzz)
        .take(200_000)
        .collect();
    // A steep signal goes by several steps from sample to sample, but visits neighbouring levels
    // in time.
    let mut levels: Vec<f64> = runs
        .iter()
        .flat_map(|run| values[run.clone()].iter().copied())
        .take(MAX_LATTICE_LEVELS)
        .collect();
    levels.sort_unstable_by(f64::total_cmp);
    let gaps = levels.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > fuzz);
    let gaps: Vec<f64> = gaps.chain(differences.iter().copied()).collect();
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    if differences.len() < 8 || !smallest.is_finite() {
        return None;
    }
    let on_lattice = |step: f64| {
        let whole = |d: &&f64| {
            let steps = **d / step;
            (steps - steps.round()).abs() < 0.05
        };
        100 * differences.iter().filter(whole).count() >= 95 * differences.len()
    };
    // Where levels are left out, the smallest gap is a multiple of the step.
    let common = |&(fuzz, least): &(f64, f64)| {
        let few = gaps.iter().take(MAX_COMMON_GAPS).copied();
        let step = few.reduce(|a, b| common_divisor(a, b, fuzz * scale))?;
        (step > least * scale && on_lattice(step)).then_some(step)
    };
    let step = Some(smallest)
        .filter(|s| on_lattice(*s))
        .or_else(|| COMMON_STEPS.iter().find_map(common))?;
    // A single step size says nothing of a lattice, unless many such steps climb over many
    // levels: one sees it by several.
    let (low, high) = extremes(values);
    let staircase =
        differences.len() >= MIN_STAIRCASE_STEPS && high - low > MIN_STAIRCASE_LEVELS * step;
    let varied = staircase || differences.iter().any(|d| *d > 1.5 * step);
    varied.then_some(step)
}

/// Euclid's common divisor of two positive numbers; what is left below `fuzz` is rounding.
fn common_divisor(mut a: f64, mut b: f64, fuzz: f64) -> f64 {
    while b > fuzz {
        let rest = a % b;
        // Just below a whole multiple is one, too.
        (a, b) = (b, rest.min(b - rest));
    }
    a
}

#[cfg(test)]
mod tests {
    use super::super::noise::*;
    use crate::model::sensor::gaussian;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const RATE: f64 = 50e3;
    const AXIS: TimeAxis = TimeAxis::Uniform {
        t0: 0.0,
        dt: 1.0 / RATE,
    };

    /// Motion of the kind the device shows: 50 Hz, impacts, a step and a decaying
    /// 6.4 kHz ring each half period.
    fn motion(n: usize) -> Vec<f64> {
        (0..n)
            .map(|i| {
                let t = i as f64 / RATE;
                let phase = (t * 100.0).fract() / 100.0;
                let step = if ((t * 100.0) as i64) % 2 == 0 {
                    20e-6
                } else {
                    -20e-6
                };
                let slow = 130e-6 * (std::f64::consts::TAU * 50.0 * t).sin();
                let bounce = 30e-6 * (std::f64::consts::TAU * 120.0 * t).sin().abs();
                let ring =
                    8e-6 * (-phase / 1.5e-3).exp() * (std::f64::consts::TAU * 6424.0 * phase).sin();
                slow + step + bounce + ring
            })
            .collect()
    }

    #[test]
    fn white_noise_on_impacts_within_ten_percent() {
        for (seed, sigma) in [(1, 5e-9), (2, 20e-9), (3, 20e-9), (4, 100e-9), (5, 1e-6)] {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let values: Vec<f64> = motion(20_000)
                .iter()
                .map(|x| x + sigma * gaussian(&mut rng))
                .collect();
            let found = estimate_noise(AXIS, &values).unwrap();
            let error = found.sigma / sigma - 1.0;
            assert!(error.abs() < 0.1, "{sigma}: {:+.1} %", 100.0 * error);
            assert!(found.white && !found.quantised, "{found:?}");
        }
    }

    #[test]
    fn noiseless_motion_has_next_to_none() {
        let found = estimate_noise(AXIS, &motion(20_000)).unwrap();
        assert!(found.sigma < 1e-10, "{found:?}");
    }

    #[test]
    fn missing_samples_and_gaps_do_not_matter() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut values: Vec<f64> = motion(20_000)
            .iter()
            .map(|x| x + 20e-9 * gaussian(&mut rng))
            .collect();
        let mut time: Vec<f64> = (0..values.len()).map(|i| i as f64 / RATE).collect();
        values.iter_mut().step_by(301).for_each(|v| *v = f64::NAN);
        time[5000..].iter_mut().for_each(|t| *t += 0.1);
        let found = estimate_noise(TimeAxis::Samples(&time), &values).unwrap();
        assert!((found.sigma / 20e-9 - 1.0).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn quantisation_is_said() {
        let mut rng = ChaCha8Rng::seed_from_u64(10);
        let rounded = |x: f64, q: f64| (x / q).round() * q;
        let coarse: Vec<f64> = motion(20_000).iter().map(|x| rounded(*x, 1e-6)).collect();
        let found = estimate_noise(AXIS, &coarse).unwrap();
        assert!(
            found.quantised && (found.step.unwrap() / 1e-6 - 1.0).abs() < 1e-3,
            "{found:?}"
        );
        assert!(found.sigma > 0.28e-6 && found.sigma < 0.45e-6, "{found:?}");
        let still: Vec<f64> = (0..2000)
            .map(|i| rounded(5e-6 * (i as f64 * 1e-3).sin(), 1e-6))
            .collect();
        let found = estimate_noise(AXIS, &still).unwrap();
        assert!(found.sigma <= 0.3e-6, "{found:?}");
        let fine: Vec<f64> = motion(20_000)
            .iter()
            .map(|x| rounded(x + 20e-9 * gaussian(&mut rng), 1e-9))
            .collect();
        let found = estimate_noise(AXIS, &fine).unwrap();
        assert!(!found.quantised && found.step.is_some(), "{found:?}");
    }

    #[test]
    fn too_short_is_an_error() {
        assert!(estimate_noise(AXIS, &[1.0; 10]).is_err());
        assert!(estimate_noise(AXIS, &[f64::NAN; 100]).is_err());
        assert!(estimate_noise(AXIS, &[]).is_err());
        assert_eq!(estimate_noise(AXIS, &[1.0; 50]).unwrap().sigma, 0.0);
    }
}
