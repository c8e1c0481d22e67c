//! Repeated trials of one motion as one recording: their mean on a common clock, and how they differ.

use super::error::CombineError;
use super::misfit::{
    AveragedTrial, Laid, drop_other_drives, enough_left, lay_all, mark_other_motions,
};
use super::said::said;
use super::stack::{Mean, Stack};
use crate::recording::Recording;
use crate::recording::error::{ImportWarning, WarningKind};

/// How trials are averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AverageOptions {
    /// Whether trials that do not belong are left out; otherwise one under another drive is an error,
    /// and one with another motion is named and averaged.
    pub leave_out_misfits: bool,
    /// Whether the zeros of the displacements are made those of the first trial before they are averaged.
    pub match_zeros: bool,
}

/// The mean of trials. Its recording keeps the spread ([`Recording::spread`]), and its warnings say
/// everything that differs between the trials.
#[derive(Debug, Clone)]
pub struct Average {
    /// The mean.
    pub recording: Recording,
    /// The trials in their order.
    pub trials: Vec<AveragedTrial>,
}

/// Averages `trials` of one motion. They are laid over each other in time by their voltage, or by their
/// motion where one has none, and read on the clock of the first one that most others fit. The mean is
/// taken where all of them are, at samples that more than half of them have. The standard deviation
/// between them is kept; with their number it is the noise of the mean
/// ([`Recording::estimate_noise`]).
///
/// # Errors
/// [`CombineError`]: fewer than two trials, another drive, nothing in common.
///
/// # Examples
/// ```
/// use impactscope::recording::combine::{AverageOptions, average};
/// use impactscope::recording::{Channel, Recording};
///
/// let time: Vec<f64> = (0..2000).map(|i| 2e-5 * f64::from(i)).collect();
/// let motion = |late: f64| -> Vec<f64> {
///     let at = |t: &f64| (500.0 * (t + late) + 1e5 * (t + late).powi(2)).sin();
///     time.iter().map(|t| 1e-6 * at(t)).collect()
/// };
/// let trial = |late: f64| Recording::new("trial", time.clone(), None, motion(late), None);
/// // The second was started 0.4 ms late.
/// let trials = [trial(0.0)?, trial(4e-4)?];
/// let all: Vec<&Recording> = trials.iter().collect();
/// let found = average(&all, AverageOptions::default())?;
/// assert!((found.trials[1].lag.ok_or("no lag")? - 4e-4).abs() < 1e-6);
/// let spread = found.recording.spread.as_ref().ok_or("no spread")?;
/// assert!(spread.mean_deviation(Channel::ProofMass).ok_or("none")? < 2e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn average(trials: &[&Recording], options: AverageOptions) -> Result<Average, CombineError> {
    let found = trials.len();
    let (reference, mut laid) = (found >= 2)
        .then(|| lay_all(trials))
        .flatten()
        .ok_or(CombineError::TooFew { found })?;
    drop_other_drives(&laid, options.leave_out_misfits)?;
    let mut stack = Stack::new(reference, &laid)?;
    mark_other_motions(&stack.motions(), &stack.members, &mut laid);
    if options.leave_out_misfits {
        for trial in laid.iter_mut().filter(|trial| trial.misfit.is_some()) {
            trial.is_used = false;
        }
        enough_left(&laid)?;
        stack = Stack::new(reference, &laid)?;
    }
    let mean = stack.mean(options.match_zeros);
    let mut recording = stack.recording(reference, &laid, &mean)?;
    let trials = described(&laid, &stack, &mean);
    let sentences = said(reference, &laid, &trials, &recording, options.match_zeros);
    recording.warnings = carried(&laid);
    let warn = |text: &String| ImportWarning::new(WarningKind::Averaged, 1, None, text);
    recording.warnings.extend(sentences.iter().map(warn));
    Ok(Average { recording, trials })
}

fn described(laid: &[Laid], stack: &Stack, mean: &Mean) -> Vec<AveragedTrial> {
    let one = |(i, trial): (usize, &Laid)| {
        let at = stack.members.iter().position(|member| *member == i);
        AveragedTrial {
            name: trial.recording.name.clone(),
            lag: trial.overlay.as_ref().map(|o| o.lag),
            zero: at.and_then(|k| mean.zeros.get(k).copied()),
            rms: at.and_then(|k| mean.rms.get(k).copied()),
            misfit: trial.misfit.clone(),
            is_used: trial.is_used,
        }
    };
    laid.iter().enumerate().map(one).collect()
}

/// What the reader said of the trials; what it said of several is said once.
fn carried(laid: &[Laid]) -> Vec<ImportWarning> {
    let mut kept: Vec<ImportWarning> = Vec::new();
    for trial in laid.iter().filter(|trial| trial.is_used) {
        for warning in &trial.recording.warnings {
            match kept.iter_mut().find(|own| own.message == warning.message) {
                Some(own) => own.count = own.count.max(warning.count),
                None => kept.push(warning.clone()),
            }
        }
    }
    kept
}
