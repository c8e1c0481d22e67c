//! View 3: a further mode shows as a narrow hump in the spectrum of what is left.

use std::f64::consts::TAU;

use nalgebra::{Complex, Matrix2, SymmetricEigen};
use rayon::prelude::*;

use super::bench::Fitted;
use crate::fit::chain::Row;
use crate::sim::{SimError, Stretcher};

/// Spacing of the frequencies looked at \[Hz\].
const SPACING: f64 = 100.0;
/// Lowest frequency \[Hz\]: a slower one would not ring within a stretch.
const LOWEST: f64 = 1500.0;
/// Significance of a hump from which it stands out.
pub const HUMP: f64 = 6.0;
/// Frequencies nearer than by this factor to that of a mode are beside it.
const BESIDE: f64 = 1.25;
/// Stretches shorter than this many samples tell no frequency.
const LEAST: usize = 40;

/// A hump in the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Unit vector of proof mass and cantilever: how they share in it.
    pub shape: (f64, f64),
    /// Power above the noise, in units of what chance leaves.
    pub significance: f64,
    /// Roughly the fall of chi2 if it were taken out.
    pub gain: f64,
}

/// The highest hump in the residuals of a fit, if there is any spectrum to speak of.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn find(fitted: &Fitted) -> Result<Option<Ring>, SimError> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&simulator, &point.segments);
    let Some(rate) = problem
        .data
        .iter()
        .map(|d| d.recording.sampling_rate())
        .reduce(f64::min)
    else {
        return Ok(None);
    };
    let count = ((0.48 * rate - LOWEST) / SPACING).floor();
    if count < 5.0 {
        return Ok(None);
    }
    let frequencies: Vec<f64> = (0..count as usize)
        .map(|k| LOWEST + k as f64 * SPACING)
        .collect();
    let spectra: Vec<Vec<[Complex<f64>; 2]>> = point
        .segments
        .par_iter()
        .enumerate()
        .filter(|(i, s)| point.used[*i] && s.samples.len() >= LEAST && !s.starts_held)
        .filter_map(|(i, segment)| {
            let mut stretcher = Stretcher::new(&simulator);
            let nuisances = problem.nuisances_of(&point.x, segment.recording);
            let mut r = Vec::new();
            let locals = &segment.locals;
            let z = &states[i];
            if !problem.evaluate(segment, z, &mut stretcher, &nuisances, locals, &mut r) {
                return None;
            }
            let rows = problem.rows(segment);
            let of = |kind: Row| -> Vec<f64> {
                let own = rows.iter().zip(&r).filter(|(row, _)| **row == kind);
                own.map(|(_, r)| r.clamp(-5.0, 5.0)).collect()
            };
            let channels = [of(Row::ProofMass), of(Row::Cantilever)];
            let interval = segment.interval;
            let at = |f: f64| {
                channels.each_ref().map(|values| {
                    let turn = Complex::from_polar(1.0, -TAU * f * interval);
                    let mut phase = Complex::new(1.0, 0.0);
                    let mut sum = Complex::new(0.0, 0.0);
                    for v in values {
                        sum += phase * *v;
                        phase *= turn;
                    }
                    sum / (values.len().max(1) as f64).sqrt()
                })
            };
            Some(frequencies.iter().map(|&f| at(f)).collect())
        })
        .collect();
    if spectra.len() < 5 {
        return Ok(None);
    }
    let n = spectra.len() as f64;
    let both = point
        .segments
        .first()
        .is_some_and(|s| problem.data[s.recording].recording.cantilever.is_some());
    // Largest share of the power that one direction of the two readings holds.
    let power: Vec<(f64, (f64, f64))> = (0..frequencies.len())
        .map(|k| {
            let mut m = Matrix2::zeros();
            for s in &spectra {
                let [p, c] = s[k];
                m[(0, 0)] += p.norm_sqr() / n;
                m[(1, 1)] += c.norm_sqr() / n;
                m[(0, 1)] += (p * c.conj()).re / n;
            }
            m[(1, 0)] = m[(0, 1)];
            if !both {
                return (m[(0, 0)], (1.0, 0.0));
            }
            let eigen = SymmetricEigen::new(m);
            let top = eigen.eigenvalues.imax();
            let v = eigen.eigenvectors.column(top);
            (eigen.eigenvalues[top], (v[0], v[1]))
        })
        .collect();
    let mut sorted: Vec<f64> = power.iter().map(|p| p.0).collect();
    let usual = crate::recording::quantile_in_place(&mut sorted, 0.5);
    let spread = usual / n.sqrt();
    // What is left beside a mode that the model has is that mode's rather than
    // another's, unless nothing else stands out.
    let structure = fitted.model.structure();
    let beside = |f: f64| {
        let known = structure.modes.iter().map(|m| m.frequency);
        known
            .filter(|known| *known > 0.0)
            .any(|known| f < BESIDE * known && known < BESIDE * f)
    };
    let highest = |which: &dyn Fn(f64) -> bool| {
        power
            .iter()
            .zip(&frequencies)
            .filter(|(_, f)| which(**f))
            .max_by(|a, b| a.0.0.total_cmp(&b.0.0))
            .map(|((p, shape), f)| Ring {
                frequency: *f,
                shape: *shape,
                significance: (p - usual) / spread,
                gain: (p - usual) * n,
            })
    };
    let elsewhere = highest(&|f| !beside(f)).filter(|r| r.significance > HUMP);
    let ring = elsewhere.or_else(|| highest(&|_| true));
    Ok(ring.filter(|r| r.gain.is_finite()))
}
