//! Vibrations of the base in the linearised problem. Some frequencies are simulated; between them
//! the phase is shifted segment by segment.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{DVector, Matrix2, Vector2};
use rayon::prelude::*;

use crate::diagnose::score_test::linearized::{Linearized, SegmentGram};
use crate::diagnose::score_test::scan::{NuisanceProjector, ScoreScan};
use crate::diagnose::thresholds::UNIDENTIFIABLE_SHARE;
use crate::model::Model;
use crate::model::effects::{ActiveEffect, EffectSpec};
use crate::sim::SimError;

/// Range of the frequencies \[Hz\].
const FREQUENCY_RANGE: (f64, f64) = (8.0, 2100.0);
/// Spacing of the simulated frequencies \[Hz\].
const SIMULATED_SPACING: f64 = 100.0;
/// Amplitude of the simulated vibrations \[m/s^2\].
pub const PROBE_ACCELERATION: f64 = 0.05;
/// Spacing of all frequencies, in turns over the time that a phase is followed.
const PHASE_STEP_TURNS: f64 = 0.2;
/// Most frequencies between two simulated ones, on either side.
const MAX_PHASE_STEPS: f64 = 2000.0;

/// A vibration of the base, and its gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VibrationLine {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Amplitude \[m/s^2\].
    pub amplitude: f64,
    /// Phase at t = 0 \[rad\].
    pub phase: f64,
    /// Fall of chi2.
    pub gain: f64,
}

/// A sine and a cosine of `f` \[Hz\] by `spec`, the vibration of the base, both of amplitude
/// [`PROBE_ACCELERATION`].
pub fn sine_and_cosine(spec: &'static EffectSpec, f: f64) -> [ActiveEffect; 2] {
    [0.0, FRAC_PI_2].map(|phase| ActiveEffect {
        spec,
        values: vec![PROBE_ACCELERATION, f, phase],
    })
}

/// Products of some segments with a sine and a cosine.
pub struct PhaseShiftedGram {
    /// With the baseline's own directions.
    pub cross: [DVector<f64>; 2],
    /// Products of the two with each other.
    pub gram: Matrix2<f64>,
    /// Products of the two with the residuals.
    pub slope: Vector2<f64>,
}

impl PhaseShiftedGram {
    /// Of no segment yet, with `unknowns` of the baseline.
    pub fn new(unknowns: usize) -> Self {
        Self {
            cross: [DVector::zeros(unknowns), DVector::zeros(unknowns)],
            gram: Matrix2::zeros(),
            slope: Vector2::zeros(),
        }
    }

    /// Adds a segment, its sine number `which` and the cosine after it shifted to a frequency
    /// higher by `shift` \[Hz\].
    pub fn add(&mut self, p: &SegmentGram, which: usize, shift: f64) {
        let (sin, cos) = (TAU * shift * p.middle).sin_cos();
        // sin(w t + turn) and cos(w t + turn) from sin and cos.
        let turn = Matrix2::new(cos, sin, -sin, cos);
        self.gram += turn * p.gram.fixed_view::<2, 2>(which, which) * turn.transpose();
        self.slope += turn * p.slope.fixed_view::<2, 1>(which, 0);
        for (i, &ci) in p.columns.iter().enumerate() {
            let own = Vector2::new(p.cross[(i, which)], p.cross[(i, which + 1)]);
            let turned = turn * own;
            self.cross[0][ci] += turned[0];
            self.cross[1][ci] += turned[1];
        }
    }

    /// Steps along the two, in units of [`PROBE_ACCELERATION`], and the fall of chi2; `None`
    /// if they are not determined.
    pub fn solve(&self, base: &NuisanceProjector) -> Option<(Vector2<f64>, f64)> {
        let mut left = self.gram;
        for i in 0..2 {
            for j in 0..2 {
                left[(i, j)] -= base.inner(&self.cross[i], &self.cross[j]);
            }
        }
        let reduced = Vector2::new(
            base.slope(&self.cross[0], self.slope[0]),
            base.slope(&self.cross[1], self.slope[1]),
        );
        // Guards the division where re-tuning can imitate the line.
        let floor = UNIDENTIFIABLE_SHARE * self.gram.trace();
        let solved = (left + Matrix2::identity() * floor).try_inverse()? * reduced;
        Some((solved, reduced.dot(&solved)))
    }
}

/// The simulated frequencies, with their products.
pub struct FrequencyComb {
    coarse: Vec<f64>,
    /// Half the spacing \[Hz\].
    half: f64,
    /// Products of all segments.
    pub products: Vec<SegmentGram>,
    /// The baseline's own directions.
    pub base: NuisanceProjector,
}

impl FrequencyComb {
    /// The comb of frequencies that the recordings can show; `None` if they can show none.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub fn new(
        linear: &Linearized<'_>,
        model: &Model,
        spec: &'static EffectSpec,
    ) -> Result<Option<Self>, SimError> {
        // A recording does not show frequencies above half its sampling rate.
        let data = linear.problem().data.iter();
        let rate = data.map(|d| d.recording.sampling_rate());
        let low = FREQUENCY_RANGE.0;
        let high = FREQUENCY_RANGE
            .1
            .min(0.4 * rate.fold(f64::INFINITY, f64::min));
        if high <= 2.0 * low {
            return Ok(None);
        }
        let count = ((high - low) / SIMULATED_SPACING).ceil().max(1.0) as usize;
        let coarse: Vec<f64> = (0..count)
            .map(|i| low + (i as f64 + 0.5) * (high - low) / count as f64)
            .collect();
        let effects: Vec<ActiveEffect> = coarse
            .iter()
            .flat_map(|&f| sine_and_cosine(spec, f))
            .collect();
        let products = linear.segment_grams(model, &effects)?;
        let base = ScoreScan::assemble(linear, &products, effects.len()).nuisance_projector();
        Ok(base.map(|base| Self {
            coarse,
            half: 0.5 * (high - low) / count as f64,
            products,
            base,
        }))
    }

    /// Frequencies that can be distinguished where the phase is followed for `span` \[s\],
    /// each as the index of a simulated one and its offset from that \[Hz\], and their spacing
    /// \[Hz\].
    pub fn frequencies(&self, span: f64) -> (Vec<(usize, f64)>, f64) {
        let fine = PHASE_STEP_TURNS / span;
        let steps = (self.half / fine).ceil().min(MAX_PHASE_STEPS) as i64;
        let own = |c| (-steps..=steps).map(move |d| (c, self.half * d as f64 / steps as f64));
        let all = (0..self.coarse.len()).flat_map(own).collect();
        (all, self.half / steps as f64)
    }

    /// The frequency itself \[Hz\].
    pub fn frequency(&self, (coarse, shift): (usize, f64)) -> f64 {
        self.coarse[coarse] + shift
    }

    /// Index of its sine among the simulated directions.
    pub fn sine_index((coarse, _): (usize, f64)) -> usize {
        2 * coarse
    }
}

/// Searches for a vibration of the base by `spec` with one phase in all recordings.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn find_vibration(
    linear: &Linearized<'_>,
    model: &Model,
    spec: &'static EffectSpec,
) -> Result<Option<VibrationLine>, SimError> {
    let Some(comb) = FrequencyComb::new(linear, model, spec)? else {
        return Ok(None);
    };
    let unknowns = linear.problem().unknowns();
    let middles = comb.products.iter().map(|p| p.middle);
    let longest = middles.fold(0.0, f64::max).max(1e-3);
    let fit_line = |at: (usize, f64)| {
        let mut turned = PhaseShiftedGram::new(unknowns);
        for p in &comb.products {
            turned.add(p, FrequencyComb::sine_index(at), at.1);
        }
        let (solved, gain) = turned.solve(&comb.base)?;
        let (s, c) = (-solved[0], -solved[1]);
        Some(VibrationLine {
            frequency: comb.frequency(at),
            amplitude: PROBE_ACCELERATION * s.hypot(c),
            phase: c.atan2(s),
            gain,
        })
    };
    let all = comb.frequencies(longest).0.into_par_iter();
    let lines: Vec<VibrationLine> = all.filter_map(fit_line).collect();
    let finite = lines.into_iter().filter(|l| l.gain.is_finite());
    Ok(finite.max_by(|a, b| a.gain.total_cmp(&b.gain)))
}
