//! Known values that the recordings contradict.
//!
//! At the end of a fit the gradient of the recordings and the pull of what is known balance. One
//! linear step without the row of a known value says where its parameter would go, and with what
//! error. If that is too far from what is known for both errors together, the recordings need another
//! value: a force is missing, or what is known is wrong.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::normal_inverse::inverse;
use crate::fit::error::FitError;
use crate::fit::problem::Problem;
use crate::fit::problem::huber::Huber;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prior_rows::known_row;
use crate::fit::solve::normal_equations::{add_row, normal_equations};
use crate::fit::solve::point::Point;
use crate::fit::thresholds::KNOWN_MAX_Z;
use crate::model::preset::known_value::{KnownValue, with_error};
use crate::sim::SimError;

/// A known value and the one that the recordings need.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contradiction {
    /// What is known.
    pub known: KnownValue,
    /// The value that the recordings need \[SI\].
    pub needed: f64,
    /// Its standard error \[SI\].
    pub std_error: f64,
    /// SI unit.
    pub unit: String,
}

impl Contradiction {
    /// Distance between both values in their common standard error.
    pub fn z(&self) -> f64 {
        let error = self.known.std_error.hypot(self.std_error);
        (self.needed - self.known.value).abs() / error
    }

    /// As a sentence without a full stop.
    pub fn text(&self) -> String {
        format!(
            "needs {} = {}, known {}: a force is missing, or what is known is wrong",
            self.known.id,
            with_error(self.needed, self.std_error, &self.unit),
            self.known.text(&self.unit)
        )
    }
}

/// The known values of `problem` that its recordings contradict at `point`, the end of a fit under
/// the loss `huber` with `chi2` per degree of freedom.
///
/// # Errors
/// [`SimError`] if the model makes no sense there.
pub(crate) fn contradictions(
    problem: &Problem,
    point: &Point,
    huber: Huber,
    chi2: f64,
) -> Result<Vec<Contradiction>, SimError> {
    let free = |known: &&KnownValue| problem.space.position(&known.id).is_some();
    let all: Vec<&KnownValue> = problem.known.iter().filter(free).collect();
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let reduced = problem.linearize(&point.x, &point.segments, &point.used, huber, &[])?;
    let (normal, gradient) = normal_equations(problem, &point.x, &reduced, huber);
    let model = problem.space.model(&point.x);
    let mut out = Vec::new();
    for known in all {
        let row = known_row(&problem.space, known, &point.x);
        let (mut free, mut slope) = (normal.clone(), gradient.clone());
        add_row(&mut free, &mut slope, &row, -1.0);
        let covariance = inverse(&free);
        let step = -(&covariance * slope);
        // The row is the value in units of the known error.
        let along: f64 = row.slopes.iter().map(|&(i, s)| s * step[i]).sum();
        let variance: f64 = row
            .slopes
            .iter()
            .flat_map(|&(i, a)| row.slopes.iter().map(move |&(j, b)| (i, j, a * b)))
            .map(|(i, j, product)| product * covariance[(i, j)])
            .sum();
        let found = Contradiction {
            needed: known.value + known.std_error * (row.value + along),
            std_error: known.std_error * (variance.max(0.0) * chi2.max(1.0)).sqrt(),
            unit: model.unit_of(&known.id).unwrap_or_default().to_owned(),
            known: known.clone(),
        };
        if found.needed.is_finite() && found.z() > KNOWN_MAX_Z {
            out.push(found);
        }
    }
    Ok(out)
}

/// A parameter that is held, and the value that the recordings need.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HeldParameter {
    /// Its id.
    pub id: String,
    /// Where it is held \[SI\].
    pub value: f64,
    /// The value that the recordings need if it alone is free as well \[SI\].
    pub needed: f64,
    /// Its standard error \[SI\].
    pub std_error: f64,
    /// SI unit.
    pub unit: String,
}

/// Those of the held parameters `ids` that the recordings of `problem` need at another value, each if
/// it alone were free together with all that is: one linear step from `point`, the end of a fit
/// under the loss `huber` with `chi2` per degree of freedom.
///
/// # Errors
/// [`FitError`] if an id is unknown or the model makes no sense there.
pub(crate) fn held_elsewhere(
    problem: &Problem,
    point: &Point,
    ids: &[String],
    (huber, chi2): (Huber, f64),
) -> Result<Vec<HeldParameter>, FitError> {
    if ids.is_empty() {
        return Ok(Vec::new());
    }
    let model = problem.space.model(&point.x);
    let free = problem.space.entries.iter().map(|e| &e.id);
    let all: Vec<String> = free.chain(ids).cloned().collect();
    let space = Space::new(&model, &all)?;
    let (own, more) = (problem.space.len(), space.len());
    let mut x = space.coordinates(&model);
    x.extend_from_slice(&point.x[own..]);
    let wider = Problem {
        space,
        ..problem.clone()
    };
    let reduced = wider.linearize(&x, &point.segments, &point.used, huber, &[])?;
    let (normal, gradient) = normal_equations(&wider, &x, &reduced, huber);
    let mut out = Vec::new();
    for at in own..more {
        let entry = &wider.space.entries[at];
        let value = model.get(&entry.id).unwrap_or(entry.spec.default);
        let keep: Vec<usize> = (0..own).chain([at]).chain(more..x.len()).collect();
        let n = keep.len();
        let covariance = inverse(&DMatrix::from_fn(n, n, |i, j| normal[(keep[i], keep[j])]));
        let step = -(&covariance * DVector::from_fn(n, |i, _| gradient[keep[i]]));
        // The value's slopes over the unknowns: those of a row with an error of 1.
        let known = KnownValue {
            id: entry.id.clone(),
            value,
            std_error: 1.0,
        };
        let row = known_row(&wider.space, &known, &x);
        let slopes: Vec<(usize, f64)> = row
            .slopes
            .iter()
            .filter_map(|&(i, s)| Some((keep.iter().position(|k| *k == i)?, s)))
            .collect();
        let along: f64 = slopes.iter().map(|&(i, s)| s * step[i]).sum();
        let mut variance = 0.0;
        for &(i, a) in &slopes {
            for &(j, b) in &slopes {
                variance += a * b * covariance[(i, j)];
            }
        }
        let (low, high) = entry.spec.limits;
        let needed = (value + along).clamp(low, high);
        let std_error = (variance.max(0.0) * chi2.max(1.0)).sqrt();
        if needed.is_finite() && (needed - value).abs() > KNOWN_MAX_Z * std_error {
            out.push(HeldParameter {
                id: entry.id.clone(),
                value,
                needed,
                std_error,
                unit: entry.spec.unit.to_owned(),
            });
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::super::contradiction::*;
    use crate::fit::FitOptions;
    use crate::fit::tests::{made, options, paper, part, run};

    /// The recording of a device with a damping that is known wrongly, or not at all well.
    fn fitted(value: f64, std_error: f64) -> Vec<String> {
        let truth = paper();
        let parts = [part(made(&truth, "square:100Hz:2V", 0.02, 3))];
        let known = KnownValue::new(&truth, "zeta1", (value, std_error)).unwrap();
        let options = FitOptions {
            known: vec![known],
            ..options(&["zeta1", "eta"])
        };
        run(&truth, &parts, &options).unwrap().remarks
    }

    #[test]
    fn a_known_value_that_the_recordings_contradict_is_said() {
        let needs = |remarks: &[String]| remarks.iter().any(|r| r.starts_with("needs zeta1 = "));
        let wrong = fitted(0.04, 2e-3);
        assert!(needs(&wrong), "{wrong:?}");
        for (value, error) in [(0.0262, 2e-4), (0.04, 0.01)] {
            let right = fitted(value, error);
            assert!(!needs(&right), "{value}: {right:?}");
        }
    }

    #[test]
    fn a_known_value_pulls_as_its_error_says() {
        // Known far better than the recording tells it, the parameter stays there.
        let truth = paper();
        let parts = [part(made(&truth, "square:100Hz:2V", 0.02, 3))];
        let at_value = |value: f64, std_error: f64| {
            let known = KnownValue::new(&truth, "zeta1", (value, std_error)).unwrap();
            let options = FitOptions {
                known: vec![known],
                ..options(&["zeta1", "eta"])
            };
            let result = run(&truth, &parts, &options).unwrap();
            let p = result.parameters.iter().find(|p| p.id == "zeta1").unwrap();
            (p.value, p.std_error)
        };
        let at = |std_error: f64| at_value(0.027, std_error);
        let (held, its_error) = at(1e-9);
        assert!((held - 0.027).abs() < 1e-7, "{held}");
        assert!(its_error < 1.1e-9, "{its_error}");
        let (free, own_error) = at(10.0);
        assert!(
            (free - 0.0262).abs() < 5.0 * own_error,
            "{free} +- {own_error}"
        );
        // As well known as the recording tells it: in the middle.
        let (middle, _) = at(own_error);
        assert!(
            (middle - 0.5 * (0.027 + free)).abs() < 0.25 * (0.027 - free).abs(),
            "{middle}"
        );
        // Where both agree, with 0.7 of the error; where they do not, the misfit widens it.
        let (_, less) = at_value(free, own_error);
        assert!(
            (0.55..0.85).contains(&(less / own_error)),
            "{less} {own_error}"
        );
    }
}
