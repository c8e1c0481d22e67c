//! The baseline re-tuned to the fitted recordings from a cold start: several starts on a subset of
//! the segments, the best of them on all.

use super::fit_steps::{Start, chi2_per_value, subset_chi2};
use crate::diagnose::data::level_drift;
use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::fitted::{Bound, Fitted, RequiredEffect};
use crate::diagnose::shooting::warm_start::subset_mask;
use crate::diagnose::shooting::workspace::{ROUGH_TOLERANCE, Workspace, positions};
use crate::diagnose::thresholds::{
    ASTRAY_SET_ASIDE_SHARE, ASTRAY_START_CHI2, FILM_MAX_CHI2_RATIO, FILM_RETRY_MAX_CHI2,
    FILM_RETRY_MIN_CHI2, RIVAL_START_MAX_RATIO, SUBSET_MISLED_RATIO,
};
use crate::fit::solve::point::{Point, settle};
use crate::model::parameter::ParameterId;
use crate::model::{Model, with_effect};
use crate::recording::quantile_in_place;

/// Film thicknesses that are tried where chi2 stays high, as shares of `dp`.
const RETRY_FILM_SHARES: [f64; 3] = [0.25, 0.6, 0.08];

/// Iterations after a fitted drift was removed.
const NO_DRIFT_STEPS: usize = 10;
/// Initial thickness of the film at contact, as a share of `dp`.
const INITIAL_FILM_SHARE: f64 = 0.2;

/// Shapes of the second mode, whose signs say how the drive is shared among the modes.
const FLIPPED_SHAPES: [ParameterId; 2] = [ParameterId::ShapeC2, ParameterId::ShapeP2];

/// A fit to all segments, reached from a start on the subset.
struct Attempt {
    /// Where the fit to the subset stood before its last steps.
    before: Point,
    /// Chi2 per value on the subset.
    rough: f64,
    fitted: Fitted,
}

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

    /// The baseline re-tuned to the fitted recordings from `model`, and the fit with a drift
    /// if the level of the ground shows one. Such a drift would lead the film to be too thin
    /// and the fit to be slow, so the baseline starts from the fit with it.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn with_and_without_drift(
        &self,
        model: &Model,
        control: &DiagnoseControl<'_>,
    ) -> Result<(Fitted, Option<RequiredEffect>), DiagnoseError> {
        // A drift that the model has already is part of the baseline.
        let Some((drift, free)) = self.unmodelled_drift(model) else {
            return Ok((self.fit_cold_start(model, &[], &[], control)?, None));
        };
        let with = self.fit_cold_start(&with_effect(model, drift.clone()), free, &[], control)?;
        let mut start = with.model.clone();
        start.effects.retain(|e| e.spec != drift.spec);
        let fitted = self.fit(&start, &[], &[], &with, NO_DRIFT_STEPS, control)?;
        let found = RequiredEffect {
            start: drift.clone(),
            free: free.clone(),
            bounds: Vec::new(),
            shape: level_drift::shape_parameters(drift.spec, free),
            predicted_gain: 0.0,
            fitted: with,
        };
        Ok((fitted, Some(found)))
    }

    /// The same with the parameters of `free` moved too, from their values in `model` and
    /// within `bounds`: an effect so strong that no model without it comes near is fitted
    /// together with everything else from a cold start.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub fn fit_cold_start(
        &self,
        model: &Model,
        free: &[String],
        bounds: &[Bound],
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        self.fit_multistart(
            model,
            (free, bounds),
            self.drive_share_is_free(free),
            control,
        )
    }

    /// Whether a fit of the additional parameters `free` also tries how the drive is shared
    /// among the modes. With an effect, that is known from the model without it.
    pub(crate) fn drive_share_is_free(&self, free: &[String]) -> bool {
        free.is_empty() || self.train.drift.is_some()
    }

    /// The baseline re-tuned from `known`, a fit of `model` to the same recordings cut
    /// otherwise, and the fit with a drift if the level shows one.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn retune_from(
        &self,
        model: &Model,
        known: &Fitted,
        control: &DiagnoseControl<'_>,
    ) -> Result<(Fitted, Option<RequiredEffect>), DiagnoseError> {
        if self.unmodelled_drift(model).is_some() {
            return self.with_and_without_drift(model, control);
        }
        Ok((
            self.fit_multistart(&known.model, (&[], &[]), false, control)?,
            None,
        ))
    }

    /// A fit from a cold start. With `drive_share_is_free` it also tries how the drive is
    /// shared among the modes.
    pub(crate) fn fit_multistart(
        &self,
        model: &Model,
        own: (&[String], &[Bound]),
        drive_share_is_free: bool,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let fitted =
            self.fit_multistart_within(model, own, (drive_share_is_free, f64::INFINITY), control)?;
        Ok(fitted.expect("no cost is beyond infinity"))
    }

    /// Like [`Self::fit_multistart`], or `None` where the subset of segments that the search
    /// begins with stays above `max_chi2` per value, each row set aside counted as
    /// [`MISREAD_CHI2`](crate::diagnose::data::robust_loss::MISREAD_CHI2).
    ///
    /// # Errors
    /// [`DiagnoseError`] if the model cannot be simulated.
    pub(crate) fn fit_multistart_within(
        &self,
        model: &Model,
        own: (&[String], &[Bound]),
        (drive_share_is_free, max_chi2): (bool, f64),
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Fitted>, DiagnoseError> {
        // A subset of the segments is enough to come near, and three times as fast.
        let subset = subset_mask(&self.train.event_free.prepared.segments);
        let starts = self.first_starts(model, own, drive_share_is_free, &subset, control)?;
        let ((problem, before), rival) = self.release_starts(starts, &subset, control)?;
        let point = self.improve(
            &problem,
            before.clone(),
            &[],
            (10, ROUGH_TOLERANCE),
            control,
        )?;
        let reached = subset_chi2(&problem, &point, &subset);
        if reached > max_chi2 {
            log::debug!("{reached:.2} per value of a part, {max_chi2:.2} at most");
            return Ok(None);
        }
        let rough = chi2_per_value(&point);
        let mut best = Attempt {
            before,
            rough,
            fitted: self.fit_all_segments(problem, point, &subset, control)?,
        };
        // Both starts may describe the subset equally well where all segments rule one out.
        if let Some(rival) = rival.filter(|_| {
            best.fitted.per_value() > SUBSET_MISLED_RATIO * rough.max(1.0) && !control.cancelled()
        }) {
            let other = self.complete_rival(rival, &subset, control)?;
            let all = vec![true; subset.len()];
            let cost = |f: &Fitted| subset_chi2(&f.problem, &f.point, &all);
            log::debug!(
                "shared otherwise: {:.1}, {:.1}",
                cost(&other.fitted),
                cost(&best.fitted)
            );
            if cost(&other.fitted) < cost(&best.fitted) {
                best = other;
            }
        }
        self.retry_films(best, &subset, control).map(Some)
    }

    /// The model that the search starts from: the ground at the level that the recordings show,
    /// the film of its usual thickness.
    fn start_model(&self, model: &Model) -> Model {
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
            let moves = |id: ParameterId| self.free.iter().any(|free| free == id.spec().id);
            if level.is_finite() && level < 0.0 && moves(ParameterId::Dp) {
                p.set(ParameterId::Dp, -level);
            }
            if moves(ParameterId::Gp) {
                p.set(
                    ParameterId::Gp,
                    (1.0 + INITIAL_FILM_SHARE) * p[ParameterId::Dp],
                );
            }
        }
        start
    }

    /// The first step from the start model and, where that stays far off, from one whose drive is
    /// shared the other way round among the modes: the better one first.
    fn first_starts(
        &self,
        model: &Model,
        own: (&[String], &[Bound]),
        drive_share_is_free: bool,
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<(Start, Option<Start>), DiagnoseError> {
        let mut start = self.start_model(model);
        let first = self.first_step(&start, own, subset, control)?;
        let asked = drive_share_is_free
            && chi2_per_value(&first.1) > ASTRAY_START_CHI2
            && model.uses(ParameterId::ShapeP2)
            && model.piezo.is_some()
            && FLIPPED_SHAPES
                .iter()
                .all(|id| self.choices.may_change(id.spec().id));
        if !asked || control.cancelled() {
            return Ok((first, None));
        }
        // A film that bends the beam by moments drives the second mode in the direction opposite
        // to that of a force at its centre.
        let p = &mut start.parameters;
        for id in FLIPPED_SHAPES {
            p.set(id, -p[id]);
        }
        let flipped = self.first_step(&start, own, subset, control)?;
        if chi2_per_value(&flipped.1) < chi2_per_value(&first.1) {
            Ok((flipped, Some(first)))
        } else {
            Ok((first, Some(flipped)))
        }
    }

    /// Releases the other parameters from the first start, and from its rival if the first may
    /// have gone astray; the better one first.
    fn release_starts(
        &self,
        ((problem, point), other): (Start, Option<Start>),
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<(Start, Option<Start>), DiagnoseError> {
        let first = chi2_per_value(&point);
        let point = self.release_parameters(&problem, point, subset, control)?;
        // The start that is nearer at first may lead astray. It then sets aside the segments that
        // it cannot describe.
        let aside = subset.iter().zip(&point.used).filter(|(f, u)| **f && !**u);
        let all = subset.iter().filter(|f| **f).count();
        let astray = chi2_per_value(&point) > ASTRAY_START_CHI2
            || aside.count() as f64 > ASTRAY_SET_ASIDE_SHARE * all as f64;
        // From the proof mass alone the first step hardly distinguishes the two.
        let data = &problem.data;
        let lone = data.iter().all(|d| d.recording.cantilever.is_none());
        let near = |other: &Start| lone || chi2_per_value(&other.1) < RIVAL_START_MAX_RATIO * first;
        let Some((flipped, begun)) =
            other.filter(|other| astray && near(other) && !control.cancelled())
        else {
            return Ok(((problem, point), None));
        };
        let released = self.release_parameters(&flipped, begun, subset, control)?;
        if subset_chi2(&flipped, &released, subset) < subset_chi2(&problem, &point, subset) {
            Ok(((flipped, released), Some((problem, point))))
        } else {
            Ok(((problem, point), Some((flipped, released))))
        }
    }

    /// Goes on with all segments from the rival start.
    fn complete_rival(
        &self,
        (problem, before): Start,
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Attempt, DiagnoseError> {
        let point = self.improve(
            &problem,
            before.clone(),
            &[],
            (10, ROUGH_TOLERANCE),
            control,
        )?;
        let rough = chi2_per_value(&point);
        let fitted = self.fit_all_segments(problem, point, subset, control)?;
        Ok(Attempt {
            before,
            rough,
            fitted,
        })
    }

    /// Tries other film thicknesses where chi2 stays high: strength and thickness of the film
    /// trade against each other along a valley that may lead astray.
    fn retry_films(
        &self,
        best: Attempt,
        subset: &[bool],
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let Attempt {
            before,
            rough,
            fitted: mut best,
        } = best;
        let thickness = best.problem.space.position("gp");
        for share in RETRY_FILM_SHARES {
            let chi2 = best.per_value();
            let Some(at) = thickness.filter(|_| {
                (FILM_RETRY_MIN_CHI2..FILM_RETRY_MAX_CHI2).contains(&chi2) && !control.cancelled()
            }) else {
                break;
            };
            let problem = best.problem.clone();
            let entry = &problem.space.entries[at];
            let mut x = before.x.clone();
            let gap = share * best.model.parameters[ParameterId::Dp];
            x[at] = gap.ln().clamp(entry.low, entry.high);
            let mut point = settle(&problem, &x, &before.segments, &before.used, ROBUST_LOSS, 2)?;
            let locked = positions(&problem, &["gp"]);
            point = self.improve(&problem, point, &locked, (5, ROUGH_TOLERANCE), control)?;
            point = self.improve(&problem, point, &[], (10, ROUGH_TOLERANCE), control)?;
            // All segments are fitted only where the subset improves.
            if chi2_per_value(&point) > FILM_MAX_CHI2_RATIO * rough {
                break;
            }
            let other = self.fit_all_segments(problem, point, subset, control)?;
            let better = other.per_value() < FILM_MAX_CHI2_RATIO * best.per_value();
            if other.per_value() < best.per_value() {
                best = other;
            }
            // Where the film is not the cause, no other thickness will do better.
            if !better {
                break;
            }
        }
        Ok(best)
    }
}
