//! Ranks the effects that could explain what a fit to Table A.1 cannot reach.
//!
//! Each candidate is added in several sizes; its size and the parameters are then improved
//! together. The best are cross-validated: fitted without one frequency, evaluated on it.
//!
//! Peaks, contacts and counted bounces jump as parameters move, so the search uses no gradients.
//! It varies one unknown after the other in shrinking steps (compass search: Kolda, Lewis and
//! Torczon, SIAM Review 45, 385, 2003).
//!
//! Not ranked: a further mode, a vibration and effects of a single recording, because peaks,
//! contacts and bounces say nothing about their constants; a compliant ground and a compressible
//! film, because they act for microseconds and take twenty times as long to simulate.

use serde::Serialize;

use super::calibrate::{
    FREE_PARAMETERS, Misfit, TableFit, cost, misfit, model_at, rows, with_values,
};
use super::measurements::{Case, cases};
use crate::fit::thresholds::MIN_GAIN_SIGMAS;
use crate::model::Model;
use crate::model::effects::{ActiveEffect, CATALOGUE, EffectSpec, find};
use crate::model::parameter::{ParameterId, Scale};

/// Candidate effects, and the parameter that is their strength: those that features determine.
fn candidate_effects() -> Vec<(&'static str, &'static str)> {
    let strength = |e: &&'static EffectSpec| Some((e.id, e.facts.feature_strength?));
    CATALOGUE.iter().filter_map(strength).collect()
}

/// Sizes of an effect that are tried, as shares of the end of its slider; for one whose slider
/// is logarithmic, places on it.
const EFFECT_SIZE_SHARES: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0];
/// Steps of the parameters, on their sliders.
const SLIDER_STEPS: [f64; 3] = [0.06, 0.03, 0.015];
/// A step of the effect's size is the factor one plus so many of those.
const EFFECT_STEP_FACTOR: f64 = 10.0;
/// Number of candidates, the best first, that are cross-validated at held-out frequencies.
const CROSS_VALIDATED: usize = 3;

/// An effect fitted together with the parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RankedEffect {
    /// Id of the effect.
    pub id: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Id of its strength.
    pub strength: &'static str,
    /// The strength as fitted, in `unit`.
    pub value: f64,
    /// Unit of the strength.
    pub unit: &'static str,
    /// Sum of robust squares over all rows.
    pub cost: f64,
    /// Errors over all rows.
    pub after: Misfit,
    /// For each held-out frequency \[Hz\]: the cost of its rows without and with the effect,
    /// neither fitted to them. Empty if the effect was not cross-validated.
    pub left_out: Vec<(f64, f64, f64)>,
    /// The model with it.
    #[serde(skip)]
    pub model: Model,
}

impl RankedEffect {
    /// Mean fall of the cost at a held-out frequency, and its standard error from the scatter of
    /// the frequencies; `None` if the effect was not cross-validated.
    pub fn gain(&self) -> Option<(f64, f64)> {
        let n = self.left_out.len() as f64;
        if n < 2.0 {
            return None;
        }
        let gains = || {
            self.left_out
                .iter()
                .map(|(_, without, with)| without - with)
        };
        let mean = gains().sum::<f64>() / n;
        let square = gains().map(|g| (g - mean).powi(2)).sum::<f64>();
        Some((mean, (square / (n * (n - 1.0))).sqrt()))
    }

    /// Whether the held-out frequencies agree that the effect improves the agreement.
    pub fn is_supported(&self) -> bool {
        self.gain()
            .is_some_and(|(mean, error)| mean > MIN_GAIN_SIGMAS * error)
    }
}

/// All candidate effects, the one with the lowest cost first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectRanking {
    /// Sum of robust squares over all rows without any effect.
    pub cost: f64,
    /// The candidates.
    pub list: Vec<RankedEffect>,
    /// Whether it was stopped: then some candidates are missing.
    pub cancelled: bool,
}

impl EffectRanking {
    /// The two best supported, which a next experiment should distinguish: those supported by the
    /// held-out frequencies first, then by cost.
    pub fn pair(&self) -> Option<(&RankedEffect, &RankedEffect)> {
        let mut all: Vec<&RankedEffect> = self.list.iter().collect();
        all.sort_by_key(|s| !s.is_supported());
        match all[..] {
            [a, b, ..] => Some((a, b)),
            _ => None,
        }
    }
}

/// One candidate: which parameter of which effect is its strength.
#[derive(Clone, Copy)]
struct CandidateStrength {
    spec: &'static EffectSpec,
    which: usize,
}

impl CandidateStrength {
    fn of(id: &str, strength: &str) -> Option<Self> {
        let spec = find(id)?;
        let which = spec.parameters.iter().position(|p| p.id == strength)?;
        Some(Self { spec, which })
    }

    /// `model` with it, of a given strength.
    fn on(self, model: &Model, strength: f64) -> Model {
        let mut values: Vec<f64> = self.spec.parameters.iter().map(|p| p.default).collect();
        values[self.which] = strength;
        let mut model = model.clone();
        model.effects.push(ActiveEffect {
            spec: self.spec,
            values,
        });
        model
    }

    /// The strengths that are tried.
    fn sizes(self) -> Vec<f64> {
        let parameter = &self.spec.parameters[self.which];
        let (low, high) = parameter.range;
        if matches!(parameter.scale, Scale::Log) {
            return EFFECT_SIZE_SHARES
                .iter()
                .map(|place| parameter.value_at(*place))
                .collect();
        }
        let up = EFFECT_SIZE_SHARES.iter().map(|share| share * high);
        let down = EFFECT_SIZE_SHARES
            .iter()
            .map(|share| share * low)
            .filter(|v| *v < 0.0);
        up.chain(down).collect()
    }
}

/// A point of the search.
#[derive(Clone)]
struct SearchPoint {
    /// Places of the parameters on their sliders.
    point: Vec<f64>,
    /// Strength of the effect.
    strength: f64,
    cost: f64,
}

/// A compass search with or without a candidate, by the cost of some cases.
struct CompassSearch<'a> {
    base: &'a Model,
    own: Option<CandidateStrength>,
    shown: &'a [Case],
    steps: &'a [f64],
}

impl CompassSearch<'_> {
    fn model(&self, found: &SearchPoint) -> Model {
        let model = model_at(self.base, &found.point);
        match self.own {
            Some(own) => own.on(&model, found.strength),
            None => model,
        }
    }

    /// `found` with its cost.
    fn evaluated(&self, mut found: SearchPoint) -> SearchPoint {
        found.cost = cost(&rows(&self.model(&found), self.shown));
        found
    }

    /// The best of all sizes of the candidate at `point`, improved together with the parameters
    /// until `go_on`, which gets the share done, returns false.
    fn search(&self, point: Vec<f64>, go_on: &mut dyn FnMut(f64) -> bool) -> SearchPoint {
        let begin = |strength: f64| {
            self.evaluated(SearchPoint {
                point: point.clone(),
                strength,
                cost: f64::INFINITY,
            })
        };
        let sizes = self.own.map_or(vec![0.0], CandidateStrength::sizes);
        let begun = sizes.into_iter().map(begin);
        let Some(mut best) = begun.min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
            return begin(0.0);
        };
        let unknowns = FREE_PARAMETERS.len() + usize::from(self.own.is_some());
        for (round, &step) in self.steps.iter().enumerate() {
            for k in 0..unknowns {
                let share = (round * unknowns + k) as f64 / (self.steps.len() * unknowns) as f64;
                if !go_on(share) {
                    return best;
                }
                let moved = |step: f64| {
                    let mut there = best.clone();
                    match there.point.get_mut(k) {
                        Some(place) => *place = (*place + step).clamp(0.0, 1.0),
                        None => {
                            there.strength *=
                                (1.0 + EFFECT_STEP_FACTOR * step.abs()).powf(step.signum())
                        }
                    }
                    self.evaluated(there)
                };
                let (up, down) = (moved(step), moved(-step));
                let near = if up.cost < down.cost { up } else { down };
                if near.cost < best.cost {
                    best = near;
                }
            }
        }
        best
    }
}

/// Ranks all candidates after `fit` of `base`. Deterministic. `progress` gets the share done, and
/// ends the work by returning `false`.
pub fn rank_effects(
    base: &Model,
    fit: &TableFit,
    progress: impl FnMut(f64) -> bool,
) -> EffectRanking {
    rank_candidates(base, fit, (&candidate_effects(), &SLIDER_STEPS), progress)
}

/// Ranks some candidates, in given steps.
fn rank_candidates(
    base: &Model,
    fit: &TableFit,
    (which, steps): (&[(&str, &str)], &[f64]),
    mut progress: impl FnMut(f64) -> bool,
) -> EffectRanking {
    let free = |own: &CandidateStrength| base.effects.iter().all(|e| e.spec != own.spec);
    let all = which
        .iter()
        .filter_map(|(id, s)| CandidateStrength::of(id, s));
    let asked: Vec<CandidateStrength> = all.filter(free).collect();
    let checked = CROSS_VALIDATED.min(asked.len());
    let searches = (1 + asked.len() + (1 + checked) * fit.left_out.len()) as f64;
    let (mut done, mut stopped) = (0.0, false);
    // Each search begins at the fit without the effect. So does the one without any effect, so
    // that none gains by the search alone.
    let mut search =
        |own: Option<CandidateStrength>, from: &Model, shown: &[Case]| -> (SearchPoint, Model) {
            let place = |id: &ParameterId| id.spec().fraction(from.parameters[*id]).clamp(0.0, 1.0);
            let compass = CompassSearch {
                base,
                own,
                shown,
                steps,
            };
            let found = compass.search(FREE_PARAMETERS.iter().map(place).collect(), &mut |share| {
                stopped |= !progress((done + share) / searches);
                !stopped
            });
            done += 1.0;
            let model = compass.model(&found);
            (found, model)
        };
    let without = search(None, &fit.model, cases()).0.cost;
    let mut list = Vec::new();
    for own in &asked {
        let (found, model) = search(Some(*own), &fit.model, cases());
        let parameter = &own.spec.parameters[own.which];
        list.push(RankedEffect {
            id: own.spec.id,
            name: own.spec.name,
            strength: parameter.id,
            value: found.strength,
            unit: parameter.unit,
            cost: found.cost,
            after: misfit(&rows(&model, cases())),
            left_out: Vec::new(),
            model,
        });
    }
    list.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    for left in &fit.left_out {
        let (hidden, shown): (Vec<Case>, Vec<Case>) =
            cases().iter().partition(|c| c.frequency == left.frequency);
        let begun = with_values(base, &left.values);
        let mut unseen =
            |own: Option<CandidateStrength>| cost(&rows(&search(own, &begun, &shown).1, &hidden));
        let without = unseen(None);
        for effect in list.iter_mut().take(CROSS_VALIDATED) {
            let own = asked.iter().find(|a| a.spec.id == effect.id);
            let with = unseen(own.copied());
            effect.left_out.push((left.frequency, without, with));
        }
    }
    // What was stopped on the way says nothing.
    if stopped {
        list.iter_mut().for_each(|s| s.left_out.clear());
    }
    EffectRanking {
        cost: without,
        list,
        cancelled: stopped,
    }
}

#[cfg(test)]
mod tests {
    use super::super::calibrate::fit_table;
    use super::super::rank_effects::*;
    use crate::model::preset::Preset;

    #[test]
    fn every_candidate_is_tried_in_sizes_within_its_slider() {
        for (id, strength) in candidate_effects() {
            let own = CandidateStrength::of(id, strength).expect(id);
            let (low, high) = own.spec.parameters[own.which].range;
            let sizes = own.sizes();
            assert!(sizes.len() >= EFFECT_SIZE_SHARES.len(), "{id}");
            assert!(
                sizes.iter().all(|s| (low..=high).contains(s)),
                "{id}: {sizes:?}"
            );
            let both = sizes.iter().any(|s| *s < 0.0);
            assert_eq!(both, low < 0.0, "{id}: {sizes:?}");
        }
    }

    #[test]
    fn candidates_never_raise_the_cost_and_can_be_stopped() {
        let base = Preset::default().model;
        let mut fit = fit_table(&base, 1, |_| true);
        fit.left_out.truncate(2);
        let all = candidate_effects();
        let some = (&all[8..9], &SLIDER_STEPS[..1]);
        let all = rank_candidates(&base, &fit, some, |_| true);
        assert_eq!(all.list.len(), 1);
        assert!(!all.cancelled && all.pair().is_none());
        // The search goes on from where the fit has come.
        assert!(all.cost <= cost(&rows(&fit.model, cases())));
        let own = &all.list[0];
        assert_eq!(own.cost, cost(&rows(&own.model, cases())));
        let effect = own.model.effects.last().unwrap();
        assert_eq!((effect.spec.id, effect.values[0]), (own.id, own.value));
        assert!(all.list[0].gain().is_some());
        // Two frequencies that gain 1 and 3: 2 +- 1.
        let mut one = all.list[0].clone();
        one.left_out = vec![(5.0, 3.0, 2.0), (15.0, 6.0, 3.0)];
        assert_eq!(one.gain(), Some((2.0, 1.0)));
        assert!(!one.is_supported());
        one.left_out[1].2 = 4.5;
        assert!(one.is_supported());
        // Of several, those that are supported come first, then the best.
        let mut three = all.clone();
        three.list = vec![all.list[0].clone(), one.clone(), all.list[0].clone()];
        three.list[0].left_out.clear();
        three.list[2].left_out.clear();
        three.list[0].id = "near";
        let (first, second) = three.pair().unwrap();
        assert_eq!((first.id, second.id), (one.id, "near"));
        let part = rank_candidates(&base, &fit, some, |share| share < 0.1);
        assert!(part.cancelled && part.list.iter().all(|s| s.gain().is_none()));
    }
}
