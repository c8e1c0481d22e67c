//! The answer put together from what the search found: named effects, everything that
//! was weighed, the events as seen, the next experiment.

use super::effect_size;
use super::next_experiment::experiment;
use super::systematic_error::untold;
use crate::diagnose::comparison::significance::HELD_GAIN;
use crate::diagnose::contact::bounce_readings::at_once;
use crate::diagnose::contact::event_readings;
use crate::diagnose::contact::restitution::LawTest;
use crate::diagnose::diagnosis::{
    BounceSeen, Candidate, Estimate, EventsSeen, Left, LevelSeen, NamedEffect, ReleaseSeen, Verdict,
};
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::discrepancy::residual_map::Sample;
use crate::diagnose::hypotheses::propose::PROMISING;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::selection::forward::{Explanation, Stand};
use crate::diagnose::selection::self_ringing;
use crate::fit::problem::prepare::Prepared;
use crate::fit::uncertainty::fit_result::uncertainty;
use crate::model::Model;
use crate::model::effects::CATALOGUE;

/// Logarithm of the odds against any one effect before the data speak.
const PRIOR: f64 = 10.0;
/// Share of the names given in sealed trials that were right, 246 of 260, whatever they
/// brought from a fall of chi2 of 50 to one of 1e5: a law outside the catalogue imitates one
/// inside as well where it is strong.
pub const RELIABLE: f64 = 0.95;

/// Share of what was called unexplained in sealed trials that an effect of the catalogue was
/// behind after all, 5 of 27.
const AFTER_ALL: f64 = 0.2;

/// Samples of both sides.
pub struct Side {
    /// Of the fitted recordings.
    pub train: Vec<Sample>,
    /// Of those kept out.
    pub held_out: Vec<Sample>,
}

impl Side {
    /// Looks at a stand.
    ///
    /// # Errors
    /// [`DiagnoseError`] if its model cannot be simulated.
    pub fn look(stand: &Stand) -> Result<Self, DiagnoseError> {
        let held_out = match &stand.held_out {
            Some(fitted) => residual_map::samples(fitted)?,
            None => Vec::new(),
        };
        Ok(Self {
            train: residual_map::samples(&stand.train)?,
            held_out,
        })
    }
}

/// The named effects, strongest first.
pub fn names(
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
            let all = n.spec.parameters.iter().zip(&effect.values);
            let bearing = all.enumerate().filter(|(i, _)| effect.bears(*i));
            let parameters = bearing.map(|(_, (p, value))| {
                let id = format!("{}.{}", n.spec.id, p.id);
                let fitted = told.parameters.iter().find(|t| t.id == id);
                Estimate {
                    id: p.id.to_owned(),
                    value: *value,
                    std_error: match n.hypothesis.told_by {
                        // Chi2 falls by the square of a height in its standard errors.
                        Some(_) if n.hypothesis.free.contains(&id) => {
                            value.abs() / (n.gain.0 + n.gain.1).max(1.0).sqrt()
                        }
                        _ => fitted.map_or(f64::INFINITY, |f| {
                            f.std_error.hypot(untold(n.spec, p, *value))
                        }),
                    },
                    unit: p.unit,
                }
            });
            let told_by = n.hypothesis.told_by.zip(stand.held_out.as_ref());
            let mut evidence = vec![match told_by {
                Some((k, held)) => format!(
                    "it happens after the fitted recordings: chi2 falls by {:.0} on {}, by which it is told, and by {:.0} on the others kept out",
                    n.gain.0, held.problem.data[k].recording.name, n.gain.1
                ),
                None => format!(
                    "chi2 falls by {:.0} on the fitted recordings and by {:.0} on those kept out",
                    n.gain.0, n.gain.1
                ),
            }];
            evidence.extend(n.told.clone());
            evidence.extend(self_ringing::beside_it(effect));
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
                    size: effect_size::of(effect, model, &after.train),
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
                std_error: error.hypot(untold(test.effect.spec, p, *value)),
                unit: p.unit,
            });
        out.push((
            test.gain,
            NamedEffect {
                id: test.id.to_owned(),
                name: test.effect.spec.name.to_owned(),
                probability: probability(test.gain + test.held_gain, 0),
                size: effect_size::of(&test.effect, full, &after.train),
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
/// others: the odds that it is no chance, and how often names that were none were right.
fn probability(worth: f64, alike: usize) -> f64 {
    let odds = (0.5 * worth - PRIOR).clamp(-700.0, 700.0);
    RELIABLE / (1.0 + (-odds).exp()) / (1 + alike) as f64
}

/// All effects of the catalogue, as far as they were weighed.
pub fn candidates(
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
            if let Some(f) = weighed.and_then(|w| w.by_itself) {
                remarks.push(format!(
                    "{}: nothing that moves the device moves it",
                    Left::Ring(f).text()
                ));
            } else if let Some(t) = trial {
                remarks.push(if t.by_chance() {
                    "it improves the fit no more than chance does".to_owned()
                } else if found.stand.held_out.is_some() && t.held_gain < HELD_GAIN {
                    "its improvement does not hold on the recordings kept out".to_owned()
                } else if named.is_some() {
                    "it improves the fit on both sides more than any other".to_owned()
                } else {
                    "another effect improves the fit more, and leaves nothing for it".to_owned()
                });
            } else if weighed.is_some_and(|w| w.promise > PROMISING) {
                remarks.push("it promises far less than the best, and was not fitted".to_owned());
            } else if weighed.is_some() {
                remarks.push("re-tuning explains all that it could".to_owned());
            } else if !found.baseline.train.model.allows(spec) {
                remarks.push("this device has nothing that it acts on".to_owned());
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
    if verdict == Verdict::Unexplained {
        // They share what chance there is that it was one of them after all.
        let all: f64 = out.iter().map(|c| c.probability).sum();
        let share = AFTER_ALL / all.max(AFTER_ALL);
        out.iter_mut().for_each(|c| c.probability *= share);
    }
    out.sort_by(|a, b| {
        b.probability
            .total_cmp(&a.probability)
            .then(b.score.total_cmp(&a.score))
    });
    out
}

/// The recording that would tell the best name from the next.
pub fn next(
    found: &Explanation,
    named: &[NamedEffect],
    volts: f64,
    noise: f64,
    bare: &Model,
) -> Option<crate::diagnose::diagnosis::NextExperiment> {
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

/// The events at the ground as measured against the baseline.
pub fn events_seen(ground: &event_readings::Ground, baseline: &Stand, sides: &Side) -> EventsSeen {
    let mut seen = EventsSeen::default();
    let shift = baseline.train.problem.data.len();
    for (readings, first) in [(&ground.train, 0), (&ground.held_out, shift)] {
        seen.bounces.extend(readings.bounces.iter().map(|b| {
            // As the law of restitution is fitted to them.
            let (ratio, ratio_error) = at_once(&readings.bounces, b);
            BounceSeen {
                recording: first + b.recording,
                time: b.time,
                speed: b.approach,
                ratio,
                ratio_error,
                dwell: -b.miss / b.approach.max(1e-12),
                dwell_error: b.miss_error / b.approach.max(1e-12),
            }
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
