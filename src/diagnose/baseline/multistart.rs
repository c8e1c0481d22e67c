//! The baseline re-tuned to the fitted recordings: from far off, in steps.

use crate::diagnose::data::level_drift;
use crate::diagnose::data::misread_segments::reassign_misread_segments;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::clock_skew::{set_clocks, skews};
use crate::diagnose::shooting::fitted::{Bound, Fitted};
use crate::diagnose::shooting::found::RequiredEffect;
use crate::diagnose::shooting::set_aside::taken_in;
use crate::diagnose::shooting::warm_start::thinned;
use crate::diagnose::shooting::workspace::{
    FINE, FORSAKEN, LOSS, ROUGH, WIDE, Workspace, positions,
};
use crate::diagnose::thresholds::{
    ASTRAY_SET_ASIDE_SHARE, ASTRAY_START_CHI2, FILM_MAX_CHI2_RATIO, FILM_RETRY_MAX_CHI2,
    FILM_RETRY_MIN_CHI2, RIVAL_START_MAX_RATIO, SUBSET_MISLED_RATIO,
};
use crate::fit::problem::Problem;
use crate::fit::problem::parameter_space::Space;
use crate::fit::solve::point::{Point, settle};
use crate::model::parameter::ParameterId;
use crate::model::{Model, with_effect};
use crate::recording::quantile_in_place;

/// Others that are tried where much is left.
const FILMS: [f64; 3] = [0.25, 0.6, 0.08];

/// What is not moved at first.
const LATER: [&str; 8] = [
    "Cs", "gp", "f1", "f2", "zeta2", "shape_c2", "shape_p2", "drive_p",
];
/// What shapes the loops of the drive: it runs off where their size is not known yet.
const LOOPS: [&str; 5] = [
    "hysteresis_memory.q",
    "hysteresis_memory.k",
    "hysteresis_memory.b2",
    "hysteresis_memory.b4",
    "hysteresis_memory.v_past",
];

/// Steps of each stretch's own fit from its first guess.
const GUESS: usize = 3;
/// Steps without a drift that was fitted.
const WITHOUT: usize = 10;
/// Thickness of the film at contact at first, as a share of `dp`.
const FILM: f64 = 0.2;

impl Workspace {
    /// The baseline alone.
    #[cfg(test)]
    pub fn baseline(
        &self,
        model: &Model,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        Ok(self.with_and_without_drift(model, control)?.0)
    }

    /// The baseline, re-tuned to the fitted recordings from `model`, and the fit with the drift if
    /// the ground's level shows one: that would lead the film astray, to where it is too thin and
    /// takes long, and the baseline begins with the fit with it.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn with_and_without_drift(
        &self,
        model: &Model,
        control: &DiagnoseControl<'_>,
    ) -> Result<(Fitted, Option<RequiredEffect>), DiagnoseError> {
        // A drift that the model has already is part of the baseline.
        let Some((drift, free)) = self.drift_beyond(model) else {
            return Ok((self.from_afar(model, &[], &[], control)?, None));
        };
        let with = self.from_afar(&with_effect(model, drift.clone()), free, &[], control)?;
        let mut start = with.model.clone();
        start.effects.retain(|e| e.spec != drift.spec);
        let fitted = self.fit(&start, &[], &[], &with, WITHOUT, control)?;
        let found = RequiredEffect {
            start: drift.clone(),
            free: free.clone(),
            bounds: Vec::new(),
            shape: level_drift::shape_beside(drift.spec, free),
            fitted: with,
        };
        Ok((fitted, Some(found)))
    }

    /// The same with the parameters of `free` moved too, from their values in `model` and
    /// within `bounds`: an effect so strong that no model without it comes near is fitted
    /// with all else from far off.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn from_afar(
        &self,
        model: &Model,
        free: &[String],
        bounds: &[Bound],
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        self.from(model, (free, bounds), self.share_open(free), control)
    }

    /// Whether it is asked how the drive is shared among the modes in a fit of the parameters of
    /// `free` besides: with an effect it is known from the model without it.
    pub(crate) fn share_open(&self, free: &[String]) -> bool {
        free.is_empty() || self.train.drift.is_some()
    }

    /// The baseline, re-tuned from `known`, a fit of `model` to the same recordings that were cut
    /// otherwise, and the fit with the drift if the level shows one.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn baseline_again(
        &self,
        model: &Model,
        known: &Fitted,
        control: &DiagnoseControl<'_>,
    ) -> Result<(Fitted, Option<RequiredEffect>), DiagnoseError> {
        if self.drift_beyond(model).is_some() {
            return self.with_and_without_drift(model, control);
        }
        Ok((self.from(&known.model, (&[], &[]), false, control)?, None))
    }

    /// A fit from far off; where `share_open`, it is asked how the drive is shared among the
    /// modes.
    pub(crate) fn from(
        &self,
        model: &Model,
        own: (&[String], &[Bound]),
        share_open: bool,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let fitted = self.within(model, own, (share_open, f64::INFINITY), control)?;
        Ok(fitted.expect("no cost is beyond infinity"))
    }

    /// The same, or `None` where a part of the stretches, on which it begins, stays farther off
    /// than `most` per value, each row set aside counted as [`FORSAKEN`].
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn within(
        &self,
        model: &Model,
        own: (&[String], &[Bound]),
        (share_open, most): (bool, f64),
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Fitted>, DiagnoseError> {
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
        let (mut problem, mut point) = self.near(&start, own, &few, control)?;
        let mut other = None;
        let off = |point: &Point| point.cost / point.rows.max(1) as f64;
        if share_open
            && off(&point) > ASTRAY_START_CHI2
            && model.uses(ParameterId::ShapeP2)
            && model.piezo.is_some()
        {
            // A film that bends the beam by moments drives the second mode the other way
            // round than a force at its centre.
            let p = &mut start.parameters;
            for id in [ParameterId::ShapeC2, ParameterId::ShapeP2] {
                p.set(id, -p[id]);
            }
            let mut flipped = self.near(&start, own, &few, control)?;
            if off(&flipped.1) < off(&point) {
                std::mem::swap(&mut problem, &mut flipped.0);
                std::mem::swap(&mut point, &mut flipped.1);
            }
            other = Some(flipped);
        }
        let first = off(&point);
        point = self.unlocked(&problem, point, &few, control)?;
        // The one that is nearer at first may lead astray, and sets aside what it does not
        // come near to.
        let aside = few.iter().zip(&point.used).filter(|(f, u)| **f && !**u);
        let all = few.iter().filter(|f| **f).count();
        let astray = off(&point) > ASTRAY_START_CHI2
            || aside.count() as f64 > ASTRAY_SET_ASIDE_SHARE * all as f64;
        // From the proof mass alone the first step hardly tells the two.
        let data = &problem.data;
        let lone = data.iter().all(|d| d.recording.cantilever.is_none());
        let near = |other: &(Problem, Point)| lone || off(&other.1) < RIVAL_START_MAX_RATIO * first;
        let mut rival = None;
        if let Some((flipped, begun)) = other.filter(|other| astray && near(other)) {
            let mut other = (self.unlocked(&flipped, begun, &few, control)?, flipped);
            if of_all(&other.1, &other.0, &few) < of_all(&problem, &point, &few) {
                std::mem::swap(&mut point, &mut other.0);
                std::mem::swap(&mut problem, &mut other.1);
            }
            rival = Some(other);
        }
        let mut before = point.clone();
        point = self.improve(&problem, point, &[], (10, ROUGH), control)?;
        let reached = of_all(&problem, &point, &few);
        if reached > most {
            log::debug!("{reached:.2} per value of a part, {most:.2} at most");
            return Ok(None);
        }
        let mut rough = off(&point);
        let mut best = self.whole(problem, point, &few, control)?;
        // What both tell of the few, all stretches may hold against one.
        if let Some((point, problem)) = rival.filter(|_| {
            best.per_value() > SUBSET_MISLED_RATIO * rough.max(1.0) && !control.cancelled()
        }) {
            let begun = point.clone();
            let point = self.improve(&problem, point, &[], (10, ROUGH), control)?;
            let reached = off(&point);
            let other = self.whole(problem, point, &few, control)?;
            let all = vec![true; few.len()];
            let cost = |f: &Fitted| of_all(&f.problem, &f.point, &all);
            log::debug!("shared otherwise: {:.1}, {:.1}", cost(&other), cost(&best));
            if cost(&other) < cost(&best) {
                (before, rough, best) = (begun, reached, other);
            }
        }
        // Strength and thickness of the film trade against each other along a valley
        // that may lead astray: other thicknesses are tried where much is left.
        let thickness = best.problem.space.position("gp");
        for share in FILMS {
            let left = best.per_value();
            let Some(at) = thickness.filter(|_| {
                (FILM_RETRY_MIN_CHI2..FILM_RETRY_MAX_CHI2).contains(&left) && !control.cancelled()
            }) else {
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
            if reached > FILM_MAX_CHI2_RATIO * rough {
                break;
            }
            let other = self.whole(problem, point, &few, control)?;
            let better = other.per_value() < FILM_MAX_CHI2_RATIO * best.per_value();
            if other.per_value() < best.per_value() {
                best = other;
            }
            // Where the film is not to blame no other will do better.
            if !better {
                break;
            }
        }
        Ok(Some(best))
    }

    /// The first step of a fit of `start` to the `few` stretches: sizes, and what damps
    /// the slow motion.
    fn near(
        &self,
        start: &Model,
        (free, bounds): (&[String], &[Bound]),
        few: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<(Problem, Point), DiagnoseError> {
        let segments = &self.train.calm.prepared.segments;
        let mut problem = self.train.calm.prepared.problem.clone();
        let mut ids = self.free.clone();
        ids.extend_from_slice(free);
        problem.space = Space::new(start, &ids)?;
        for (id, range) in self.bounds.iter().chain(bounds) {
            problem.space.keep_between(id, *range);
        }
        let mut x = problem.space.coordinates(start);
        x.resize(problem.unknowns(), 0.0);
        let mut point = settle(&problem, &x, segments, few, WIDE, 3)?;
        let mut locked = positions(&problem, &LATER);
        if locked.len() < problem.space.len() {
            locked.extend(skews(&problem));
            locked.extend(positions(&problem, &LOOPS));
            locked.extend(self.read_alone(&problem));
            point = self.improve(&problem, point, &locked, (7, ROUGH), control)?;
            reassign_misread_segments(&problem, &mut point, segments)?;
        }
        Ok((problem, point))
    }

    /// Goes on with all but the film's thickness.
    fn unlocked(
        &self,
        problem: &Problem,
        mut point: Point,
        few: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Point, DiagnoseError> {
        let segments = &self.train.calm.prepared.segments;
        // What acts most comes first: frequencies and dampings of motions that are far off
        // in size would go astray.
        let late: [&[&str]; 2] = [&["Cs", "gp", "shape_p2"], &["gp"]];
        for ids in late {
            let mut locked = positions(problem, ids);
            if locked.len() == problem.space.len() {
                continue;
            }
            if ids.len() > 2 {
                locked.extend(skews(problem));
            }
            locked.extend(positions(problem, &LOOPS));
            locked.extend(self.read_alone(problem));
            point = self.improve(problem, point, &locked, (7, ROUGH), control)?;
            set_clocks(problem, &mut point, segments, few)?;
            if reassign_misread_segments(problem, &mut point, segments)? {
                // What was set aside must not count any more.
                point = settle(problem, &point.x, &point.segments, &point.used, LOSS, 1)?;
            }
        }
        Ok(point)
    }

    /// Positions of what the recordings say by themselves better than a fit that is far off.
    fn read_alone(&self, problem: &Problem) -> Vec<usize> {
        let ids = self.train.drift.iter().flat_map(|(_, ids)| ids);
        positions(problem, &ids.map(String::as_str).collect::<Vec<_>>())
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
        let others: Vec<bool> = few.iter().map(|f| !f).collect();
        let mut point = taken_in(&problem, point, segments, &others, GUESS)?;
        reassign_misread_segments(&problem, &mut point, segments)?;
        point = self.improve(&problem, point, &[], (20, FINE), control)?;
        if set_clocks(&problem, &mut point, segments, &vec![true; few.len()])? {
            point = self.improve(&problem, point, &[], (10, FINE), control)?;
        }
        if reassign_misread_segments(&problem, &mut point, segments)? {
            point = self.improve(&problem, point, &[], (10, FINE), control)?;
        }
        self.finish(problem, point)
    }
}

/// Cost per value of the `few` stretches, those set aside included.
fn of_all(problem: &Problem, point: &Point, few: &[bool]) -> f64 {
    let few = point.segments.iter().zip(few).filter(|(_, f)| **f);
    let rows: usize = few.map(|(s, _)| problem.rows(s).len()).sum();
    let aside = rows.saturating_sub(point.rows);
    (point.cost + FORSAKEN * aside as f64) / rows.max(1) as f64
}
