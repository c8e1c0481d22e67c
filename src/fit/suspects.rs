//! Who is to blame for what a fit to Table A.1 cannot reach: each effect of the catalogue that
//! could be is fitted beside the parameters, and judged at frequencies that it was not shown.
//!
//! A further mode, a vibration and what befalls a single recording have constants of which peaks,
//! contacts and bounces say nothing; they are not asked. Nor are a ground that gives way and a
//! compressible film, of which a run takes twenty times as long and which act for microseconds.

use serde::Serialize;

use super::cma::{Search, minimise};
use super::table_a1::{Case, cases};
use super::table_fit::{FREE, Misfit, TableFit, cost, misfit, model_at, rows, with_values};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, EffectSpec, find};

/// Effects that are asked, their strength, and where it is next to nothing.
const ASKED: [(&str, &str, f64); 10] = [
    ("amplifier_lag", "tau", 0.0),
    ("piezo_creep", "c", 0.0),
    ("hysteresis_memory", "s", 0.0),
    ("electrostatic", "A", 1e-10),
    ("cubic_stiffness", "k3", 0.0),
    ("quadratic_drag", "cd", 1e-9),
    ("dry_friction", "fc", 0.0),
    ("long_range_attraction", "A", 0.0),
    ("adhesion_saturation", "dF", 0.0),
    ("velocity_restitution", "n", 0.0),
];

/// Generations of each search that are enough, from where the fit has come.
pub const GENERATIONS: usize = 12;
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
    /// left out agree on, or else the nearest.
    pub fn pair(&self) -> Option<(&Suspect, &Suspect)> {
        let gain = |s: &&Suspect| s.gain().map_or(f64::NEG_INFINITY, |g| g.0);
        let mut all: Vec<&Suspect> = self.list.iter().collect();
        all.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
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
    nothing: f64,
}

impl Asked {
    /// `model` with it, at a place on the strength's slider.
    fn on(&self, model: &Model, place: f64) -> Model {
        let mut values: Vec<f64> = self.spec.parameters.iter().map(|p| p.default).collect();
        values[self.which] = self.spec.parameters[self.which].value_at(place);
        let mut model = model.clone();
        model.effects.push(ActiveEffect {
            spec: self.spec,
            values,
        });
        model
    }
}

/// A fit with a suspect.
struct Fitted {
    cost: f64,
    strength: f64,
    model: Model,
}

/// Asks all suspects after `fit` of `base`. Deterministic. `progress` is called with the share
/// done, and ends the work with `false`.
pub fn suspects(
    base: &Model,
    fit: &TableFit,
    generations: usize,
    progress: impl FnMut(f64) -> bool,
) -> Suspects {
    ask(base, fit, &ASKED, generations, progress)
}

/// Asks some.
fn ask(
    base: &Model,
    fit: &TableFit,
    which: &[(&str, &str, f64)],
    generations: usize,
    mut progress: impl FnMut(f64) -> bool,
) -> Suspects {
    let asked: Vec<Asked> = which
        .iter()
        .filter_map(|(id, strength, nothing)| {
            let spec = find(id)?;
            let which = spec.parameters.iter().position(|p| p.id == *strength)?;
            let own = Asked {
                spec,
                which,
                nothing: *nothing,
            };
            let free = base.effects.iter().all(|e| e.spec != spec);
            free.then_some(own)
        })
        .collect();
    let searches = 1 + asked.len() + (1 + CROSS_CHECKED.min(asked.len())) * fit.left_out.len();
    let (mut done, mut stopped) = (0, false);
    // From where a fit without it has come; with none as well, so that none gains by the
    // search alone.
    let mut search = |own: Option<Asked>, from: &Model, shown: &[Case]| -> Fitted {
        let mut start: Vec<f64> = FREE
            .iter()
            .map(|id| id.spec().fraction(from.parameters[*id]).clamp(0.0, 1.0))
            .collect();
        let strength = own.map(|own| &own.spec.parameters[own.which]);
        let places = own.zip(strength);
        start.extend(places.map(|(own, p)| p.fraction(own.nothing).clamp(0.0, 1.0)));
        let with = |point: &[f64]| {
            let (parameters, place) = point.split_at(FREE.len());
            let model = model_at(base, parameters);
            match (own, place) {
                (Some(own), [place]) => own.on(&model, *place),
                _ => model,
            }
        };
        let options = Search {
            generations,
            step: 0.1,
            least_step: 1e-3,
            seed: 17,
        };
        let found = minimise(
            &start,
            &options,
            |point| cost(&rows(&with(point), shown)),
            |generation, _| {
                let share = (generation + 1) as f64 / generations as f64;
                stopped |= !progress((f64::from(done) + share) / searches as f64);
                !stopped
            },
        );
        done += 1;
        Fitted {
            cost: found.value,
            strength: strength.map_or(0.0, |p| p.value_at(found.point[FREE.len()])),
            model: with(&found.point),
        }
    };
    let without = search(None, &fit.model, cases());
    let mut list = Vec::new();
    for own in &asked {
        let found = search(Some(*own), &fit.model, cases());
        let parameter = &own.spec.parameters[own.which];
        list.push(Suspect {
            id: own.spec.id,
            name: own.spec.name,
            strength: parameter.id,
            value: found.strength,
            unit: parameter.unit,
            cost: found.cost,
            after: misfit(&rows(&found.model, cases())),
            left_out: Vec::new(),
            model: found.model,
        });
    }
    list.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    for left in &fit.left_out {
        let (hidden, shown): (Vec<Case>, Vec<Case>) =
            cases().iter().partition(|c| c.frequency == left.frequency);
        let of = |fitted: &Fitted| cost(&rows(&fitted.model, &hidden));
        let begun = with_values(base, &left.values);
        let without = of(&search(None, &begun, &shown));
        for suspect in list.iter_mut().take(CROSS_CHECKED) {
            let own = asked.iter().find(|a| a.spec.id == suspect.id);
            let with = of(&search(own.copied(), &begun, &shown));
            suspect.left_out.push((left.frequency, without, with));
        }
    }
    // What was stopped on the way says nothing.
    if stopped {
        list.iter_mut().for_each(|s| s.left_out.clear());
    }
    Suspects {
        cost: without.cost,
        list,
        cancelled: stopped,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::table_fit::fit_table;
    use crate::model::preset::Preset;

    #[test]
    fn every_suspect_begins_as_next_to_nothing() {
        let base = Preset::default().model;
        let plain = cost(&rows(&base, cases()));
        for (id, strength, nothing) in ASKED {
            let spec = find(id).expect(id);
            let which = spec.parameters.iter().position(|p| p.id == strength);
            let which = which.expect(strength);
            let own = Asked {
                spec,
                which,
                nothing,
            };
            let place = spec.parameters[which].fraction(nothing);
            assert!((0.0..=1.0).contains(&place), "{id} {place}");
            let with = cost(&rows(&own.on(&base, place), cases()));
            assert!((with / plain - 1.0).abs() < 0.1, "{id}: {with} {plain}");
        }
    }

    #[test]
    fn suspects_come_no_farther_and_can_be_stopped() {
        let base = Preset::default().model;
        let mut fit = fit_table(&base, 1, |_| true);
        fit.left_out.truncate(2);
        let some = &ASKED[4..7];
        let all = ask(&base, &fit, some, 1, |_| true);
        assert_eq!(all.list.len(), some.len());
        assert!(!all.cancelled && all.pair().is_some());
        assert!(all.list.is_sorted_by(|a, b| a.cost <= b.cost));
        assert!(all.list.iter().all(|s| s.gain().is_some()));
        // Two frequencies that gain 1 and 3: 2 +- 1.
        let mut one = all.list[0].clone();
        one.left_out = vec![(5.0, 3.0, 2.0), (15.0, 6.0, 3.0)];
        assert_eq!(one.gain(), Some((2.0, 1.0)));
        assert!(!one.told());
        one.left_out[1].2 = 4.5;
        assert!(one.told());
        let part = ask(&base, &fit, some, 1, |share| share < 0.5);
        assert!(part.cancelled && part.list.iter().all(|s| s.gain().is_none()));
    }
}
