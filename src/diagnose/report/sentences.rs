//! Findings, remarks and evidence as sentences for people.
//!
//! The sentences begin with a small letter and have no full stop, so that they may stand in a list
//! or be joined; [`capitalised`](super::words::capitalised) does the rest.

use super::words::{effect_name, gain, listed};
use crate::diagnose::diagnosis::Quantity;
use crate::diagnose::findings::{
    CandidateRemark, Evidence, Finding, FindingKind, LawProof, Remark, RetunedParameter,
};
use crate::model::preset::known_value::with_error;
use crate::model::unit::format_quantity;

/// A finding as a sentence.
pub fn finding(finding: &Finding) -> String {
    let value = finding.statistic;
    match &finding.kind {
        FindingKind::MeanSquare => {
            format!("the mean square of the residuals is still {value:.2} times that of the noise")
        }
        FindingKind::MissingForce { over } => {
            let over = Quantity::of_symbol(over);
            let over = over.map_or("displacement, velocity or voltage", Quantity::text);
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
            "the friction is stronger at some heights than at others, and dry friction is not: compare a friction that depends on the load".to_owned()
        }
        FindingKind::OneForceInTheirPlace { effects } => {
            let imitate = match effects[..] {
                [_] => "imitates a force over the displacement and leaves",
                _ => "together imitate one force over the displacement and leave",
            };
            format!(
                "{} {imitate} part of it: probably a law that is not in the catalogue",
                listed(effects)
            )
        }
        FindingKind::TooSmallShare {
            effects,
            of_segments,
        } => {
            let percent = 100.0 * of_segments;
            let what = if value < *of_segments {
                format!(
                    "{percent:.0} % of what is missing within the segments, but only {:.0} % of what is missing at the joins between them",
                    100.0 * value
                )
            } else {
                format!("{percent:.0} % of what is missing")
            };
            format!("{} would explain {what}: too little for a name", listed(effects))
        }
        FindingKind::KnownContradicted(found) => found.text(),
    }
}

/// A remark as a sentence.
pub fn remark(remark: &Remark) -> String {
    match remark {
        Remark::LastThirdHeldOut => "no recordings were held out, so the last third of each was used instead; recordings with other excitations are a stricter test".to_owned(),
        Remark::NoContact { reason } => format!(
            "no contact was found ({reason}): impact, adhesion and film cannot be determined"
        ),
        Remark::DifferentDevices { error } => format!("{error}; therefore nothing is named"),
        Remark::FewSamples(samples) => format!(
            "only {samples} samples: slow or rare effects cannot be seen in them"
        ),
        Remark::ProofMassOnly => "only the proof mass was recorded: what moves the cantilever alone cannot be distinguished from the drive".to_owned(),
        Remark::SingleExcitation => "a single excitation cannot distinguish many effects: record two or three more waveforms".to_owned(),
        Remark::HeldOutReadOtherPoints(1) => "1 held-out recording was not used: its channels differ from those of the fitted ones".to_owned(),
        Remark::HeldOutReadOtherPoints(count) => format!(
            "{count} held-out recordings were not used: their channels differ from those of the fitted ones"
        ),
        Remark::InstrumentFault { recording, fault } => {
            format!("{recording}: {}", fault.sentence())
        }
        Remark::CoarseSampling { said } => said.clone(),
        Remark::NothingHeldOut => "no recordings were held out, so no improvement can be proved".to_owned(),
        Remark::VibrationPhasesDiffer => "the base vibrates with a different phase in each recording; the phase given is that of the first recording".to_owned(),
        Remark::ScalesDiffer(most) => format!(
            "the scales of the readings differ from recording to recording, by {most:.1} % at most; each was fitted"
        ),
        Remark::RestsAboveGround { recording } => format!(
            "{recording}: the mass comes to rest above the ground without touching it, so this recording says nothing about contact"
        ),
        Remark::NamesRefused(reason) => finding(reason),
        Remark::MisreadReadings { train, held_out } => format!(
            "{train:.0} % of the fitted and {held_out:.0} % of the held-out readings were not used: an event near them was missed or placed wrongly"
        ),
        Remark::ContactAmbiguous => "it is uncertain whether the mass touches the ground in some recordings; the reading was chosen that explains all of them".to_owned(),
        Remark::NothingRetuned => "no parameter was free, so the model was compared as it is: values that are slightly wrong count as missing physics".to_owned(),
        Remark::Retuned(all) => {
            let each: Vec<String> = all.iter().map(retuned).collect();
            format!("re-tuned: {}", each.join("; "))
        }
        Remark::HeldAsGiven(ids) => format!(
            "held at the values of the device: {}; free them if they are not known so well",
            ids.iter().map(|id| parameter_words(id)).collect::<Vec<_>>().join(", ")
        ),
        Remark::KnownContradicted(found) => found.text(),
        Remark::HeldElsewhere(held) => format!(
            "needs {} = {}, held at {}: another value, or a force is missing",
            parameter_words(&held.id),
            with_error(held.needed, held.std_error, &held.unit),
            format_quantity(held.value, &held.unit, 4)
        ),
        Remark::OutOfTime {
            seconds,
            not_compared,
        } => {
            let time = format_quantity(*seconds, "s", 3);
            let rest = match &not_compared[..] {
                [] => "all effects were compared, but not to the end".to_owned(),
                these => format!("not compared: {}", these.join(", ")),
            };
            format!("the time of {time} was used up; {rest}; a longer time (--budget on the command line) may find more")
        }
    }
}

/// A re-tuned parameter.
fn retuned(parameter: &RetunedParameter) -> String {
    let RetunedParameter {
        id,
        from,
        to,
        unit,
        known,
    } = parameter;
    let write = |value: f64| format_quantity(value, unit, 4);
    let known = known.as_ref().map_or(String::new(), |known| {
        format!(", known {}", known.text(unit))
    });
    let id = parameter_words(id);
    format!("{id} from {} to {}{known}", write(*from), write(*to))
}

/// A parameter in words: an effect's own with the effect's name.
fn parameter_words(id: &str) -> String {
    match id.split_once('.') {
        Some((effect, own)) => format!("{own} of {}", effect_name(effect)),
        None => id.to_owned(),
    }
}

/// Remarks as sentences.
pub fn remarks(all: &[Remark]) -> Vec<String> {
    all.iter().map(remark).collect()
}

/// Evidence for an effect as a sentence.
pub fn evidence(evidence: &Evidence) -> String {
    match evidence {
        Evidence::Releases {
            from_s,
            to_s,
            logarithmic,
            proof,
            ..
        } => {
            let bends = if *logarithmic {
                "grows as the logarithm of contact time"
            } else {
                "levels off"
            };
            format!(
                "{}: the pull-off force {bends} between {:.2} and {:.1} ms of contact{}",
                events(evidence),
                1e3 * from_s,
                1e3 * to_s,
                proved(*proof)
            )
        }
        Evidence::Dwell {
            seconds,
            error,
            proof,
            ..
        } => format!(
            "{}: the mass stays below the ground's level for {:.2} +- {:.2} us{}",
            events(evidence),
            1e6 * seconds,
            1e6 * error,
            proved(*proof)
        ),
        Evidence::Restitution {
            power,
            error,
            proof,
            ..
        } => format!(
            "{}: restitution varies as the speed to the power {power:.3} +- {error:.3}{}",
            events(evidence),
            proved(*proof)
        ),
        Evidence::RejectedTwin { twin, chosen, fall } => format!(
            "{twin} would fit as well in flight, but not where the mass bounces: chi2 there is {fall:.0} lower with {chosen}"
        ),
        Evidence::SecondMode { frequency } => format!(
            "together with it a second mode at {:.1} kHz; its coupling to the drive is hardly distinguishable from its shape and was held fixed",
            1e-3 * frequency
        ),
        Evidence::Gains { fitted, held_out } => match held_out {
            Some(held_out) => format!(
                "chi2 falls by {} on the fitted and by {} on held-out recordings",
                gain(*fitted),
                gain(*held_out)
            ),
            None => format!("chi2 falls by {} on the fitted recordings", gain(*fitted)),
        },
        Evidence::AfterFitted {
            recording,
            gain,
            held_out,
        } => format!(
            "the effect begins after the fitted recordings: {recording} determines it (chi2 falls by {gain:.0}), the other held-out recordings confirm it (chi2 falls by {held_out:.0})"
        ),
        Evidence::EventGains {
            fitted,
            held_out,
            cross_validated,
        } => {
            let on = if *cross_validated {
                "each recording left out in turn"
            } else {
                "held-out recordings"
            };
            format!(
                "chi2 of the events falls by {} on the fitted and by {} on {on}",
                gain(*fitted),
                gain(*held_out)
            )
        }
        Evidence::SequentialTime => {
            "its time is counted from the start of the first recording".to_owned()
        }
    }
}

/// How many events speak of a contact law.
fn events(law: &Evidence) -> String {
    match law {
        Evidence::Releases { count, .. } => format!("{count} releases"),
        Evidence::Dwell { count, .. } | Evidence::Restitution { count, .. } => {
            format!("{count} bounces")
        }
        _ => "the events".to_owned(),
    }
}

/// Which recordings prove a contact law, to be added to its evidence.
fn proved(proof: LawProof) -> &'static str {
    match proof {
        LawProof::Alone => "",
        LawProof::WithHeldOut => ", but only together with the held-out recordings",
        LawProof::CrossValidated => ", confirmed by leaving out each recording in turn",
        LawProof::NotCrossValidated => {
            ", tested by leaving out each recording in turn, without success"
        }
    }
}

/// What speaks for or against an effect as a sentence.
pub fn candidate(remark: &CandidateRemark) -> String {
    let text = match remark {
        CandidateRemark::LawFallsShort { law, fall, needed } => {
            return format!(
                "{}: chi2 {} with this law, {needed:.0} needed",
                events(law),
                falls(*fall)
            );
        }
        CandidateRemark::LawFailsProof { law, fall } => {
            let by = if law.is_cross_validated() {
                "leaving out each recording in turn does not confirm it"
            } else {
                "held-out recordings do not confirm it"
            };
            return format!(
                "{}: chi2 {} with this law, but {by}",
                events(law),
                falls(*fall)
            );
        }
        CandidateRemark::LawNotNamed { law, fall } => {
            return format!(
                "{}: chi2 {} with this law, but other conditions for a name are not met",
                events(law),
                falls(*fall)
            );
        }
        CandidateRemark::SelfRings(frequency) => {
            return format!(
                "something rings by itself at {:.2} kHz, and nothing that moves the device excites it",
                1e-3 * frequency
            );
        }
        CandidateRemark::Refused => {
            "it fits best, but its name was refused: see what limits this answer"
        }
        CandidateRemark::Insignificant => "it improves the fit no more than chance would",
        CandidateRemark::FailsHeldOut => "its improvement does not hold on held-out recordings",
        CandidateRemark::Outweighed => {
            "another effect improves the fit more, and nothing remains for this one"
        }
        CandidateRemark::NotFitted => {
            "its predicted gain is far below that of the best effect, so it was not fitted"
        }
        CandidateRemark::AbsorbedByRetuning => {
            "re-tuning the device's own parameters explains everything that this effect could"
        }
        CandidateRemark::NothingToActOn => "this device has nothing that it could act on",
        CandidateRemark::NotTested => "these recordings do not test it",
        CandidateRemark::InModel => "the model has it already",
        CandidateRemark::NotReached => "the diagnosis ended before it was compared",
    };
    text.to_owned()
}

/// How chi2 changes, as a verb.
fn falls(fall: f64) -> String {
    if fall < 0.5 {
        "does not fall".to_owned()
    } else {
        format!("falls by {}", gain(fall))
    }
}

#[cfg(test)]
#[path = "sentences_tests.rs"]
mod tests;
