//! The proof: residuals along each recording by the baseline and with the named effects, and their
//! distances.

use crate::diagnose::comparison::trial::{ModelState, SelectionResult};
use crate::diagnose::diagnosis::{BeforeAfter, Distance, ProofOf, Regime, Strip};
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::discrepancy::residual_map::{Sample, sum_of_squares};
use crate::diagnose::findings::Remark;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::SET_ASIDE_REMARK_PERCENT;

/// Bins of a strip.
const STRIP_BINS: usize = 240;

/// Residuals of the proof mass with their times, broken where a segment ends.
fn residuals(samples: &[Sample]) -> Vec<[f64; 2]> {
    let mut out = Vec::with_capacity(samples.len());
    for (i, s) in samples.iter().enumerate() {
        if i > 0 && samples[i - 1].segment != s.segment {
            out.push([s.time, f64::NAN]);
        }
        out.push([s.time, s.miss_p]);
    }
    out
}

/// Residuals over time and distances of each recording of one side: `before` by the baseline as
/// fitted, `after` with the named effects.
fn strips(
    (fitted, before): (&Fitted, &[Sample]),
    after: &[Sample],
    held_out: bool,
) -> (Vec<Strip>, Vec<ProofOf>) {
    let mut strips = Vec::new();
    let mut proofs = Vec::new();
    for (k, data) in fitted.problem.data.iter().enumerate() {
        let r = &data.recording;
        let (begin, end) = r.span();
        let width = ((end - begin) / STRIP_BINS as f64).max(1e-12);
        let own = |samples: &[Sample]| -> Vec<Sample> {
            samples
                .iter()
                .filter(|s| s.recording == k)
                .copied()
                .collect()
        };
        let (b, a) = (own(before), own(after));
        let bins = |samples: &[Sample]| -> Vec<f64> {
            let mut sums = vec![(0.0, 0usize); STRIP_BINS];
            for s in samples.iter().filter(|s| s.miss_p.is_finite()) {
                let bin = &mut sums[(((s.time - begin) / width) as usize).min(STRIP_BINS - 1)];
                bin.0 += s.miss_p * s.miss_p;
                bin.1 += 1;
            }
            sums.into_iter()
                .map(|(sum, n)| {
                    if n > 0 {
                        (sum / n as f64).sqrt()
                    } else {
                        f64::NAN
                    }
                })
                .collect()
        };
        let mut xp = vec![(0.0, 0usize); STRIP_BINS];
        for (t, x) in r.time.iter().zip(&r.proof_mass).filter(|p| p.1.is_finite()) {
            let bin = &mut xp[(((t - begin) / width) as usize).min(STRIP_BINS - 1)];
            bin.0 += x;
            bin.1 += 1;
        }
        let mut regime = vec![Regime::Impact; STRIP_BINS];
        for s in &b {
            regime[(((s.time - begin) / width) as usize).min(STRIP_BINS - 1)] = s.regime;
        }
        strips.push(Strip {
            recording: r.name.clone(),
            held_out,
            time: (0..STRIP_BINS)
                .map(|i| begin + (i as f64 + 0.5) * width)
                .collect(),
            before: bins(&b),
            after: bins(&a),
            xp: xp
                .into_iter()
                .map(|(sum, n)| if n > 0 { sum / n as f64 } else { f64::NAN })
                .collect(),
            regime,
            samples_before: residuals(&b),
            samples_after: residuals(&a),
        });
        let correlation = |samples: &[Sample]| {
            let (mut product, mut square) = (0.0, 0.0);
            for pair in samples.windows(2).filter(|p| p[0].segment == p[1].segment) {
                if pair[0].white.0.is_finite() && pair[1].white.0.is_finite() {
                    product += pair[0].white.0 * pair[1].white.0;
                    square += pair[0].white.0 * pair[0].white.0;
                }
            }
            if square > 0.0 { product / square } else { 0.0 }
        };
        proofs.push(ProofOf {
            recording: r.name.clone(),
            held_out,
            noise: data.sigmas.xp,
            covered: b.len() as f64 / r.len().max(1) as f64,
            distance: BeforeAfter {
                before: distance_of(&b),
                after: distance_of(&a),
            },
            correlation: (correlation(&b), correlation(&a)),
        });
    }
    (strips, proofs)
}

/// Distance over the samples of a recording.
pub(super) fn distance_of(samples: &[Sample]) -> Distance {
    let (sum, n) = sum_of_squares(samples.iter().map(|s| s.miss_p));
    let white = samples.iter().flat_map(|s| [s.white.0, s.white.1]);
    let (square, m) = sum_of_squares(white);
    Distance {
        rms: (sum / n.max(1) as f64).sqrt(),
        chi2: square / m.max(1) as f64,
    }
}

/// The comparison of the baseline with the named effects, on the same segments.
pub struct Proof {
    /// The baseline.
    pub baseline: ModelState,
    /// With the named effects.
    pub state: ModelState,
    /// Samples of the baseline.
    pub before: SplitSamples,
    /// Samples with the named effects.
    pub after: SplitSamples,
}

impl Proof {
    /// Brings both to the same segments, also where one of them set some aside: see
    /// [`Workspace::on_common_segments`].
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub fn new(workspace: &Workspace, found: &SelectionResult) -> Result<Self, DiagnoseError> {
        let (mut baseline, mut state) = (found.baseline.clone(), found.state.clone());
        let train = [&found.baseline.train, &found.state.train];
        [baseline.train, state.train] = workspace.on_common_segments(&workspace.train, train)?;
        if let (Some(side), Some(a), Some(b)) = (
            &workspace.held_out,
            &found.baseline.held_out,
            &found.state.held_out,
        ) {
            let held_out = workspace.on_common_segments(side, [a, b])?;
            [baseline.held_out, state.held_out] = held_out.map(Some);
        }
        let (before, after) = (SplitSamples::look(&baseline)?, SplitSamples::look(&state)?);
        Ok(Self {
            baseline,
            state,
            before,
            after,
        })
    }

    /// How much of either side was set aside as misread, if that is much.
    pub fn misread(&self) -> Option<Remark> {
        let held_out = self
            .baseline
            .held_out
            .as_ref()
            .map_or(0.0, Fitted::set_aside_share);
        let (train, held_out) = (
            100.0 * self.baseline.train.set_aside_share(),
            100.0 * held_out,
        );
        (train.max(held_out) > SET_ASIDE_REMARK_PERCENT)
            .then_some(Remark::MisreadReadings { train, held_out })
    }

    /// Distances of the fitted recordings.
    pub fn of_train(&self) -> BeforeAfter {
        BeforeAfter {
            before: residual_map::distance(&self.baseline.train, &self.before.train),
            after: residual_map::distance(&self.state.train, &self.after.train),
        }
    }

    /// Distances of the held-out recordings; no numbers if there are none.
    pub fn of_held_out(&self) -> BeforeAfter {
        let none = Distance {
            rms: f64::NAN,
            chi2: f64::NAN,
        };
        let of = |state: &ModelState, samples: &[Sample]| {
            let fitted = state.held_out.as_ref();
            fitted.map_or(none, |f| residual_map::distance(f, samples))
        };
        BeforeAfter {
            before: of(&self.baseline, &self.before.held_out),
            after: of(&self.state, &self.after.held_out),
        }
    }

    /// Residuals over time and distances of each recording, fitted ones first.
    pub fn of_recordings(&self) -> (Vec<Strip>, Vec<ProofOf>) {
        let train = (&self.baseline.train, &self.before.train[..]);
        let (mut all, mut proofs) = strips(train, &self.after.train, false);
        if let Some(held) = &self.baseline.held_out {
            let held_out = (held, &self.before.held_out[..]);
            let (strips, own) = strips(held_out, &self.after.held_out, true);
            all.extend(strips);
            proofs.extend(own);
        }
        (all, proofs)
    }
}

/// Samples of both sides.
pub struct SplitSamples {
    /// Of the fitted recordings.
    pub train: Vec<Sample>,
    /// Of the held-out ones.
    pub held_out: Vec<Sample>,
}

impl SplitSamples {
    /// Of a model as fitted.
    ///
    /// # Errors
    /// [`DiagnoseError`] if its model cannot be simulated.
    pub fn look(state: &ModelState) -> Result<Self, DiagnoseError> {
        let held_out = match &state.held_out {
            Some(fitted) => residual_map::samples(fitted)?,
            None => Vec::new(),
        };
        Ok(Self {
            train: residual_map::samples(&state.train)?,
            held_out,
        })
    }
}
