//! Why recordings cannot be put together.

use thiserror::Error;

use crate::recording::error::FileText;

/// Why recordings cannot be averaged or merged. Each message names the recordings and says what to do.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // The fields are names and measured numbers, written with their units.
pub enum CombineError {
    #[error(
        "an average needs two recordings of the same motion at least, {found} given; name more files, or a file with several recordings"
    )]
    TooFew { found: usize },
    #[error(
        "{name} has no voltage, so nothing says how the two runs lie over each other in time; record the drive in both, or give the lag with --lag"
    )]
    NoVoltage { name: FileText },
    #[error(
        "the voltage of {name} is constant, so nothing says how the two runs lie over each other in time; give the lag with --lag"
    )]
    ConstantVoltage { name: FileText },
    #[error(
        "{name} does not fit {reference} at any shift in time: {channel} agree to {correlation:.2} at best, {least} is needed; they were driven by different voltages, or one file is another run"
    )]
    NoMatch {
        name: FileText,
        reference: FileText,
        channel: &'static str,
        correlation: f64,
        least: f64,
    },
    #[error(
        "{name} and {reference} have too little time in common; record runs of about the same length"
    )]
    NoOverlap { name: FileText, reference: FileText },
    #[error(
        "the voltages of {reference} and {name} differ by {difference} rms where they overlap, {allowed} is allowed ({relation}); give recordings under the same drive, or its scale with --scale V="
    )]
    VoltagesDiffer {
        name: FileText,
        reference: FileText,
        difference: String,
        allowed: String,
        relation: String,
    },
    #[error(
        "{count} of {all} recordings are no trials of the motion of the others: {which}; choose the trials with --trial 1,2, or leave those out with --leave-out-misfits"
    )]
    DoNotBelong {
        count: usize,
        all: usize,
        which: FileText,
    },
    #[error(
        "{left} of {all} recordings are left after those that do not belong were left out ({which}); an average needs two"
    )]
    NothingLeft {
        left: usize,
        all: usize,
        which: FileText,
    },
    #[error(
        "{name} has both xp and xc already; to merge two runs, give files with one displacement each, or say which column with --column"
    )]
    HasBothPoints { name: FileText },
}
