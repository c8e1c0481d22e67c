//! Diagnoses made by hand, as an engine would give them.

use crate::diagnose::diagnosis::*;
use crate::diagnose::findings::{CandidateRemark, Evidence, Finding, FindingKind, Remark};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, find};

/// Names, lengths \[s\] and distances \[units of 20 nm\] of nine recordings.
const RECORDINGS: [(&str, f64, f64, bool); 9] = [
    ("ramped 5 8 0.25", 0.4, 14.1, false),
    ("square 15 8", 0.2, 22.4, false),
    ("sine 50 8", 0.12, 9.6, false),
    ("square 50 6", 0.12, 19.3, false),
    ("square 300 6", 0.05, 31.0, false),
    ("ramped 10 8 0.15", 0.3, 16.2, true),
    ("sine 15 8", 0.2, 4.1, true),
    ("square 40 7", 0.15, 23.7, true),
    ("square 300 8", 0.05, 36.5, true),
];
const NOISE: f64 = 20e-9;

/// A number from -1 to 1 that looks like chance and is always the same.
fn chance(i: usize) -> f64 {
    let x = ((i as f64 + 1.0) * 12.9898).sin() * 43758.5453;
    2.0 * (x - x.floor()) - 1.0
}

/// Quadratic drag, found in nine recordings of both points.
pub fn drag() -> Diagnosis {
    let mut model = Model::default();
    let drag = find("quadratic_drag").unwrap();
    let mut active = ActiveEffect::new(drag);
    active.set("cd", 1.02e-7);
    model.effects.push(active);
    Diagnosis {
        verdict: Verdict::MissingPhysics,
        remaining: None,
        named: vec![NamedEffect {
            id: "quadratic_drag".into(),
            name: drag.name.into(),
            probability: 0.9991,
            size: 9.14e-9,
            parameters: vec![Estimate {
                id: "cd".into(),
                value: 1.023e-7,
                std_error: 1.1e-9,
                unit: "N s^2/m^2",
            }],
            alike: vec!["film_spring".into()],
            evidence: vec![Evidence::Gains {
                fitted: 82875.0,
                held_out: Some(41250.0),
            }],
        }],
        candidates: candidates(),
        mismatch: mismatch(),
        marginals: marginals(),
        forces: forces(),
        balance: Some(balance()),
        strips: RECORDINGS.iter().enumerate().map(strip).collect(),
        events: events(),
        noise: NOISE,
        train: both(18.7, 1.01),
        held_out: both(21.9, 1.02),
        proof: RECORDINGS
            .iter()
            .enumerate()
            .map(|(i, (name, _, rms, held_out))| ProofOf {
                recording: (*name).into(),
                held_out: *held_out,
                noise: NOISE,
                covered: 0.93 + 0.06 * chance(i),
                distance: both(*rms, 1.01 + 0.02 * chance(i + 50)),
                correlation: (0.97 + 0.02 * chance(i), 0.11 + 0.03 * chance(i)),
            })
            .collect(),
        next_experiment: Some(NextExperiment {
            drive: "square:220Hz:8V".into(),
            separates: ("quadratic_drag".into(), "film_spring".into()),
            expected: 1234.5,
        }),
        baseline: Model::default(),
        model,
        remarks: vec![
            Remark::ProofMassOnly,
            Remark::RestsAboveGround {
                recording: "<square 300 6> & others".into(),
            },
        ],
        cancelled: false,
        findings: Vec::new(),
    }
}

/// Nothing left out, and most of what can be missing is missing.
pub fn adequate() -> Diagnosis {
    let plain = drag();
    Diagnosis {
        verdict: Verdict::Adequate,
        named: Vec::new(),
        mismatch: Vec::new(),
        marginals: Vec::new(),
        forces: Vec::new(),
        balance: None,
        strips: Vec::new(),
        events: EventsSeen::default(),
        train: both(1.0, 1.0),
        held_out: both(1.01, f64::NAN),
        // One fitted, one held out.
        proof: plain.proof.into_iter().skip(4).take(2).collect(),
        next_experiment: None,
        remarks: Vec::new(),
        model: Model::default(),
        candidates: vec![Candidate {
            score: f64::NAN,
            ..plain.candidates[1].clone()
        }],
        ..drag()
    }
}

/// Quadratic drag, and a force over the displacement that it leaves.
pub fn partly() -> Diagnosis {
    let mut d = drag();
    d.verdict = Verdict::PartlyExplained;
    d.train = both(18.7, 7.94);
    d.held_out = both(21.9, 9.31);
    d.findings = vec![Finding {
        kind: FindingKind::MissingForce { over: "xp" },
        statistic: 5210.0,
    }];
    d.remaining = Some(Remaining {
        share: 0.18,
        share_of_runs: Some(0.042),
        regime: Regime::FarFlight,
        depends_on: Some(Quantity::Displacement),
        force: d.forces.pop(),
    });
    d.forces = forces();
    for strip in &mut d.strips {
        strip.after.iter_mut().for_each(|rms| *rms *= 8.0);
    }
    d
}

/// Something that the catalogue does not carry, with numbers that are not finite wherever
/// there may be one, and names that must be escaped.
pub fn unexplained() -> Diagnosis {
    let mut d = drag();
    d.verdict = Verdict::Unexplained;
    d.remaining = Some(Remaining {
        share: 1.0,
        share_of_runs: None,
        regime: Regime::NearGroundApproach,
        depends_on: None,
        force: None,
    });
    d.named.clear();
    d.model = d.baseline.clone();
    d.held_out.after = d.held_out.before;
    d.train.after = d.train.before;
    d.proof[0].distance.before.rms = f64::NAN;
    d.proof[1].recording = "<b>&\"odd\" name' that is much too long for the space.csv".into();
    d.strips[1].recording = d.proof[1].recording.clone();
    d.marginals[0].before[3] = f64::INFINITY;
    d.forces[0].std_error[2] = f64::NAN;
    d.forces[1].force[2] = f64::NAN;
    d.forces[1].law.clear();
    if let Some(balance) = &mut d.balance {
        balance.after.clear();
        balance.before.iter_mut().for_each(|c| c.curve.law.clear());
        balance.before[0].curve.force[2] = f64::NAN;
    }
    d.events.bounces[0].ratio_error = f64::NAN;
    d.events.releases.truncate(1);
    d.events.levels[0].miss = f64::NAN;
    d.strips[2].time.clear();
    d
}

fn both(before: f64, after: f64) -> BeforeAfter {
    let of = |rms: f64| Distance {
        rms: rms * NOISE,
        chi2: rms * rms,
    };
    BeforeAfter {
        before: of(before),
        after: of(after),
    }
}

fn candidates() -> Vec<Candidate> {
    let rows = [
        ("quadratic_drag", 0.9991, 81250.0, 1.02),
        ("film_spring", 8e-4, 61210.0, 1.31),
        ("dry_friction", 1e-6, 30110.0, 88.0),
        ("amplifier_lag", 0.0, 1210.0, 201.0),
        ("sensor_lag", 0.0, 310.0, f64::NAN),
        ("zero_drift", 0.0, 12.0, f64::NAN),
        ("gravity", 0.0, 2.0, f64::NAN),
    ];
    rows.map(|(id, probability, score, held_out_chi2)| {
        let fitted = held_out_chi2.is_finite();
        Candidate {
            id: id.into(),
            name: find(id).unwrap().name.into(),
            probability,
            score,
            gain: if fitted { 1.02 * score } else { f64::NAN },
            held_out_gain: if fitted { 0.5 * score } else { f64::NAN },
            held_out_chi2,
            remarks: match (id, fitted) {
                ("quadratic_drag", _) => Vec::new(),
                (_, true) => vec![CandidateRemark::Outweighed],
                (_, false) => vec![CandidateRemark::NotFitted],
            },
        }
    })
    .into()
}

fn mismatch() -> Vec<Mismatch> {
    let regimes = [
        Regime::FarFlight,
        Regime::NearGroundDeparture,
        Regime::FarFlight,
        Regime::NearGroundApproach,
    ];
    (0..15)
        .map(|i| {
            let (name, length, _, _) = RECORDINGS[(4 + i * 3) % 9];
            let start = 0.8 * length * chance(i).abs();
            Mismatch {
                recording: name.into(),
                start,
                end: start + 0.0007 + 0.05 * length,
                channel: if i % 5 == 4 { "xc" } else { "xp" },
                regime: regimes[i % 4],
                share: 0.18 * 0.8f64.powi(i as i32),
            }
        })
        .collect()
}

fn marginals() -> Vec<Marginal> {
    let of = |against, unit, from: f64, to: f64, peak: f64| {
        let at: Vec<f64> = (0..20)
            .map(|i| from + (to - from) * (i as f64 + 0.5) / 20.0)
            .collect();
        let before = (0..20).map(|i| {
            let u = (i as f64 - 9.5) / 9.5;
            1.0 + peak * u.powi(4) + 0.2 * chance(i).abs()
        });
        Marginal {
            against,
            unit,
            before: before.collect(),
            after: (0..20).map(|i| 1.0 + 0.1 * chance(i)).collect(),
            at,
        }
    };
    vec![
        of("xp", "m", -58e-6, 70e-6, 30.0),
        of("xp'", "m/s", -0.3, 0.35, 900.0),
        of("V", "V", -8.0, 8.0, 50.0),
        of("drive phase", "", 0.0, 1.0, 20.0),
        of("time since contact", "s", 0.0, 8e-3, 10.0),
    ]
}

fn forces() -> Vec<ForceCurve> {
    let of = |against, unit, from: f64, to: f64, law: fn(f64) -> f64| {
        let at: Vec<f64> = (0..24)
            .map(|i| from + (to - from) * (i as f64 + 0.5) / 24.0)
            .collect();
        let error = |i: usize| 2e-10 * (1.0 + chance(i).abs());
        ForceCurve {
            against,
            unit,
            force: (0..24)
                .map(|i| law(at[i]) + error(i) * chance(i + 99))
                .collect(),
            std_error: (0..24).map(error).collect(),
            law: at.iter().map(|x| law(*x)).collect(),
            at,
        }
    };
    vec![
        of("xp'", "m/s", -0.3, 0.3, |v| -1.02e-7 * v * v.abs()),
        of("xp", "m", -58e-6, 70e-6, |_| -1e-10),
    ]
}

/// The same by the force balance.
fn balance() -> BalanceForces {
    let curve = |curve: ForceCurve, gain: f64| BalanceCurve {
        quantity: Quantity::of_symbol(curve.against).unwrap(),
        curve,
        absorbed: Absorbed {
            constant: true,
            slope: true,
        },
        gain: (gain, 0.4 * gain),
        by_chance: 10,
        is_significant: gain > 100.0,
    };
    let mut all = forces().into_iter();
    let before = vec![
        curve(all.next().unwrap(), 52310.0),
        curve(all.next().unwrap(), 14.0),
    ];
    let mut after = before.clone();
    for c in &mut after {
        c.curve.force = (0..c.curve.at.len()).map(|i| 2e-10 * chance(i)).collect();
        c.curve.law.clear();
        (c.gain, c.is_significant) = ((11.0, -4.0), false);
    }
    BalanceForces { before, after }
}

fn strip((number, (name, length, rms, held_out)): (usize, &(&str, f64, f64, bool))) -> Strip {
    let count = 400;
    let time: Vec<f64> = (0..count)
        .map(|i| (i as f64 + 0.5) * length / count as f64)
        .collect();
    let cycle = |t: f64| (t * 45.0).fract();
    let regime = |t: f64| match cycle(t) {
        u if u < 0.45 => Regime::FarFlight,
        u if u < 0.6 => Regime::NearGroundApproach,
        u if u < 0.65 => Regime::Impact,
        u if u < 0.85 => Regime::Contact,
        u if u < 0.88 => Regime::Release,
        _ => Regime::NearGroundDeparture,
    };
    let before = |(i, t): (usize, &f64)| match regime(*t) {
        Regime::Contact => NOISE * (1.0 + 0.1 * chance(i)),
        Regime::Release => f64::NAN,
        _ => NOISE * rms * (0.4 + (9.0 * cycle(*t)).sin().abs()) * (1.0 + 0.2 * chance(i)),
    };
    Strip {
        recording: (*name).into(),
        held_out: *held_out,
        before: time.iter().enumerate().map(before).collect(),
        after: (0..count)
            .map(|i| NOISE * (1.0 + 0.12 * chance(i + number)))
            .collect(),
        xp: time
            .iter()
            .map(|t| match regime(*t) {
                Regime::Contact => -58e-6,
                _ => -58e-6 + 120e-6 * (std::f64::consts::PI * cycle(*t)).sin().abs(),
            })
            .collect(),
        regime: time.iter().map(|t| regime(*t)).collect(),
        samples_before: Vec::new(),
        samples_after: Vec::new(),
        time,
    }
}

fn events() -> EventsSeen {
    EventsSeen {
        bounces: (0..40)
            .map(|i| BounceSeen {
                recording: i % 9,
                time: 0.01 * i as f64,
                speed: 0.02 + 0.28 * chance(i).abs(),
                ratio: 0.378 + 0.01 * chance(i + 7),
                ratio_error: 0.008,
                dwell: 2e-6 * chance(i + 11),
                dwell_error: 1.5e-6,
            })
            .collect(),
        releases: (0..18)
            .map(|i| {
                let contact = 1e-3 + 30e-3 * chance(i + 3).abs();
                ReleaseSeen {
                    recording: i % 9,
                    time: 0.02 * i as f64,
                    contact,
                    force: 2.743e-8 + 1.7e-6 * contact + 1e-9 * chance(i),
                    force_error: 1e-9,
                }
            })
            .collect(),
        levels: (0..18)
            .map(|i| LevelSeen {
                recording: i % 9,
                time: 0.02 * i as f64,
                miss: 4e-9 * chance(i),
                error: 3e-9,
            })
            .collect(),
    }
}
