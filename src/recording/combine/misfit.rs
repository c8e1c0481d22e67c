//! Which trials are no trials of the motion of the others.

use super::error::CombineError;
use super::overlay::{Overlay, compare_voltages, lay_over};
use crate::model::unit::format_quantity;
use crate::recording::Recording;
use crate::recording::statistics::median_in_place;

/// A trial that is this many times as far from the others as they are from each other is another
/// motion; bounces that scatter from trial to trial differ by less.
const MAX_DISTANCE_RATIO: f64 = 3.0;
/// Least distance of such a trial, as a share of what the trials move by: below it all are alike.
const MIN_DISTANCE_SHARE: f64 = 0.02;
/// Two trials that are farther apart than this share of their motion are two motions; which of them is
/// the right one nothing says.
const MAX_PAIR_SHARE: f64 = 0.5;
/// Most samples that distances are taken from.
const MAX_COMPARED: usize = 20_000;

/// Why a trial does not belong to the others.
#[derive(Debug, Clone, PartialEq)]
pub enum Misfit {
    /// Its voltage is another one.
    OtherDrive {
        /// Root mean square of the difference \[V\].
        rms: f64,
    },
    /// It fits at no shift in time.
    NoMatch(CombineError),
    /// Its motion is another one.
    OtherMotion {
        /// How far it is from the others, root mean square \[m\].
        distance: f64,
        /// How far the others are from each other \[m\]; 0 of two trials.
        usual: f64,
    },
}

impl Misfit {
    /// A clause that says it.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Misfit::OtherDrive { rms } => format!(
                "another drive, its voltage differs by {} rms",
                format_quantity(*rms, "V", 3)
            ),
            Misfit::NoMatch(CombineError::NoMatch { correlation, .. }) => {
                format!("no match at any shift in time, correlation {correlation:.2} at best")
            }
            Misfit::NoMatch(error) => error.to_string(),
            Misfit::OtherMotion { distance, usual } => {
                let distance = format_quantity(*distance, "m", 3);
                if *usual > 0.0 {
                    let usual = format_quantity(*usual, "m", 3);
                    format!(
                        "another motion, {distance} rms from the others, which are {usual} apart"
                    )
                } else {
                    format!("another motion, {distance} rms from the other trial")
                }
            }
        }
    }
}

/// One of the trials.
#[derive(Debug, Clone, PartialEq)]
pub struct AveragedTrial {
    /// Name of its recording.
    pub name: String,
    /// To be added to its times \[s\]; `None` where no lag was found.
    pub lag: Option<f64>,
    /// How far its zero lies above that of the average \[m\], if it is in it.
    pub zero: Option<f64>,
    /// Root mean square of what it differs from the average beyond that \[m\], if it is in it.
    pub rms: Option<f64>,
    /// Why it does not belong to the others, if so.
    pub misfit: Option<Misfit>,
    /// Whether it is in the average.
    pub is_used: bool,
}

/// A trial and how it lies over the reference.
#[derive(Debug)]
pub(super) struct Laid<'a> {
    pub recording: &'a Recording,
    pub overlay: Option<Overlay>,
    pub misfit: Option<Misfit>,
    pub is_used: bool,
}

/// The first of the trials that most others fit, and how all lie over it; `None` of no trials.
pub(super) fn lay_all<'a>(trials: &[&'a Recording]) -> Option<(&'a Recording, Vec<Laid<'a>>)> {
    let mut best: Option<(usize, &'a Recording, Vec<Laid<'a>>)> = None;
    for reference in trials {
        let laid: Vec<Laid> = trials.iter().map(|trial| lay(reference, trial)).collect();
        let fitting = laid.iter().filter(|one| one.misfit.is_none()).count();
        if best.as_ref().is_none_or(|(most, _, _)| fitting > *most) {
            best = Some((fitting, reference, laid));
        }
        if 2 * fitting > trials.len() {
            break;
        }
    }
    best.map(|(_, reference, laid)| (reference, laid))
}

fn lay<'a>(reference: &Recording, trial: &'a Recording) -> Laid<'a> {
    let is_reference = std::ptr::eq(reference, trial);
    let found = if is_reference {
        Ok(Overlay::default())
    } else {
        lay_over(reference, trial, true)
    };
    let (overlay, mut misfit) = match found {
        Ok(overlay) => (Some(overlay), None),
        Err(error) => (None, Some(Misfit::NoMatch(error))),
    };
    if let Some(overlay) = overlay.as_ref().filter(|_| !is_reference) {
        let agreement = compare_voltages(reference, trial, overlay.lag);
        misfit = agreement
            .filter(|found| !found.is_one_drive())
            .map(|found| Misfit::OtherDrive { rms: found.rms });
    }
    Laid {
        recording: trial,
        overlay,
        is_used: misfit.is_none(),
        misfit,
    }
}

/// The trials that do not belong, by number and name.
fn named(laid: &[Laid]) -> String {
    let all = laid.iter().enumerate().filter_map(|(i, trial)| {
        let misfit = trial.misfit.as_ref()?;
        let name = &trial.recording.name;
        Some(format!("{} ({name}): {}", i + 1, misfit.words()))
    });
    all.collect::<Vec<_>>().join("; ")
}

/// Trials under another drive are an error, unless they are to be left out.
pub(super) fn drop_other_drives(laid: &[Laid], leave_out: bool) -> Result<(), CombineError> {
    let count = laid.iter().filter(|trial| trial.misfit.is_some()).count();
    if count > 0 && !leave_out {
        return Err(CombineError::DoNotBelong {
            count,
            all: laid.len(),
            which: named(laid).into(),
        });
    }
    enough_left(laid)
}

/// Whether two trials are left.
pub(super) fn enough_left(laid: &[Laid]) -> Result<(), CombineError> {
    let left = laid.iter().filter(|trial| trial.is_used).count();
    if left >= 2 {
        return Ok(());
    }
    Err(CombineError::NothingLeft {
        left,
        all: laid.len(),
        which: named(laid).into(),
    })
}

/// Marks trials whose motion is another one than that of the others: `motions` of the trials `members`, at
/// the same instants.
pub(super) fn mark_other_motions(motions: &[&[f64]], members: &[usize], laid: &mut [Laid]) {
    let n = motions.len();
    let size = motions
        .iter()
        .map(|x| deviation(x.iter().copied()))
        .fold(0.0, f64::max);
    let between = |i: usize, j: usize| {
        let stride = motions[i].len().div_ceil(MAX_COMPARED).max(1);
        let pairs = motions[i].iter().zip(motions[j]).step_by(stride);
        deviation(pairs.map(|(a, b)| a - b))
    };
    // How far each is from the one in the middle of the others.
    let scores: Vec<f64> = (0..n)
        .map(|i| {
            let others = (0..n).filter(|j| *j != i);
            let mut all: Vec<f64> = others.map(|j| between(i, j)).collect();
            median_in_place(&mut all)
        })
        .collect();
    let usual = if n == 2 {
        0.0
    } else {
        median_in_place(&mut scores.clone())
    };
    let least = if n == 2 {
        MAX_PAIR_SHARE
    } else {
        MIN_DISTANCE_SHARE
    };
    for (member, distance) in members.iter().zip(scores) {
        let is_other = distance > MAX_DISTANCE_RATIO * usual && distance > least * size;
        if let Some(trial) = laid.get_mut(*member).filter(|_| is_other) {
            trial.misfit = Some(Misfit::OtherMotion { distance, usual });
        }
    }
}

/// Standard deviation of the finite values.
fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let finite = || values.clone().filter(|v| v.is_finite());
    let count = finite().count().max(1) as f64;
    let mean = finite().sum::<f64>() / count;
    (finite().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}
