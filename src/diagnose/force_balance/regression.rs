//! The regression of one state of knowledge: equations of all recordings with the effects that are
//! known so far, and further columns that are asked about.

use rayon::prelude::*;

use super::equations::Equations;
use super::least_squares::gram::{Gram, Solution};
use super::measured_run::MeasuredRun;
use super::slow_mode::SlowMode;
use super::windows::{FlightWindows, windows};
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;
use crate::model::{Model, with_effect};
use crate::recording::median_in_place;
use crate::sim::{ActingForces, Options, SimError, StretchSimulator};

/// Thicknesses of the gas film at contact that the baseline may have together, as shares of the
/// model's own: forces of films between these are their sums, all but exactly.
const FILM_SHARES: [f64; 3] = [0.4, 1.0, 2.5];
/// Step of an effect's parameter for differences, as a share of its value.
const PARAMETER_STEP_SHARE: f64 = 1e-3;

/// Median of the size of a standard normal number.
const MEDIAN_OF_NORMAL: f64 = 0.6745;
/// Most rows that overlooked events may spoil, as a share of all.
const MAX_MISREAD_SHARE: f64 = 0.03;

/// An effect with those of its parameters that are fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedEffect {
    /// The effect.
    pub effect: ActiveEffect,
    /// Indices of its fitted parameters.
    pub free: Vec<usize>,
    /// Bounds of these.
    pub bounds: Vec<(f64, f64)>,
}

/// Recordings with their windows.
#[derive(Debug, Clone)]
pub struct Runs {
    /// The recordings.
    pub runs: Vec<MeasuredRun>,
    /// The windows of each flight of each.
    pub windows: Vec<Vec<FlightWindows>>,
    /// Half width of the test functions \[s\].
    w: f64,
}

impl Runs {
    /// Those recordings with test functions of half width `w` \[s\].
    pub fn new(runs: Vec<MeasuredRun>, w: f64) -> Self {
        let windows = runs.iter().map(|run| windows(run, w)).collect();
        Self { runs, windows, w }
    }

    /// The same with readings whose scales differ from recording to recording by `sigma`.
    pub fn with_scale_sigma(mut self, sigma: f64) -> Self {
        self.runs.iter_mut().for_each(|run| run.scale_sigma = sigma);
        self
    }

    /// Lets the drive of each recording act later by so much more \[s\].
    pub fn delay_drives(&mut self, more: &[f64]) {
        for ((run, own), more) in self.runs.iter_mut().zip(&mut self.windows).zip(more) {
            if *more != 0.0 {
                run.delay_drive(run.skew + more);
                let trusts: Vec<f64> = own.iter().flatten().map(|w| w.trust).collect();
                *own = windows(run, self.w);
                for (window, trust) in own.iter_mut().flatten().zip(trusts) {
                    window.trust = trust;
                }
            }
        }
    }
}

/// Products over the recordings of a split for one state of knowledge. Columns: the baseline's own,
/// those of the effects' parameters, then one for each question.
#[derive(Debug, Clone)]
pub struct Regression {
    /// Products of all recordings.
    pub total: Gram,
    /// Number of columns of the baseline and of the known effects' parameters.
    pub known: usize,
}

/// What is known so far: the device with effects, and how its readings accelerate.
#[derive(Debug, Clone)]
pub struct Knowledge {
    /// The device, with the effects of its preset.
    pub model: Model,
    /// Coefficients of the equation.
    pub mode: SlowMode,
    /// Effects that were found.
    pub effects: Vec<FittedEffect>,
    /// Coefficients of the baseline's columns: damping, stiffness, drive, film. A regression looks for
    /// changes of these, so that it loses no digits.
    coefficients: Vec<f64>,
}

impl Knowledge {
    /// Of `model` as it is, whose slowest mode is `mode`.
    pub fn new(model: &Model, mode: SlowMode) -> Self {
        let mut coefficients = Vec::new();
        if mode.is_sprung {
            coefficients.extend([mode.damping, mode.stiffness]);
        }
        if model.piezo.is_some() {
            coefficients.extend([mode.drive, 0.0, 0.0]);
        }
        if model.has_ground {
            let strength = mode.mass * model.parameters[ParameterId::Cs];
            let own = |share: f64| if share == 1.0 { strength } else { 0.0 };
            coefficients.extend(FILM_SHARES.map(own));
        }
        Self {
            model: model.clone(),
            mode,
            effects: Vec::new(),
            coefficients,
        }
    }

    /// Index of the first column of an effect's parameter.
    pub fn first_parameter(&self) -> usize {
        self.coefficients.len()
    }

    /// The device with everything that is known to act.
    pub fn whole_model(&self) -> Model {
        let found = self.effects.iter();
        found.fold(self.model.clone(), |m, e| with_effect(&m, e.effect.clone()))
    }

    /// Takes over what `solution` has found of the baseline.
    pub fn adopt(&mut self, solution: &Solution) {
        for (&column, value) in solution.columns.iter().zip(solution.values.iter()) {
            if let Some(own) = self.coefficients.get_mut(column) {
                *own += value;
            }
        }
        let mut own = self.coefficients.iter().copied();
        if self.mode.is_sprung {
            self.mode.damping = own.next().unwrap_or(self.mode.damping);
            self.mode.stiffness = own.next().unwrap_or(self.mode.stiffness);
        }
        if self.model.piezo.is_some() {
            self.mode.drive = own.next().unwrap_or(self.mode.drive);
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
    let devices = Devices::of(known)?;
    let whole = known.whole_model();
    let with = |effect: &ActiveEffect| {
        // Added last, without replacing one of the same kind that is known already.
        let mut model = whole.clone();
        model.effects.push(effect.clone());
        StretchSimulator::new(&model, &Options::default())
    };
    let questions = asked.iter().map(with).collect::<Result<Vec<_>, _>>()?;
    let (total, known) = sum_over(runs, |run, windows| {
        let mut own = devices.equations(run, windows, known);
        let count = own.columns.len();
        for simulator in &questions {
            let force = difference(&along(run, simulator), &own.acting.whole);
            own.columns.push(own.equations.of_forces(&force));
        }
        (own.gram(), count)
    });
    Ok(Regression { total, known })
}

/// Products summed over the recordings of `runs`, with the number of known columns, the same in each.
pub(super) fn sum_over(
    runs: &Runs,
    one: impl Fn(&MeasuredRun, &[FlightWindows]) -> (Gram, usize) + Sync,
) -> (Gram, usize) {
    let all = runs.runs.par_iter().zip(&runs.windows);
    let parts: Vec<(Gram, usize)> = all.map(|(run, windows)| one(run, windows)).collect();
    let mut total = Gram::new(parts.first().map_or(0, |p| p.0.slopes.len()));
    for (gram, _) in &parts {
        total.add(gram);
    }
    (total, parts.first().map_or(0, |p| p.1))
}

/// The device as a regression needs it.
pub(super) struct Devices {
    /// Without effects.
    plain: StretchSimulator,
    /// With all that are known.
    joint: StretchSimulator,
    /// With each fitted parameter varied by a step, and the steps.
    varied: Vec<(StretchSimulator, f64)>,
}

impl Devices {
    /// Those of what is `known`.
    ///
    /// # Errors
    /// [`SimError`] if a model makes no sense.
    pub(super) fn of(known: &Knowledge) -> Result<Self, SimError> {
        let options = Options::default();
        let mut plain = known.model.clone();
        plain.effects.clear();
        let whole = known.whole_model();
        Ok(Self {
            plain: StretchSimulator::new(&plain, &options)?,
            joint: StretchSimulator::new(&whole, &options)?,
            varied: varied_devices(known, &whole)?,
        })
    }

    /// The equations of `run` in its `windows`.
    pub(super) fn equations<'r>(
        &self,
        run: &'r MeasuredRun,
        windows: &[FlightWindows],
        known: &Knowledge,
    ) -> KnownEquations<'r> {
        let acting = Acting::new(run, &self.plain, &self.joint);
        let equations = Equations::new(run, windows.to_vec(), &known.mode, &acting.drive);
        let (columns, right) = known_columns(&equations, known, &acting, &self.varied);
        KnownEquations {
            equations,
            acting,
            columns,
            right,
        }
    }
}

/// The equations of a recording for what is known.
pub(super) struct KnownEquations<'r> {
    /// Rows and their noise.
    pub(super) equations: Equations<'r>,
    /// What acts.
    pub(super) acting: Acting,
    /// Columns of what is known; others may be added.
    pub(super) columns: Vec<Vec<f64>>,
    /// The right-hand side.
    right: Vec<f64>,
}

impl KnownEquations<'_> {
    /// Their products.
    pub(super) fn gram(&self) -> Gram {
        self.equations
            .gram(&self.columns, &self.right, &self.acting.drive)
    }
}

/// The device with each fitted parameter of each effect varied by a step, and the steps.
fn varied_devices(
    known: &Knowledge,
    whole: &Model,
) -> Result<Vec<(StretchSimulator, f64)>, SimError> {
    let mut varied = Vec::new();
    for fitted in &known.effects {
        for &i in &fitted.free {
            let mut effect = fitted.effect.clone();
            let step = parameter_step(&effect, i);
            effect.values[i] += step;
            let model = with_effect(whole, effect);
            varied.push((StretchSimulator::new(&model, &Options::default())?, step));
        }
    }
    Ok(varied)
}

/// Step of parameter `i` of an effect for differences, in its unit.
fn parameter_step(effect: &ActiveEffect, i: usize) -> f64 {
    let (low, high) = effect.spec.parameters[i].range;
    let size = if effect.values[i] == 0.0 {
        0.01 * (high - low).abs()
    } else {
        effect.values[i].abs()
    };
    let step = PARAMETER_STEP_SHARE * size;
    // At its upper limit a parameter can only be lowered.
    if effect.values[i] + step > effect.spec.parameters[i].limits.1 {
        -step
    } else {
        step
    }
}

/// What acts along the motion of a recording.
pub(super) struct Acting {
    /// All that is known.
    pub(super) whole: Vec<ActingForces>,
    /// The device without effects.
    base: Vec<ActingForces>,
    /// The force of the drive \[N\].
    drive: Vec<f64>,
}

impl Acting {
    fn new(run: &MeasuredRun, plain: &StretchSimulator, joint: &StretchSimulator) -> Self {
        let whole = along(run, joint);
        Self {
            drive: whole.iter().map(|a| a.drive).collect(),
            base: along(run, plain),
            whole,
        }
    }
}

/// What acts along the motion of `run`.
pub(super) fn along(run: &MeasuredRun, simulator: &StretchSimulator) -> Vec<ActingForces> {
    simulator.acting_forces(&run.drive, &run.nodes, &|t| run.motion_at(t))
}

pub(super) fn difference(of: &[ActingForces], from: &[ActingForces]) -> Vec<ActingForces> {
    of.iter().zip(from).map(|(a, b)| a.beyond(b)).collect()
}

/// The columns of what is known, and the right-hand side.
fn known_columns(
    equations: &Equations<'_>,
    known: &Knowledge,
    acting: &Acting,
    varied: &[(StretchSimulator, f64)],
) -> (Vec<Vec<f64>>, Vec<f64>) {
    let run = equations.run;
    let mut columns = Vec::new();
    if known.mode.is_sprung {
        columns.extend(equations.structure_columns());
    }
    if known.model.piezo.is_some() {
        // What faster modes yield to the drive moves the reading with it.
        columns.extend((0..3).map(|order| equations.of_values(order, &acting.drive)));
    }
    if known.model.has_ground {
        columns.extend(film_columns(equations, &known.model));
    }
    // What the known effects do to all but the drive is on the right; how the drive acts is fitted.
    let mut effects = difference(&acting.whole, &acting.base);
    effects.iter_mut().for_each(|a| a.drive = 0.0);
    let mut right = equations.accelerations();
    let mut subtract = |column: &[f64], by: f64| {
        for (r, c) in right.iter_mut().zip(column) {
            *r -= by * c;
        }
    };
    subtract(&equations.of_forces(&effects), 1.0);
    for (column, coefficient) in columns.iter().zip(&known.coefficients) {
        subtract(column, *coefficient);
    }
    for (simulator, step) in varied {
        let mut slope = equations.of_forces(&difference(&along(run, simulator), &acting.whole));
        slope.iter_mut().for_each(|c| *c /= step);
        columns.push(slope);
    }
    (columns, right)
}

/// Columns of the gas film, eq (10): `F = d/dt [Cs / 2 (xp + gp)^-2]`, for some thicknesses.
fn film_columns(equations: &Equations<'_>, model: &Model) -> Vec<Vec<f64>> {
    let p = &model.parameters;
    let (gp, dp) = (p[ParameterId::Gp], p[ParameterId::Dp]);
    let at_contact = gp - dp;
    let one = |share: f64| {
        let gap = dp + share * at_contact;
        // Below the ground the film stays as thick as half of what it is there.
        let potential = |xp: f64| 0.5 * (xp + gap).max(0.5 * share * at_contact).powi(-2);
        let motion = equations.run.motion.iter();
        let values: Vec<f64> = motion.map(|m| potential(m.xp)).collect();
        equations.of_values(1, &values)
    };
    FILM_SHARES.map(one).into()
}

/// What `solution` leaves of each recording, with its equations.
fn left_by<'r>(
    devices: &Devices,
    (run, windows): (&'r MeasuredRun, &[FlightWindows]),
    known: &Knowledge,
    solution: &Solution,
) -> (KnownEquations<'r>, Vec<f64>) {
    let own = devices.equations(run, windows, known);
    let mut left = own.right.clone();
    for (column, value) in own.columns.iter().zip(solution.values.iter()) {
        for (l, c) in left.iter_mut().zip(column) {
            *l -= value * c;
        }
    }
    (own, left)
}

/// Weighs the rows of `runs` anew by what `solution` leaves: a contact that was overlooked in a flight
/// spoils few rows, and these by far. The farther a row is beyond `limit` typical misfits, the less it
/// counts. With `is_last` all count alike where such rows are many, for then a force is missing.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn weigh_rows(
    runs: &mut Runs,
    known: &Knowledge,
    solution: &Solution,
    (limit, is_last): (f64, bool),
) -> Result<(), SimError> {
    let devices = Devices::of(known)?;
    let one = |(run, windows): (&MeasuredRun, &Vec<FlightWindows>)| {
        let (own, left) = left_by(&devices, (run, windows), known, solution);
        own.equations.misfits(&left, &own.acting.drive)
    };
    let all: Vec<Vec<f64>> = runs.runs.par_iter().zip(&runs.windows).map(one).collect();
    let mut sizes: Vec<f64> = all.iter().flatten().map(|z| z.abs()).collect();
    if sizes.is_empty() {
        return Ok(());
    }
    let typical = median_in_place(&mut sizes) / MEDIAN_OF_NORMAL;
    let most = limit * typical.max(1.0);
    let beyond = sizes.iter().filter(|z| **z > most).count() as f64;
    let are_many = beyond > MAX_MISREAD_SHARE * sizes.len() as f64;
    for (windows, misfits) in runs.windows.iter_mut().zip(&all) {
        for (window, z) in windows.iter_mut().flatten().zip(misfits) {
            let share = (most / z.abs()).min(1.0);
            window.trust = match (is_last, are_many) {
                (true, true) => 1.0,
                (true, false) => share * share,
                (false, _) => share,
            };
        }
    }
    Ok(())
}

/// By how much the drive of each recording acts later than it was assumed to by what `solution` leaves
/// \[s\].
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn clock_skews(
    runs: &Runs,
    known: &Knowledge,
    solution: &Solution,
) -> Result<Vec<f64>, SimError> {
    if known.model.piezo.is_none() {
        return Ok(vec![0.0; runs.runs.len()]);
    }
    let devices = Devices::of(known)?;
    let one = |(run, windows): (&MeasuredRun, &Vec<FlightWindows>)| {
        let (known, left) = left_by(&devices, (run, windows), known, solution);
        let own = known.equations.own_unknowns(&left, &known.acting.drive);
        // The last one is the skew.
        own.last().copied().unwrap_or(0.0)
    };
    Ok(runs.runs.par_iter().zip(&runs.windows).map(one).collect())
}
