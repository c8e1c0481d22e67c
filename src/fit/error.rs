//! Why a fit does not begin, or ends without a result. Each message says what is wrong, where,
//! and what to do; values in a message are text with units.

use thiserror::Error;

use super::thresholds::KNOWN_VOLTAGE;
use crate::sim::SimError;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // The fields are what the message names.
pub enum FitError {
    #[error("all parameters are locked; free at least one, for example eta or dp")]
    NothingFree,
    #[error("{id}: {reason}")]
    Choice { id: String, reason: String },
    #[error("there is no parameter {id} to fit; there are {known}")]
    UnknownParameter { id: String, known: String },
    #[error("{id} was not fitted, so it has no profile; the fitted parameters are {fitted}")]
    NotFitted { id: String, fitted: String },
    #[error("{id} has no effect on the device {device}; lock it")]
    IrrelevantParameter { id: String, device: String },
    #[error(
        "{id} has no effect: the shapes of its mode, or the share of its creep, are 0; give them values first, or lock it"
    )]
    InactiveParameter { id: String },
    #[error("no recording was given; give at least one to fit to")]
    NoRecording,
    #[error("{recording}: {samples} samples are too few to fit to; record at least {needed}")]
    TooShort {
        recording: String,
        samples: usize,
        needed: usize,
    },
    #[error(
        "{recording}: xp is constant, so there is no motion to fit to; record while the device moves"
    )]
    Constant { recording: String },
    #[error(
        "{recording}: xp is nothing but noise of {noise} about one level, so there is no motion to read; check the column of xp, or record while the device moves"
    )]
    NoMotion { recording: String, noise: String },
    #[error("{recording}: {what}; {remedy}")]
    Connection {
        recording: String,
        what: String,
        remedy: String,
    },
    #[error("{recording}: xc is constant, so it was not recorded; remove that column")]
    ConstantCantilever { recording: String },
    #[error(
        "{recording}: {channel} stays at its {which} value {value} for {percent:.0} % of the time, so the reading is saturated; record with a larger range"
    )]
    Saturated {
        recording: String,
        channel: &'static str,
        which: &'static str,
        value: String,
        percent: f64,
    },
    #[error(
        "{recording}: there is no drive channel, but the device is driven; export the voltage too (a column \"V [V]\")"
    )]
    NoDrive { recording: String },
    #[error(
        "{recording}: the noise of {channel} cannot be estimated ({reason}), and the fit needs it for its weights; export the recording without missing samples"
    )]
    Noise {
        recording: String,
        channel: &'static str,
        reason: String,
    },
    #[error(
        "{recording} and {other} hold the same samples; give each recording once, to fit to or to hold out"
    )]
    DuplicateRecording { recording: String, other: String },
    #[error(
        "{recording}: the voltage does not move, so eta cannot be fitted; check the column of V, fit without eta, or add a recording in which the voltage changes"
    )]
    ConstantDrive { recording: String },
    #[error(
        "{recording}: the ground is at xp = {level} in the recording, but at xp = -{dp} in the device; check the unit of xp, or correct dp"
    )]
    OtherUnit {
        recording: String,
        level: String,
        dp: String,
    },
    #[error(
        "{recording}: {channel} reads {value} at t = {time}, a thousand times beyond all other readings; clear that cell, or check the file"
    )]
    Spike {
        recording: String,
        channel: &'static str,
        value: String,
        time: String,
    },
    #[error(
        "{recording}: the voltage reaches {most}, but the drive of the device is known up to {known} V; check the unit of V",
        known = KNOWN_VOLTAGE
    )]
    OtherVoltage { recording: String, most: String },
    #[error("{recording} {what}, but the device rings at f1 = {f1}; check the unit of t, or f1")]
    OtherTime {
        recording: String,
        what: String,
        f1: String,
    },
    #[error(
        "{id} belongs to the instrument, not to the device: zeros and noise of each recording are estimated with every fit; do not fit it"
    )]
    NuisanceParameter { id: String },
    #[error(
        "{recording}: the ground lies at {level} in the recording, but gp = {gp} is not fitted and must exceed dp; fit gp too, set it beyond that, or check the unit of xp"
    )]
    GroundBeyondFilm {
        recording: String,
        level: String,
        gp: String,
    },
    #[error(
        "there is no contact in any of the recordings ({reason}), so that {parameters} cannot be fitted; lock them, or add a recording in which the mass hits the ground"
    )]
    NoContact { parameters: String, reason: String },
    #[error(
        "{recording} seems to be of another device than {other}: {evidence}; fit them separately"
    )]
    DifferentDevices {
        recording: String,
        other: String,
        evidence: String,
    },
    #[error("the starting values are invalid: {0}")]
    Start(#[from] SimError),
    #[error(
        "{recording}: no segment of it could be used ({reason}); cut the recording or give better starting values"
    )]
    NoSegments { recording: String, reason: String },
    #[error("the fit was cancelled before its first result")]
    Cancelled,
}
