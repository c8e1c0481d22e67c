//! A vibration of the base that is not synchronous with the recordings: its phase differs between
//! them. The recordings are then shifted in time to the vibration's clock for the analysis.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rayon::prelude::*;

use super::base_vibration::{FrequencyComb, PROBE_ACCELERATION, PhaseShiftedGram, sine_and_cosine};
use crate::diagnose::diagnosis::Diagnosis;
use crate::diagnose::score_test::linearized::{Linearized, SegmentGram};
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{
    AMPLITUDE_MAX_SPREAD, AMPLITUDE_MIN_Z, OWN_PHASES_MIN_GAIN, OWN_PHASES_MIN_SHARE,
    VIBRATION_LOOKED_FOR_CHI2,
};
use crate::fit::Part;
use crate::model::effects::{EffectSpec, base_sinusoid};
use crate::recording::Recording;
use crate::sim::SimError;

/// Halvings of the step by which a frequency is refined.
const FREQUENCY_HALVINGS: usize = 24;

/// Start times of the recordings by the clock of a vibration.
#[derive(Debug, Clone, PartialEq)]
pub struct VibrationClock {
    /// Offsets to be added to the times of the fitted and the held-out recordings \[s\].
    offsets: (Vec<f64>, Vec<f64>),
}

/// Vibrations of one frequency in all recordings of a split.
struct RecordingVibrations {
    /// Sine and cosine amplitudes of each recording \[m/s^2\].
    parts: Vec<Vector2<f64>>,
    /// Standard errors of both.
    errors: Vec<f64>,
    /// Fall of chi2 with a phase for each recording, and with one for all.
    gains: (f64, f64),
}

impl VibrationClock {
    /// The clock of a vibration that `train` and `held_out`, fits without one, show with
    /// another phase in each recording; `None` if they show none.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn of(train: &Fitted, held_out: Option<&Fitted>) -> Result<Option<Self>, SimError> {
        let Some(spec) = base_sinusoid() else {
            return Ok(None);
        };
        let count = train.problem.data.len();
        // Without a misfit there is nothing to explain by another clock.
        let little = train.per_value() < VIBRATION_LOOKED_FOR_CHI2;
        if count < 2 || little || train.model.effects.iter().any(|e| e.spec == spec) {
            return Ok(None);
        }
        let linear = Linearized::new(train)?;
        let Some(frequency) = frequency(&linear, train, spec)? else {
            return Ok(None);
        };
        let Some(own) = recording_vibrations(&linear, train, (spec, frequency), 0)? else {
            return Ok(None);
        };
        let (gain, shared) = own.gains;
        log::debug!("{frequency:.3} Hz with own phases {gain:.0}, with one {shared:.0}");
        if gain < OWN_PHASES_MIN_GAIN
            || gain - shared < OWN_PHASES_MIN_GAIN.max(OWN_PHASES_MIN_SHARE * gain)
        {
            return Ok(None);
        }
        let held_out_side = match held_out {
            Some(held) => {
                let linear = Linearized::new(held)?;
                let locked = held.problem.space.len();
                match recording_vibrations(&linear, held, (spec, frequency), locked)? {
                    Some(held_out_side) => Some(held_out_side),
                    None => return Ok(None),
                }
            }
            None => None,
        };
        let all = std::iter::once(&own).chain(&held_out_side);
        let sizes = all.flat_map(|side| side.parts.iter().map(|p| p.norm()).zip(&side.errors));
        let sizes: Vec<(f64, f64)> = sizes.map(|(size, error)| (size, *error)).collect();
        log::debug!("amplitudes {sizes:.3?}");
        if !amplitudes_agree(&sizes) {
            return Ok(None);
        }
        let phase = |part: &Vector2<f64>| part.y.atan2(part.x);
        let first = phase(&own.parts[0]);
        let late = |part: &Vector2<f64>| {
            let turn = phase(part) - first;
            (turn - TAU * (turn / TAU).round()) / (TAU * frequency)
        };
        let of = |side: &RecordingVibrations| side.parts.iter().map(late).collect();
        Ok(Some(Self {
            offsets: (of(&own), held_out_side.as_ref().map_or_else(Vec::new, of)),
        }))
    }

    /// The recordings by the vibration's clock.
    pub fn shift_recordings(&self, train: &[Part], held_out: &[Part]) -> (Vec<Part>, Vec<Part>) {
        let side = |parts: &[Part], late: &[f64]| -> Vec<Part> {
            let both = parts.iter().zip(late);
            both.map(|(part, late)| Part {
                recording: Arc::new(shifted(&part.recording, *late)),
                samples: part.samples.clone(),
            })
            .collect()
        };
        (
            side(train, &self.offsets.0),
            side(held_out, &self.offsets.1),
        )
    }

    /// Converts the times of a diagnosis back to the recordings' own clocks.
    pub fn undo(&self, diagnosis: &mut Diagnosis) {
        let late: Vec<f64> = self
            .offsets
            .0
            .iter()
            .chain(&self.offsets.1)
            .copied()
            .collect();
        // One strip per recording, the fitted ones first.
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

fn shifted(recording: &Recording, by: f64) -> Recording {
    let mut out = recording.clone();
    out.time.iter_mut().for_each(|t| *t += by);
    out
}

/// Whether the amplitudes, with their errors, may be those of one vibration.
fn amplitudes_agree(sizes: &[(f64, f64)]) -> bool {
    let weights = sizes.iter().map(|(size, error)| (size, error.powi(-2)));
    let (sum, weight) = weights.fold((0.0, 0.0), |(s, w), (size, own)| (s + own * size, w + own));
    let mean = sum / weight;
    let seen = sizes.iter().filter(|s| s.0 > AMPLITUDE_MIN_Z * s.1).count();
    let near = |s: &(f64, f64)| {
        (s.0 - mean).abs() < AMPLITUDE_MAX_SPREAD.0 * mean + AMPLITUDE_MAX_SPREAD.1 * s.1
    };
    seen >= 2 && sizes.iter().all(near)
}

/// The frequency with the largest gain under separate phases \[Hz\].
fn frequency(
    linear: &Linearized<'_>,
    fitted: &Fitted,
    spec: &'static EffectSpec,
) -> Result<Option<f64>, SimError> {
    let Some(comb) = FrequencyComb::new(linear, &fitted.model, spec)? else {
        return Ok(None);
    };
    let spans = fitted.problem.data.iter().map(|d| d.recording.span());
    let longest = spans.map(|(begin, end)| end - begin).fold(1e-3, f64::max);
    let gain = |at: (usize, f64)| -> f64 {
        let all = gram_per_recording(linear, &comb.products, FrequencyComb::sine_index(at), at.1)
            .into_iter();
        all.filter_map(|own| Some(own.solve(&comb.base)?.1)).sum()
    };
    let (all, mut reach) = comb.frequencies(longest);
    let gains: Vec<((usize, f64), f64)> = all.into_par_iter().map(|at| (at, gain(at))).collect();
    let best = gains.into_iter().filter(|g| g.1.is_finite());
    let Some((mut at, mut most)) = best.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Ok(None);
    };
    for _ in 0..FREQUENCY_HALVINGS {
        let beside = [at.1 - reach, at.1 + reach].map(|shift| (shift, gain((at.0, shift))));
        match beside.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((shift, gain)) if gain > most => (at.1, most) = (shift, gain),
            _ => reach *= 0.5,
        }
    }
    Ok(Some(comb.frequency(at)))
}

/// Products of each recording with a sine and a cosine; see [`PhaseShiftedGram::add`].
fn gram_per_recording(
    linear: &Linearized<'_>,
    products: &[SegmentGram],
    which: usize,
    shift: f64,
) -> Vec<PhaseShiftedGram> {
    let (problem, segments) = (linear.problem(), &linear.point().segments);
    let own = |_| PhaseShiftedGram::new(problem.unknowns());
    let mut out: Vec<PhaseShiftedGram> = problem.data.iter().map(own).collect();
    for p in products {
        out[segments[p.segment].recording].add(p, which, shift);
    }
    out
}

/// The vibrations of a split with its first `locked` unknowns fixed; `None` where they are not
/// determined.
fn recording_vibrations(
    linear: &Linearized<'_>,
    fitted: &Fitted,
    (spec, frequency): (&'static EffectSpec, f64),
    locked: usize,
) -> Result<Option<RecordingVibrations>, SimError> {
    let products = linear.segment_grams(&fitted.model, &sine_and_cosine(spec, frequency))?;
    let Some(base) = ScoreScan::assemble(linear, &products, 2).projector_with_locked(locked) else {
        return Ok(None);
    };
    let each = gram_per_recording(linear, &products, 0, 0.0);
    let m = 2 * each.len();
    let cross = |i: usize| &each[i / 2].cross[i % 2];
    let normal = DMatrix::from_fn(m, m, |i, j| {
        let own = if i / 2 == j / 2 {
            each[i / 2].gram[(i % 2, j % 2)]
        } else {
            0.0
        };
        own - base.inner(cross(i), cross(j))
    });
    let slope = DVector::from_fn(m, |i, _| base.slope(cross(i), each[i / 2].slope[i % 2]));
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
        PROBE_ACCELERATION * (0.5 * variance).sqrt()
    };
    Ok(Some(RecordingVibrations {
        parts: (0..each.len())
            .map(|k| PROBE_ACCELERATION * Vector2::new(solved[2 * k], solved[2 * k + 1]))
            .collect(),
        errors: (0..each.len()).map(error).collect(),
        gains: (gain, of_all),
    }))
}

#[cfg(test)]
mod tests {
    use super::super::vibration_clock::*;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::model::effects::ActiveEffect;
    use crate::model::effects::find;
    use crate::model::preset::Preset;
    use crate::model::with_effect;

    #[test]
    fn amplitudes_of_one_vibration_agree() {
        let shaken = [(9.6, 0.1), (9.7, 0.2), (9.5, 0.05), (8.0, 0.6)];
        assert!(amplitudes_agree(&shaken));
        // What follows the drive is larger where that is.
        assert!(!amplitudes_agree(&[
            (9.6, 0.1),
            (4.7, 0.2),
            (0.5, 0.05),
            (8.0, 0.6)
        ]));
        // One recording that shows it proves nothing of phases.
        assert!(!amplitudes_agree(&[(9.6, 0.1), (9.0, 4.0), (8.0, 6.0)]));
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
            test_support::parts_of(&model, &[drive], 25e3, 20e-9)
        };
        both.flat_map(one).collect()
    }

    fn clocks_of(parts: &[Part]) -> Option<VibrationClock> {
        let model = Preset::embedded("paper").unwrap().model;
        let fitted = test_support::workspace(parts)
            .baseline(&model, &QUIET)
            .unwrap();
        VibrationClock::of(&fitted, None).unwrap()
    }

    #[test]
    fn recordings_are_shifted_to_the_clock_of_the_vibration() {
        let parts = shaken_in(&[0.4, 2.2]);
        let clocks = clocks_of(&parts).unwrap();
        let late = (2.2 - 0.4) / (TAU * 137.0);
        assert_eq!(clocks.offsets.0[0], 0.0);
        assert!(
            (clocks.offsets.0[1] - late).abs() < 2e-5,
            "{clocks:?} {late}"
        );
        let (moved, _) = clocks.shift_recordings(&parts, &[]);
        let first = |part: &Part| part.recording.time[0];
        assert!((first(&moved[1]) - first(&parts[1]) - late).abs() < 2e-5);
        // By that clock there is one phase.
        assert_eq!(clocks_of(&moved), None);
    }

    #[test]
    fn one_phase_for_all_needs_no_other_clock() {
        assert_eq!(clocks_of(&shaken_in(&[0.4, 0.4])), None);
    }
}
