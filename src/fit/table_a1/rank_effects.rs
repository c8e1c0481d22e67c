//! Who is to blame for what a fit to Table A.1 cannot reach: each effect of the catalogue that
//! could be is tried in several sizes beside the parameters, both are then improved together, and
//! the nearest are judged at frequencies that they were not shown.
//!
//! Peaks, contacts and counted bounces jump as parameters move, so that the search compares and
//! takes no slopes: one unknown after the other, in steps that grow smaller (compass search: Kolda,
//! Lewis and Torczon, SIAM Review 45, 385, 2003).
//!
//! A further mode, a vibration and what befalls a single recording have constants of which peaks,
//! contacts and bounces say nothing; they are not asked. Nor are a ground that gives way and a
//! compressible film, of which a run takes twenty times as long and which act for microseconds.

use serde::Serialize;

use super::calibrate::{FREE, Misfit, TableFit, cost, misfit, model_at, rows, with_values};
use super::measurements::{Case, cases};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, CATALOGUE, EffectSpec, find};
use crate::model::parameter::{ParameterId, Scale};

/// Effects that are asked, and their strength: those that features determine.
fn suspected() -> Vec<(&'static str, &'static str)> {
    let strength = |e: &&'static EffectSpec| Some((e.id, e.facts.feature_strength?));
    CATALOGUE.iter().filter_map(strength).collect()
}

/// Sizes of an effect that are tried, as shares of the end of its slider; for one whose slider
/// is logarithmic, places on it.
const SIZES: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0];
/// Steps of the parameters, on their sliders.
const STEPS: [f64; 3] = [0.06, 0.03, 0.015];
/// A step of the effect's size is the factor one plus so many of those.
const FACTOR: f64 = 10.0;
/// Those that come nearest are also asked at frequencies left out.
const CROSS_CHECKED: usize = 3;
/// Standard errors by which the frequencies left out must agree.
const AGREE: f64 = 2.0;

/// An effect fitted beside the parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspect {
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
    /// Each frequency that was left out \[Hz\]: the sum over its rows without and with the
    /// effect, neither fit shown them. Empty where it was not asked.
    pub left_out: Vec<(f64, f64, f64)>,
    /// The model with it.
    #[serde(skip)]
    pub model: Model,
}

impl Suspect {
    /// By how much the sum falls at a frequency left out, and the standard error of that by how
    /// the frequencies differ; `None` where it was not asked.
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

    /// Whether the frequencies left out agree that it comes nearer to the experiments.
    pub fn told(&self) -> bool {
        self.gain()
            .is_some_and(|(mean, error)| mean > AGREE * error)
    }
}

/// All suspects, the nearest first.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Suspects {
    /// Sum of robust squares over all rows without any.
    pub cost: f64,
    /// The suspects.
    pub list: Vec<Suspect>,
    /// Whether it was stopped: then some were not asked.
    pub cancelled: bool,
}

impl Suspects {
    /// The two that the table speaks for most, to be told apart: those that the frequencies
    /// left out agree on, then the nearest.
    pub fn pair(&self) -> Option<(&Suspect, &Suspect)> {
        let mut all: Vec<&Suspect> = self.list.iter().collect();
        all.sort_by_key(|s| !s.told());
        match all[..] {
            [a, b, ..] => Some((a, b)),
            _ => None,
        }
    }
}

/// A suspect's freedom: which value of which effect.
#[derive(Clone, Copy)]
struct Asked {
    spec: &'static EffectSpec,
    which: usize,
}

impl Asked {
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
            return SIZES
                .iter()
                .map(|place| parameter.value_at(*place))
                .collect();
        }
        let up = SIZES.iter().map(|share| share * high);
        let down = SIZES.iter().map(|share| share * low).filter(|v| *v < 0.0);
        up.chain(down).collect()
    }
}

/// Where a search stands.
#[derive(Clone)]
struct Found {
    /// Places of the parameters on their sliders.
    point: Vec<f64>,
    /// Strength of the effect.
    strength: f64,
    cost: f64,
}

/// A search with or without a suspect, judged by some cases.
struct Compass<'a> {
    base: &'a Model,
    own: Option<Asked>,
    shown: &'a [Case],
    steps: &'a [f64],
}

impl Compass<'_> {
    fn model(&self, found: &Found) -> Model {
        let model = model_at(self.base, &found.point);
        match self.own {
            Some(own) => own.on(&model, found.strength),
            None => model,
        }
    }

    /// `found` with its cost.
    fn weighed(&self, mut found: Found) -> Found {
        found.cost = cost(&rows(&self.model(&found), self.shown));
        found
    }

    /// The best of all sizes of the suspect at `point`, improved together with the parameters
    /// until `go_on`, which is told the share done, says no.
    fn search(&self, point: Vec<f64>, go_on: &mut dyn FnMut(f64) -> bool) -> Found {
        let begin = |strength: f64| {
            self.weighed(Found {
                point: point.clone(),
                strength,
                cost: f64::INFINITY,
            })
        };
        let sizes = self.own.map_or(vec![0.0], Asked::sizes);
        let begun = sizes.into_iter().map(begin);
        let Some(mut best) = begun.min_by(|a, b| a.cost.total_cmp(&b.cost)) else {
            return begin(0.0);
        };
        let unknowns = FREE.len() + usize::from(self.own.is_some());
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
                        None => there.strength *= (1.0 + FACTOR * step.abs()).powf(step.signum()),
                    }
                    self.weighed(there)
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

/// Asks all suspects after `fit` of `base`. Deterministic. `progress` is called with the share
/// done, and ends the work with `false`.
pub fn suspects(base: &Model, fit: &TableFit, progress: impl FnMut(f64) -> bool) -> Suspects {
    ask(base, fit, (&suspected(), &STEPS), progress)
}

/// Asks some, in given steps.
fn ask(
    base: &Model,
    fit: &TableFit,
    (which, steps): (&[(&str, &str)], &[f64]),
    mut progress: impl FnMut(f64) -> bool,
) -> Suspects {
    let free = |own: &Asked| base.effects.iter().all(|e| e.spec != own.spec);
    let all = which.iter().filter_map(|(id, s)| Asked::of(id, s));
    let asked: Vec<Asked> = all.filter(free).collect();
    let checked = CROSS_CHECKED.min(asked.len());
    let searches = (1 + asked.len() + (1 + checked) * fit.left_out.len()) as f64;
    let (mut done, mut stopped) = (0.0, false);
    // From where a fit without it has come; with none as well, so that none gains by the
    // search alone.
    let mut search = |own: Option<Asked>, from: &Model, shown: &[Case]| -> (Found, Model) {
        let place = |id: &ParameterId| id.spec().fraction(from.parameters[*id]).clamp(0.0, 1.0);
        let compass = Compass {
            base,
            own,
            shown,
            steps,
        };
        let found = compass.search(FREE.iter().map(place).collect(), &mut |share| {
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
        list.push(Suspect {
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
        let mut unseen = |own: Option<Asked>| cost(&rows(&search(own, &begun, &shown).1, &hidden));
        let without = unseen(None);
        for suspect in list.iter_mut().take(CROSS_CHECKED) {
            let own = asked.iter().find(|a| a.spec.id == suspect.id);
            let with = unseen(own.copied());
            suspect.left_out.push((left.frequency, without, with));
        }
    }
    // What was stopped on the way says nothing.
    if stopped {
        list.iter_mut().for_each(|s| s.left_out.clear());
    }
    Suspects {
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
    fn every_suspect_is_tried_in_sizes_within_its_slider() {
        for (id, strength) in suspected() {
            let own = Asked::of(id, strength).expect(id);
            let (low, high) = own.spec.parameters[own.which].range;
            let sizes = own.sizes();
            assert!(sizes.len() >= SIZES.len(), "{id}");
            assert!(
                sizes.iter().all(|s| (low..=high).contains(s)),
                "{id}: {sizes:?}"
            );
            let both = sizes.iter().any(|s| *s < 0.0);
            assert_eq!(both, low < 0.0, "{id}: {sizes:?}");
        }
    }

    #[test]
    fn suspects_come_no_farther_and_can_be_stopped() {
        let base = Preset::default().model;
        let mut fit = fit_table(&base, 1, |_| true);
        fit.left_out.truncate(2);
        let all = suspected();
        let some = (&all[8..9], &STEPS[..1]);
        let all = ask(&base, &fit, some, |_| true);
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
        assert!(!one.told());
        one.left_out[1].2 = 4.5;
        assert!(one.told());
        // Of several those that are told come first, then the nearest.
        let mut three = all.clone();
        three.list = vec![all.list[0].clone(), one.clone(), all.list[0].clone()];
        three.list[0].left_out.clear();
        three.list[2].left_out.clear();
        three.list[0].id = "near";
        let (first, second) = three.pair().unwrap();
        assert_eq!((first.id, second.id), (one.id, "near"));
        let part = ask(&base, &fit, some, |share| share < 0.1);
        assert!(part.cancelled && part.list.iter().all(|s| s.gain().is_none()));
    }
}
