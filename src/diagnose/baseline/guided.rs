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
    pub(super) fn fits_of_rivals(
        &self,
        found: Vec<BalanceRival>,
        own: (&[String], &[Bound]),
        control: &DiagnoseControl<'_>,
    ) -> Result<Vec<RequiredEffect>, DiagnoseError> {
        let mut out: Vec<RequiredEffect> = Vec::new();
        let least = found.first().map_or(0.0, |best| best.left);
        let near = |rival: &BalanceRival| rival.left < GUIDED_MAX_RATIO * least.max(1.0);
        for rival in found.into_iter().filter(near) {
            if control.cancelled() {
                break;
            }
            let least = out.iter().map(|r| r.fitted.per_value());
            let least = least.fold(f64::INFINITY, f64::min);
            let fitted = self.guided_fit(rival, own, GUIDED_MAX_RATIO * least, control)?;
            out.extend(fitted);
        }
        out.sort_by(|a, b| a.fitted.cost.total_cmp(&b.fitted.cost));
        Ok(out)
    }

    /// The workspace with the best of the `guided` fits as what has led the baseline astray, the others
    /// as its rivals, and the baseline without it; `None` where the baseline does as well.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub(super) fn led_astray(
        &self,
        guided: Vec<RequiredEffect>,
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<(Self, Fitted)>, DiagnoseError> {
        let mut guided = guided.into_iter();
        let Some(best) = guided.next() else {
            return Ok(None);
        };
        let mut plain = best.fitted.model.clone();
        plain.effects.retain(|e| e.spec != best.start.spec);
        let plain = self.fit(&plain, &[], &[], &best.fitted, PLAIN_STEPS, control);
        let Some(plain) = simulated(plain)? else {
            return Ok(None);
        };
        let ratio = plain.per_value() / best.fitted.per_value();
        log::debug!("without {}: {:.3}", best.start.spec.id, plain.per_value());
        if ratio < GUIDED_MIN_CHI2_RATIO {
            return Ok(None);
        }
        let mut workspace = self.clone();
        workspace.required_effect = Some(Arc::new(best));
        workspace.rival_effects = Arc::new(guided.collect());
        Ok(Some((workspace, plain)))
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
        let (astray, plain) = workspace.led_astray(fits, &QUIET).unwrap().unwrap();
        assert!(plain.is_lost(), "{}", plain.per_value());
        assert_eq!(
            astray.cold_fits().next().unwrap().start.spec.id,
            "cubic_stiffness"
        );
    }
}
