//! Naming: hypotheses are promised by the scan, refitted, judged on the recordings kept
//! out, and added one by one as long as both sides improve beyond chance.

use super::bench::{Bench, Bound, Fitted, with_effect};
use super::kin;
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use super::promises::{FOUND, Hypothesis, PROMISING, promises};
use crate::model::Model;
use crate::model::effects::EffectSpec;

/// Share of the best refit below which a promise is far behind.
const FAR: f64 = 0.3;
/// Least fall of chi2 on the fitted recordings for a name. The best of some thirty
/// directions and some thousand frequencies falls by up to 20 by chance alone.
pub const TRAIN_GAIN: f64 = 30.0;
/// The same where the best of many times or frequencies was searched for.
const SEARCHED_GAIN: f64 = 50.0;
/// An earlier effect that brought so many times more than a later one is not asked again
/// whether it is needed.
const SURE: f64 = 4.0;
/// Least fall on the recordings kept out.
pub const HELD_GAIN: f64 = 10.0;
/// A further name must explain this share of what the first ones explained.
const SHARE: f64 = 0.004;
/// Two hypotheses whose gains differ by less than this share cannot be told apart.
const ALIKE: f64 = 0.03;
/// Nor if they differ by less than this.
const ALIKE_LEAST: f64 = 8.0;
/// Most hypotheses refitted in a round.
const MOST: usize = 4;

/// A hypothesis after a fit with it.
#[derive(Debug, Clone)]
pub struct Weighed {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Fall of chi2 promised.
    pub promise: f64,
    /// The fit, if it was worth one.
    pub trial: Option<Trial>,
}

/// A fit with one more effect, judged.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Of the fitted recordings.
    pub train: Fitted,
    /// Of those kept out.
    pub held_out: Option<Fitted>,
    /// Fall of chi2 on the fitted recordings.
    pub gain: f64,
    /// Fall on those kept out; 0 if there are none.
    pub held_gain: f64,
    /// The hypothesis.
    pub hypothesis: Hypothesis,
}

impl Trial {
    /// Both gains.
    pub fn worth(&self) -> f64 {
        self.gain + self.held_gain
    }
}

/// Where the search stands: a model with the effects named so far.
#[derive(Debug, Clone)]
pub struct Stand {
    /// Fit to the recordings to be fitted.
    pub train: Fitted,
    /// Those kept out, judged.
    pub held_out: Option<Fitted>,
    /// The effects named, in the order found.
    pub named: Vec<Named>,
}

impl Stand {
    /// The effects named.
    pub fn specs(&self) -> Vec<&'static EffectSpec> {
        self.named.iter().map(|n| n.spec).collect()
    }
}

/// An effect that was named.
#[derive(Debug, Clone)]
pub struct Named {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Its freedoms.
    pub hypothesis: Hypothesis,
    /// Fall of chi2 that it brought on either side.
    pub gain: (f64, f64),
    /// Others that did as well.
    pub alike: Vec<&'static str>,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// The re-tuned baseline.
    pub baseline: Stand,
    /// With the effects named.
    pub stand: Stand,
    /// Everything weighed against the baseline.
    pub weighed: Vec<Weighed>,
}

/// Looks for what `baseline` lacks.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn explain(
    bench: &Bench,
    baseline: Stand,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<Explanation, DiagnoseError> {
    let mut stand = baseline.clone();
    let mut bench = bench.clone();
    let mut weighed: Vec<Weighed> = Vec::new();
    let mut explained = 0.0;
    let rounds = options.by_hand.as_ref().map_or(options.most, Vec::len);
    for round in 0..rounds {
        if control.cancelled() {
            break;
        }
        let about = |detail: &str, share: f64| {
            report(detail, (round as f64 + share) / rounds as f64);
        };
        let only = options.by_hand.as_ref().map(|ids| ids[round].as_str());
        let round_weighed = weigh(&bench, &stand, options, only, control, &about)?;
        let best = round_weighed
            .iter()
            .filter_map(|w| w.trial.as_ref().map(|t| (w.spec, t)))
            .max_by(|a, b| a.1.worth().total_cmp(&b.1.worth()))
            .map(|(spec, t)| (spec, t.clone()));
        let alike: Vec<&'static str> = best.as_ref().map_or(Vec::new(), |(spec, best)| {
            let slack = (ALIKE * best.worth()).max(ALIKE_LEAST);
            let near = |w: &&Weighed| {
                w.spec != *spec
                    && w.trial
                        .as_ref()
                        .is_some_and(|t| t.worth() > best.worth() - slack)
            };
            round_weighed
                .iter()
                .filter(near)
                .map(|w| w.spec.id)
                .collect()
        });
        if round == 0 {
            weighed = round_weighed;
        }
        let Some((spec, trial)) = best else {
            // Asked for by hand, the next one may still be something.
            if only.is_some() {
                continue;
            }
            break;
        };
        let held = bench.held_out.is_none() || trial.held_gain > HELD_GAIN;
        let least = if trial.hypothesis.searched {
            SEARCHED_GAIN
        } else {
            TRAIN_GAIN
        };
        let chance = trial.gain < least || !held || trial.worth() < SHARE * explained;
        if only.is_none() && (chance || formal(&stand, &trial)?) {
            break;
        }
        explained += trial.worth();
        if trial.hypothesis.series {
            bench = bench.in_series();
        }
        stand.named.push(Named {
            spec,
            hypothesis: trial.hypothesis,
            gain: (trial.gain, trial.held_gain),
            alike,
        });
        stand.train = trial.train;
        stand.held_out = trial.held_out;
        if only.is_none() {
            drop_needless(&bench, &mut stand, control)?;
        }
    }
    Ok(Explanation {
        baseline,
        stand,
        weighed,
    })
}

/// Whether what `trial` brings is little more than the effects named before would bring if
/// their laws were of somewhat other form.
fn formal(stand: &Stand, trial: &Trial) -> Result<bool, DiagnoseError> {
    let named = stand.specs();
    if named.is_empty() {
        return Ok(false);
    }
    let (before, after) = (
        kin::gain(&stand.train, &named)?,
        kin::gain(&trial.train, &named)?,
    );
    let own = 1.0 - (before - after).max(0.0) / trial.gain;
    log::debug!(
        "{}: kin of those named bring {before:.0} without it and {after:.0} with it, of {:.0}",
        trial.hypothesis.start.spec.id,
        trial.gain
    );
    let held = trial.held_out.is_some() && own * trial.held_gain < HELD_GAIN;
    Ok(own * trial.gain < TRAIN_GAIN || held)
}

/// Weighs all hypotheses that `stand` does not have yet, or `only` one effect whatever it
/// promises.
fn weigh(
    bench: &Bench,
    stand: &Stand,
    options: &DiagnoseOptions,
    only: Option<&str>,
    control: &DiagnoseControl<'_>,
    about: &dyn Fn(&str, f64),
) -> Result<Vec<Weighed>, DiagnoseError> {
    about("scan of the catalogue", 0.0);
    let mut hypotheses = promises(bench, stand)?;
    let wanted = |id: &str| match only {
        Some(only) => only == id,
        None => options.candidates.is_empty() || options.candidates.iter().any(|c| c == id),
    };
    let has = |spec: &EffectSpec| stand.named.iter().any(|n| n.spec == spec);
    hypotheses.retain(|h| wanted(h.start.spec.id) && !has(h.start.spec));
    hypotheses.sort_by(|a, b| b.promise.total_cmp(&a.promise));
    for h in &hypotheses {
        let start = &h.start;
        log::debug!(
            "{} promises {:.1} at {:?}",
            start.spec.id,
            h.promise,
            start.values
        );
    }
    let mut out: Vec<Weighed> = Vec::new();
    let mut best = 0.0f64;
    let count = hypotheses.len().clamp(1, MOST);
    for (k, hypothesis) in hypotheses.into_iter().enumerate() {
        // Where the promise is far below what a refit has reached, a refit is in vain:
        // promises are right where the baseline is near the data.
        let least = if hypothesis.searched {
            FOUND
        } else {
            PROMISING
        };
        let worth = hypothesis.promise > least && hypothesis.promise > FAR * best;
        let worth = worth || only.is_some();
        let mut trial = None;
        if k < MOST && worth && !control.cancelled() {
            about(
                hypothesis.start.spec.name,
                (k + 1) as f64 / (count + 1) as f64,
            );
            trial = attempt(bench, stand, &hypothesis, control)?;
            best = trial.as_ref().map_or(best, |t| best.max(t.gain));
        }
        out.push(Weighed {
            spec: hypothesis.start.spec,
            promise: hypothesis.promise,
            trial,
        });
    }
    Ok(out)
}

/// A fit with one more effect, or `None` if it cannot be simulated.
fn attempt(
    bench: &Bench,
    stand: &Stand,
    hypothesis: &Hypothesis,
    control: &DiagnoseControl<'_>,
) -> Result<Option<Trial>, DiagnoseError> {
    let start = with_effect(&stand.train.model, hypothesis.start.clone());
    let (mut free, mut bounds) = freedoms(stand);
    free.extend_from_slice(&hypothesis.free);
    bounds.extend_from_slice(&hypothesis.bounds);
    let series = hypothesis.series.then(|| bench.in_series());
    let bench = series.as_ref().unwrap_or(bench);
    let train = match bench.fit(&start, &free, &bounds, &stand.train, 12, control) {
        Ok(fitted) => fitted,
        Err(DiagnoseError::Sim(_)) => return Ok(None),
        Err(error) => return Err(error),
    };
    let held_out = bench.judge(&train.model, (&train, stand.held_out.as_ref()), control)?;
    let held_gain = match (&stand.held_out, &held_out) {
        (Some(before), Some(after)) => before.cost - after.cost,
        _ => 0.0,
    };
    Ok(Some(Trial {
        gain: stand.train.cost - train.cost,
        held_gain,
        train,
        held_out,
        hypothesis: hypothesis.clone(),
    }))
}

/// Freedoms and bounds of the effects named so far.
fn freedoms(stand: &Stand) -> (Vec<String>, Vec<Bound>) {
    let all = stand.named.iter().map(|n| &n.hypothesis);
    (
        all.clone().flat_map(|h| h.free.clone()).collect(),
        all.flat_map(|h| h.bounds.clone()).collect(),
    )
}

/// Drops effects that a later one has made needless.
fn drop_needless(
    bench: &Bench,
    stand: &mut Stand,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    let mut k = 0;
    while stand.named.len() > 1 && k + 1 < stand.named.len() {
        if control.cancelled() {
            break;
        }
        // Each was the best of its round: without it at least what the next ones brought
        // would be lost.
        let latest = stand.named.last().map_or(0.0, |n| n.gain.0);
        let own = stand.named[k].gain.0;
        if latest > SURE * TRAIN_GAIN && own > SURE * latest {
            k += 1;
            continue;
        }
        let mut without = stand.clone();
        let dropped = without.named.remove(k);
        let mut start: Model = stand.train.model.clone();
        start.effects.retain(|e| e.spec != dropped.spec);
        let (free, bounds) = freedoms(&without);
        let train = match bench.fit(&start, &free, &bounds, &stand.train, 12, control) {
            Ok(fitted) => fitted,
            Err(DiagnoseError::Sim(_)) => {
                k += 1;
                continue;
            }
            Err(error) => return Err(error),
        };
        let held_out = bench.judge(&train.model, (&train, stand.held_out.as_ref()), control)?;
        let lost = train.cost - stand.train.cost;
        let held_lost = match (&held_out, &stand.held_out) {
            (Some(after), Some(before)) => after.cost - before.cost,
            _ => HELD_GAIN,
        };
        if lost < TRAIN_GAIN || held_lost < 0.5 * HELD_GAIN {
            without.train = train;
            without.held_out = held_out;
            *stand = without;
        } else {
            k += 1;
        }
    }
    Ok(())
}
