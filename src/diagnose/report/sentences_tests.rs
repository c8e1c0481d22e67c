//! The sentences keep one form.

use crate::diagnose::findings::*;
use crate::diagnose::report::sentences::*;
use crate::fit::{Contradiction, HeldParameter};
use crate::model::effects::CATALOGUE;
use crate::model::preset::known_value::KnownValue;
use crate::recording::Channel;
use crate::recording::instrument_faults::{FaultKind, InstrumentFault};

/// One of each kind of finding; kinds with two sentences twice.
fn findings() -> Vec<Finding> {
    let share = |of_segments| FindingKind::TooSmallShare {
        effects: vec!["quadratic drag", "gravity"],
        of_segments,
    };
    let force = |over| FindingKind::MissingForce { over };
    let kinds = [
        FindingKind::MeanSquare,
        force("xp"),
        force("xp'"),
        force("V"),
        force(""),
        FindingKind::LocalSegment,
        FindingKind::BrokenJoins,
        FindingKind::SelfRinging,
        FindingKind::FailsHeldOut {
            effect: "zero drift",
        },
        FindingKind::VibrationWithDisplacement,
        FindingKind::ForceOfBothDisplacements,
        FindingKind::FrictionByHeight,
        FindingKind::OneForceInTheirPlace {
            effects: vec!["gravity"],
        },
        FindingKind::OneForceInTheirPlace {
            effects: vec!["gravity", "quadratic drag"],
        },
        share(0.3),
        share(0.9),
        FindingKind::KnownContradicted(contradiction()),
    ];
    let of = |kind| Finding {
        kind,
        statistic: 0.52,
    };
    kinds.into_iter().map(of).collect()
}

fn contradiction() -> Contradiction {
    Contradiction {
        known: gravity(),
        needed: 7.3,
        std_error: 0.1,
        unit: "m/s^2".to_owned(),
    }
}

#[test]
fn a_contradicted_value_is_said_with_both_errors() {
    let said = remark(&Remark::KnownContradicted(contradiction()));
    assert!(
        said.starts_with(
            "needs gravity.g = 7.3 m/s^2 +- 0.1 m/s^2, known 9.81 m/s^2 +- 0.05 m/s^2: "
        ),
        "{said}"
    );
}

fn gravity() -> KnownValue {
    KnownValue {
        id: "gravity.g".to_owned(),
        value: 9.81,
        std_error: 0.05,
    }
}

fn all_remarks() -> Vec<Remark> {
    let recording = || "ramped 5 8".to_owned();
    vec![
        Remark::LastThirdHeldOut,
        Remark::NoContact {
            reason: "nothing is flat".to_owned(),
        },
        Remark::DifferentDevices {
            error: "f1 differs".to_owned(),
        },
        Remark::FewSamples(1234),
        Remark::ProofMassOnly,
        Remark::SingleExcitation,
        Remark::HeldOutReadOtherPoints(1),
        Remark::HeldOutReadOtherPoints(2),
        Remark::InstrumentFault {
            recording: recording(),
            fault: InstrumentFault {
                kind: FaultKind::Spikes,
                channel: Channel::ProofMass,
                count: 12,
                samples: 12,
                of_samples: 3456,
                places: vec![(0.25, 0.25)],
                size: 2e-6,
            },
        },
        Remark::CoarseSampling {
            said: "too few samples".to_owned(),
        },
        Remark::NothingHeldOut,
        Remark::VibrationPhasesDiffer,
        Remark::ScalesDiffer(0.6),
        Remark::RestsAboveGround {
            recording: recording(),
        },
        Remark::NamesRefused(Finding {
            kind: FindingKind::FrictionByHeight,
            statistic: 61.0,
        }),
        Remark::MisreadReadings {
            train: 4.0,
            held_out: 2.0,
        },
        Remark::ContactAmbiguous,
        Remark::NothingRetuned,
        Remark::Retuned(vec![RetunedParameter {
            id: "gravity.g".to_owned(),
            from: 9.81,
            to: 9.79,
            unit: "m/s^2".to_owned(),
            known: Some(gravity()),
        }]),
        Remark::HeldAsGiven(vec!["quadratic_drag.cd".to_owned()]),
        Remark::KnownContradicted(contradiction()),
        Remark::HeldElsewhere(HeldParameter {
            id: "quadratic_drag.cd".to_owned(),
            value: 1e-7,
            needed: 2e-7,
            std_error: 1e-8,
            unit: "N s^2/m^2".to_owned(),
        }),
        Remark::OutOfTime {
            seconds: 5.0,
            not_compared: vec!["gravity".to_owned(), "dry friction".to_owned()],
        },
        Remark::OutOfTime {
            seconds: 5.0,
            not_compared: Vec::new(),
        },
    ]
}

/// The evidence of contact laws, with each proof.
fn laws() -> Vec<Evidence> {
    let proofs = [
        LawProof::Alone,
        LawProof::WithHeldOut,
        LawProof::CrossValidated,
        LawProof::NotCrossValidated,
    ];
    let of = |proof| {
        let releases = |logarithmic| Evidence::Releases {
            count: 12,
            from_s: 1.2e-3,
            to_s: 40e-3,
            logarithmic,
            proof,
        };
        [
            releases(false),
            releases(true),
            Evidence::Dwell {
                count: 20,
                seconds: 3e-6,
                error: 2e-7,
                proof,
            },
            Evidence::Restitution {
                count: 20,
                power: -0.1,
                error: 0.01,
                proof,
            },
        ]
    };
    proofs.into_iter().flat_map(of).collect()
}

fn all_evidence() -> Vec<Evidence> {
    let mut all = laws();
    all.extend([
        Evidence::RejectedTwin {
            twin: "amplifier lag",
            chosen: "late readings",
            fall: 120.0,
        },
        Evidence::SecondMode { frequency: 39.2e3 },
        Evidence::Gains {
            fitted: 99.0,
            held_out: Some(45.0),
        },
        Evidence::Gains {
            fitted: 99.0,
            held_out: None,
        },
        Evidence::AfterFitted {
            recording: "square 15 8".to_owned(),
            gain: 80.0,
            held_out: 70.0,
        },
        Evidence::SequentialTime,
    ]);
    all.extend([true, false].map(|cross_validated| Evidence::EventGains {
        fitted: 80.0,
        held_out: 30.0,
        cross_validated,
    }));
    all
}

fn candidate_remarks() -> Vec<CandidateRemark> {
    let mut all = vec![
        CandidateRemark::Refused,
        CandidateRemark::SelfRings(12e3),
        CandidateRemark::Insignificant,
        CandidateRemark::FailsHeldOut,
        CandidateRemark::Outweighed,
        CandidateRemark::NotFitted,
        CandidateRemark::AbsorbedByRetuning,
        CandidateRemark::NothingToActOn,
        CandidateRemark::NotTested,
    ];
    for law in laws() {
        let (law, fall) = (|| law.clone(), 80.0);
        all.extend([8.0, -3.0].map(|fall| CandidateRemark::LawFallsShort {
            law: law(),
            fall,
            needed: 25.0,
        }));
        all.push(CandidateRemark::LawFailsProof { law: law(), fall });
        all.push(CandidateRemark::LawNotNamed { law: law(), fall });
    }
    all
}

#[test]
fn every_sentence_has_one_form() {
    let mut all: Vec<String> = findings().iter().map(finding).collect();
    all.extend(remarks(&all_remarks()));
    all.extend(all_evidence().iter().map(evidence));
    all.extend(candidate_remarks().iter().map(candidate));
    for text in &all {
        let first = text.chars().next();
        assert!(first.is_some_and(|c| !c.is_uppercase()), "{text}");
        assert!(text.trim() == text && !text.ends_with('.'), "{text}");
        for wrong in ["{", "}", "  ", " ,", " :", ";;", "NaN", "inf "] {
            assert!(!text.contains(wrong), "{wrong} in {text}");
        }
        // Ids of a single word are words of the language as well.
        let ids = CATALOGUE.iter().map(|e| e.id).filter(|id| id.contains('_'));
        for id in ids {
            assert!(!text.contains(id), "{id} in {text}");
        }
    }
}

#[test]
fn a_law_that_falls_short_is_no_evidence() {
    let short = CandidateRemark::LawFallsShort {
        law: laws().swap_remove(0),
        fall: 8.2,
        needed: 25.0,
    };
    assert_eq!(
        candidate(&short),
        "12 releases: chi2 falls by 8 with this law, 25 needed"
    );
}

#[test]
fn a_share_at_the_joins_is_told_apart_from_that_within_segments() {
    let shares: Vec<String> = findings()
        .iter()
        .filter(|f| matches!(f.kind, FindingKind::TooSmallShare { .. }))
        .map(finding)
        .collect();
    let [within, at_joins] = shares.as_slice() else {
        panic!("{shares:?}");
    };
    assert!(
        at_joins.contains("90 % of what is missing within the segments, but only 52 %"),
        "{at_joins}"
    );
    assert!(!within.contains("joins"), "{within}");
}
