//! A diagnosis from beginning to end.

use std::time::Instant;

use super::bench::{Bench, Fitted, remaining, with_effect};
use super::condition::condition;
use super::evidence::{self, Evidence};
use super::explain::{self, Explanation, HELD_GAIN, Stand, TRAIN_GAIN};
use super::laws::{self, LawTest};
use super::locate::{self, Sample};
use super::next::experiment;
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, DiagnoseProgress};
use super::result::{
    BeforeAfter, BounceSeen, Candidate, Diagnosis, Distance, Estimate, EventsSeen, LevelSeen,
    NamedEffect, ReleaseSeen, Verdict,
};
use super::{events, size};
use crate::fit::Part;
use crate::fit::prepare::Prepared;
use crate::fit::result::uncertainty;
use crate::model::Model;
use crate::model::effects::{CATALOGUE, find};
use crate::recording::quantile_in_place;

/// Chi2 per value from which something is left whatever it is: the noise is known to a
/// few percent.
const FLOOR: f64 = 1.08;
/// Fall of chi2 by forces without a name from which something is left.
const NAMELESS: f64 = 60.0;
/// A single stretch this far above the others, in units of what chance leaves.
const LOCAL: f64 = 8.0;
/// Share of what is missing that named effects must carry.
const CARRIED: f64 = 0.6;
/// Logarithm of the odds against any one effect before the data speak.
const PRIOR: f64 = 10.0;

/// Diagnoses `train`, judged on `held_out`, against `model`, which is re-tuned first.
/// Deterministic. Cancelled, it says what it has found so far.
///
/// # Errors
/// [`DiagnoseError`] if a recording or the model cannot be used.
pub fn diagnose(
    model: &Model,
    train: &[Part],
    held_out: &[Part],
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    for id in options
        .candidates
        .iter()
        .chain(options.by_hand.iter().flatten())
    {
        if find(id).is_none() {
            let known: Vec<&str> = CATALOGUE.iter().map(|e| e.id).collect();
            return Err(DiagnoseError::UnknownEffect {
                id: id.clone(),
                known: known.join(", "),
            });
        }
    }
    model
        .check()
        .map_err(|e| DiagnoseError::Sim(crate::sim::SimError::from(e)))?;
    let begun = Instant::now();
    let say = |stage: &'static str, detail: &str, done: f64| {
        (control.progress)(&DiagnoseProgress {
            stage,
            detail: detail.to_owned(),
            done,
            remaining: remaining(done, begun.elapsed()),
        });
    };
    say("recordings", "", 0.0);
    let ready = condition(model, train, held_out)?;
    let mut remarks = ready.remarks;
    let bench = Bench::new(model, &ready.train, &ready.held_out, options)?;
    if bench.held_out.is_none() {
        remarks.push("nothing was kept out, so that no improvement can be proved".to_owned());
    }
    say("baseline", "re-tuning", 0.05);
    let base = bench.baseline(model, control)?;
    say("baseline", "recordings kept out", 0.25);
    let base_held = bench.judge(&base.model, None, control)?;
    let baseline = Stand {
        train: base,
        held_out: base_held,
        named: Vec::new(),
    };

    say("ground", "bounces and releases", 0.3);
    let seen = events::read(&bench, &baseline.train, baseline.held_out.as_ref())?;
    let mut tests = laws::tests(&seen);
    let held_events = bench.held_out.is_some();
    let by_hand = |id: &str| {
        options
            .by_hand
            .as_ref()
            .map(|ids| ids.iter().any(|i| i == id))
    };
    let named = |t: &LawTest| by_hand(t.id).unwrap_or_else(|| passes(t, held_events));
    let compliant = tests
        .iter()
        .find(|t| t.id == "compliant_ground" && named(t))
        .cloned();

    say("naming", "", 0.35);
    let mut chosen = options.clone();
    if compliant.is_some() {
        // A level that gives way under load passes for one that steps.
        if chosen.candidates.is_empty() {
            chosen.candidates = CATALOGUE.iter().map(|e| e.id.to_owned()).collect();
        }
        chosen.candidates.retain(|id| id != "gap_step");
    }
    if !ready.may_name {
        chosen.most = 0;
    }
    let report = |detail: &str, share: f64| say("naming", detail, 0.35 + 0.4 * share);
    let mut found = explain::explain(&bench, baseline, &chosen, control, &report)?;

    let mut named_laws: Vec<LawTest> = Vec::new();
    if ready.may_name {
        if let Some(test) = compliant {
            named_laws.push(test);
        } else {
            if !found.stand.named.is_empty() {
                say("ground", "bounces and releases again", 0.78);
                let (t, h) = (&found.stand.train, found.stand.held_out.as_ref());
                tests = laws::tests(&events::read(&bench, t, h)?);
            }
            named_laws.extend(tests.iter().filter(|t| named(t)).cloned());
        }
    }

    say("evidence", "", 0.8);
    let before = Side::look(&found.baseline)?;
    let evidence = evidence::measure(&found.baseline.train)?;
    let some = !found.stand.named.is_empty();
    let after_evidence = if some {
        evidence::measure(&found.stand.train)?
    } else {
        evidence.clone()
    };
    let left = whats_left(&found.stand, &after_evidence);
    let mut verdict = if some || !named_laws.is_empty() {
        Verdict::MissingPhysics
    } else if left.is_some() {
        Verdict::Unexplained
    } else {
        Verdict::Adequate
    };
    if some && options.by_hand.is_none() {
        let carried: f64 = found.stand.named.iter().map(|n| n.gain.0).sum();
        let share =
            carried / (carried + after_evidence.joint.max(0.0) + excess(&found.stand.train));
        if share < CARRIED && left.is_some() {
            verdict = Verdict::Unexplained;
            let names: Vec<&str> = found.stand.named.iter().map(|n| n.spec.name).collect();
            remarks.push(format!(
                "{} would explain {:.0} % of what is missing, too little for a name",
                names.join(" and "),
                100.0 * share
            ));
            found.stand = found.baseline.clone();
        }
    }
    if let Some(left) = left.filter(|_| verdict != Verdict::Adequate) {
        remarks.push(left);
    }

    say("proof", "", 0.92);
    let model_of = |stand: &Stand, laws_too: bool| {
        let mut m = laws::baseline(&stand.train.model, &seen.train);
        for test in named_laws.iter().filter(|_| laws_too) {
            m = with_effect(&m, test.effect.clone());
            for (id, value) in &test.sets {
                m.parameters.set(*id, *value);
            }
        }
        m
    };
    let (bare, full) = (
        model_of(&found.baseline, false),
        model_of(&found.stand, true),
    );
    let after = Side::look(&found.stand)?;
    let named = names(&found, &named_laws, &after, &full)?;
    let candidates = candidates(&found, &tests, &named_laws, verdict);
    let noise = {
        let mut all: Vec<f64> = found
            .baseline
            .train
            .problem
            .data
            .iter()
            .map(|d| d.sigmas.xp)
            .collect();
        quantile_in_place(&mut all, 0.5)
    };
    let volts = found
        .baseline
        .train
        .problem
        .data
        .iter()
        .filter_map(|d| d.recording.voltage.as_ref())
        .flat_map(|v| v.iter())
        .filter(|v| v.is_finite())
        .fold(0.0f64, |a, v| a.max(v.abs()));
    let next_experiment = next(&found, &named, volts, noise, &bare);
    let mut mismatch = locate::mismatches(&found.baseline.train, &before.train);
    mismatch.extend(laws::mismatches(&named_laws, &seen, &found.baseline));
    let (mut strips, mut proof) =
        locate::strips((&found.baseline.train, &before.train), &after.train, false);
    if let Some(held) = &found.baseline.held_out {
        let (s, p) = locate::strips((held, &before.held_out), &after.held_out, true);
        strips.extend(s);
        proof.extend(p);
    }
    let mut forces = evidence.curves;
    for curve in &mut forces {
        curve.law = size::law_on(curve, &found, &before.train);
    }
    let distances = |pick: fn(&Stand) -> Option<&Fitted>, b: &[Sample], a: &[Sample]| BeforeAfter {
        before: pick(&found.baseline).map_or(Distance::default(), |f| locate::distance(f, b)),
        after: pick(&found.stand).map_or(Distance::default(), |f| locate::distance(f, a)),
    };
    say("done", "", 1.0);
    Ok(Diagnosis {
        verdict,
        named,
        candidates,
        mismatch,
        marginals: locate::marginals(&before.train, &after.train),
        forces,
        strips,
        events: events_seen(&seen, &found.baseline, &before),
        noise,
        train: distances(|s| Some(&s.train), &before.train, &after.train),
        held_out: distances(|s| s.held_out.as_ref(), &before.held_out, &after.held_out),
        proof,
        next_experiment,
        baseline: bare,
        model: full,
        remarks,
        cancelled: control.cancelled(),
    })
}

/// Fall of chi2 foreseen on the recordings kept out from which a law is named though the
/// fitted ones hardly tell it.
const FORESEEN: f64 = 60.0;

fn passes(test: &LawTest, held_events: bool) -> bool {
    let told = test.gain > TRAIN_GAIN && (!held_events || test.held_gain > 0.5 * HELD_GAIN);
    told || test.id == "adhesion_saturation" && test.gain > -HELD_GAIN && test.held_gain > FORESEEN
}

/// Samples of both sides.
struct Side {
    train: Vec<Sample>,
    held_out: Vec<Sample>,
}

impl Side {
    fn look(stand: &Stand) -> Result<Self, DiagnoseError> {
        let held_out = match &stand.held_out {
            Some(fitted) => locate::samples(fitted)?,
            None => Vec::new(),
        };
        Ok(Self {
            train: locate::samples(&stand.train)?,
            held_out,
        })
    }
}

/// Chi2 above the floor, all together.
fn excess(fitted: &Fitted) -> f64 {
    let rows = fitted.point.rows as f64;
    (fitted.cost - 1.03 * rows).max(0.0)
}

/// One sentence on what is not explained yet, if there is anything.
fn whats_left(stand: &Stand, evidence: &Evidence) -> Option<String> {
    let per_value = |f: &Fitted| f.cost / f.point.rows.max(1) as f64;
    let worst = stand
        .held_out
        .iter()
        .map(per_value)
        .fold(per_value(&stand.train), f64::max);
    if worst > FLOOR {
        return Some(format!(
            "what is left is {:.2} times the noise in the mean square: something is still not explained",
            worst
        ));
    }
    if evidence.joint > NAMELESS {
        let what = evidence.strongest.map_or("state", |s| s.0.symbol());
        return Some(format!(
            "a force that depends on {what} would still take away {:.0} of chi2",
            evidence.joint
        ));
    }
    let local = locate::most_local(&stand.train)
        .max(stand.held_out.as_ref().map_or(0.0, locate::most_local));
    (local > LOCAL)
        .then(|| format!("one stretch is {local:.0} standard deviations above what noise leaves"))
}

/// The named effects, strongest first.
fn names(
    found: &Explanation,
    named_laws: &[LawTest],
    after: &Side,
    full: &Model,
) -> Result<Vec<NamedEffect>, DiagnoseError> {
    let stand = &found.stand;
    let mut out: Vec<(f64, NamedEffect)> = Vec::new();
    if !stand.named.is_empty() {
        let prepared = Prepared {
            problem: stand.train.problem.clone(),
            segments: stand.train.point.segments.clone(),
            nuisances: Vec::new(),
        };
        let chi2 = stand.train.cost / stand.train.point.rows.max(1) as f64;
        let model = &stand.train.model;
        let told = uncertainty(model, &prepared, &stand.train.point, chi2.max(1.0))?;
        for n in &stand.named {
            let Some(effect) = model.effects.iter().find(|e| e.spec == n.spec) else {
                continue;
            };
            let parameters = n.spec.parameters.iter().zip(&effect.values);
            let parameters = parameters.map(|(p, value)| {
                let id = format!("{}.{}", n.spec.id, p.id);
                let fitted = told.parameters.iter().find(|t| t.id == id);
                Estimate {
                    id: p.id.to_owned(),
                    value: *value,
                    std_error: fitted.map_or(f64::INFINITY, |f| f.std_error),
                    unit: p.unit,
                }
            });
            let mut evidence = vec![format!(
                "chi2 falls by {:.0} on the fitted recordings and by {:.0} on those kept out",
                n.gain.0, n.gain.1
            )];
            if n.hypothesis.series {
                evidence
                    .push("its time counts through the recordings in the order given".to_owned());
            }
            out.push((
                n.gain.0,
                NamedEffect {
                    id: n.spec.id.to_owned(),
                    name: n.spec.name.to_owned(),
                    probability: probability(n.gain.0 + n.gain.1, n.alike.len()),
                    size: size::of(effect, model, &after.train),
                    parameters: parameters.collect(),
                    alike: n.alike.iter().map(|a| (*a).to_owned()).collect(),
                    evidence,
                },
            ));
        }
    }
    for test in named_laws {
        let parameters = test.effect.spec.parameters.iter().zip(&test.effect.values);
        let parameters = parameters
            .zip(&test.errors)
            .map(|((p, value), error)| Estimate {
                id: p.id.to_owned(),
                value: *value,
                std_error: *error,
                unit: p.unit,
            });
        out.push((
            test.gain,
            NamedEffect {
                id: test.id.to_owned(),
                name: test.effect.spec.name.to_owned(),
                probability: probability(test.gain + test.held_gain, 0),
                size: size::of(&test.effect, full, &after.train),
                parameters: parameters.collect(),
                alike: Vec::new(),
                evidence: vec![
                    test.evidence.clone(),
                    format!(
                        "chi2 of the events falls by {:.0} on the fitted recordings and by {:.0} on those kept out",
                        test.gain, test.held_gain
                    ),
                ],
            },
        ));
    }
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(out.into_iter().map(|(_, n)| n).collect())
}

/// Probability of a name whose chi2 fell by `worth` on both sides, shared with `alike`
/// others.
fn probability(worth: f64, alike: usize) -> f64 {
    let odds = (0.5 * worth - PRIOR).clamp(-700.0, 700.0);
    1.0 / (1.0 + (-odds).exp()) / (1 + alike) as f64
}

/// All effects of the catalogue, as far as they were weighed.
fn candidates(
    found: &Explanation,
    tests: &[LawTest],
    named_laws: &[LawTest],
    verdict: Verdict,
) -> Vec<Candidate> {
    let mut out: Vec<Candidate> = CATALOGUE
        .iter()
        .map(|spec| {
            let named = found.stand.named.iter().find(|n| n.spec == *spec);
            let weighed = found.weighed.iter().find(|w| w.spec == *spec);
            let trial = weighed.and_then(|w| w.trial.as_ref());
            let test = tests.iter().find(|t| t.id == spec.id);
            let law = named_laws.iter().any(|t| t.id == spec.id);
            let mut remarks = Vec::new();
            let (gain, held_gain, held_chi2) = match (trial, test) {
                (Some(t), _) => (
                    t.gain,
                    t.held_gain,
                    t.held_out
                        .as_ref()
                        .map_or(f64::NAN, |h| h.cost / h.point.rows.max(1) as f64),
                ),
                (None, Some(t)) => {
                    remarks.push(t.evidence.clone());
                    (t.gain, t.held_gain, t.held_chi2)
                }
                _ => (f64::NAN, f64::NAN, f64::NAN),
            };
            if let Some(t) = trial {
                remarks.push(if t.gain < TRAIN_GAIN {
                    "it improves the fit no more than chance does".to_owned()
                } else if found.stand.held_out.is_some() && t.held_gain < HELD_GAIN {
                    "its improvement does not hold on the recordings kept out".to_owned()
                } else if named.is_some() {
                    "it improves the fit on both sides more than any other".to_owned()
                } else {
                    "another effect improves the fit more, and leaves nothing for it".to_owned()
                });
            } else if weighed.is_some() {
                remarks.push("re-tuning explains all that it could".to_owned());
            } else if test.is_none() {
                remarks.push("these recordings do not ask about it".to_owned());
            }
            let probability = match (named, verdict) {
                (Some(n), Verdict::MissingPhysics) => {
                    probability(n.gain.0 + n.gain.1, n.alike.len())
                }
                _ if law => test.map_or(0.0, |t| probability(t.gain + t.held_gain, 0)),
                _ => {
                    let alike = found
                        .stand
                        .named
                        .iter()
                        .find(|n| n.alike.contains(&spec.id));
                    match (alike, trial) {
                        (Some(n), Some(t)) => probability(t.worth(), n.alike.len()),
                        // What others explain better has no odds of its own.
                        _ if found.stand.named.is_empty() && gain.is_finite() => {
                            probability(gain.min(gain + held_gain), 0).min(0.5)
                        }
                        _ => 0.0,
                    }
                }
            };
            Candidate {
                id: spec.id.to_owned(),
                name: spec.name.to_owned(),
                probability,
                score: weighed.map_or(0.0, |w| w.promise),
                gain,
                held_out_gain: held_gain,
                held_out_chi2: held_chi2,
                remarks,
            }
        })
        .collect();
    out.sort_by(|a, b| {
        b.probability
            .total_cmp(&a.probability)
            .then(b.score.total_cmp(&a.score))
    });
    out
}

/// The recording that would tell the best name from the next.
fn next(
    found: &Explanation,
    named: &[NamedEffect],
    volts: f64,
    noise: f64,
    bare: &Model,
) -> Option<super::result::NextExperiment> {
    let mut trials: Vec<_> = found
        .weighed
        .iter()
        .filter_map(|w| w.trial.as_ref().map(|t| (w.spec.id, t)))
        .filter(|(_, t)| t.gain > 0.0)
        .collect();
    trials.sort_by(|a, b| b.1.worth().total_cmp(&a.1.worth()));
    let whole = |m: &Model| {
        let mut m = m.clone();
        for (id, value) in bare.parameters.iter() {
            use crate::model::parameter::ParameterId as P;
            if matches!(id, P::Alpha | P::Ca | P::Ca0) {
                m.parameters.set(id, value);
            }
        }
        m
    };
    match (trials.first(), trials.get(1)) {
        (Some(a), Some(b))
            if named.is_empty() || found.stand.named.iter().any(|n| n.spec.id == a.0) =>
        {
            let (ma, mb) = (whole(&a.1.train.model), whole(&b.1.train.model));
            experiment((&ma, a.0), (&mb, b.0), volts, noise)
        }
        (Some(a), None) => experiment(
            (&whole(&a.1.train.model), a.0),
            (bare, "nothing"),
            volts,
            noise,
        ),
        _ => None,
    }
}

fn events_seen(ground: &events::Ground, baseline: &Stand, sides: &Side) -> EventsSeen {
    let mut seen = EventsSeen::default();
    let shift = baseline.train.problem.data.len();
    for (readings, first) in [(&ground.train, 0), (&ground.held_out, shift)] {
        seen.bounces
            .extend(readings.bounces.iter().map(|b| BounceSeen {
                recording: first + b.recording,
                time: b.time,
                speed: b.approach,
                ratio: b.ratio,
                ratio_error: b.error,
                dwell: -b.miss / b.approach.max(1e-12),
                dwell_error: b.miss_error / b.approach.max(1e-12),
            }));
        seen.releases
            .extend(readings.releases.iter().map(|r| ReleaseSeen {
                recording: first + r.recording,
                time: r.time,
                contact: r.contact,
                force: r.force,
                force_error: r.error,
            }));
    }
    for (samples, first, fitted) in [
        (&sides.train, 0, Some(&baseline.train)),
        (&sides.held_out, shift, baseline.held_out.as_ref()),
    ] {
        let Some(fitted) = fitted else { continue };
        for group in samples.chunk_by(|a, b| a.segment == b.segment) {
            let held = &fitted.point.segments[group[0].segment].starts_held;
            let misses: Vec<f64> = group
                .iter()
                .map(|s| s.miss_p)
                .filter(|m| m.is_finite())
                .collect();
            if !held || misses.len() < 8 {
                continue;
            }
            let n = misses.len() as f64;
            seen.levels.push(LevelSeen {
                recording: first + group[0].recording,
                time: 0.5 * (group[0].time + group[group.len() - 1].time),
                miss: misses.iter().sum::<f64>() / n,
                error: fitted.problem.data[group[0].recording].sigmas.xp / n.sqrt(),
            });
        }
    }
    seen
}
