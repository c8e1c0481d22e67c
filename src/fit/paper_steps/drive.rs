//! Step 1, drive (fig. 3): the two polynomial branches of `gc(V)` from a quasi-static
//! cycle of the voltage.
//!
//! In slow motion `xp` is the static answer to `eta gc(V)`. The recording is cut into
//! blocks of one period of the first mode, over which its ring averages out; blocks in
//! contact, across a turn of the voltage, or in which the voltage moves too far are left
//! out. Each branch is then a least-squares polynomial with a robust loss, of the paper's
//! order: second where the voltage falls, third where it rises, eq (9).

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::StepError;
use crate::fit::contact_readings::check_readable;
use crate::fit::error::FitError;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::thresholds::{
    BRANCH_HUBER_THRESHOLD, MAX_BLOCK_VOLTAGE_SHARE, MIN_BRANCH_COVERAGE, RING_DECAY_TIMES,
};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::piezo::{Branch, Piezo};
use crate::model::structure::Structure;
use crate::model::unit::counted;
use crate::recording::Recording;
use crate::recording::features::{FeatureOptions, recording_features};
use crate::recording::measured_drive::MeasuredDrive;

/// Orders of the polynomials, eq (9).
const BRANCH_POLYNOMIAL_ORDERS: [usize; 2] = [3, 2];
/// What to record instead.
const SLOW_CYCLE_REMEDY: &str = "also record whole slow cycles of the voltage, for example a 5 Hz sine so small that the mass hardly touches the ground";

/// A point of the figure: one block.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DrivePoint {
    /// Time of its middle \[s\].
    pub time: f64,
    /// Mean voltage \[V\].
    pub voltage: f64,
    /// `gc` that the mean displacement stands for.
    pub gain: f64,
    /// Rising or falling.
    pub branch: Branch,
}

/// One branch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BranchFit {
    /// Coefficients in rising powers of V, zero beyond the order.
    pub coefficients: [f64; 4],
    /// Their standard errors.
    pub errors: [f64; 4],
    /// Voltages between which it was seen \[V\].
    pub seen: (f64, f64),
    /// Root mean square of what the polynomial leaves, in units of `gc`.
    pub scatter: f64,
    /// Blocks used.
    pub blocks: usize,
}

/// Both branches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DriveFit {
    /// For V' > 0.
    pub rising: BranchFit,
    /// For V' < 0.
    pub falling: BranchFit,
    /// What the branches were fitted to.
    pub points: Vec<DrivePoint>,
    /// Lowest and highest voltage seen on both branches \[V\], and the gaps between them
    /// there, rising less falling, in units of `gc`: a closed loop has none.
    pub open_ends: [(f64, f64); 2],
}

impl DriveFit {
    /// The branches as a device's drive.
    pub fn piezo(&self) -> Piezo {
        Piezo {
            rising: self.rising.coefficients,
            falling: self.falling.coefficients,
        }
    }
}

/// Fits both branches to recordings of `model`; the paper used one that reaches +-8 V and one that
/// just avoids contact. `eta` and the structure are held: the branches are in units of `eta`, and
/// include the offset of the readings.
///
/// # Errors
/// [`StepError`] if a recording has no voltage, or all together show too little of a slow
/// cycle.
pub fn fit_drive(model: &Model, recordings: &[Arc<Recording>]) -> Result<DriveFit, StepError> {
    let options = FitOptions::for_model(model);
    fit_drive_to(model, recordings, |recording| {
        let part = [Part::whole(Arc::clone(recording))];
        check_readable(model, &part, &summarize(model, &part), &options)
    })
}

/// [`fit_drive`] to recordings that `check` does not refuse.
///
/// # Errors
/// As [`fit_drive`].
pub(super) fn fit_drive_to(
    model: &Model,
    recordings: &[Arc<Recording>],
    check: impl Fn(&Arc<Recording>) -> Result<(), FitError>,
) -> Result<DriveFit, StepError> {
    let per_gain = gain_scale(model)?;
    if recordings.is_empty() {
        return Err(FitError::NoRecording.into());
    }
    let mut points = Vec::new();
    let (mut low, mut high) = (f64::NAN, f64::NAN);
    for recording in recordings {
        let Some(drive) = recording.own_drive() else {
            return Err(StepError::Channel {
                recording: recording.name.clone(),
                channel: "V",
                step: "the drive",
            });
        };
        check(recording)?;
        let drive = drive.map_err(|error| unsuited(recording, error.to_string()))?;
        points.extend(blocks(model, recording, &drive, per_gain)?);
        low = low.min(extreme(&recording.voltage, f64::min));
        high = high.max(extreme(&recording.voltage, f64::max));
    }
    let branch = |branch: Branch, order: usize| {
        let own: Vec<DrivePoint> = points
            .iter()
            .filter(|p| p.branch == branch)
            .copied()
            .collect();
        fit_branch(&own, order, high - low).ok_or_else(|| {
            let name = if branch == Branch::Rising {
                "rising"
            } else {
                "falling"
            };
            let (from, to) = range(&own);
            let seen = if own.is_empty() {
                String::new()
            } else {
                format!(", from {from:.1} to {to:.1} V")
            };
            let least = 2 * (order + 1);
            let needed = if own.len() < least {
                format!("{least} or more are needed")
            } else {
                format!(
                    "they cover {:.0} % of the {:.1} V that the drive moves, {:.0} % are needed",
                    100.0 * (to - from) / (high - low),
                    high - low,
                    100.0 * MIN_BRANCH_COVERAGE
                )
            };
            StepError::Unsuited {
                recording: names(recordings),
                reason: format!(
                    "{} of slow free motion on the {name} branch{seen}; {needed}",
                    counted(own.len(), "block"),
                ),
                remedy: SLOW_CYCLE_REMEDY,
            }
        })
    };
    let rising = branch(Branch::Rising, BRANCH_POLYNOMIAL_ORDERS[0])?;
    let falling = branch(Branch::Falling, BRANCH_POLYNOMIAL_ORDERS[1])?;
    let open = |v: f64| {
        let gap = value(&rising.coefficients, v) - value(&falling.coefficients, v);
        (v, gap)
    };
    Ok(DriveFit {
        open_ends: [
            open(rising.seen.0.max(falling.seen.0)),
            open(rising.seen.1.min(falling.seen.1)),
        ],
        rising,
        falling,
        points,
    })
}

/// Lowest and highest voltage of some points \[V\].
fn range(points: &[DrivePoint]) -> (f64, f64) {
    let all = points.iter().map(|p| p.voltage);
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    })
}

fn names(recordings: &[Arc<Recording>]) -> String {
    let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
    names.join(", ")
}

/// Static displacement of the proof mass per unit of `gc` \[m\].
fn gain_scale(model: &Model) -> Result<f64, StepError> {
    let lacks = |what| StepError::Device {
        device: model.name.clone(),
        what,
        step: "the drive",
    };
    if model.piezo.is_none() {
        return Err(lacks("drive"));
    }
    let gain = model
        .structure()
        .static_gain()
        .ok_or_else(|| lacks("spring"))?;
    Ok(gain * model.parameters[ParameterId::Eta])
}

fn extreme(values: &Option<Vec<f64>>, pick: fn(f64, f64) -> f64) -> f64 {
    let finite = values.iter().flatten().copied().filter(|v| v.is_finite());
    finite.fold(f64::NAN, pick)
}

fn unsuited(recording: &Recording, reason: String) -> StepError {
    StepError::Unsuited {
        recording: recording.name.clone(),
        reason,
        remedy: SLOW_CYCLE_REMEDY,
    }
}

/// The blocks that are slow, free and on one branch, under the drive.
fn blocks(
    model: &Model,
    recording: &Recording,
    drive: &MeasuredDrive,
    per_gain: f64,
) -> Result<Vec<DrivePoint>, StepError> {
    let span = extreme(&recording.voltage, f64::max) - extreme(&recording.voltage, f64::min);
    let piece_at = |t: f64| drive.pieces.partition_point(|p| p.end <= t);
    let structure = model.structure();
    let slowest = structure
        .modes
        .iter()
        .filter(|mode| mode.frequency > 0.0)
        .min_by(|a, b| a.frequency.total_cmp(&b.frequency))
        .copied()
        .ok_or_else(|| unsuited(recording, "the device has no vibration mode".to_owned()))?;
    let length = 1.0 / slowest.frequency;
    let lag = static_lag(&structure);
    let settle = RING_DECAY_TIMES / (0.5 * slowest.damping()).max(1e-3 * slowest.omega());
    let features = recording_features(recording, &FeatureOptions::default());
    let contacts = &features.events.contacts;

    let mut found = Vec::new();
    // The time before the recording is unknown.
    let mut quiet_since = recording.time.first().copied().unwrap_or(0.0);
    let mut contact = 0;
    let mut from = 0;
    while from < recording.len() {
        let start = recording.time[from];
        let to = recording.time.partition_point(|&t| t < start + length);
        let end = recording.time.get(to).copied().unwrap_or(start + length);
        let here = from..to;
        from = to.max(from + 1);
        while contacts.get(contact).is_some_and(|c| c.end < start) {
            contact += 1;
        }
        if let Some(touch) = contacts.get(contact).filter(|c| c.start <= end) {
            quiet_since = quiet_since.max(touch.end);
            continue;
        }
        let (first, last) = (piece_at(start), piece_at(end));
        let branch = drive.pieces[first].branch;
        let voltage_moves = drive_range(recording, here.clone());
        let turned = drive.pieces[first..=last]
            .iter()
            .any(|p| p.branch != branch);
        if turned || voltage_moves.is_nan() || voltage_moves > MAX_BLOCK_VOLTAGE_SHARE * span {
            quiet_since = end;
            continue;
        }
        if start < quiet_since + settle {
            continue;
        }
        let mean = |values: &[f64]| {
            let (sum, count) = values[here.clone()]
                .iter()
                .filter(|v| v.is_finite())
                .fold((0.0, 0usize), |(s, n), v| (s + v, n + 1));
            (2 * count > here.len()).then(|| sum / count as f64)
        };
        let voltage = recording.voltage.as_deref().and_then(mean);
        if let (Some(voltage), Some(xp)) = (voltage, mean(&recording.proof_mass)) {
            let rate = voltage_moves / (end - start);
            let falls = branch == Branch::Falling;
            found.push(DrivePoint {
                time: 0.5 * (start + end),
                // The displacement now follows the voltage one damping time ago.
                voltage: voltage + if falls { lag * rate } else { -lag * rate },
                gain: xp / per_gain,
                branch,
            });
        }
    }
    Ok(found)
}

/// By how much slow motion of the proof mass is behind the drive \[s\]: each mode by its
/// `2 zeta / w`, weighted by its share of the static displacement.
fn static_lag(structure: &Structure) -> f64 {
    let (mut behind, mut whole) = (0.0, 0.0);
    for mode in structure.modes.iter().filter(|m| m.frequency > 0.0) {
        let share = mode.phi_drive * mode.phi_p / mode.omega().powi(2);
        whole += share;
        behind += share * mode.damping() / mode.omega().powi(2);
    }
    behind / whole
}

/// How far the voltage moves within a block \[V\].
fn drive_range(recording: &Recording, block: std::ops::Range<usize>) -> f64 {
    let volts = recording.voltage.as_deref().unwrap_or_default();
    let finite = volts[block].iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::NAN, f64::NAN), |(l, h), v| (l.min(v), h.max(v)));
    high - low
}

fn value(c: &[f64; 4], v: f64) -> f64 {
    c[0] + v * (c[1] + v * (c[2] + v * c[3]))
}

/// A robust polynomial; `None` if the branch covers too little for its order.
fn fit_branch(points: &[DrivePoint], order: usize, span: f64) -> Option<BranchFit> {
    let count = order + 1;
    let (low, high) = range(points);
    if points.len() < 2 * count || high - low < MIN_BRANCH_COVERAGE * span {
        return None;
    }
    // Powers of the voltage over its span are about equally large.
    let unit = 0.5 * span;
    let design = DMatrix::from_fn(points.len(), count, |i, j| {
        (points[i].voltage / unit).powi(j as i32)
    });
    let gains = DVector::from_iterator(points.len(), points.iter().map(|p| p.gain));
    let mut weights = DVector::from_element(points.len(), 1.0);
    let mut solution = DVector::zeros(count);
    let mut covariance = DMatrix::zeros(count, count);
    for _ in 0..20 {
        let weighted = DMatrix::from_fn(points.len(), count, |i, j| weights[i] * design[(i, j)]);
        let normal = design.transpose() * &weighted;
        covariance = normal.try_inverse()?;
        solution = &covariance * weighted.transpose() * &gains;
        let residual = &gains - &design * &solution;
        let mut sizes: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        // From the median of absolute values to the standard deviation of a normal distribution.
        let scatter = 1.4826 * sizes[sizes.len() / 2];
        let limit = BRANCH_HUBER_THRESHOLD * scatter.max(1e-12);
        weights = residual.map(|r| (limit / r.abs().max(1e-300)).min(1.0));
    }
    let residual = &gains - &design * &solution;
    let freedom = (points.len() - count) as f64;
    let variance = residual
        .iter()
        .zip(weights.iter())
        .map(|(r, w)| w * r * r)
        .sum::<f64>()
        / freedom;
    let mut fit = BranchFit {
        coefficients: [0.0; 4],
        errors: [0.0; 4],
        seen: (low, high),
        scatter: variance.sqrt(),
        blocks: points.len(),
    };
    for j in 0..count {
        let scale = unit.powi(j as i32);
        fit.coefficients[j] = solution[j] / scale;
        fit.errors[j] = (variance * covariance[(j, j)]).sqrt() / scale;
    }
    Some(fit)
}

#[cfg(test)]
#[path = "drive_tests.rs"]
mod tests;
