//! Findings and remarks as sentences for people.
//!
//! The sentences begin with a small letter and have no full stop, so that they may stand in a list
//! or be joined; [`capitalised`](super::words::capitalised) does the rest.

use super::words::listed;
use crate::diagnose::findings::{Finding, FindingKind, Remark};

/// A finding as a sentence.
pub fn finding(finding: &Finding) -> String {
    let value = finding.statistic;
    match &finding.kind {
        FindingKind::MeanSquare => {
            format!("the mean square of the residuals is still {value:.2} times that of the noise")
        }
        FindingKind::MissingForce { over } => {
            format!("a force that depends on {over} would lower chi2 by another {value:.0}")
        }
        FindingKind::LocalSegment => format!(
            "in one segment the residuals are {value:.0} standard deviations above what noise leaves"
        ),
        FindingKind::BrokenJoins => format!(
            "the simulated motion does not continue from one segment to the next: {value:.0} standard deviations over all of them"
        ),
        FindingKind::SelfRinging => {
            format!("something rings by itself at {:.2} kHz", 1e-3 * value)
        }
        FindingKind::FailsHeldOut { effect } => format!(
            "{effect} lowers chi2 by {value:.0} on the fitted recordings, far more than chance would, but not on held-out recordings: either something else is missing, or the held-out recordings do not show it"
        ),
        FindingKind::VibrationWithDisplacement => {
            "the residual vibration grows with the displacement, and no vibration of the base does that: a stiffness that varies in time is not in the catalogue".to_owned()
        }
        FindingKind::ForceOfBothDisplacements => {
            "the missing force depends on the displacements of both points: no force on the proof mass alone does, and the catalogue has none that does".to_owned()
        }
        FindingKind::FrictionByHeight => {
            "the friction is stronger at some heights than at others, and dry friction is not: a friction that depends on the load is not in the catalogue".to_owned()
        }
        FindingKind::OneForceInTheirPlace { effects } => format!(
            "{} would imitate a force over the displacement and still leave part of it: that is rather one law which is not in the catalogue",
            listed(effects)
        ),
        FindingKind::TooSmallShare {
            effects,
            of_segments,
        } => {
            let broken = if value < *of_segments {
                ", and the motion would continue no better from one segment to the next"
            } else {
                ""
            };
            format!(
                "{} would explain {:.0} % of what is missing{broken}: too little for a name",
                listed(effects),
                100.0 * of_segments
            )
        }
    }
}

/// A remark as a sentence.
pub fn remark(remark: &Remark) -> String {
    match remark {
        Remark::LastThirdHeldOut => "no recordings were held out, so the last third of each recording was. Recordings with other excitations would be a harder test".to_owned(),
        Remark::NoContact { reason } => format!(
            "no contact was found ({reason}): impact, adhesion and film cannot be determined"
        ),
        Remark::DifferentDevices { error } => format!("{error}; therefore nothing is named"),
        Remark::FewSamples(samples) => format!(
            "{samples} samples are few: slow or rare effects cannot be seen in them"
        ),
        Remark::ProofMassOnly => "only the proof mass was recorded: what moves the cantilever alone cannot be distinguished from the drive".to_owned(),
        Remark::SingleExcitation => "a single excitation cannot distinguish many effects: record two or three more waveforms".to_owned(),
        Remark::HeldOutReadOtherPoints(count) => format!(
            "held-out recordings that were not used because they read other points than the fitted ones: {count}"
        ),
        Remark::ClippedSamples {
            recording,
            channel,
            clipped,
            samples,
        } => format!(
            "{recording}: {clipped} of {samples} samples of {channel} lie at the end of the sensor's range and were not used"
        ),
        Remark::NothingHeldOut => "no recordings were held out, so no improvement can be proved".to_owned(),
        Remark::VibrationPhasesDiffer => "the base vibrates with a different phase in each recording; the phase given is that of the first recording".to_owned(),
        Remark::RestsAboveGround { recording } => format!(
            "{recording}: the mass comes to rest above the ground without touching it, so this recording says nothing about contact"
        ),
        Remark::NamesRefused(reason) => finding(reason),
        Remark::MisreadReadings { train, held_out } => format!(
            "{train:.0} % of the fitted and {held_out:.0} % of the held-out readings were not used: an event near them was missed or placed wrongly"
        ),
        Remark::ContactAmbiguous => "it is uncertain whether the mass touches the ground in some recordings; the reading was chosen that explains all of them".to_owned(),
    }
}

/// Remarks as sentences.
pub fn remarks(all: &[Remark]) -> Vec<String> {
    all.iter().map(remark).collect()
}
