//! Fits that begin where the force balance points to. A large effect draws a fit without it far away,
//! and whatever is linearised there is wrong; the balance needs neither.

use std::sync::Arc;

use crate::diagnose::data::robust_loss::ROBUST_LOSS;
use crate::diagnose::force_balance::{BalanceGuide, BalanceRival, guide};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, simulated};
use crate::diagnose::shooting::clock_skew::{median_skew, shift_skews, skew_indices};
use crate::diagnose::shooting::fitted::{Bound, Fitted, RequiredEffect};
use crate::diagnose::shooting::workspace::{FINE_TOLERANCE, Workspace};
use crate::diagnose::thresholds::{GUIDED_MAX_RATIO, GUIDED_MIN_CHI2, GUIDED_MIN_CHI2_RATIO};
use crate::fit::solve::point::settle;
use crate::model::Model;
use crate::model::effects::{EffectSpec, own_ids};

/// Iterations of the fit from a common clock.
const CLOCK_STEPS: usize = 4;
/// Iterations of the fit without the effect.
const PLAIN_STEPS: usize = 10;

/// What the balance of forces leads the baseline to.
pub(super) enum GuidedBaseline {
    /// The baseline, which needs none of the effects.
    Plain(Fitted),
    /// The workspace with the best of the fits with an effect as what has led the baseline astray, the
    /// others as its rivals; and the baseline without it.
    Astray(Box<Workspace>, Fitted),
    /// Nothing that comes near.
    Unknown,
}

/// Those of the effects `found`, best first, that leave about as little as the best.
fn near_the_best(found: Vec<BalanceRival>) -> impl Iterator<Item = BalanceRival> {
    let least = found.first().map_or(0.0, |best| best.left);
    let near = move |rival: &BalanceRival| rival.left < GUIDED_MAX_RATIO * least.max(1.0);
    found.into_iter().filter(near)
}

/// Whether the fit with an effect is so much better than `plain`, the one without, that the lack of it
/// leads a baseline astray.
fn is_called_for(with: &RequiredEffect, plain: &Fitted) -> bool {
    plain.per_value() >= GUIDED_MIN_CHI2_RATIO * with.fitted.per_value()
}

impl Workspace {
    /// Fits with each of the effects that `model` lacks most by the balance of forces, from what it
    /// says of everything else; best first. With the effect, the parameters of `own` are moved too.
    /// Empty where the balance sees little: what is small needs no such start.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the recordings cannot be used.
    pub(crate) fn guided_fits(
        &self,
        model: &Model,
        own: (&[String], &[Bound]),
        asked: &dyn Fn(&EffectSpec) -> bool,
        control: &DiagnoseControl<'_>,
    ) -> Result<Vec<RequiredEffect>, DiagnoseError> {
        let guide = self.balance_guide(model, asked)?;
        self.fits_of_rivals(guide.rivals, own, control)
    }

    /// What the balance of forces says of `model`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the recordings cannot be used.
    pub(super) fn balance_guide(
        &self,
        model: &Model,
        asked: &dyn Fn(&EffectSpec) -> bool,
    ) -> Result<BalanceGuide, DiagnoseError> {
        Ok(simulated(guide(self, model, asked, GUIDED_MIN_CHI2))?.unwrap_or_default())
    }

    /// Fits with each of the effects that the balance of forces calls for, best first.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the recordings cannot be used.
    fn fits_of_rivals(
        &self,
        found: Vec<BalanceRival>,
        own: (&[String], &[Bound]),
        control: &DiagnoseControl<'_>,
    ) -> Result<Vec<RequiredEffect>, DiagnoseError> {
        let mut fits = Vec::new();
        for rival in near_the_best(found) {
            self.fit_rival(rival, own, &mut fits, control)?;
        }
        Ok(fits)
    }

    /// Adds the fit with `rival` to `fits`, which stay in order, best first, if it comes near them.
    fn fit_rival(
        &self,
        rival: BalanceRival,
        own: (&[String], &[Bound]),
        fits: &mut Vec<RequiredEffect>,
        control: &DiagnoseControl<'_>,
    ) -> Result<(), DiagnoseError> {
        if control.cancelled() {
            return Ok(());
        }
        let least = fits.iter().map(|r| r.fitted.per_value());
        let least = least.fold(f64::INFINITY, f64::min);
        let fitted = self.guided_fit(rival, own, GUIDED_MAX_RATIO * least, control)?;
        fits.extend(fitted);
        fits.sort_by(|a, b| a.fitted.cost.total_cmp(&b.fitted.cost));
        Ok(())
    }

    /// The baseline from where the balance of forces points to. What the balance sees may be an effect,
    /// or no more than a place from which the plain model is found.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub(super) fn guided_baseline(
        &self,
        found: Vec<BalanceRival>,
        control: &DiagnoseControl<'_>,
    ) -> Result<GuidedBaseline, DiagnoseError> {
        let mut fits: Vec<RequiredEffect> = Vec::new();
        let mut plain: Option<(Fitted, f64)> = None;
        for rival in near_the_best(found) {
            self.fit_rival(rival, (&[], &[]), &mut fits, control)?;
            let Some(best) = fits.first() else { continue };
            // A better fit with an effect leads to another one without.
            if plain.as_ref().is_some_and(|p| p.1 <= best.fitted.cost) {
                continue;
            }
            let Some(without) = self.without_effect(best, control)? else {
                continue;
            };
            if !is_called_for(best, &without) && !without.is_lost() {
                return Ok(GuidedBaseline::Plain(without));
            }
            plain = Some((without, best.fitted.cost));
        }
        let (Some((plain, _)), false) = (plain, fits.is_empty()) else {
            return Ok(GuidedBaseline::Unknown);
        };
        if !is_called_for(&fits[0], &plain) {
            return Ok(GuidedBaseline::Unknown);
        }
        let mut workspace = self.clone();
        workspace.required_effect = Some(Arc::new(fits.remove(0)));
        workspace.rival_effects = Arc::new(fits);
        Ok(GuidedBaseline::Astray(Box::new(workspace), plain))
    }

    /// The fit from `with` on, but without its effect; `None` where it cannot be simulated.
    fn without_effect(
        &self,
        with: &RequiredEffect,
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Fitted>, DiagnoseError> {
        let mut model = with.fitted.model.clone();
        model.effects.retain(|e| e.spec != with.start.spec);
        let plain = self.fit(&model, &[], &[], &with.fitted, PLAIN_STEPS, control);
        let plain = simulated(plain)?;
        if let Some(plain) = &plain {
            let id = with.start.spec.id;
            log::debug!("without {id}: {:.3}", plain.per_value());
        }
        Ok(plain)
    }

    /// The fit with one of them, or `None` where it stays beyond `max_chi2` per value.
    fn guided_fit(
        &self,
        rival: BalanceRival,
        own: (&[String], &[Bound]),
        max_chi2: f64,
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<RequiredEffect>, DiagnoseError> {
        let (free, bounds) = (rival.form.free_ids(), rival.bounds);
        let all = |own: &[String]| [own, &free].concat();
        let within = [own.1, &bounds].concat();
        let fitted = self.fit_multistart_within(
            &rival.model,
            (&all(own.0), &within),
            (false, max_chi2),
            control,
        );
        let Some(fitted) = simulated(fitted)?.flatten() else {
            return Ok(None);
        };
        let fitted = self.with_common_clock(fitted, control)?;
        log::debug!("guided {:?}: {:.3}", rival.effect, fitted.per_value());
        Ok(Some(RequiredEffect {
            shape: own_ids(rival.form.spec, rival.form.shape),
            start: rival.effect,
            free,
            bounds,
            predicted_gain: rival.gain.0,
            fitted,
        }))
    }

    /// `fitted`, or the fit from clocks that are all the usual one, if that is better. Where a jump of
    /// the drive meets a sample, the cost has a kink at which the clock of a short recording stops.
    fn with_common_clock(
        &self,
        fitted: Fitted,
        control: &DiagnoseControl<'_>,
    ) -> Result<Fitted, DiagnoseError> {
        let (problem, point) = (&fitted.problem, &fitted.point);
        let clocks = skew_indices(problem);
        if clocks.len() < 2 || control.cancelled() {
            return Ok(fitted);
        }
        let usual = median_skew(problem, point);
        let mut x = point.x.clone();
        clocks.iter().for_each(|i| x[*i] = 0.0);
        shift_skews(problem, &mut x, usual);
        let start = settle(problem, &x, &point.segments, &point.used, ROBUST_LOSS, 2)?;
        let steps = (CLOCK_STEPS, FINE_TOLERANCE);
        let point = self.improve(problem, start, &[], steps, control)?;
        let other = self.finish(problem.clone(), point)?;
        log::debug!("from one clock {:.1}, {:.1}", other.cost, fitted.cost);
        Ok(if other.cost < fitted.cost {
            other
        } else {
            fitted
        })
    }
}

#[cfg(test)]
mod tests {
    use super::GuidedBaseline;
    use crate::diagnose::test_support::{QUIET, workspace_of};
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;
    use crate::model::with_effect;

    const DRIVES: [(&str, f64); 4] = [
        ("square:15Hz:8V", 0.12),
        ("sine:30Hz:7V", 0.1),
        ("ramped:12Hz:8V:0.25", 0.1),
        ("triangle:40Hz:6V", 0.1),
    ];

    #[test]
    fn a_large_effect_is_fitted_from_where_the_balance_points_to() {
        let paper = Preset::embedded("paper").unwrap().model;
        let any = |_: &_| true;
        let sound = workspace_of(&paper, &DRIVES, 25e3, 20e-9);
        let found = sound.guided_fits(&paper, (&[], &[]), &any, &QUIET).unwrap();
        assert!(found.is_empty(), "{:?}", found[0].start);
        let effect = ActiveEffect {
            spec: find("cubic_stiffness").unwrap(),
            values: vec![6e3, 0.0, 0.0],
        };
        let stiff = with_effect(&paper, effect);
        let workspace = workspace_of(&stiff, &DRIVES, 25e3, 20e-9);
        let fits = workspace.guided_fits(&paper, (&[], &[]), &any, &QUIET);
        let fits = fits.unwrap();
        assert_eq!(fits[0].start.spec.id, "cubic_stiffness");
        assert!(
            fits[0].fitted.per_value() < 1.05,
            "{}",
            fits[0].fitted.per_value()
        );
        let guide = workspace.balance_guide(&paper, &any).unwrap();
        let found = workspace.guided_baseline(guide.rivals, &QUIET).unwrap();
        let GuidedBaseline::Astray(astray, plain) = found else {
            panic!("the stiffness is called for");
        };
        assert!(plain.is_lost(), "{}", plain.per_value());
        assert_eq!(
            astray.cold_fits().next().unwrap().start.spec.id,
            "cubic_stiffness"
        );
    }
}
