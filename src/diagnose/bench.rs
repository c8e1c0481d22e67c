//! Recordings made ready for a diagnosis, and fits of models to them.
//!
//! All fits here are over calm stretches ([`super::calm`]): what happens at the ground is
//! looked at by itself ([`super::events`]).

use std::time::Duration;

use super::calm::{Calm, prepare_calm};
use super::noise::{self, Noise, Stays};
use super::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use super::stretches::{adopt, heal, thinned};
use crate::fit::chain::Sigmas;
use crate::fit::prepare::{Findings, Prepared, default_length, look, prepare};
use crate::fit::problem::{Nuisance, Problem};
use crate::fit::robust::Huber;
use crate::fit::segment::Segment;
use crate::fit::solve::{Clock, Plan, Point, improve, settle};
use crate::fit::space::Space;
use crate::fit::{Control, FitError, FitOptions, FreeNuisances, Part, Progress};
use crate::model::Model;
use crate::model::effects::ActiveEffect;
use crate::model::parameter::ParameterId;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, StretchSimulator};

/// Standard deviation of what is known of the skew between the clocks of voltage and
/// readings \[s\].
const SKEW: f64 = 5e-6;
/// Loss by which fits are compared, in units of the noise.
pub const LOSS: Huber = Huber(6.0);
/// Others that are tried where much is left.
const FILMS: [f64; 3] = [0.25, 0.6, 0.08];
/// Chi2 per value above which other films are tried.
const MUCH: f64 = 1.15;
/// Another film must bring it below this share for more to be tried.
const BETTER: f64 = 0.95;
/// Modes that are simulated quickly.
const QUICK_MODES: usize = 2;
/// What is not moved at first.
const LATER: [&str; 8] = [
    "Cs", "gp", "f1", "f2", "zeta2", "shape_c2", "shape_p2", "drive_p",
];
/// Chi2 per value after the first step above which a drive that is shared otherwise among
/// the modes is tried.
const ASTRAY: f64 = 3.0;
/// Thickness of the film at contact at first, as a share of `dp`.
const FILM: f64 = 0.2;
/// Share of the cost by which an iteration must lower it to be followed by another, at
/// the end.
const FINE: f64 = 2e-6;
/// The same on the way.
const ROUGH: f64 = 2e-3;

/// Factor by which the frequencies of the modes may be off.
const FREQUENCY: f64 = 1.5;
/// The same of their dampings.
const DAMPING: f64 = 20.0;
/// A damping ratio may be as large as this whatever it was thought to be.
const DAMPED: f64 = 0.3;
/// The same of their shapes.
const SHAPE: f64 = 3.0;

/// A parameter's id, `effect.parameter`, with its least and largest value.
pub type Bound = (String, (f64, f64));

/// Recordings on one side: fitted, or kept out.
#[derive(Debug, Clone)]
pub struct Side {
    /// The recordings.
    pub parts: Vec<Part>,
    findings: Vec<Findings>,
    /// Cut into calm stretches.
    pub calm: Calm,
}

/// Everything that does not change while hypotheses are weighed.
#[derive(Debug, Clone)]
pub struct Bench {
    /// To fit.
    pub train: Side,
    /// Kept out; without recordings if there are none.
    pub held_out: Option<Side>,
    /// Noise of the readings.
    pub noise: Noise,
    /// Relative standard error of its size.
    pub noise_error: f64,
    /// Ids of the baseline's own freedoms.
    pub free: Vec<String>,
    bounds: Vec<Bound>,
    options: FitOptions,
}

/// A model fitted to one side.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The model at the fit.
    pub model: Model,
    /// The problem with its parameters.
    pub problem: Problem,
    /// Where it ended.
    pub point: Point,
    /// Robust cost by [`LOSS`], corrected for the stretches' own unknowns.
    pub cost: f64,
}

impl Fitted {
    /// Rows minus the stretches' own unknowns.
    pub fn freedom(&self) -> f64 {
        let own: usize = self.point.segments.iter().map(|s| s.locals.len()).sum();
        self.point.rows.saturating_sub(own).max(1) as f64
    }
}

/// What re-tuning may move: the baseline's own parameters that calm stretches tell, and
/// how the readings and the drive share in the modes.
fn freedoms(model: &Model, lone: bool) -> Vec<String> {
    use ParameterId as P;
    let own = [
        P::Eta,
        P::Dp,
        P::Zeta1,
        P::Zeta2,
        P::Cs,
        P::Gp,
        P::F1,
        P::F2,
        P::ShapeC1,
        P::ShapeC2,
        P::ShapeP2,
        P::DriveP,
    ];
    // Without the cantilever's reading nothing shows its shares.
    let seen = |p: &P| !lone || !matches!(p, P::ShapeC1 | P::ShapeC2 | P::ShapeP2);
    let mut free: Vec<String> = own
        .into_iter()
        .filter(|p| model.uses(*p) && seen(p))
        .filter(|p| *p != P::F1 || model.parameters[P::F1] > 0.0)
        .map(|p| p.spec().id.to_owned())
        .collect();
    for effect in &model.effects {
        let own = effect.spec.parameters.iter();
        free.extend(own.map(|p| format!("{}.{}", effect.spec.id, p.id)));
    }
    free
}

/// Bounds of the structure's own freedoms: a structure that may become any other would
/// take over what is missing, or run off to modes that no reading could show.
fn structure_bounds(model: &Model) -> Vec<Bound> {
    use ParameterId as P;
    let near = |id: P, factor: f64| {
        let value = model.parameters[id];
        (id.spec().id.to_owned(), (value / factor, value * factor))
    };
    let frequencies = [P::F1, P::F2].map(|id| near(id, FREQUENCY));
    let dampings = [P::Zeta1, P::Zeta2].map(|id| {
        let (id, (least, most)) = near(id, DAMPING);
        (id, (least, most.max(DAMPED)))
    });
    // Shapes may have either sign: so may the drive's share in a mode.
    let shapes = [P::ShapeC1, P::ShapeC2, P::ShapeP2].map(|id| {
        let most = SHAPE * model.parameters[id].abs();
        (id.spec().id.to_owned(), (-most, most))
    });
    frequencies
        .into_iter()
        .chain(dampings)
        .chain(shapes)
        .collect()
}

impl Bench {
    /// Makes recordings ready.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a recording or the model cannot be used.
    pub fn new(
        model: &Model,
        train: &[Part],
        held_out: &[Part],
        options: &DiagnoseOptions,
    ) -> Result<Self, DiagnoseError> {
        if train.is_empty() {
            return Err(DiagnoseError::NoRecording);
        }
        let lone = train.iter().all(|p| p.recording.cantilever.is_none()) || !model.has_cantilever;
        let free = freedoms(model, lone);
        // One length for all models, so that all are judged by the same stretches.
        let simulation = crate::sim::Options {
            tolerance: options.tolerance,
            ..crate::sim::Options::default()
        };
        let longest = default_length(&StretchSimulator::new(model, &simulation)?, lone);
        let fit = FitOptions {
            free: free.clone(),
            longest: Some(longest),
            nuisances: FreeNuisances {
                offsets: true,
                scales: None,
                skew: Some(SKEW),
            },
            tolerance: options.tolerance,
            ..FitOptions::for_model(model)
        };
        let space = Space::new(model, &free)?;
        let side = |parts: &[Part]| -> Result<Side, FitError> {
            let findings = look(model, parts);
            let calm = prepare_calm(model, &space, parts, &findings, &fit)?;
            Ok(Side {
                parts: parts.to_vec(),
                findings,
                calm,
            })
        };
        let mut train = side(train)?;
        let mut held_out = if held_out.is_empty() {
            None
        } else {
            Some(side(held_out)?)
        };
        let picks: [fn(&mut Sigmas) -> &mut f64; 2] = [|s| &mut s.xp, |s| &mut s.xc];
        let mut information = 0.0;
        for pick in picks {
            let mut all: Vec<(usize, &mut f64)> = std::iter::once(&mut train)
                .chain(&mut held_out)
                .flat_map(|s| &mut s.calm.prepared.problem.data)
                .map(|d| (d.recording.len(), pick(&mut d.sigmas)))
                .collect();
            information += noise::pool(&mut all).powi(-2);
        }
        let sides = || std::iter::once(&train).chain(&held_out);
        let stays: Vec<Stays<'_>> = sides()
            .flat_map(|s| s.calm.prepared.problem.data.iter().zip(&s.calm.timelines))
            .map(|(d, timeline)| Stays {
                recording: &d.recording,
                timeline,
                sigma: d.sigmas.xp,
            })
            .collect();
        let noise = noise::estimate(&stays);
        for side in std::iter::once(&mut train).chain(&mut held_out) {
            side.colour(&noise);
        }
        for data in std::iter::once(&train)
            .chain(&held_out)
            .flat_map(|s| &s.calm.prepared.problem.data)
        {
            log::debug!("{}: {:?}", data.recording.name, data.sigmas);
        }
        Ok(Self {
            train,
            held_out,
            noise,
            noise_error: information.max(1.0).powf(-0.5),
            free,
            bounds: structure_bounds(model),
            options: fit,
        })
    }

    /// Beginnings of the fitted recordings in the series of all, in the order given \[s\].
    pub fn epochs(&self) -> Vec<f64> {
        let mut at = 0.0;
        let parts = self.train.parts.iter();
        parts
            .map(|part| {
                let (begin, end) = part.recording.span();
                let epoch = at - begin;
                at += end - begin;
                epoch
            })
            .collect()
    }

    /// The same recordings as one series in time: what happens to the ground once, happens
    /// to all later ones. Those kept out come last.
    pub fn in_series(&self) -> Self {
        let mut series = self.clone();
        let mut epochs = self.epochs();
        let length = |p: &Part| p.recording.span().1 - p.recording.span().0;
        let mut at: f64 = self.train.parts.iter().map(length).sum();
        for (data, epoch) in series
            .train
            .calm
            .prepared
            .problem
            .data
            .iter_mut()
            .zip(&epochs)
        {
            data.epoch = *epoch;
        }
        epochs.clear();
        if let Some(held_out) = &mut series.held_out {
            for (data, part) in held_out
                .calm
                .prepared
                .problem
                .data
                .iter_mut()
                .zip(&held_out.parts)
            {
                data.epoch = at - part.recording.span().0;
                at += length(part);
            }
        }
        series
    }

    /// The baseline, re-tuned to the fitted recordings from `model`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn baseline(
        &self,
        model: &Model,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let mut start = model.clone();
        if model.has_ground {
            let known = self
                .train
                .findings
                .iter()
                .filter_map(|f| f.level.clone().ok());
            let mut known: Vec<f64> = known.collect();
            let level = quantile_in_place(&mut known, 0.5);
            let p = &mut start.parameters;
            if level.is_finite() && level < 0.0 {
                p.set(ParameterId::Dp, -level);
            }
            p.set(ParameterId::Gp, (1.0 + FILM) * p[ParameterId::Dp]);
        }
        // A part of the stretches is enough to come near, and three times as fast.
        let few = thinned(&self.train.calm.prepared.segments);
        let (mut problem, mut point) = self.near(&start, &few, control)?;
        let off = |point: &Point| point.cost / point.rows.max(1) as f64;
        if off(&point) > ASTRAY && model.uses(ParameterId::ShapeP2) && model.piezo.is_some() {
            // A film that bends the beam by moments drives the second mode the other way
            // round than a force at its centre.
            let p = &mut start.parameters;
            for id in [ParameterId::ShapeC2, ParameterId::ShapeP2] {
                p.set(id, -p[id]);
            }
            let (flipped, other) = self.near(&start, &few, control)?;
            if off(&other) < off(&point) {
                (problem, point) = (flipped, other);
            }
        }
        let segments = &self.train.calm.prepared.segments;
        // What acts most comes first: frequencies and dampings of motions that are far off
        // in size would go astray.
        let late: [&[&str]; 2] = [&["Cs", "gp", "shape_p2"], &["gp"]];
        for ids in late {
            let mut locked = positions(&problem, ids);
            if locked.len() == problem.space.len() {
                continue;
            }
            if ids.len() > 2 {
                locked.extend(skews(&problem));
            }
            point = self.improve(&problem, point, &locked, (7, ROUGH), control)?;
            heal(&problem, &mut point, segments)?;
        }
        let before = point.clone();
        point = self.improve(&problem, point, &[], (10, ROUGH), control)?;
        let rough = point.cost / point.rows.max(1) as f64;
        let mut best = self.whole(problem, point, &few, control)?;
        // Strength and thickness of the film trade against each other along a valley
        // that may lead astray: other thicknesses are tried where much is left.
        let thickness = best.problem.space.position("gp");
        for share in FILMS {
            let left = best.cost / best.point.rows.max(1) as f64;
            let Some(at) = thickness.filter(|_| left > MUCH && !control.cancelled()) else {
                break;
            };
            let problem = best.problem.clone();
            let entry = &problem.space.entries[at];
            let mut x = before.x.clone();
            let gap = share * best.model.parameters[ParameterId::Dp];
            x[at] = gap.ln().clamp(entry.low, entry.high);
            let mut point = settle(&problem, &x, &before.segments, &before.used, LOSS, 2)?;
            let locked = positions(&problem, &["gp"]);
            point = self.improve(&problem, point, &locked, (5, ROUGH), control)?;
            point = self.improve(&problem, point, &[], (10, ROUGH), control)?;
            // All stretches only where the few promise something.
            let reached = point.cost / point.rows.max(1) as f64;
            if reached > BETTER * rough {
                break;
            }
            let other = self.whole(problem, point, &few, control)?;
            let per_row = |f: &Fitted| f.cost / f.point.rows.max(1) as f64;
            let better = per_row(&other) < BETTER * per_row(&best);
            if per_row(&other) < per_row(&best) {
                best = other;
            }
            // Where the film is not to blame no other will do better.
            if !better {
                break;
            }
        }
        Ok(best)
    }

    /// The first step of a fit of `start` to the `few` stretches: sizes, and what damps
    /// the slow motion.
    fn near(
        &self,
        start: &Model,
        few: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<(Problem, Point), DiagnoseError> {
        let segments = &self.train.calm.prepared.segments;
        let mut problem = self.train.calm.prepared.problem.clone();
        problem.space = Space::new(start, &self.free)?;
        for (id, range) in &self.bounds {
            problem.space.keep_between(id, *range);
        }
        let mut x = problem.space.coordinates(start);
        x.resize(problem.unknowns(), 0.0);
        let mut point = settle(&problem, &x, segments, few, Huber(1e4), 3)?;
        let mut locked = positions(&problem, &LATER);
        if locked.len() < problem.space.len() {
            locked.extend(skews(&problem));
            point = self.improve(&problem, point, &locked, (7, ROUGH), control)?;
            heal(&problem, &mut point, segments)?;
        }
        Ok((problem, point))
    }

    /// Goes on with all stretches where a fit was to the `few` only.
    fn whole(
        &self,
        problem: Problem,
        point: Point,
        few: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let segments = &self.train.calm.prepared.segments;
        // The others begin from their first guess.
        let others: Vec<bool> = few.iter().map(|f| !f).collect();
        let rest = settle(&problem, &point.x, segments, &others, Huber(1e4), 3)?;
        let (mut own, mut used) = (point.segments, point.used);
        for i in (0..few.len()).filter(|&i| !few[i]) {
            own[i] = rest.segments[i].clone();
            used[i] = true;
        }
        let mut point = settle(&problem, &point.x, &own, &used, LOSS, 2)?;
        heal(&problem, &mut point, segments)?;
        point = self.improve(&problem, point, &[], (20, FINE), control)?;
        if heal(&problem, &mut point, segments)? {
            point = self.improve(&problem, point, &[], (10, FINE), control)?;
        }
        self.finish(problem, point)
    }

    /// A model with effects, fitted to the fitted recordings from `start`, whose values
    /// for the baseline's freedoms and the ids of `free` are moved; those in `bounds` stay
    /// within them. `from` is a fit of a model near by.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn fit(
        &self,
        start: &Model,
        free: &[String],
        bounds: &[Bound],
        from: &Fitted,
        iterations: usize,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let mut ids = self.free.clone();
        ids.extend_from_slice(free);
        let mut problem = self.train.calm.prepared.problem.clone();
        problem.space = Space::new(start, &ids)?;
        for (id, bound) in self.bounds.iter().chain(bounds) {
            problem.space.keep_between(id, *bound);
        }
        let mut x = problem.space.coordinates(start);
        x.extend_from_slice(&from.point.x[from.problem.space.len()..]);
        shift_skews(&problem, &mut x, delay(start)? - delay(&from.model)?);
        let fresh = modes(start) != modes(&from.model);
        let mut point = if fresh {
            let side = &self.train;
            let space = &problem.space;
            let calm = prepare_calm(start, space, &side.parts, &side.findings, &self.options)?;
            let segments = calm.prepared.segments;
            // The same stretches, with more unknowns each: what was misread stays aside.
            let used = if segments.len() == from.point.used.len() {
                from.point.used.clone()
            } else {
                vec![true; segments.len()]
            };
            let (old, new) = (
                from.problem.simulator(&from.point.x)?,
                StretchSimulator::new(start, &problem.options)?,
            );
            let segments = adopt(&from.point.segments, segments, (&old, &new), &problem);
            // What is new finds its place first, on a part of the stretches.
            let few = some_of(&segments, &used);
            let start = settle(&problem, &x, &segments, &few, LOSS, 3)?;
            let known: Vec<usize> = (0..self.free.len()).collect();
            let near = self.improve(&problem, start, &known, (12, ROUGH), control)?;
            let near = self.improve(&problem, near, &[], (6, ROUGH), control)?;
            let mut all = segments;
            for i in (0..all.len()).filter(|&i| few[i]) {
                all[i] = near.segments[i].clone();
            }
            settle(&problem, &near.x, &all, &used, LOSS, 3)?
        } else if modes(start) > QUICK_MODES {
            // Fast modes make short steps: the way is gone on a part of the stretches.
            let own = &from.point;
            let few = some_of(&own.segments, &own.used);
            let start = settle(&problem, &x, &own.segments, &few, LOSS, 2)?;
            let near = self.improve(&problem, start, &[], (iterations, ROUGH), control)?;
            settle(&problem, &near.x, &own.segments, &own.used, LOSS, 2)?
        } else {
            let own = &from.point;
            settle(&problem, &x, &own.segments, &own.used, LOSS, 2)?
        };
        point = self.improve(&problem, point, &[], (iterations, FINE), control)?;
        self.finish(problem, point)
    }

    /// A model against the recordings kept out, its parameters frozen; `None` if there are
    /// none. `train` is its fit, or a fit near by; `from` is the judgement of a model near
    /// by.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn judge(
        &self,
        model: &Model,
        (train, from): (&Fitted, Option<&Fitted>),
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Fitted>, DiagnoseError> {
        let Some(side) = &self.held_out else {
            return Ok(None);
        };
        let mut problem = side.calm.prepared.problem.clone();
        problem.space = Space::new(model, &self.free)?;
        let mut x = problem.space.coordinates(model);
        let near = from.filter(|f| modes(&f.model) == modes(model));
        // The clocks are those of the fitted recordings.
        let (clocks, late) = match from {
            Some(from) => (0.0, delay(model)? - delay(&from.model)?),
            None => (usual_skew(train), delay(model)? - delay(&train.model)?),
        };
        let (segments, point) = match near {
            Some(from) => {
                x.extend_from_slice(&from.point.x[from.problem.space.len()..]);
                shift_skews(&problem, &mut x, clocks + late);
                let own = &from.point;
                let point = settle(&problem, &x, &own.segments, &own.used, LOSS, 2)?;
                (side.calm.prepared.segments.clone(), point)
            }
            None => {
                match from {
                    Some(from) => x.extend_from_slice(&from.point.x[from.problem.space.len()..]),
                    None => x.resize(problem.unknowns(), 0.0),
                }
                shift_skews(&problem, &mut x, clocks + late);
                let space = &problem.space;
                let (parts, findings) = (&side.parts, &side.findings);
                let segments = prepare_calm(model, space, parts, findings, &self.options)?
                    .prepared
                    .segments;
                let used = match from {
                    Some(from) if from.point.used.len() == segments.len() => {
                        from.point.used.clone()
                    }
                    _ => vec![true; segments.len()],
                };
                let (segments, loss) = match from {
                    Some(from) => {
                        let old = from.problem.simulator(&from.point.x)?;
                        let new = StretchSimulator::new(model, &problem.options)?;
                        let own = &from.point.segments;
                        (adopt(own, segments, (&old, &new), &problem), LOSS)
                    }
                    None => (segments, Huber(1e4)),
                };
                let point = settle(&problem, &x, &segments, &used, loss, 3)?;
                (segments, point)
            }
        };
        let locked: Vec<usize> = (0..problem.space.len()).collect();
        let mut point = self.improve(&problem, point, &locked, (10, FINE), control)?;
        if from.is_none() && heal(&problem, &mut point, &segments)? {
            point = self.improve(&problem, point, &locked, (5, FINE), control)?;
        }
        Ok(Some(self.finish(problem, point)?))
    }

    /// Recordings of a side cut with their events, into stretches of at most `longest`
    /// \[s\], for `model`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn with_events(
        &self,
        side: &Side,
        model: &Model,
        longest: f64,
    ) -> Result<Prepared, DiagnoseError> {
        let space = Space::new(model, &self.free)?;
        let options = FitOptions {
            longest: Some(longest),
            ..self.options.clone()
        };
        Ok(prepare(
            model,
            &space,
            &side.parts,
            &side.findings,
            &options,
        )?)
    }

    fn improve(
        &self,
        problem: &Problem,
        point: Point,
        locked: &[usize],
        (iterations, enough): (usize, f64),
        control: &DiagnoseControl<'_>,
    ) -> Result<Point, DiagnoseError> {
        let quiet = |_: &Progress| {};
        let control = Control {
            cancel: control.cancel,
            progress: &quiet,
        };
        let plan = Plan {
            stage: "calm stretches",
            iterations,
            locked,
            enough,
        };
        let mut clock = Clock::new(iterations);
        let point = improve(problem, point, &plan, &control, &mut clock)?;
        log::debug!(
            "chi2 {:.1} of {} rows with {:?}",
            point.cost,
            point.rows,
            Values(problem, &point)
        );
        Ok(point)
    }

    fn finish(&self, problem: Problem, point: Point) -> Result<Fitted, DiagnoseError> {
        let point = settle(&problem, &point.x, &point.segments, &point.used, LOSS, 2)?;
        let mut own: usize = point.segments.iter().map(|s| s.locals.len()).sum();
        let model = problem.space.model(&point.x);
        if problem.simulator(&point.x)?.reading_states().is_some() {
            // The first reading of each stretch is taken over, and its noise fades with
            // the lag.
            let channels = |s: &Segment| {
                let data = &problem.data[s.recording].recording;
                2 * (1 + usize::from(data.cantilever.is_some()))
            };
            own += point.segments.iter().map(channels).sum::<usize>();
        }
        Ok(Fitted {
            model,
            cost: point.cost + own as f64,
            problem,
            point,
        })
    }
}

impl Side {
    /// Takes over what was found of the noise.
    fn colour(&mut self, noise: &Noise) {
        for data in &mut self.calm.prepared.problem.data {
            data.sigmas.xp *= noise.factor;
            data.sigmas.xc *= noise.factor;
            data.sigmas.colour = noise.colour;
        }
    }

    /// The stretches as first guessed.
    pub fn segments(&self) -> &[Segment] {
        &self.calm.prepared.segments
    }
}

/// Where a fit stands, for the log.
struct Values<'a>(&'a Problem, &'a Point);

impl std::fmt::Debug for Values<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(problem, point) = self;
        let values = problem.space.values(&point.x);
        for (entry, value) in problem.space.entries.iter().zip(values) {
            write!(f, "{} {value:.4e}, ", entry.id)?;
        }
        write!(f, "{} stretches", point.segments.len())
    }
}

/// `model` with one more effect, in place of one of the same kind.
pub fn with_effect(model: &Model, effect: ActiveEffect) -> Model {
    let mut with = model.clone();
    with.effects.retain(|e| e.spec != effect.spec);
    with.effects.push(effect);
    with
}

/// Time by which the effects make readings late \[s\].
fn delay(model: &Model) -> Result<f64, SimError> {
    let options = crate::sim::Options::default();
    Ok(StretchSimulator::new(model, &options)?.reading_delay())
}

/// Skew of the clocks in most recordings of a fit \[s\].
fn usual_skew(fitted: &Fitted) -> f64 {
    let first = fitted.problem.space.len();
    let mut all: Vec<f64> = skews(&fitted.problem)
        .into_iter()
        .map(|i| fitted.point.x[i] * fitted.problem.nuisances[i - first].unit)
        .collect();
    let skew = quantile_in_place(&mut all, 0.5);
    if skew.is_finite() { skew } else { 0.0 }
}

/// Moves all skews by `by` \[s\]: a delay of the readings that comes or goes is taken out
/// of them, or left to them.
fn shift_skews(problem: &Problem, x: &mut [f64], by: f64) {
    let first = problem.space.len();
    for i in skews(problem) {
        x[i] += by / problem.nuisances[i - first].unit;
    }
}

/// Those of `used` that are used on the way.
fn some_of(segments: &[Segment], used: &[bool]) -> Vec<bool> {
    let few = thinned(segments).into_iter();
    few.zip(used).map(|(few, used)| few && *used).collect()
}

fn modes(model: &Model) -> usize {
    let further = model.effects.iter().filter(|e| e.spec.id == "extra_mode");
    model.modes.len() + further.count()
}

fn positions(problem: &Problem, ids: &[&str]) -> Vec<usize> {
    ids.iter()
        .filter_map(|id| problem.space.position(id))
        .collect()
}

fn skews(problem: &Problem) -> Vec<usize> {
    let all = problem.nuisances.iter().enumerate();
    all.filter(|(_, n)| n.what == Nuisance::Skew)
        .map(|(i, _)| problem.space.len() + i)
        .collect()
}

/// An estimate of the time left from the share done and the time it took.
pub fn remaining(done: f64, elapsed: Duration) -> Duration {
    if done <= 0.0 {
        return Duration::ZERO;
    }
    elapsed.mul_f64(((1.0 - done) / done).clamp(0.0, 1e4))
}
