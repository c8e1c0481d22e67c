//! The regression of one state of knowledge: equations of all recordings with the effects that are
//! known so far, and further columns that are asked about.

use rayon::prelude::*;

use super::equations::Equations;
use super::gram::{Gram, Solution};
use super::measured_run::MeasuredRun;
use super::structure::AccelerationModel;
use super::windows::FlightWindows;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;
use crate::model::{Model, with_effect};
use crate::sim::{ActingForces, Options, SimError, StretchSimulator};

/// Thicknesses of the gas film at contact that the baseline may have together, as shares of the
/// model's own: forces of films between these are their sums, all but exactly.
const FILM_SHARES: [f64; 3] = [0.4, 1.0, 2.5];
/// Step of an effect's parameter for differences, as a share of its value.
const PARAMETER_STEP_SHARE: f64 = 1e-3;

/// An effect with those of its parameters that are fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedEffect {
    /// The effect.
    pub effect: ActiveEffect,
    /// Indices of its fitted parameters.
    pub free: Vec<usize>,
}

/// Recordings with their windows.
#[derive(Debug, Clone)]
pub struct Runs {
    /// The recordings.
    pub runs: Vec<MeasuredRun>,
    /// The windows of each flight of each.
    pub windows: Vec<Vec<FlightWindows>>,
}

/// Products over the recordings of a split for one state of knowledge. Columns: the baseline's own,
/// those of the effects' parameters, then one or two for each question.
#[derive(Debug, Clone)]
pub struct Regression {
    /// Products of all recordings.
    pub total: Gram,
    /// Products of each recording.
    pub each: Vec<Gram>,
    /// Number of columns of the baseline and of the known effects' parameters.
    pub known: usize,
    /// Columns of each question.
    pub asked: Vec<Vec<usize>>,
}

/// What is known so far: the device with effects, and how its readings accelerate.
#[derive(Debug, Clone)]
pub struct Knowledge {
    /// The device, with the effects of its preset.
    pub model: Model,
    /// Coefficients of the equations.
    pub structure: AccelerationModel,
    /// Effects that were found.
    pub effects: Vec<FittedEffect>,
}

impl Knowledge {
    /// The device with everything that is known to act.
    pub fn whole_model(&self) -> Model {
        let found = self.effects.iter();
        found.fold(self.model.clone(), |m, e| with_effect(&m, e.effect.clone()))
    }

    /// Coefficients of the baseline's columns: damping, stiffness and drive in each equation.
    fn structure_columns(&self) -> usize {
        let n = self.structure.readings();
        let sprung = if self.structure.is_sprung() {
            2 * n * n
        } else {
            0
        };
        sprung + if self.model.piezo.is_some() { n } else { 0 }
    }

    /// Takes over the structure that `solution` has found.
    pub fn adopt(&mut self, solution: &Solution) {
        let n = self.structure.readings();
        let value = |column: usize| {
            let place = solution.columns.iter().position(|c| *c == column);
            place.map(|k| solution.values[k]).filter(|v| *v != 0.0)
        };
        let mut at = 0;
        if self.structure.is_sprung() {
            for matrix in [&mut self.structure.damping, &mut self.structure.stiffness] {
                for row in 0..n {
                    for j in 0..n {
                        matrix[(row, j)] = value(at).unwrap_or(matrix[(row, j)]);
                        at += 1;
                    }
                }
            }
        }
        if self.model.piezo.is_some() {
            for row in 0..n {
                self.structure.drive[row] = value(at).unwrap_or(self.structure.drive[row]);
                at += 1;
            }
        }
    }
}

/// Products over `runs` for what is `known`, with the questions `asked`: effects at the size at
/// which they act in proportion.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn regression(
    runs: &Runs,
    known: &Knowledge,
    asked: &[ActiveEffect],
) -> Result<Regression, SimError> {
    let options = Options::default();
    let mut plain = known.model.clone();
    plain.effects.clear();
    let whole = known.whole_model();
    let plain = StretchSimulator::new(&plain, &options)?;
    let joint = StretchSimulator::new(&whole, &options)?;
    // Differences along the fitted parameters of the effects.
    let mut varied = Vec::new();
    for fitted in &known.effects {
        for &i in &fitted.free {
            let mut effect = fitted.effect.clone();
            let step = parameter_step(&effect, i);
            effect.values[i] += step;
            let model = with_effect(&whole, effect);
            varied.push((StretchSimulator::new(&model, &options)?, step));
        }
    }
    let with = |effect: &ActiveEffect| {
        // Added last, without replacing one of the same kind that is known already.
        let mut model = whole.clone();
        model.effects.push(effect.clone());
        StretchSimulator::new(&model, &options)
    };
    let questions = asked.iter().map(with).collect::<Result<Vec<_>, _>>()?;
    let parts: Vec<(Gram, usize, Vec<Vec<usize>>)> = runs
        .runs
        .par_iter()
        .zip(&runs.windows)
        .map(|(run, windows)| {
            let equations = Equations::new(run, windows.clone(), &known.structure);
            gram_of_run(&equations, known, (&plain, &joint), &varied, &questions)
        })
        .collect();
    let known_columns = parts.first().map_or(0, |p| p.1);
    // A question's columns are the same in all recordings: those that any of them needs.
    let mut all = Gram::new(parts.first().map_or(0, |p| p.0.slopes.len()));
    for (gram, ..) in &parts {
        all.add(gram);
    }
    let asked = parts.first().map(|p| p.2.clone()).unwrap_or_default();
    Ok(Regression {
        total: all,
        each: parts.into_iter().map(|p| p.0).collect(),
        known: known_columns,
        asked,
    })
}

/// Step of parameter `i` of an effect for differences, in its unit.
fn parameter_step(effect: &ActiveEffect, i: usize) -> f64 {
    let (low, high) = effect.spec.parameters[i].range;
    let size = if effect.values[i] == 0.0 {
        0.01 * (high - low).abs()
    } else {
        effect.values[i].abs()
    };
    PARAMETER_STEP_SHARE * size
}

fn gram_of_run(
    equations: &Equations<'_>,
    known: &Knowledge,
    (plain, joint): (&StretchSimulator, &StretchSimulator),
    varied: &[(StretchSimulator, f64)],
    questions: &[StretchSimulator],
) -> (Gram, usize, Vec<Vec<usize>>) {
    let run = equations.run;
    let acting = |simulator: &StretchSimulator| {
        simulator.acting_forces(&run.drive, &run.nodes, &|t| run.motion_at(t))
    };
    let (base, whole) = (acting(plain), acting(joint));
    let drive: Vec<f64> = whole.iter().map(|a| a.drive).collect();
    let difference = |of: &[ActingForces], from: &[ActingForces]| -> Vec<ActingForces> {
        of.iter().zip(from).map(|(a, b)| a.beyond(b)).collect()
    };
    let mut columns = Vec::new();
    let n = known.structure.readings();
    if known.structure.is_sprung() {
        columns.extend(equations.structure_columns());
    }
    if known.model.piezo.is_some() {
        columns.extend((0..n).map(|row| equations.in_one_equation(row, &drive)));
    }
    debug_assert_eq!(columns.len(), known.structure_columns());
    if known.model.has_ground {
        columns.extend(film_columns(equations, &known.model));
    }
    // What the known effects do to all but the drive is on the right; how the drive acts is fitted.
    let mut effects = difference(&whole, &base);
    effects.iter_mut().for_each(|a| a.drive = 0.0);
    let mut right = equations.accelerations();
    for (r, known) in right.iter_mut().zip(equations.of_forces(&effects)) {
        *r -= known;
    }
    for (simulator, step) in varied {
        let mut along = equations.of_forces(&difference(&acting(simulator), &whole));
        along.iter_mut().for_each(|c| *c /= step);
        columns.push(along);
    }
    // How a force on the mass moves the cantilever is known less well than how it moves the mass.
    for fitted in &known.effects {
        let mut without = known.whole_model();
        without.effects.retain(|e| e.spec != fitted.effect.spec);
        let forces = StretchSimulator::new(&without, &Options::default()).map(|s| acting(&s));
        if let (Ok(forces), true) = (forces, n > 1) {
            let own = difference(&whole, &forces);
            let on_mass: Vec<f64> = own.iter().map(|a| a.on_mass).collect();
            columns.push(equations.in_one_equation(1, &on_mass));
        }
    }
    let known_columns = columns.len();
    let mut asked = Vec::new();
    for simulator in questions {
        let own = difference(&acting(simulator), &whole);
        let mut of_one = vec![columns.len()];
        columns.push(equations.of_forces(&own));
        if n > 1 {
            let on_mass: Vec<f64> = own.iter().map(|a| a.on_mass).collect();
            of_one.push(columns.len());
            columns.push(equations.in_one_equation(1, &on_mass));
        }
        asked.push(of_one);
    }
    (
        equations.gram(&columns, &right, &drive),
        known_columns,
        asked,
    )
}

/// Columns of the gas film, eq (10): `F = d/dt [Cs / 2 (xp + gp)^-2]`, for some thicknesses in each
/// equation.
fn film_columns(equations: &Equations<'_>, model: &Model) -> Vec<Vec<f64>> {
    let p = &model.parameters;
    let (gp, dp) = (p[ParameterId::Gp], p[ParameterId::Dp]);
    let at_contact = gp - dp;
    let run = equations.run;
    let mut out = Vec::new();
    for share in FILM_SHARES {
        let gap = dp + share * at_contact;
        // Below the ground the film stays as thick as half of what it is there.
        let potential = |xp: f64| 0.5 * (xp + gap).max(0.5 * share * at_contact).powi(-2);
        let values: Vec<f64> = run.motion.iter().map(|m| potential(m.xp)).collect();
        for row in 0..run.readings.len() {
            out.push(equations.rate_in_one_equation(row, &values));
        }
    }
    out
}
