//! Zero, scale and clock of a recording's readings, estimated against one run.

use nalgebra::{SMatrix, SVector};

use super::Experiment;
use crate::fit::options::FreeNuisances;
use crate::recording::align::Alignment;
use crate::sim::{Trace, TraceCursor};

/// Numbers that are estimated: clock, zero and scale of the proof mass, of the cantilever.
const COUNT: usize = 5;
/// Most Gauss-Newton steps.
const MAX_STEPS: usize = 6;
/// A change of the clock by less than this share of a sampling interval is the last.
const CONVERGED_INTERVALS: f64 = 1e-5;
/// Samples from which the instrument is estimated, evenly picked.
const MAX_SAMPLES: usize = 8000;
/// Prior standard deviations between which an estimate is kept.
const MAX_PRIOR_SIGMAS: f64 = 4.0;

/// What is known beforehand of a recording's instrument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentPriors {
    /// Whether the zero of each reading is unknown.
    pub zeros: bool,
    /// Standard deviation of each reading's scale around 1; `None` holds it.
    pub scale: Option<f64>,
    /// Standard deviation of the clock of the readings against that of the voltage \[s\]; `None`
    /// holds it.
    pub clock: Option<f64>,
    /// By how much more the drive may lie earlier or later, all times alike \[s\]: edges between
    /// samples.
    pub drive_reach: f64,
}

impl Default for InstrumentPriors {
    /// As for a fit: [`FreeNuisances::default`].
    fn default() -> Self {
        let shared = FreeNuisances::default();
        Self {
            zeros: shared.offsets,
            scale: shared.scales,
            clock: shared.skew,
            drive_reach: 0.0,
        }
    }
}

/// The alignment of an experiment's readings to `trace` that leaves least, within the priors.
#[must_use]
pub fn estimate_instrument(
    experiment: &Experiment,
    trace: &Trace,
    priors: &InstrumentPriors,
) -> Alignment {
    let start = experiment.alignment;
    let recording = &experiment.recording;
    let (sigma_p, sigma_c) = experiment.noise;
    let stride = recording.len().div_ceil(MAX_SAMPLES).max(1);
    let clock_sigma = priors.clock.unwrap_or(0.0);
    let reach = MAX_PRIOR_SIGMAS * clock_sigma + priors.drive_reach;
    let scale_sigma = priors.scale.unwrap_or(0.0);
    // Parameters: shift of the clock, then change of zero and factor of the scale of each reading.
    let mut p = SVector::<f64, COUNT>::zeros();
    let aligned = |p: &SVector<f64, COUNT>| Alignment {
        time_shift: start.time_shift + p[0],
        xp_offset: start.xp_offset + p[1],
        xp_scale: start.xp_scale * (1.0 + p[2]),
        xc_offset: start.xc_offset + p[3],
        xc_scale: start.xc_scale * (1.0 + p[4]),
        ..start
    };
    let cantilever = recording.cantilever.as_deref().zip(sigma_c);
    let held = [
        reach <= 0.0,
        !priors.zeros,
        scale_sigma <= 0.0,
        !priors.zeros || cantilever.is_none(),
        scale_sigma <= 0.0 || cantilever.is_none(),
    ];
    let weight = |sigma: f64| if sigma > 0.0 { sigma.powi(-2) } else { 1.0 };
    for _ in 0..MAX_STEPS {
        let alignment = aligned(&p);
        let mut normal = SMatrix::<f64, COUNT, COUNT>::zeros();
        let mut right = SVector::<f64, COUNT>::zeros();
        let mut cursor = TraceCursor::new(trace);
        for i in (0..recording.len()).step_by(stride) {
            let Some(reading) = cursor.at(alignment.time(recording.time[i])) else {
                continue;
            };
            let raw = recording.proof_mass[i];
            let off = reading.xp - alignment.xp_scale * raw - alignment.xp_offset;
            let row =
                SVector::<f64, COUNT>::from([reading.vp, -1.0, -start.xp_scale * raw, 0.0, 0.0]);
            add(&mut normal, &mut right, row, off, weight(sigma_p));
            if let Some((values, sigma)) = cantilever {
                let raw = values[i];
                let off = reading.xc - alignment.xc_scale * raw - alignment.xc_offset;
                let row = SVector::<f64, COUNT>::from([
                    reading.vc,
                    0.0,
                    0.0,
                    -1.0,
                    -start.xc_scale * raw,
                ]);
                add(&mut normal, &mut right, row, off, weight(sigma));
            }
        }
        // The thinned samples stand for all; the priors count once.
        let share = stride as f64;
        normal *= share;
        right *= share;
        for (k, sigma) in [
            (0, clock_sigma.max(priors.drive_reach)),
            (2, scale_sigma),
            (4, scale_sigma),
        ] {
            if sigma > 0.0 {
                normal[(k, k)] += sigma.powi(-2);
                right[k] -= p[k] * sigma.powi(-2);
            }
        }
        for k in (0..COUNT).filter(|&k| held[k]) {
            normal.row_mut(k).fill(0.0);
            normal.column_mut(k).fill(0.0);
            normal[(k, k)] = 1.0;
            right[k] = 0.0;
        }
        let Some(factor) = normal.cholesky() else {
            break;
        };
        let before = p;
        p += factor.solve(&right);
        p[0] = p[0].clamp(-reach, reach);
        for k in [2, 4] {
            let most = MAX_PRIOR_SIGMAS * scale_sigma;
            p[k] = p[k].clamp(-most, most);
        }
        if !p.iter().all(|v| v.is_finite()) {
            p = before;
            break;
        }
        if (p[0] - before[0]).abs() < CONVERGED_INTERVALS * recording.interval() {
            break;
        }
    }
    aligned(&p)
}

/// Adds a row `off + row . change -> 0` to the normal equations; rows with a number missing say
/// nothing.
fn add(
    normal: &mut SMatrix<f64, COUNT, COUNT>,
    right: &mut SVector<f64, COUNT>,
    row: SVector<f64, COUNT>,
    off: f64,
    weight: f64,
) {
    if !off.is_finite() || row.iter().any(|v| !v.is_finite()) {
        return;
    }
    *normal += row * row.transpose() * weight;
    *right -= row * (off * weight);
}
