//! Residuals along each recording, before and after, and how far it is told.

use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::diagnosis::{BeforeAfter, Distance, ProofOf, Regime, Strip};
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::discrepancy::residual_map::{Sample, sum_of_squares};
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::Fitted;

/// Bins of a strip.
const BINS: usize = 240;

/// Residuals of the proof mass with their times, broken where a stretch ends.
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

/// Residuals over time of each recording of one side, and its proof: `before` at the
/// baseline's fit, `after` with the named effects.
pub fn strips(
    (fitted, before): (&Fitted, &[Sample]),
    after: &[Sample],
    held_out: bool,
) -> (Vec<Strip>, Vec<ProofOf>) {
    let mut strips = Vec::new();
    let mut proofs = Vec::new();
    for (k, data) in fitted.problem.data.iter().enumerate() {
        let r = &data.recording;
        let (begin, end) = r.span();
        let width = ((end - begin) / BINS as f64).max(1e-12);
        let own = |samples: &[Sample]| -> Vec<Sample> {
            samples
                .iter()
                .filter(|s| s.recording == k)
                .copied()
                .collect()
        };
        let (b, a) = (own(before), own(after));
        let bins = |samples: &[Sample]| -> Vec<f64> {
            let mut sums = vec![(0.0, 0usize); BINS];
            for s in samples.iter().filter(|s| s.miss_p.is_finite()) {
                let bin = &mut sums[(((s.time - begin) / width) as usize).min(BINS - 1)];
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
        let mut xp = vec![(0.0, 0usize); BINS];
        for (t, x) in r.time.iter().zip(&r.proof_mass).filter(|p| p.1.is_finite()) {
            let bin = &mut xp[(((t - begin) / width) as usize).min(BINS - 1)];
            bin.0 += x;
            bin.1 += 1;
        }
        let mut regime = vec![Regime::Impact; BINS];
        for s in &b {
            regime[(((s.time - begin) / width) as usize).min(BINS - 1)] = s.regime;
        }
        strips.push(Strip {
            recording: r.name.clone(),
            held_out,
            time: (0..BINS)
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
        let of = |samples: &[Sample]| {
            let (sum, n) = sum_of_squares(samples.iter().map(|s| s.miss_p));
            let white = samples.iter().flat_map(|s| [s.white.0, s.white.1]);
            let (square, m) = sum_of_squares(white);
            Distance {
                rms: (sum / n.max(1) as f64).sqrt(),
                chi2: square / m.max(1) as f64,
            }
        };
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
                before: of(&b),
                after: of(&a),
            },
            correlation: (correlation(&b), correlation(&a)),
        });
    }
    (strips, proofs)
}

/// Samples of both sides.
pub struct SplitSamples {
    /// Of the fitted recordings.
    pub train: Vec<Sample>,
    /// Of those kept out.
    pub held_out: Vec<Sample>,
}

impl SplitSamples {
    /// Looks at a stand.
    ///
    /// # Errors
    /// [`DiagnoseError`] if its model cannot be simulated.
    pub fn look(stand: &ModelState) -> Result<Self, DiagnoseError> {
        let held_out = match &stand.held_out {
            Some(fitted) => residual_map::samples(fitted)?,
            None => Vec::new(),
        };
        Ok(Self {
            train: residual_map::samples(&stand.train)?,
            held_out,
        })
    }
}
