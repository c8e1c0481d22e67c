//! A level that drifts: all rests on the ground lie on one smooth course, and nothing is
//! found below it.

use nalgebra::{DMatrix, DVector};

use super::{LevelChange, block_size, quiet};
use crate::recording::Recording;
use crate::recording::level::estimate_contact_level;
use crate::recording::noise::NoiseEstimate;

/// Smallest drift that is reported, in units of the noise of a sample.
const MIN_DRIFT_NOISE: f64 = 7.0;
/// Most blocks that are analysed.
const MAX_BLOCKS: usize = 5000;
/// The course begins from two rests, each the lowest of one of so many equal spans.
const START_SPANS: usize = 48;
/// Time constants that are tried, as shares of the recording; the last is as good as a line.
const TRIED_TIME_CONSTANTS: [f64; 7] = [0.02, 0.05, 0.12, 0.3, 0.7, 1.5, 10.0];
/// Once the rests are known, the course is made of terms that settle in these shares of the
/// recording, and a line.
const TERM_TIME_CONSTANTS: [f64; 4] = [0.02, 0.06, 0.2, 0.6];
/// How near the rests lie to the course \[m\]: at first, when its shape may not be among those
/// tried ...
const START_TOLERANCE: f64 = 0.4e-6;
/// ... and in the end in units of their spread.
const FINAL_TOLERANCE: f64 = 3.0;
/// Largest scatter of the rests about the final course, in units of the noise of a sample. A
/// level that depends on the load, or moves in steps, scatters more.
const MAX_SCATTER: f64 = 1.5;
/// Fewest blocks of rest, and fewest of the [`START_SPANS`] in which they must lie.
const MIN_RESTS_AND_SPANS: (usize, usize) = (12, 5);
/// Largest share of the blocks below the course.
const MAX_SHARE_BELOW: f64 = 4e-3;
/// Rounds in which the course and the rests on it are found from each other.
const REFINEMENT_ROUNDS: usize = 4;
/// Singular values below this share of the largest are noise.
const MIN_SINGULAR_SHARE: f64 = 1e-3;
/// A term has settled after so many of its time constants.
const SETTLING_TIMES: f64 = 3.0;
/// Over the whole recording the course drifts at most so many times as far as between the rests.
const MAX_EXTRAPOLATION: f64 = 2.0;
/// The terms together move at most so many times as far as the drift. More is needed only for
/// jumps between rests, such as where the mass hovers over the ground at times.
const MAX_CANCELLATION: f64 = 5.0;

/// A drift of the ground's level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelDrift {
    /// Beginning of the recording \[s\].
    begin: f64,
    /// Times of the first and the last rest that show it \[s\].
    shown: (f64, f64),
    /// Steady part \[m/s\].
    rate: f64,
    /// Parts that settle: how far \[m\] with what time constant \[s\].
    settling: [(f64, f64); TERM_TIME_CONSTANTS.len()],
}

impl LevelDrift {
    /// Beginning of its recording \[s\].
    #[must_use]
    pub fn begin(&self) -> f64 {
        self.begin
    }

    /// Times of the first and the last rest that show it \[s\].
    #[must_use]
    pub fn shown(&self) -> (f64, f64) {
        self.shown
    }

    /// By how much the level is higher at `t` \[s\] than at the beginning \[m\].
    #[must_use]
    pub fn rise_at(&self, t: f64) -> f64 {
        let t = t - self.begin;
        let settled = |(a, tau): &(f64, f64)| -a * (-t / tau).exp_m1();
        self.rate * t + self.settling.iter().map(settled).sum::<f64>()
    }

    /// How far its parts move between the rests that show it, each by itself \[m\].
    fn moved(&self) -> f64 {
        let (first, last) = (self.shown.0 - self.begin, self.shown.1 - self.begin);
        let settles =
            |(a, tau): &(f64, f64)| a.abs() * ((-first / tau).exp() - (-last / tau).exp());
        self.rate.abs() * (last - first) + self.settling.iter().map(settles).sum::<f64>()
    }
}

/// A block of samples.
struct Block {
    /// Middle, from the beginning \[s\].
    time: f64,
    /// Mean \[m\].
    level: f64,
    /// Whether it goes along a line but for the noise.
    even: bool,
}

impl Block {
    /// Which of [`START_SPANS`] it is in.
    fn span(&self, length: f64) -> usize {
        ((self.time / length * START_SPANS as f64) as usize).min(START_SPANS - 1)
    }
}

/// Blocks without missing samples, which half overlap unless the recording is very long.
fn blocks(recording: &Recording, sigma: f64) -> Vec<Block> {
    let (time, xp) = (&recording.time, &recording.proof_mass);
    let size = block_size(recording.interval());
    let n = size as f64;
    let middle = 0.5 * (n - 1.0);
    let about = (0..size).map(|k| (k as f64 - middle).powi(2)).sum::<f64>();
    let step = (size / 2).max(xp.len() / MAX_BLOCKS);
    let starts = (0..xp.len().saturating_sub(size)).step_by(step);
    let one = |first: usize| {
        let values = &xp[first..first + size];
        let level = values.iter().sum::<f64>() / n;
        let slope = |(k, x): (usize, &f64)| (k as f64 - middle) * (x - level);
        let slope = values.iter().enumerate().map(slope).sum::<f64>() / about;
        let off = |(k, x): (usize, &f64)| (x - level - slope * (k as f64 - middle)).powi(2);
        let spread = (values.iter().enumerate().map(off).sum::<f64>() / n).sqrt();
        level.is_finite().then(|| Block {
            time: 0.5 * (time[first] + time[first + size - 1]) - time[0],
            level,
            even: quiet(spread, sigma, n),
        })
    };
    starts.filter_map(one).collect()
}

/// Rests within `width` of a course \[m\], which is given for each block, if hardly anything
/// lies below it.
fn near(blocks: &[Block], course: impl Fn(usize) -> f64, width: f64) -> Vec<usize> {
    let mut room = ((MAX_SHARE_BELOW * blocks.len() as f64) as usize).max(2);
    let mut rests = Vec::new();
    for (i, block) in blocks.iter().enumerate() {
        let off = block.level - course(i);
        if off < -width {
            if room == 0 {
                return Vec::new();
            }
            room -= 1;
        } else if block.even && off < width {
            rests.push(i);
        }
    }
    rests
}

/// The rests on the course through two of the lowest rests on which there are most.
fn rough(blocks: &[Block], length: f64, sigma: f64) -> Option<Vec<usize>> {
    let mut lowest: Vec<Option<usize>> = vec![None; START_SPANS];
    for (i, block) in blocks.iter().enumerate().filter(|(_, b)| b.even) {
        let own = &mut lowest[block.span(length)];
        if own.is_none_or(|k| block.level < blocks[k].level) {
            *own = Some(i);
        }
    }
    let lowest: Vec<usize> = lowest.into_iter().flatten().collect();
    let width = START_TOLERANCE.max(FINAL_TOLERANCE * sigma);
    let mut best = Vec::new();
    // What settles, and what slows down without end.
    let shapes: [fn(f64) -> f64; 2] = [|u| -(-u).exp_m1(), f64::ln_1p];
    for (tau, shape) in TRIED_TIME_CONSTANTS
        .iter()
        .flat_map(|share| shapes.map(|shape| (share * length, shape)))
    {
        let shape: Vec<f64> = blocks.iter().map(|b| shape(b.time / tau)).collect();
        for (k, &i) in lowest.iter().enumerate() {
            for &j in &lowest[..k] {
                let size = (blocks[i].level - blocks[j].level) / (shape[i] - shape[j]);
                let course = |b: usize| blocks[i].level + size * (shape[b] - shape[i]);
                let rests = near(blocks, course, width);
                if rests.len() > best.len() {
                    best = rests;
                }
            }
        }
    }
    spread_out(blocks, &best, length).then_some(best)
}

/// Whether there are enough rests, at enough times.
fn spread_out(blocks: &[Block], rests: &[usize], length: f64) -> bool {
    let mut spans: Vec<usize> = rests.iter().map(|&i| blocks[i].span(length)).collect();
    spans.dedup();
    rests.len() >= MIN_RESTS_AND_SPANS.0 && spans.len() >= MIN_RESTS_AND_SPANS.1
}

/// The drift of the ground's level in `recording`, if there is one: with it taken out the
/// ground must show all its signs.
#[must_use]
pub fn find_level_drift(recording: &Recording, noise: Option<NoiseEstimate>) -> Option<LevelDrift> {
    let sigma = noise.filter(|n| n.sigma > 0.0)?.sigma;
    let (begin, end) = recording.span();
    let blocks = blocks(recording, sigma);
    let rests = rough(&blocks, end - begin, sigma)?;
    // Quick terms may go astray before the first rest.
    let drift = (0..TERM_TIME_CONSTANTS.len()).find_map(|quickest| {
        let drift = near_rests(&blocks, rests.clone(), (begin, end), sigma, quickest)?;
        let range = |from: f64, to: f64| {
            let inside = blocks.iter().map(|b| begin + b.time);
            let inside = inside.filter(|t| (from..=to).contains(t));
            let rises: Vec<f64> = inside.map(|t| drift.rise_at(t)).collect();
            let (low, high) = crate::recording::extremes(&rises);
            high - low
        };
        let (seen, all) = (range(drift.shown.0, drift.shown.1), range(begin, end));
        let plain = drift.moved() < MAX_CANCELLATION * seen && all < MAX_EXTRAPOLATION * seen;
        (seen > MIN_DRIFT_NOISE * sigma && plain).then_some(drift)
    })?;
    let xp = LevelChange::Drift(drift).taken_out(&recording.time, &recording.proof_mass);
    let level = estimate_contact_level(recording.axis(), recording.voltage.as_deref(), &xp, noise);
    level.is_ok().then_some(drift)
}

/// The course through `rests`, and those near it, found from each other, without the terms
/// before the `quickest`.
fn near_rests(
    blocks: &[Block],
    mut rests: Vec<usize>,
    (begin, end): (f64, f64),
    sigma: f64,
    quickest: usize,
) -> Option<LevelDrift> {
    let mut drift = None;
    for _ in 0..REFINEMENT_ROUNDS {
        let (course, level) = through(blocks, &rests, (begin, end), quickest)?;
        let course_at = |i: usize| level + course.rise_at(begin + blocks[i].time);
        let off = |&i: &usize| (blocks[i].level - course_at(i)).powi(2);
        let rms = (rests.iter().map(off).sum::<f64>() / rests.len() as f64).sqrt();
        rests = near(blocks, course_at, FINAL_TOLERANCE * rms.max(sigma));
        if !spread_out(blocks, &rests, end - begin) {
            return None;
        }
        drift = (rms < MAX_SCATTER * sigma).then_some(course);
    }
    drift
}

/// Least squares through `rests` in a recording from `begin` to `end` \[s\], without the terms
/// before the `quickest`: the drift, and the level at the beginning \[m\].
fn through(
    blocks: &[Block],
    rests: &[usize],
    (begin, end): (f64, f64),
    quickest: usize,
) -> Option<(LevelDrift, f64)> {
    let rests: Vec<&Block> = rests.iter().map(|&i| &blocks[i]).collect();
    let (first, last) = (rests.first()?.time, rests.last()?.time);
    let taus = TERM_TIME_CONSTANTS.map(|share| share * (end - begin));
    let mut rows = Vec::with_capacity(rests.len() * (2 + taus.len()));
    for rest in &rests {
        rows.extend([1.0, rest.time / last]);
        // What is over before the first rest is not shown by any.
        let shown = |k: usize| k >= quickest && first < SETTLING_TIMES * taus[k];
        let settled = |k: usize| {
            if shown(k) {
                -(-rest.time / taus[k]).exp_m1()
            } else {
                0.0
            }
        };
        rows.extend((0..taus.len()).map(settled));
    }
    let matrix = DMatrix::from_row_slice(rests.len(), 2 + taus.len(), &rows);
    let levels = DVector::from_fn(rests.len(), |i, _| rests[i].level);
    let svd = matrix.svd(true, true);
    let floor = MIN_SINGULAR_SHARE * svd.singular_values.max();
    let found = svd.solve(&levels, floor).ok()?;
    let drift = LevelDrift {
        begin,
        shown: (begin + first, begin + last),
        rate: found[1] / last,
        settling: std::array::from_fn(|k| (found[2 + k], taus[k])),
    };
    let finite = found.iter().all(|x| x.is_finite());
    finite.then_some((drift, found[0]))
}

#[cfg(test)]
mod tests {
    use super::super::drift::*;
    use crate::recording::Channel;

    /// A mass that is on the ground half of each 10 ms, jumps 80 um between and rests up
    /// there for a while, with a stand-in for noise; the zero moves by `drift`.
    fn jumps(drift: impl Fn(f64) -> f64) -> Recording {
        jumps_each(0.01, 10_000, drift)
    }

    /// The same for so many samples, half of each `period` \[s\].
    fn jumps_each(period: f64, n: u32, drift: impl Fn(f64) -> f64) -> Recording {
        let time: Vec<f64> = (0..n).map(|i| 2e-5 * f64::from(i)).collect();
        let phase_at = |t: f64| (t / period).fract();
        let noise = |i: usize| {
            let x = (i as f64 * 12.9898).sin() * 43758.5453;
            7e-8 * (x - x.floor() - 0.5)
        };
        let xp = time.iter().enumerate().map(|(i, t)| {
            let phase = phase_at(*t);
            let up = (16.0 * (phase - 0.5) * (1.0 - phase)).clamp(0.0, 0.6);
            drift(*t) + 80e-6 * up + noise(i)
        });
        let voltage = time.iter().map(|t| 8.0 * phase_at(*t)).collect();
        Recording::new("jumps", time.clone(), Some(voltage), xp.collect(), None).unwrap()
    }

    fn found(recording: &Recording) -> Option<LevelDrift> {
        find_level_drift(recording, recording.estimate_noise(Channel::ProofMass).ok())
    }

    #[test]
    fn a_drift_of_any_course_is_followed_to_the_noise() {
        let courses: [fn(f64) -> f64; 4] = [
            |t| 8e-6 * (t / 0.05).ln_1p(),
            |t| -10e-6 * (1.0 - (-t / 0.06).exp()),
            |t| 4e-5 * t,
            |t| -5e-6 * (t / 0.2).sqrt(),
        ];
        for (k, course) in courses.iter().enumerate() {
            let drift = found(&jumps(course)).unwrap_or_else(|| panic!("drift {k}"));
            for t in [0.012, 0.05, 0.11, 0.19] {
                let off = drift.rise_at(t) - drift.rise_at(0.1) - course(t) + course(0.1);
                // A root begins steeply.
                let allowed = if k == 3 { 10e-8 } else { 3e-8 };
                assert!(off.abs() < allowed, "{k}: {off:e} m at {t} s");
            }
        }
    }

    #[test]
    fn rests_of_two_levels_are_no_drift() {
        // In the first of six stays the mass is on the ground, in the others a little above it.
        let above = |t: f64| if t < 0.02 { 0.0 } else { 1.6e-7 };
        assert_eq!(found(&jumps_each(0.025, 7500, above)), None);
    }

    #[test]
    fn a_steady_level_and_a_mass_that_never_rests_show_no_drift() {
        assert_eq!(found(&jumps(|_| 0.0)), None);
        // A sine that touches nothing, whose mean drifts.
        let mut free = jumps(|_| 0.0);
        for (x, t) in free.proof_mass.iter_mut().zip(&free.time) {
            *x = 50e-6 * (600.0 * t).sin() + 4e-5 * t;
        }
        assert_eq!(found(&free), None);
    }
}
