//! Zero, scale and clock of a recording's readings, and what its drive leaves open, estimated
//! against runs.

use nalgebra::{DMatrix, DVector};

use super::Experiment;
use crate::fit::options::FreeNuisances;
use crate::recording::align::Alignment;
use crate::sim::{Reading, Trace, TraceCursor};

/// Numbers of the instrument: clock, zero and scale of the proof mass, of the cantilever.
const INSTRUMENT_COUNT: usize = 5;
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

/// How the readings change with a number that a run depends on.
#[derive(Debug, Clone, Copy)]
pub struct RunColumn<'a> {
    /// The run with the number changed by `step`.
    pub changed: &'a Trace,
    /// See `changed`.
    pub step: f64,
    /// Standard deviation of the number around 0.
    pub sigma: f64,
    /// Farthest from 0.
    pub most: f64,
    /// Its present value.
    pub value: f64,
    /// From when to when it is what makes `changed` differ \[s\], by the recording's clock: a run may
    /// have several numbers changed, far apart.
    pub window: (f64, f64),
}

/// The alignment of an experiment's readings to `trace` that leaves least, within the priors.
#[must_use]
pub fn estimate_instrument(
    experiment: &Experiment,
    trace: &Trace,
    priors: &InstrumentPriors,
) -> Alignment {
    estimate_with_runs(experiment, trace, priors, &[], 0.0).0
}

/// The same together with numbers that the run depends on: also their new values. Levenberg's and
/// Marquardt's `damping` keeps these near their present ones: 0 not at all, 1 halfway.
#[must_use]
pub fn estimate_with_runs(
    experiment: &Experiment,
    trace: &Trace,
    priors: &InstrumentPriors,
    columns: &[RunColumn<'_>],
    damping: f64,
) -> (Alignment, Vec<f64>) {
    let start = experiment.alignment;
    let bounds = Bounds::new(experiment, priors);
    let count = INSTRUMENT_COUNT + columns.len();
    let mut p = DVector::<f64>::zeros(count);
    for _ in 0..MAX_STEPS {
        let (mut normal, mut right) = normal_equations(experiment, trace, &p, columns);
        for (k, sigma) in bounds.sigmas.iter().enumerate() {
            if *sigma > 0.0 {
                normal[(k, k)] += sigma.powi(-2);
                right[k] -= p[k] * sigma.powi(-2);
            }
        }
        for (k, column) in columns.iter().enumerate() {
            let k = INSTRUMENT_COUNT + k;
            right[k] -= damping * normal[(k, k)] * p[k];
            normal[(k, k)] *= 1.0 + damping;
            let weight = column.sigma.max(1e-300).powi(-2);
            normal[(k, k)] += weight;
            right[k] -= (p[k] + column.value) * weight;
        }
        for k in (0..INSTRUMENT_COUNT).filter(|&k| bounds.held[k]) {
            normal.row_mut(k).fill(0.0);
            normal.column_mut(k).fill(0.0);
            normal[(k, k)] = 1.0;
            right[k] = 0.0;
        }
        let Some(change) = scaled_solution(normal, &right) else {
            break;
        };
        let before = p.clone();
        p += change;
        for k in 0..INSTRUMENT_COUNT {
            p[k] = p[k].clamp(-bounds.most[k], bounds.most[k]);
        }
        for (k, column) in columns.iter().enumerate() {
            let value = (p[INSTRUMENT_COUNT + k] + column.value).clamp(-column.most, column.most);
            p[INSTRUMENT_COUNT + k] = value - column.value;
        }
        if p.iter().any(|v| !v.is_finite()) {
            p = before;
            break;
        }
        if (p[0] - before[0]).abs() < CONVERGED_INTERVALS * experiment.recording.interval() {
            break;
        }
    }
    let values = columns
        .iter()
        .enumerate()
        .map(|(k, c)| c.value + p[INSTRUMENT_COUNT + k])
        .collect();
    (aligned(&start, &p), values)
}

/// What of the instrument is held, its priors and its limits.
struct Bounds {
    held: [bool; INSTRUMENT_COUNT],
    sigmas: [f64; INSTRUMENT_COUNT],
    most: [f64; INSTRUMENT_COUNT],
}

impl Bounds {
    fn new(experiment: &Experiment, priors: &InstrumentPriors) -> Self {
        let clock = priors.clock.unwrap_or(0.0);
        let reach = MAX_PRIOR_SIGMAS * clock + priors.drive_reach;
        let scale = priors.scale.unwrap_or(0.0);
        let both = experiment.recording.cantilever.is_some() && experiment.noise.1.is_some();
        let held = [
            reach <= 0.0,
            !priors.zeros,
            scale <= 0.0,
            !priors.zeros || !both,
            scale <= 0.0 || !both,
        ];
        let most_scale = MAX_PRIOR_SIGMAS * scale;
        Self {
            held,
            sigmas: [clock.max(priors.drive_reach), 0.0, scale, 0.0, scale],
            most: [reach, f64::INFINITY, most_scale, f64::INFINITY, most_scale],
        }
    }
}

fn aligned(start: &Alignment, p: &DVector<f64>) -> Alignment {
    Alignment {
        time_shift: start.time_shift + p[0],
        xp_offset: start.xp_offset + p[1],
        xp_scale: start.xp_scale * (1.0 + p[2]),
        xc_offset: start.xc_offset + p[3],
        xc_scale: start.xc_scale * (1.0 + p[4]),
        ..*start
    }
}

/// Normal equations of all samples' `simulation - reading` for a change of the numbers `p`.
fn normal_equations(
    experiment: &Experiment,
    trace: &Trace,
    p: &DVector<f64>,
    columns: &[RunColumn<'_>],
) -> (DMatrix<f64>, DVector<f64>) {
    let start = experiment.alignment;
    let alignment = aligned(&start, p);
    let recording = &experiment.recording;
    let stride = recording.len().div_ceil(MAX_SAMPLES).max(1);
    let weight = |sigma: f64| if sigma > 0.0 { sigma.powi(-2) } else { 1.0 };
    let (noise_p, noise_c) = experiment.aligned_noise(&start);
    let weight_p = weight(noise_p);
    let cantilever = recording.cantilever.as_deref().zip(noise_c);
    let count = p.len();
    let mut normal = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    let mut cursor = TraceCursor::new(trace);
    let mut others: Vec<TraceCursor<'_>> = columns
        .iter()
        .map(|c| TraceCursor::new(c.changed))
        .collect();
    let mut row = vec![0.0; count];
    let mut moved: Vec<Option<Option<Reading>>> = vec![None; columns.len()];
    for i in (0..recording.len()).step_by(stride) {
        let t = alignment.time(recording.time[i]);
        let Some(reading) = cursor.at(t) else {
            continue;
        };
        let open = columns.iter().map(|c| t >= c.window.0 && t < c.window.1);
        for ((slot, other), open) in moved.iter_mut().zip(&mut others).zip(open) {
            *slot = open.then(|| other.at(t));
        }
        let mut add = |row: &mut [f64], x: fn(&Reading) -> f64, measured: f64, weight: f64| {
            let mut off = x(&reading) - measured;
            for (k, (column, moved)) in columns.iter().zip(&moved).enumerate() {
                let change = match moved {
                    None => 0.0,
                    Some(moved) => moved.as_ref().map_or(f64::NAN, x) - x(&reading),
                };
                row[INSTRUMENT_COUNT + k] = change / column.step;
                off += row[INSTRUMENT_COUNT + k] * p[INSTRUMENT_COUNT + k];
            }
            if !off.is_finite() || row.iter().any(|v| !v.is_finite()) {
                return;
            }
            for a in 0..count {
                if row[a] == 0.0 {
                    continue;
                }
                right[a] -= row[a] * off * weight;
                for b in 0..=a {
                    normal[(a, b)] += row[a] * row[b] * weight;
                }
            }
        };
        let raw = recording.proof_mass[i];
        row[..INSTRUMENT_COUNT].copy_from_slice(&[
            reading.vp,
            -1.0,
            -start.xp_scale * raw,
            0.0,
            0.0,
        ]);
        let measured = alignment.xp_scale * raw + alignment.xp_offset;
        add(&mut row, |r| r.xp, measured, weight_p);
        if let Some((values, sigma)) = cantilever {
            let raw = values[i];
            row[..INSTRUMENT_COUNT].copy_from_slice(&[
                reading.vc,
                0.0,
                0.0,
                -1.0,
                -start.xc_scale * raw,
            ]);
            let measured = alignment.xc_scale * raw + alignment.xc_offset;
            add(&mut row, |r| r.xc, measured, weight(sigma));
        }
    }
    normal.fill_upper_triangle_with_lower_triangle();
    // The thinned samples stand for all; priors count once.
    (normal * stride as f64, right * stride as f64)
}

/// Solution of normal equations whose unknowns have very different units.
fn scaled_solution(mut normal: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = right.len();
    let scale: Vec<f64> = (0..n)
        .map(|k| normal[(k, k)].sqrt())
        .map(|s| if s > 0.0 { s } else { 1.0 })
        .collect();
    for a in 0..n {
        for b in 0..n {
            normal[(a, b)] /= scale[a] * scale[b];
        }
        // What nothing determines stays where it is.
        normal[(a, a)] += 1e-12;
    }
    let scaled = DVector::from_fn(n, |k, _| right[k] / scale[k]);
    let solution = normal.cholesky()?.solve(&scaled);
    Some(DVector::from_fn(n, |k, _| solution[k] / scale[k]))
}
