//! Readings that seem late by more than segments tolerate although something lags. An amplifier
//! delays as much and rounds the edges of the voltage; a sensor rounds the motion that it reads.
//! Recordings cut again for late readings have the edges in the wrong place, and segments that
//! cannot be described so are set aside.

use std::sync::Arc;

use crate::diagnose::data::reading_assumptions::ReadingAssumptions;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions, simulated};
use crate::diagnose::score_test::forms::{MIN_LAG_SHARE, pace_parameters};
use crate::diagnose::score_test::reading_scales::has_own_scales;
use crate::diagnose::shooting::fitted::{Bound, Fitted, RequiredEffect};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    LAG_MAX_CHI2_RATIO, LAG_SUBSET_MAX_RATIO, SENSOR_LAG_ASKED_CHI2,
};
use crate::fit::inspect::recording_summary::lag_of;
use crate::model::effects::{ActiveEffect, CATALOGUE, EdgeLag, EffectSpec, LagKind, own_ids};
use crate::model::{Model, with_effect};
use crate::recording::extremes;

/// Iterations of the fit with lagging readings.
const FIT_STEPS: usize = 5;

impl Workspace {
    /// Where the data show a lag of the readings \[s\]: the recordings cut for it, with the
    /// fit that includes the lag, the fit of the baseline to them, and the lag. `again` makes
    /// recordings ready under other assumptions. `None` without a lag, or where it alone does
    /// not come near.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub(crate) fn sensor_lag_baseline(
        &self,
        model: &Model,
        options: &DiagnoseOptions,
        control: &DiagnoseControl<'_>,
        again: &dyn Fn(&Self, &ReadingAssumptions) -> Result<Self, DiagnoseError>,
    ) -> Result<Option<(Self, Fitted, f64)>, DiagnoseError> {
        let lag_in_data = || lag_of(&self.train.parts, &self.train.findings);
        let asked = |(spec, _): &Lag| model.has_ground && options.asks(spec.id);
        let with_size = |sensor: Lag| Some((sensor, lag_in_data()?));
        let Some((sensor, tau)) = sensor_lag().filter(asked).and_then(with_size) else {
            return Ok(None);
        };
        let Some((start, free, bounds)) = lag_start(sensor, tau, model) else {
            return Ok(None);
        };
        let known = ReadingAssumptions {
            lag: tau,
            own_scales: has_own_scales(&self.train.event_free.prepared.problem),
            ..ReadingAssumptions::default()
        };
        let Ok(mut sharp) = again(self, &known) else {
            return Ok(None);
        };
        let with = with_effect(model, start.clone());
        let Some(fitted) = simulated(sharp.fit_multistart(&with, (&free, &bounds), true, control))?
        else {
            return Ok(None);
        };
        log::debug!(
            "readings lag by {:.1} us: {:.2}",
            1e6 * tau,
            fitted.per_value()
        );
        if fitted.is_lost() {
            return Ok(None);
        }
        let mut plain = fitted.model.clone();
        plain.effects.retain(|e| e.spec != start.spec);
        let plain = sharp.fit(&plain, &[], &[], &fitted, FIT_STEPS, control);
        let Some(train) = simulated(plain)? else {
            return Ok(None);
        };
        // A slow enough mass moves as if read through a lag.
        let rival = train.chi2_with_set_aside(&sharp)?;
        if fitted.chi2_with_set_aside(&sharp)? > LAG_MAX_CHI2_RATIO * rival {
            return Ok(None);
        }
        sharp.required_effect = Some(Arc::new(RequiredEffect {
            shape: other_lag_parameters(start.spec, &free),
            start,
            free,
            bounds,
            predicted_gain: 0.0,
            fitted,
        }));
        Ok(Some((sharp, train, tau)))
    }

    /// The fit with a lag of the amplifier or the sensor of about `late` \[s\], if it
    /// describes the recordings as first cut better than late readings do: those of
    /// `cut_again`, with the baseline `tuned`.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub(crate) fn best_lag(
        &self,
        late: f64,
        (cut_again, tuned): (&Self, &Fitted),
        options: &DiagnoseOptions,
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<RequiredEffect>, DiagnoseError> {
        let mut best: Option<(f64, RequiredEffect)> = None;
        let mut rival = tuned.chi2_with_set_aside(cut_again)?;
        // A sensor's lag is found from a warm start, unless the segments with edges were
        // set aside.
        let asked = lags()
            .filter(|(_, lag)| rival > SENSOR_LAG_ASKED_CHI2 || lag.kind != LagKind::Readings);
        for which in asked.filter(|(spec, _)| options.asks(spec.id)) {
            if control.cancelled() {
                break;
            }
            // The middle of an edge is late by half its duration.
            let size = if which.1.kind == LagKind::DriveSlews {
                2.0 * late / self.voltage_range()
            } else {
                late
            };
            let Some((start, free, bounds)) = lag_start(which, size, &self.initial_model) else {
                continue;
            };
            let with = with_effect(&tuned.model, start.clone());
            // A rule of thumb, because a fit to all segments takes three times as
            // long: rows set aside count more here, and other film thicknesses are not
            // tried.
            let least = best.as_ref().map_or(rival, |best| best.0.min(rival));
            let asked = (
                self.drive_share_is_free(&free),
                LAG_SUBSET_MAX_RATIO * least,
            );
            let fitted = self.fit_multistart_within(&with, (&free, &bounds), asked, control);
            let Some(fitted) = simulated(fitted)?.flatten() else {
                continue;
            };
            let own = fitted.chi2_with_set_aside(self)?;
            log::debug!("{}: {own:.3} per value", free[0]);
            if best.as_ref().is_none_or(|best| own < best.0) {
                let found = RequiredEffect {
                    shape: other_lag_parameters(start.spec, &free),
                    start,
                    free,
                    bounds,
                    predicted_gain: 0.0,
                    fitted,
                };
                best = Some((own, found));
            }
        }
        let Some((own, found)) = best.filter(|best| best.0 < LAG_MAX_CHI2_RATIO * rival) else {
            return Ok(None);
        };
        if control.cancelled() {
            return Ok(None);
        }
        let sensor = sensor_lag();
        let sensor = sensor.and_then(|sensor| lag_start(sensor, late, &self.initial_model));
        if let Some((start, free, bounds)) = sensor {
            let with = with_effect(&tuned.model, start);
            let near = cut_again.fit(&with, &free, &bounds, tuned, FIT_STEPS, control);
            if let Some(near) = simulated(near)? {
                rival = rival.min(near.chi2_with_set_aside(cut_again)?);
            }
        }
        log::debug!("{own:.3} per value, cut again {rival:.3}");
        Ok((own < LAG_MAX_CHI2_RATIO * rival).then_some(found))
    }

    /// Range of the voltage in the fitted recordings \[V\].
    fn voltage_range(&self) -> f64 {
        let parts = self.train.parts.iter();
        let all = parts.filter_map(|p| p.recording.voltage.as_deref());
        let ends = all.map(extremes);
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| {
            (a.0.min(b.0), a.1.max(b.1))
        });
        (high - low).max(f64::MIN_POSITIVE)
    }
}

impl Fitted {
    /// Chi2 per value of the fitted recordings of `workspace`, segments set aside included.
    fn chi2_with_set_aside(&self, workspace: &Workspace) -> Result<f64, DiagnoseError> {
        let segments = &self.point.segments;
        let rows: usize = segments.iter().map(|s| self.problem.rows(s).len()).sum();
        Ok(self.cost_with_set_aside(workspace.train.segments())? / rows.max(1) as f64)
    }
}

/// Parameters that shape a lag, besides those in `free`.
fn other_lag_parameters(spec: &'static EffectSpec, free: &[String]) -> Vec<String> {
    let first = own_ids(spec, &[0]);
    let mut all: Vec<String> = first.into_iter().chain(pace_parameters(spec)).collect();
    all.retain(|id| !free.contains(id));
    all
}

/// An effect, and a parameter of it by which edges appear late.
type Lag = (&'static EffectSpec, EdgeLag);

/// All parameters that make readings late by rounding edges, with their effects.
fn lags() -> impl Iterator<Item = Lag> {
    CATALOGUE.iter().flat_map(|spec| {
        let own = spec.facts.edge_lags.iter();
        own.map(|lag| (*spec, *lag))
    })
}

/// The lag of the sensor.
fn sensor_lag() -> Option<Lag> {
    lags().find(|(_, lag)| lag.kind == LagKind::Readings)
}

/// An effect of [`lags`] of that size, its fitted parameter and its bounds; `None` if `model` has
/// it already or nothing drives it.
fn lag_start(
    (spec, lag): Lag,
    late: f64,
    model: &Model,
) -> Option<(ActiveEffect, Vec<String>, Vec<Bound>)> {
    let which = lag.parameter;
    let has = model.effects.iter().any(|e| e.spec == spec);
    let has_size = late > 0.0 && late.is_finite();
    if !has_size || has || model.piezo.is_none() {
        return None;
    }
    let mut effect = ActiveEffect::new(spec);
    effect.values.iter_mut().for_each(|v| *v = 0.0);
    effect.values[which] = late;
    let free = own_ids(spec, &[which]);
    let bounds = vec![(free[0].clone(), (MIN_LAG_SHARE * late, f64::INFINITY))];
    Some((effect, free, bounds))
}

#[cfg(test)]
mod tests {
    use super::super::lag_rivals::*;
    use crate::diagnose::data::reading_assumptions::ContactAmbiguity;
    use crate::diagnose::test_support;
    use crate::diagnose::test_support::QUIET;
    use crate::model::effects::find;
    use crate::model::preset::Preset;

    /// The paper's device with value `which` of the effect `id`.
    fn with(id: &str, which: usize, value: f64) -> Model {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        effect.values.iter_mut().for_each(|v| *v = 0.0);
        effect.values[which] = value;
        with_effect(&Preset::embedded("paper").unwrap().model, effect)
    }

    /// The lag that the re-tuning finds in recordings.
    fn found(workspace: Workspace) -> Option<f64> {
        let paper = Preset::embedded("paper").unwrap().model;
        let options = DiagnoseOptions::default();
        let tuned = workspace
            .retune_baseline(
                &paper,
                (&options, &ContactAmbiguity::AsFitted),
                &QUIET,
                &|| (),
            )
            .unwrap();
        let known = tuned.workspace.required_effect?;
        known.fitted.model.get(&known.free[0])
    }

    /// The same of a device with value `which` of the effect `id`.
    fn lagging(id: &str, which: usize, value: f64) -> Option<f64> {
        // Slow drives determine the latency, edges its cause.
        let drives = [
            ("sine:20Hz:8V", 0.1),
            ("ramped:10Hz:8V:0.15", 0.1),
            ("chirp:1Hz:60Hz:7V", 0.1),
            ("square:40Hz:8V", 0.06),
        ];
        found(test_support::workspace_of(
            &with(id, which, value),
            &drives,
            50e3,
            20e-9,
        ))
    }

    #[test]
    fn a_lag_of_the_drive_by_samples_is_distinguished_from_late_readings() {
        let tau = lagging("amplifier_lag", 0, 70e-6).unwrap();
        assert!((tau - 70e-6).abs() < 1e-6, "{tau}");
        assert_eq!(lagging("sensor_lag", 1, 70e-6), None);
    }

    #[test]
    fn a_lag_of_the_readings_by_samples_is_found() {
        let tau = lagging("sensor_lag", 0, 50e-6).unwrap();
        assert!((tau - 50e-6).abs() < 0.5e-6, "{tau}");
    }

    #[test]
    fn clocks_that_disagree_reveal_a_slew_rate_limit() {
        const INVERSE_SLEW_RATE: f64 = 6.5e-6;
        let drives = [
            ("ramped:5Hz:8V:0.25", 0.2),
            ("square:15Hz:8V", 0.2),
            ("sine:50Hz:8V", 0.06),
            ("square:50Hz:6V", 0.12),
        ];
        let mut parts = test_support::parts_of(
            &with("amplifier_lag", 1, INVERSE_SLEW_RATE),
            &drives,
            50e3,
            20e-9,
        );
        for part in &mut parts {
            Arc::make_mut(&mut part.recording).cantilever = None;
        }
        let pace = found(test_support::workspace(&parts)).unwrap();
        assert!((pace / INVERSE_SLEW_RATE - 1.0).abs() < 0.02, "{pace}");
    }
}
