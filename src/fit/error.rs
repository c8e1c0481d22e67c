//! Why a fit does not begin, or ends without a result. Each message says what is wrong,
//! where, and what to do.

use thiserror::Error;

use crate::sim::SimError;

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, Error)]
#[allow(missing_docs)] // The fields are what the message names.
pub enum FitError {
    #[error("all parameters are locked; free at least one, for example eta or dp")]
    NothingFree,
    #[error("there is no parameter {id} to fit; there are {known}")]
    UnknownParameter { id: String, known: String },
    #[error("{id} was not fitted, so that it has no profile; fitted were {fitted}")]
    NotFitted { id: String, fitted: String },
    #[error("{id} has no bearing on the device {device}; lock it")]
    Unused { id: String, device: String },
    #[error(
        "{id} belongs to what the device does not have, for the shapes of that mode or the share of that creep are 0; give them values first, or lock it"
    )]
    Idle { id: String },
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
    #[error("{recording}: xc is constant, so that it was not recorded; leave that column out")]
    StillCantilever { recording: String },
    #[error(
        "{recording}: {channel} stands at its {which} value {value} for {percent:.0} % of the time while the rest moves; the reading is saturated: record with a larger range"
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
        "{recording}: the noise of {channel} cannot be told ({reason}), and without it nothing can be weighed; export the recording without missing samples"
    )]
    Noise {
        recording: String,
        channel: &'static str,
        reason: String,
    },
    #[error(
        "{recording} and {other} hold the same samples; give each recording once, to fit to or to hold out"
    )]
    Twice { recording: String, other: String },
    #[error(
        "{recording}: the voltage does not move, so that eta cannot be fitted; check the column of V, fit without eta, or add a recording in which the drive works"
    )]
    StillDrive { recording: String },
    #[error(
        "{recording}: the ground lies at {level} in the recording, but the device's is at dp = {dp}; check the unit of xp, or set dp to about that"
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
        "{recording}: the voltage reaches {most}, but the drive of the device is known for some volts; check the unit of V"
    )]
    OtherVoltage { recording: String, most: String },
    #[error("{recording} {what}, but the device rings at f1 = {f1}; check the unit of t, or f1")]
    OtherTime {
        recording: String,
        what: String,
        f1: String,
    },
    #[error(
        "{id} is of the rig, not of the device: zeros and noise of each recording are found with every fit; do not fit it"
    )]
    OfTheRig { id: String },
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
    #[error("the starting values make no sense: {0}")]
    Start(#[from] SimError),
    #[error(
        "{recording}: no stretch of it could be used ({reason}); cut the recording or give better starting values"
    )]
    NoSegments { recording: String, reason: String },
    #[error("the fit was cancelled before its first result")]
    Cancelled,
}
