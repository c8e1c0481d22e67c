//! The model fitted to the experiment column of Table A.1: how near it comes to the 16 experiments,
//! and how well it predicts a held-out frequency.

use rayon::prelude::*;
use serde::Serialize;

use super::cma_es::{Found, Search, minimize};
use super::compare::{Column, Row, figures, span};
use super::measurements::{Case, Figures, cases};
use crate::fit::thresholds::{MAX_GOOD_ERROR, TABLE_HUBER_THRESHOLD};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::sim::{Options, simulate};

/// The free parameters. The film's thickness at contact, `gp - dp`, is held.
pub const FREE_PARAMETERS: [ParameterId; 7] = [
    ParameterId::Eta,
    ParameterId::Dp,
    ParameterId::Zeta1,
    ParameterId::Cs,
    ParameterId::Ca,
    ParameterId::Ca0,
    ParameterId::Alpha,
];

/// Most generations of each of the five searches.
pub const MAX_GENERATIONS: usize = 60;
/// Errors that count the same: peak \[relative\], contact [relative to it or to 1 ms], bounces.
const ERROR_SCALES: [f64; 3] = [0.1, 0.3, 2.0];
/// Smallest scale of a contact's error \[s\]: below it, the error is relative to this.
const MIN_CONTACT_SCALE: f64 = 1e-3;
/// Samples per second; features need no more.
const SAMPLING_RATE: f64 = 25e3;

/// Errors of one column's cases.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Misfit {
    /// Mean absolute relative error of the peaks.
    pub peak: f64,
    /// Mean absolute relative error of the contact durations that have one.
    pub contact: f64,
    /// Cases within 30 % in both.
    pub both_within_30_percent: usize,
    /// Cases in which bouncing is predicted where there is some, none where none.
    pub bounce_existence: usize,
    /// Cases.
    pub cases: usize,
}

/// A frequency held out of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// The frequency \[Hz\].
    pub frequency: f64,
    /// Parameters fitted to the other frequencies, SI, in the order of [`FREE_PARAMETERS`].
    pub values: Vec<f64>,
    /// Errors at it before any fit, and by the fit to the other frequencies.
    pub before: Misfit,
    /// The same after.
    pub after: Misfit,
}

/// The result.
#[derive(Debug, Clone, PartialEq)]
pub struct TableFit {
    /// The model with the fitted values.
    pub model: Model,
    /// Rows of the fitted model.
    pub rows: Vec<Row>,
    /// Errors before and after, over all cases.
    pub before: Misfit,
    /// The same after.
    pub after: Misfit,
    /// Cross-validation by frequency; incomplete if it was stopped.
    pub left_out: Vec<LeftOut>,
    /// Whether it was stopped: then the model is the best so far.
    pub cancelled: bool,
}

/// What a fit to the table cannot decide, as a sentence.
pub const TABLE_LIMITS: &str = "The table has 16 rows of three features: a good fit does not say what is missing. `impactscope validate --suspects` tries each effect of the catalogue at held-out frequencies, and says which recording would distinguish the two best.";

impl TableFit {
    /// Cases that stay more than 30 % off in peak or contact.
    pub fn missed(&self) -> Vec<&Case> {
        let off = |row: &&Row| {
            let errors = row.errors(Column::Experiment);
            let good = |e: Option<f64>| e.is_some_and(|e| e.abs() <= MAX_GOOD_ERROR);
            !(good(errors.peak) && good(errors.contact))
        };
        self.rows.iter().filter(off).map(|row| &row.case).collect()
    }

    /// What the fit makes worse, and at which held-out frequency; `None` if nothing.
    pub fn made_worse(&self) -> Option<String> {
        let worse = |before: &Misfit, after: &Misfit| {
            let percent = |what: &str, from: f64, to: f64| {
                // Half a percent does not show in the figures as they are written.
                (to > from + 0.005)
                    .then(|| format!("{what} from {:.0} to {:.0} %", 100.0 * from, 100.0 * to))
            };
            let fewer = |what: &str, from: usize, to: usize| {
                (to < from).then(|| format!("{what} from {from} to {to}"))
            };
            let all = [
                percent("the mean error of the peaks", before.peak, after.peak),
                percent(
                    "the mean error of the contacts",
                    before.contact,
                    after.contact,
                ),
                fewer(
                    "the number of cases within 30 % in both",
                    before.both_within_30_percent,
                    after.both_within_30_percent,
                ),
                fewer(
                    "the number of cases whose bouncing is predicted",
                    before.bounce_existence,
                    after.bounce_existence,
                ),
            ];
            let changes: Vec<String> = all.into_iter().flatten().collect();
            (!changes.is_empty()).then(|| changes.join(", "))
        };
        let fitted = worse(&self.before, &self.after)
            .map(|changes| format!("The fit made worse: {changes}."));
        let blind: Vec<String> = self
            .left_out
            .iter()
            .filter_map(|l| {
                Some(format!(
                    "at {} Hz {}",
                    l.frequency,
                    worse(&l.before, &l.after)?
                ))
            })
            .collect();
        let blind = (!blind.is_empty()).then(|| {
            format!(
                "Frequencies that a fit to the others made worse: {}.",
                blind.join("; ")
            )
        });
        let sentences: Vec<String> = fitted.into_iter().chain(blind).collect();
        (!sentences.is_empty()).then(|| sentences.join(" "))
    }

    /// Standard errors of the parameters in SI, in the order of [`FREE_PARAMETERS`], from how much
    /// they change when a frequency is held out (the jackknife over frequencies: Efron and
    /// Tibshirani, An Introduction to the Bootstrap, 1993, chapter 11). `None` if some were
    /// not.
    pub fn errors(&self) -> Option<Vec<f64>> {
        if self.cancelled || self.left_out.len() < 2 {
            return None;
        }
        let n = self.left_out.len() as f64;
        let error = |k: usize| {
            let values = || self.left_out.iter().map(|l| l.values[k]);
            let mean = values().sum::<f64>() / n;
            ((n - 1.0) / n * values().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt()
        };
        Some((0..FREE_PARAMETERS.len()).map(error).collect())
    }

    /// Gives a device the fitted values.
    pub fn apply(&self, model: &mut Model) {
        for id in FREE_PARAMETERS.into_iter().chain([ParameterId::Gp]) {
            model.parameters.set(id, self.model.parameters[id]);
        }
    }
}

/// Values of the free parameters, SI.
fn values(model: &Model) -> Vec<f64> {
    FREE_PARAMETERS
        .iter()
        .map(|id| model.parameters[*id])
        .collect()
}

/// `base` with the free parameters at a point of the cube.
pub(crate) fn model_at(base: &Model, point: &[f64]) -> Model {
    let places = FREE_PARAMETERS.iter().zip(point);
    let values: Vec<f64> = places
        .map(|(id, place)| id.spec().value_at(*place))
        .collect();
    with_values(base, &values)
}

/// `base` with values of the free parameters, SI.
pub(crate) fn with_values(base: &Model, values: &[f64]) -> Model {
    let mut model = base.clone();
    let film = base.parameters[ParameterId::Gp] - base.parameters[ParameterId::Dp];
    for (id, value) in FREE_PARAMETERS.iter().zip(values) {
        model.parameters.set(*id, *value);
    }
    let dp = model.parameters[ParameterId::Dp];
    model.parameters.set(ParameterId::Gp, dp + film);
    model
}

/// Rows of some cases; a case that cannot be simulated has no figures.
pub(crate) fn rows(model: &Model, cases: &[Case]) -> Vec<Row> {
    let options = Options {
        rate: SAMPLING_RATE,
        ..Options::default()
    };
    cases
        .par_iter()
        .map(|case| {
            let trace = simulate(model, &case.waveform(), span(case), &options);
            Row {
                case: *case,
                model: trace.map_or(Figures::default(), |trace| figures(case, &trace)),
            }
        })
        .collect()
}

/// Sum of robust squares over the rows, against the experiment.
pub(crate) fn cost(rows: &[Row]) -> f64 {
    rows.iter()
        .map(|row| {
            let published = row.published(Column::Experiment);
            let errors = row.errors(Column::Experiment);
            let contact = published
                .contact
                .zip(row.model.contact)
                .map(|(p, m)| (p - m) / p.max(MIN_CONTACT_SCALE));
            [errors.peak, contact, errors.bounces]
                .into_iter()
                .zip(ERROR_SCALES)
                .map(|(error, scale)| {
                    // A missing figure is as bad as one that is off by its own size.
                    let size = error.map_or(1.0, f64::abs) / scale;
                    if size <= TABLE_HUBER_THRESHOLD {
                        size * size
                    } else {
                        TABLE_HUBER_THRESHOLD * (2.0 * size - TABLE_HUBER_THRESHOLD)
                    }
                })
                .sum::<f64>()
        })
        .sum()
}

pub(crate) fn misfit(rows: &[Row]) -> Misfit {
    let s = super::compare::statistics(rows, Column::Experiment);
    Misfit {
        peak: s.peak_mean_absolute_error,
        contact: s.contact_mean_absolute_error,
        both_within_30_percent: s.both_within_30_percent,
        bounce_existence: (s.bounce_existence * s.cases as f64).round() as usize,
        cases: s.cases,
    }
}

/// Fits to all cases, then once without each frequency. Deterministic. `progress` is
/// called with the share done, and ends the work with `false`: then the result is the
/// best so far, without the frequencies that had not been held out yet.
pub fn fit_table(
    base: &Model,
    generations: usize,
    mut progress: impl FnMut(f64) -> bool,
) -> TableFit {
    let start: Vec<f64> = FREE_PARAMETERS
        .iter()
        .map(|id| id.spec().fraction(base.parameters[*id]).clamp(0.0, 1.0))
        .collect();
    let mut frequencies: Vec<f64> = cases().iter().map(|c| c.frequency).collect();
    frequencies.dedup();
    let fits = 1 + frequencies.len();
    let mut done = 0;
    let mut stopped = false;
    // The result, and whether it ran to its end.
    let mut fit = |shown: &[Case]| -> (Found, bool) {
        let search = Search {
            generations,
            step: 0.12,
            least_step: 1e-3,
            seed: 16,
        };
        let found = minimize(
            &start,
            &search,
            |point| cost(&rows(&model_at(base, point), shown)),
            |generation, _| {
                let share = (generation + 1) as f64 / generations as f64;
                stopped |= !progress((done as f64 + share) / fits as f64);
                !stopped
            },
        );
        done += 1;
        (found, !stopped)
    };
    let (all, mut whole) = fit(cases());
    let model = model_at(base, &all.point);
    let mut left_out = Vec::new();
    for frequency in frequencies {
        if !whole {
            break;
        }
        let (hidden, shown): (Vec<Case>, Vec<Case>) =
            cases().iter().partition(|c| c.frequency == frequency);
        let found;
        (found, whole) = fit(&shown);
        if whole {
            let without = model_at(base, &found.point);
            left_out.push(LeftOut {
                frequency,
                values: values(&without),
                before: misfit(&rows(base, &hidden)),
                after: misfit(&rows(&without, &hidden)),
            });
        }
    }
    let rows_after = rows(&model, cases());
    TableFit {
        before: misfit(&rows(base, cases())),
        after: misfit(&rows_after),
        rows: rows_after,
        model,
        left_out,
        cancelled: !whole,
    }
}

#[cfg(test)]
mod tests {
    use super::super::calibrate::*;
    use crate::model::preset::Preset;

    #[test]
    fn a_short_fit_is_no_worse_and_can_be_stopped() {
        let base = Preset::default().model;
        let fit = fit_table(&base, 1, |_| true);
        // From the start as the search sees it: the 6 V squares stick or not by a hair.
        let start: Vec<f64> = FREE_PARAMETERS
            .iter()
            .map(|id| id.spec().fraction(base.parameters[*id]))
            .collect();
        let before = cost(&rows(&model_at(&base, &start), cases()));
        assert!(cost(&fit.rows) <= before);
        assert_eq!(fit.left_out.len(), 4);
        assert!(fit.left_out.iter().all(|l| l.after.cases == 4));
        assert!(!fit.cancelled && !fit.missed().is_empty());
        // What is worse is said, and where.
        let mut traded = fit.clone();
        traded.left_out.truncate(1);
        let misfit = |peak, contact, both_within_30_percent| Misfit {
            peak,
            contact,
            both_within_30_percent,
            bounce_existence: 9,
            cases: 16,
        };
        traded.before = misfit(0.4, 0.2, 5);
        traded.after = misfit(0.1, 0.25, 7);
        traded.after.bounce_existence = 6;
        traded.left_out[0].before = misfit(0.1, 0.1, 4);
        traded.left_out[0].after = misfit(0.1, 0.1, 2);
        let text = traded.made_worse().unwrap();
        assert!(!text.contains("peaks"), "{text}");
        for part in [
            "The fit made worse: the mean error of the contacts from 20 to 25 %",
            "at 5 Hz the number of cases within 30 % in both from 4 to 2",
            "the number of cases whose bouncing is predicted from 9 to 6",
        ] {
            assert!(text.contains(part), "{text}");
        }
        traded.after = traded.before;
        traded.left_out.clear();
        assert_eq!(traded.made_worse(), None);
        // Four values 1, 2, 3, 4: their squares about the mean add up to 5.
        let mut spread = fit.clone();
        for (value, left) in (1..).zip(&mut spread.left_out) {
            left.values = vec![f64::from(value); FREE_PARAMETERS.len()];
        }
        let errors = spread.errors().unwrap();
        assert_eq!(errors.len(), FREE_PARAMETERS.len());
        assert!((errors[0] - (0.75f64 * 5.0).sqrt()).abs() < 1e-12);
        let mut device = base.clone();
        fit.apply(&mut device);
        assert_eq!(device, fit.model);
        // Stopped in the third of five fits, what was done by then is kept.
        let part = fit_table(&base, 1, |share| share < 0.5);
        assert!(part.cancelled && part.errors().is_none());
        assert_eq!(part.model, fit.model);
        assert_eq!(part.left_out, fit.left_out[..1]);
        let none = fit_table(&base, 1, |_| false);
        assert!(none.cancelled && none.left_out.is_empty());
    }
}
