//! A vibration of the base that knows nothing of when recordings begin: its phase is another one
//! in each of them. Recordings are then told by one clock, the vibration's, for as long as they
//! are looked at.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rayon::prelude::*;

use super::bench::{Fitted, LOSS};
use super::promises::{LINES, SHAKE, SPACING};
use super::result::Diagnosis;
use super::scan::{Base, Linear, Products, Scan};
use crate::fit::Part;
use crate::model::effects::{ActiveEffect, EffectSpec, find};
use crate::recording::Recording;
use crate::sim::SimError;

/// Distance of the frequencies looked at, in turns over the longest stretch.
const FINE: f64 = 0.2;
/// Most frequencies between two that are simulated, on either side.
const MOST_STEPS: f64 = 2000.0;
/// Fall of chi2 by a vibration with phases of its own from which it is one, and by which they
/// must bring more than one phase for all.
const TOLD: f64 = 100.0;
/// The same as a share of the fall.
const MORE: f64 = 0.2;
/// Chi2 per value from which it is looked for.
const LEAST: f64 = 1.02;
/// How far apart the amplitudes in the recordings may be: as a share, and in standard errors.
const ALIKE: (f64, f64) = (0.15, 4.0);
/// Standard errors from which an amplitude is one.
const SEEN: f64 = 5.0;
/// Times a frequency is halved in on.
const HALVINGS: usize = 24;

/// When recordings begin by the clock of a vibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Clocks {
    /// To be added to the times of each recording: those fitted, those kept out \[s\].
    late: (Vec<f64>, Vec<f64>),
}

/// Vibrations of one frequency in all recordings of a side.
struct Shaken {
    /// Sine and cosine of each recording \[m/s^2\].
    parts: Vec<Vector2<f64>>,
    /// Standard error of both.
    errors: Vec<f64>,
    /// Fall of chi2 with phases of their own, and with one for all.
    gains: (f64, f64),
}

impl Clocks {
    /// Those of a vibration that `train` and `held_out`, fits without one, show with another phase
    /// in each recording; `None` if they show none.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn of(train: &Fitted, held_out: Option<&Fitted>) -> Result<Option<Self>, SimError> {
        let Some(spec) = find("base_vibration") else {
            return Ok(None);
        };
        let count = train.problem.data.len();
        // Where nothing is left of the recordings there is nothing to be told by another clock.
        let little = train.per_value() < LEAST;
        if count < 2 || little || train.model.effects.iter().any(|e| e.spec == spec) {
            return Ok(None);
        }
        let linear = Linear::new(&train.problem, &train.point, LOSS)?;
        let Some(frequency) = frequency(&linear, train, spec)? else {
            return Ok(None);
        };
        let Some(own) = shaken(&linear, train, (spec, frequency), 0)? else {
            return Ok(None);
        };
        let (gain, shared) = own.gains;
        log::debug!("{frequency:.3} Hz with own phases {gain:.0}, with one {shared:.0}");
        if gain < TOLD || gain - shared < TOLD.max(MORE * gain) {
            return Ok(None);
        }
        let kept_out = match held_out {
            Some(held) => {
                let linear = Linear::new(&held.problem, &held.point, LOSS)?;
                let locked = held.problem.space.len();
                match shaken(&linear, held, (spec, frequency), locked)? {
                    Some(kept_out) => Some(kept_out),
                    None => return Ok(None),
                }
            }
            None => None,
        };
        let all = std::iter::once(&own).chain(&kept_out);
        let sizes = all.flat_map(|side| side.parts.iter().map(|p| p.norm()).zip(&side.errors));
        let sizes: Vec<(f64, f64)> = sizes.map(|(size, error)| (size, *error)).collect();
        log::debug!("amplitudes {sizes:.3?}");
        if !alike(&sizes) {
            return Ok(None);
        }
        let phase = |part: &Vector2<f64>| part.y.atan2(part.x);
        let first = phase(&own.parts[0]);
        let late = |part: &Vector2<f64>| {
            let turn = phase(part) - first;
            (turn - TAU * (turn / TAU).round()) / (TAU * frequency)
        };
        let of = |side: &Shaken| side.parts.iter().map(late).collect();
        Ok(Some(Self {
            late: (of(&own), kept_out.as_ref().map_or_else(Vec::new, of)),
        }))
    }

    /// Recordings by the vibration's clock.
    pub fn told(&self, train: &[Part], held_out: &[Part]) -> (Vec<Part>, Vec<Part>) {
        let side = |parts: &[Part], late: &[f64]| -> Vec<Part> {
            let both = parts.iter().zip(late);
            both.map(|(part, late)| Part {
                recording: Arc::new(later(&part.recording, *late)),
                samples: part.samples.clone(),
            })
            .collect()
        };
        (side(train, &self.late.0), side(held_out, &self.late.1))
    }

    /// Tells the times of a diagnosis by the recordings' own clocks again.
    pub fn undo(&self, diagnosis: &mut Diagnosis) {
        let late: Vec<f64> = self.late.0.iter().chain(&self.late.1).copied().collect();
        // Strips are of one recording each, those fitted first.
        let names: Vec<String> = diagnosis
            .strips
            .iter()
            .map(|s| s.recording.clone())
            .collect();
        let of_name = |name: &str| {
            let known = names.iter().position(|n| n == name);
            known.and_then(|k| late.get(k)).copied().unwrap_or(0.0)
        };
        for found in &mut diagnosis.mismatch {
            let late = of_name(&found.recording);
            found.start -= late;
            found.end -= late;
        }
        for (strip, late) in diagnosis.strips.iter_mut().zip(&late) {
            strip.time.iter_mut().for_each(|t| *t -= late);
            let samples = strip.samples_before.iter_mut();
            for sample in samples.chain(&mut strip.samples_after) {
                sample[0] -= late;
            }
        }
        let at = |k: usize| late.get(k).copied().unwrap_or(0.0);
        let events = &mut diagnosis.events;
        for seen in &mut events.bounces {
            seen.time -= at(seen.recording);
        }
        for seen in &mut events.releases {
            seen.time -= at(seen.recording);
        }
        for seen in &mut events.levels {
            seen.time -= at(seen.recording);
        }
    }
}

fn later(recording: &Recording, by: f64) -> Recording {
    let mut out = recording.clone();
    out.time.iter_mut().for_each(|t| *t += by);
    out
}

/// Whether those amplitudes with their errors may be of one vibration.
fn alike(sizes: &[(f64, f64)]) -> bool {
    let weights = sizes.iter().map(|(size, error)| (size, error.powi(-2)));
    let (sum, weight) = weights.fold((0.0, 0.0), |(s, w), (size, own)| (s + own * size, w + own));
    let mean = sum / weight;
    let seen = sizes.iter().filter(|s| s.0 > SEEN * s.1).count();
    let near = |s: &(f64, f64)| (s.0 - mean).abs() < ALIKE.0 * mean + ALIKE.1 * s.1;
    seen >= 2 && sizes.iter().all(near)
}

fn vibration(spec: &'static EffectSpec, f: f64) -> [ActiveEffect; 2] {
    [0.0, FRAC_PI_2].map(|phase| ActiveEffect {
        spec,
        values: vec![SHAKE, f, phase],
    })
}

/// The frequency at which phases of their own bring most \[Hz\].
fn frequency(
    linear: &Linear<'_>,
    fitted: &Fitted,
    spec: &'static EffectSpec,
) -> Result<Option<f64>, SimError> {
    let data = &fitted.problem.data;
    let rate = data.iter().map(|d| d.recording.sampling_rate());
    let (low, high) = (
        LINES.0,
        LINES.1.min(0.4 * rate.fold(f64::INFINITY, f64::min)),
    );
    if high < 2.0 * low {
        return Ok(None);
    }
    let count = ((high - low) / SPACING).ceil() as usize;
    let half = 0.5 * (high - low) / count as f64;
    let coarse = (0..count).map(|i| low + (2 * i + 1) as f64 * half);
    let coarse: Vec<f64> = coarse.collect();
    let effects: Vec<ActiveEffect> = coarse.iter().flat_map(|f| vibration(spec, *f)).collect();
    let products = linear.products(&fitted.model, &effects)?;
    let Some(base) = Scan::gather(linear, &products, effects.len()).base() else {
        return Ok(None);
    };
    let span = |d: &crate::fit::problem::Data| {
        let (begin, end) = d.recording.span();
        end - begin
    };
    let longest = data.iter().map(span).fold(1e-3, f64::max);
    let steps = (half * longest / FINE).ceil().min(MOST_STEPS) as i64;
    let gain = |c: usize, shift: f64| -> f64 {
        let all = blocks(linear, fitted, &products, (2 * c, shift));
        all.iter().map(|block| block.gain(&base)).sum()
    };
    let all: Vec<(usize, f64)> = (0..count)
        .flat_map(|c| (-steps..=steps).map(move |d| (c, half * d as f64 / steps as f64)))
        .collect();
    let gains: Vec<(usize, f64, f64)> = all
        .into_par_iter()
        .map(|(c, shift)| (c, shift, gain(c, shift)))
        .collect();
    let best = gains.into_iter().filter(|g| g.2.is_finite());
    let Some((c, mut at, mut most)) = best.max_by(|a, b| a.2.total_cmp(&b.2)) else {
        return Ok(None);
    };
    let mut reach = half / steps as f64;
    for _ in 0..HALVINGS {
        let beside = [at - reach, at + reach].map(|shift| (shift, gain(c, shift)));
        match beside.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((shift, gain)) if gain > most => (at, most) = (shift, gain),
            _ => reach *= 0.5,
        }
    }
    Ok(Some(coarse[c] + at))
}

/// Products of one recording's sine and cosine.
struct Block {
    cross: [DVector<f64>; 2],
    gram: Matrix2<f64>,
    slope: Vector2<f64>,
}

impl Block {
    /// Fall of chi2 if only this recording had it.
    fn gain(&self, base: &Base) -> f64 {
        let inner = Matrix2::from_fn(|i, j| base.inner(&self.cross[i], &self.cross[j]));
        let slope = Vector2::from_fn(|i, _| base.slope(&self.cross[i], self.slope[i]));
        let left = self.gram - inner + Matrix2::identity() * (1e-7 * self.gram.trace());
        left.try_inverse()
            .map_or(0.0, |inverse| slope.dot(&(inverse * slope)))
    }
}

/// Products of each recording with the sine number `which` and the cosine that follows it, both
/// turned to a frequency that is higher by `shift` \[Hz\].
fn blocks(
    linear: &Linear<'_>,
    fitted: &Fitted,
    products: &[Products],
    (which, shift): (usize, f64),
) -> Vec<Block> {
    let n = linear.problem().unknowns();
    let data = &fitted.problem.data;
    let empty = || Block {
        cross: [DVector::zeros(n), DVector::zeros(n)],
        gram: Matrix2::zeros(),
        slope: Vector2::zeros(),
    };
    let mut out: Vec<Block> = data.iter().map(|_| empty()).collect();
    for p in products {
        let block = &mut out[linear.point().segments[p.segment].recording];
        let (sin, cos) = (TAU * shift * p.middle).sin_cos();
        let turn = Matrix2::new(cos, sin, -sin, cos);
        block.gram += turn * p.gram.fixed_view::<2, 2>(which, which) * turn.transpose();
        block.slope += turn * p.slope.fixed_view::<2, 1>(which, 0);
        for (i, &ci) in p.columns.iter().enumerate() {
            let own = Vector2::new(p.cross[(i, which)], p.cross[(i, which + 1)]);
            let turned = turn * own;
            block.cross[0][ci] += turned[0];
            block.cross[1][ci] += turned[1];
        }
    }
    out
}

/// The vibrations of a side, its first `locked` unknowns as they are; `None` where they cannot be
/// told.
fn shaken(
    linear: &Linear<'_>,
    fitted: &Fitted,
    (spec, frequency): (&'static EffectSpec, f64),
    locked: usize,
) -> Result<Option<Shaken>, SimError> {
    let products = linear.products(&fitted.model, &vibration(spec, frequency))?;
    let Some(base) = Scan::gather(linear, &products, 2).base_without(locked) else {
        return Ok(None);
    };
    let blocks = blocks(linear, fitted, &products, (0, 0.0));
    let m = 2 * blocks.len();
    let cross = |i: usize| &blocks[i / 2].cross[i % 2];
    let normal = DMatrix::from_fn(m, m, |i, j| {
        let own = if i / 2 == j / 2 {
            blocks[i / 2].gram[(i % 2, j % 2)]
        } else {
            0.0
        };
        own - base.inner(cross(i), cross(j))
    });
    let slope = DVector::from_fn(m, |i, _| base.slope(cross(i), blocks[i / 2].slope[i % 2]));
    let Some(inverse) = normal.clone().cholesky().map(|factor| factor.inverse()) else {
        return Ok(None);
    };
    let solved = -(&inverse * &slope);
    let gain = -slope.dot(&solved);
    let (mut shared, mut along) = (Matrix2::zeros(), Vector2::zeros());
    for i in 0..m {
        along[i % 2] += slope[i];
        for j in 0..m {
            shared[(i % 2, j % 2)] += normal[(i, j)];
        }
    }
    let of_all = shared
        .try_inverse()
        .map_or(0.0, |inverse| along.dot(&(inverse * along)));
    let error = |k: usize| {
        let variance = inverse[(2 * k, 2 * k)] + inverse[(2 * k + 1, 2 * k + 1)];
        SHAKE * (0.5 * variance).sqrt()
    };
    Ok(Some(Shaken {
        parts: (0..blocks.len())
            .map(|k| SHAKE * Vector2::new(solved[2 * k], solved[2 * k + 1]))
            .collect(),
        errors: (0..blocks.len()).map(error).collect(),
        gains: (gain, of_all),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench::with_effect;
    use crate::diagnose::made::{self, QUIET};
    use crate::model::preset::Preset;

    #[test]
    fn amplitudes_of_one_vibration_are_alike() {
        let shaken = [(9.6, 0.1), (9.7, 0.2), (9.5, 0.05), (8.0, 0.6)];
        assert!(alike(&shaken));
        // What follows the drive is larger where that is.
        assert!(!alike(&[(9.6, 0.1), (4.7, 0.2), (0.5, 0.05), (8.0, 0.6)]));
        // One recording that shows it proves nothing of phases.
        assert!(!alike(&[(9.6, 0.1), (9.0, 4.0), (8.0, 6.0)]));
    }

    /// Recordings of the paper's device on a base that shakes in those phases.
    fn shaken_in(phases: &[f64]) -> Vec<Part> {
        let drives = [("sine:20Hz:8V", 0.1), ("square:40Hz:8V", 0.06)];
        let both = drives.into_iter().zip(phases);
        let one = |(drive, phase): ((&str, f64), &f64)| {
            let effect = ActiveEffect {
                spec: find("base_vibration").unwrap(),
                values: vec![3.0, 137.0, *phase],
            };
            let model = with_effect(&Preset::embedded("paper").unwrap().model, effect);
            made::parts_of(&model, &[drive], 25e3, 20e-9)
        };
        both.flat_map(one).collect()
    }

    fn clocks_of(parts: &[Part]) -> Option<Clocks> {
        let model = Preset::embedded("paper").unwrap().model;
        let fitted = made::bench(parts).baseline(&model, &QUIET).unwrap();
        Clocks::of(&fitted, None).unwrap()
    }

    #[test]
    fn recordings_are_told_by_the_clock_of_what_shakes_them() {
        let parts = shaken_in(&[0.4, 2.2]);
        let clocks = clocks_of(&parts).unwrap();
        let late = (2.2 - 0.4) / (TAU * 137.0);
        assert_eq!(clocks.late.0[0], 0.0);
        assert!((clocks.late.0[1] - late).abs() < 2e-5, "{clocks:?} {late}");
        let (told, _) = clocks.told(&parts, &[]);
        let first = |part: &Part| part.recording.time[0];
        assert!((first(&told[1]) - first(&parts[1]) - late).abs() < 2e-5);
        // By that clock there is one phase.
        assert_eq!(clocks_of(&told), None);
    }

    #[test]
    fn one_phase_for_all_asks_for_no_other_clock() {
        assert_eq!(clocks_of(&shaken_in(&[0.4, 0.4])), None);
    }
}
