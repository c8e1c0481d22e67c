//! Readings that seem late by more than stretches bear, where it is the drive that lags: an
//! amplifier delays by as much, and rounds the edges of the voltage off besides. Recordings that
//! were cut again for late readings have the edges in the wrong place for it.

use super::{Bench, Bound, Fitted, Found, with_effect};
use crate::diagnose::candidates::{LEAST_LAG, own_ids, shape_of};
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::model::Model;
use crate::model::effects::{ActiveEffect, find};

/// Share of what late readings cost per value up to which a drive that lags suits better.
const BETTER: f64 = 0.95;
/// Steps of the fit with readings that lag.
const STEPS: usize = 5;

impl Bench {
    /// The fit with an amplifier that lags by `late` \[s\], if that suits the recordings as they
    /// were cut at first better than late readings do: those of `cut_again`, for which `tuned` is
    /// the baseline.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a model cannot be simulated.
    pub(super) fn lagging(
        &self,
        late: f64,
        (cut_again, tuned): (&Self, &Fitted),
        control: &DiagnoseControl<'_>,
    ) -> Result<Option<Found>, DiagnoseError> {
        let Some((start, free, bounds)) = lag("amplifier_lag", late, &self.outset) else {
            return Ok(None);
        };
        let with = |start: &ActiveEffect| with_effect(&tuned.model, start.clone());
        let fitted = match self.from_afar(&with(&start), &free, &bounds, control) {
            Ok(fitted) => fitted,
            Err(DiagnoseError::Sim(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        let mut rival = tuned.whole_per_value(cut_again)?;
        let own = fitted.whole_per_value(self)?;
        if own > BETTER * rival || control.cancelled() {
            return Ok(None);
        }
        if let Some((start, free, bounds)) = lag("sensor_lag", late, &self.outset) {
            let readings = cut_again.fit(&with(&start), &free, &bounds, tuned, STEPS, control);
            rival = match readings {
                Ok(readings) => rival.min(readings.whole_per_value(cut_again)?),
                Err(DiagnoseError::Sim(_)) => rival,
                Err(error) => return Err(error),
            };
        }
        log::debug!("a drive that lags {own:.3} per value, readings that do {rival:.3}");
        Ok((own < BETTER * rival).then(|| Found {
            shape: shape_of(start.spec),
            start,
            free,
            bounds,
            fitted,
        }))
    }
}

impl Fitted {
    /// Cost per value of the fitted recordings of `bench`, all stretches counted.
    fn whole_per_value(&self, bench: &Bench) -> Result<f64, DiagnoseError> {
        let segments = &self.point.segments;
        let rows: usize = segments.iter().map(|s| self.problem.rows(s).len()).sum();
        Ok(self.whole_cost(bench.train.segments())? / rows.max(1) as f64)
    }
}

/// The effect `id` with a time constant of `late` \[s\], what is fitted of it and within which
/// bounds; `None` if `model` has it already or nothing drives it.
fn lag(id: &str, late: f64, model: &Model) -> Option<(ActiveEffect, Vec<String>, Vec<Bound>)> {
    let spec = find(id)?;
    let has = model.effects.iter().any(|e| e.spec == spec);
    if late <= 0.0 || has || model.piezo.is_none() {
        return None;
    }
    let mut effect = ActiveEffect::new(spec);
    effect.values.iter_mut().for_each(|v| *v = 0.0);
    effect.values[0] = late;
    let free = own_ids(spec, &[0]);
    let bounds = vec![(free[0].clone(), (LEAST_LAG * late, f64::INFINITY))];
    Some((effect, free, bounds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::DiagnoseOptions;
    use crate::diagnose::made::{self, QUIET};
    use crate::model::preset::Preset;

    /// What the re-tuning makes of recordings of a device with value `which` of the effect `id`.
    fn lagging(id: &str, which: usize, value: f64) -> Option<f64> {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        effect.values.iter_mut().for_each(|v| *v = 0.0);
        effect.values[which] = value;
        let paper = Preset::embedded("paper").unwrap().model;
        let concealed = with_effect(&paper, effect);
        // Slow drives agree about how late it is, edges tell why.
        let drives = [
            ("sine:20Hz:8V", 0.1),
            ("ramped:10Hz:8V:0.15", 0.1),
            ("chirp:1Hz:60Hz:7V", 0.1),
            ("square:40Hz:8V", 0.06),
        ];
        let bench = made::bench_of(&concealed, &drives, 50e3, 20e-9);
        let options = DiagnoseOptions::default();
        let tuned = bench.tuned(&paper, &options, &QUIET, &|| ()).unwrap();
        let known = tuned.bench.found?;
        known.fitted.model.get(&known.free[0])
    }

    #[test]
    fn a_drive_that_lags_by_samples_is_told_from_late_readings() {
        let tau = lagging("amplifier_lag", 0, 70e-6).unwrap();
        assert!((tau - 70e-6).abs() < 1e-6, "{tau}");
        assert_eq!(lagging("sensor_lag", 1, 70e-6), None);
    }
}
