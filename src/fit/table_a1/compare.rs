//! The paper's validation (section 5): the 16 cases of Table A.1 simulated, together with the
//! paper's simulation and the experiment, and the statistics of its Table 3.

use rayon::prelude::*;
use serde::Serialize;

use super::measurements::{Case, Figures, cases};
use crate::fit::thresholds::{
    BOUNCE_DIGIT, CONTACT_DIGIT, MAX_GOOD_ERROR, MAX_REPRODUCED_ERROR, MIN_CONTACT_PER_PERIOD,
    PEAK_DIGIT,
};
use crate::model::Model;
use crate::recording::TimeAxis;
use crate::recording::features::{FeatureOptions, features};
use crate::sim::{Options, SimError, Trace, simulate};

/// Periods simulated: the first two are left to the transient, the rest are averaged.
const SIMULATED_PERIODS: f64 = 6.0;
/// Periods simulated where each takes 0.1 s or more: such runs forget their start in one.
const SLOW_PERIODS: f64 = 4.0;

/// A case with what the model gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The published figures.
    pub case: Case,
    /// The model's.
    pub model: Figures,
}

/// A column of the table to compare with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// The paper's own simulation.
    Paper,
    /// The experiment.
    Experiment,
}

/// Errors of a row against a column, simulation minus published as everywhere in the program (the
/// paper has them the other way round). Relative errors are (model - published) / published, zero
/// where both are zero, `None` where the published figure alone is zero or the model has none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Bounces, model minus published.
    pub bounces: Option<f64>,
    /// Peak, relative.
    pub peak: Option<f64>,
    /// Contact duration, relative.
    pub contact: Option<f64>,
}

impl Row {
    /// The published figures of a column.
    pub fn published(&self, column: Column) -> Figures {
        match column {
            Column::Paper => self.case.simulation,
            Column::Experiment => self.case.experiment,
        }
    }

    /// The model's errors against a column.
    pub fn errors(&self, column: Column) -> Errors {
        let published = self.published(column);
        let relative = |published: Option<f64>, model: Option<f64>| {
            let (published, model) = (published?, model?);
            if published == 0.0 {
                (model == 0.0).then_some(0.0)
            } else {
                Some((model - published) / published)
            }
        };
        Errors {
            bounces: published
                .bounces
                .zip(self.model.bounces)
                .map(|(p, m)| m - p),
            peak: relative(published.peak, self.model.peak),
            contact: relative(published.contact, self.counted_contact()),
        }
    }

    /// The model's contact \[s\]; a touch in passing counts as none.
    fn counted_contact(&self) -> Option<f64> {
        let contact = self.model.contact?;
        Some(if contact < MIN_CONTACT_PER_PERIOD {
            0.0
        } else {
            contact
        })
    }

    /// What of the published figures the model reproduces: the number of bounces, and peak and
    /// contact to a few percent or to the digits that are printed.
    pub fn reproduced(&self, column: Column) -> Reproduced {
        let published = self.published(column);
        let near = |published: Option<f64>, model: Option<f64>, share: f64, digit: f64| {
            let pair = published.zip(model);
            pair.is_some_and(|(p, m)| (m - p).abs() <= (share * p.abs()).max(digit))
        };
        let share = MAX_REPRODUCED_ERROR;
        Reproduced {
            bounces: near(published.bounces, self.model.bounces, 0.0, BOUNCE_DIGIT),
            peak: near(published.peak, self.model.peak, share, PEAK_DIGIT),
            contact: near(
                published.contact,
                self.counted_contact(),
                share,
                CONTACT_DIGIT,
            ),
        }
    }
}

/// What the word "reproduced" claims, for people.
pub const REPRODUCED_MEANS: &str = "Reproduced: the number of bounces is right, and peak and contact are within 5 % or the printed digit";

/// Which published figures of a case a model reproduces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reproduced {
    /// The number of bounces, to half a bounce.
    pub bounces: bool,
    /// The peak.
    pub peak: bool,
    /// The contact.
    pub contact: bool,
}

impl Reproduced {
    /// Whether the whole case is reproduced.
    #[must_use]
    pub fn all(self) -> bool {
        self.bounces && self.peak && self.contact
    }
}

/// Table 3 of the paper, against one column. Shares are of all cases; a case without a
/// figure counts as wrong.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistics {
    /// Cases.
    pub cases: usize,
    /// Share of cases in which bouncing is predicted where there is some, none where none.
    pub bounce_existence: f64,
    /// Share of cases whose number of bounces is right, to half a bounce.
    pub bounce_number: f64,
    /// Mean absolute error of the number of bounces.
    pub bounce_mean_error: f64,
    /// Mean relative error of the peak, with sign.
    pub peak_mean_error: f64,
    /// Mean absolute relative error of the peak.
    pub peak_mean_absolute_error: f64,
    /// Cases whose peak is within 30 %.
    pub peak_within_30_percent: usize,
    /// Mean relative error of the contact duration, with sign.
    pub contact_mean_error: f64,
    /// Mean absolute relative error of the contact duration.
    pub contact_mean_absolute_error: f64,
    /// Cases whose contact duration is within 30 %.
    pub contact_within_30_percent: usize,
    /// Cases within 30 % in both.
    pub both_within_30_percent: usize,
    /// Cases whose peak is reproduced.
    pub peak_reproduced: usize,
    /// Cases whose contact duration is reproduced.
    pub contact_reproduced: usize,
    /// Cases reproduced in bounces, peak and contact.
    pub reproduced: usize,
}

/// The statistics of `rows` against a column.
pub fn statistics(rows: &[Row], column: Column) -> Statistics {
    let errors: Vec<Errors> = rows.iter().map(|row| row.errors(column)).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
        sum / f64::from(count.max(1))
    };
    let share = |count: usize| count as f64 / rows.len().max(1) as f64;
    let good = |error: Option<f64>| error.is_some_and(|e| e.abs() <= MAX_GOOD_ERROR);
    let count = |test: &dyn Fn(&Errors) -> bool| errors.iter().filter(|e| test(e)).count();
    let same = |test: &dyn Fn(Reproduced) -> bool| {
        let all = rows.iter().map(|row| row.reproduced(column));
        all.filter(|r| test(*r)).count()
    };
    let existence = rows
        .iter()
        .filter(|row| {
            let any = |bounces: Option<f64>| bounces.map(|b| b >= 0.5);
            let model = any(row.model.bounces);
            model.is_some() && model == any(row.published(column).bounces)
        })
        .count();
    Statistics {
        cases: rows.len(),
        bounce_existence: share(existence),
        bounce_number: share(count(&|e| e.bounces.is_some_and(|b| b.abs() <= 0.5))),
        bounce_mean_error: mean(&mut errors.iter().filter_map(|e| e.bounces.map(f64::abs))),
        peak_mean_error: mean(&mut errors.iter().filter_map(|e| e.peak)),
        peak_mean_absolute_error: mean(&mut errors.iter().filter_map(|e| e.peak.map(f64::abs))),
        peak_within_30_percent: count(&|e| good(e.peak)),
        contact_mean_error: mean(&mut errors.iter().filter_map(|e| e.contact)),
        contact_mean_absolute_error: mean(
            &mut errors.iter().filter_map(|e| e.contact.map(f64::abs)),
        ),
        contact_within_30_percent: count(&|e| good(e.contact)),
        both_within_30_percent: count(&|e| good(e.peak) && good(e.contact)),
        peak_reproduced: same(&|r| r.peak),
        contact_reproduced: same(&|r| r.contact),
        reproduced: same(&|r| r.all()),
    }
}

/// Span over which a case is simulated \[s\].
pub fn span(case: &Case) -> f64 {
    let slow = case.frequency < 10.0;
    let periods = if slow {
        SLOW_PERIODS
    } else {
        SIMULATED_PERIODS
    };
    periods / case.frequency
}

/// Simulates one case.
///
/// # Errors
/// [`SimError`] if the model cannot be simulated.
pub fn simulate_case(model: &Model, case: &Case) -> Result<Trace, SimError> {
    simulate(model, &case.waveform(), span(case), &Options::default())
}

/// The figures of a simulated case.
pub fn figures(case: &Case, trace: &Trace) -> Figures {
    let options = FeatureOptions {
        contact_level: trace.ground_level,
        period: Some(1.0 / case.frequency),
        noise: Some(0.0),
        ..FeatureOptions::default()
    };
    let axis = TimeAxis::Uniform {
        t0: trace.t0,
        dt: trace.dt,
    };
    Figures::of(&features(
        axis,
        Some(&trace.voltage),
        &trace.proof_mass,
        &options,
    ))
}

/// Simulates all 16 cases, on all cores; rows in the order of the table.
///
/// # Errors
/// [`SimError`] of the first case that cannot be simulated.
pub fn validate(model: &Model) -> Result<Vec<Row>, SimError> {
    cases()
        .par_iter()
        .map(|case| {
            let trace = simulate_case(model, case)?;
            Ok(Row {
                case: *case,
                model: figures(case, &trace),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::compare::*;
    use crate::model::preset::Preset;

    fn row(published: Figures, model: Figures) -> Row {
        let case = Case {
            experiment: published,
            ..cases()[0]
        };
        Row { case, model }
    }

    fn of(bounces: f64, peak: f64, contact: f64) -> Figures {
        Figures {
            bounces: Some(bounces),
            peak: Some(peak),
            contact: Some(contact),
        }
    }

    #[test]
    fn statistics_are_those_of_the_definition() {
        let rows = [
            row(of(0.0, 100e-6, 0.0), of(0.0, 90e-6, 0.0)),
            row(of(2.0, 200e-6, 1e-3), of(1.0, 220e-6, 2e-3)),
            row(of(1.0, 100e-6, 0.0), Figures::default()),
        ];
        let s = statistics(&rows, Column::Experiment);
        assert_eq!(s.cases, 3);
        assert!((s.bounce_existence - 2.0 / 3.0).abs() < 1e-12);
        assert!((s.bounce_number - 1.0 / 3.0).abs() < 1e-12);
        assert!((s.bounce_mean_error - 0.5).abs() < 1e-12);
        assert!(s.peak_mean_error.abs() < 1e-12);
        assert!((s.peak_mean_absolute_error - 0.1).abs() < 1e-12);
        assert_eq!(
            (s.peak_within_30_percent, s.contact_within_30_percent),
            (2, 1)
        );
        // Too long by as much as is published: the sign is that of simulation minus published.
        assert!((s.contact_mean_error - 0.5).abs() < 1e-12);
    }

    /// The paper's own figures through the same arithmetic: its Table 3 says 100 % bounce
    /// existence, and 62.5 % of contacts within 30 %; the signs of four printed errors
    /// are wrong, so its means are not compared.
    #[test]
    fn the_papers_own_simulation_gives_its_table_3() {
        let rows: Vec<Row> = cases()
            .iter()
            .map(|case| Row {
                case: *case,
                model: case.simulation,
            })
            .collect();
        let s = statistics(&rows, Column::Experiment);
        assert_eq!(s.bounce_existence, 1.0);
        assert_eq!(s.contact_within_30_percent, 10);
    }

    #[test]
    fn reproduced_is_said_of_nothing_else() {
        let published = of(2.0, 200e-6, 10e-3);
        let says = |model: Figures| row(published, model).reproduced(Column::Experiment);
        assert!(says(of(2.4, 209e-6, 10.4e-3)).all(), "within 5 %");
        // 30 % off is the paper's limit, but not reproduced.
        assert!(!says(of(2.0, 240e-6, 10e-3)).peak && !says(of(2.0, 200e-6, 8e-3)).contact);
        assert!(!says(of(1.0, 200e-6, 10e-3)).bounces);
        assert!(!says(Figures::default()).all());
        // A touch in passing where the table has none.
        let none = row(of(0.0, 100e-6, 0.0), of(0.0, 100e-6, 0.1e-3));
        assert!(none.reproduced(Column::Experiment).all());
        // The paper's own simulation reproduces itself, and not its experiment.
        let own: Vec<Row> = cases()
            .iter()
            .map(|case| Row {
                case: *case,
                model: case.simulation,
            })
            .collect();
        assert_eq!(statistics(&own, Column::Paper).reproduced, cases().len());
        assert!(statistics(&own, Column::Experiment).reproduced <= 2);
    }

    #[test]
    fn the_paper_preset_comes_near_the_papers_simulation() {
        let rows = validate(&Preset::default().model).unwrap();
        let s = statistics(&rows, Column::Paper);
        println!("{s:#?}");
        assert!(s.peak_mean_absolute_error <= 0.03);
        assert!(s.contact_within_30_percent >= 13);
    }
}
