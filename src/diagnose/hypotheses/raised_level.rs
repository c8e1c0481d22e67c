//! Recordings whose ground, as read, lies higher than that of the others: the mass may have come
//! to rest above it without touching it. Each recording has a zero of its own, which absorbs a
//! wrong level, so that only the flights before and after reveal it.

use super::lag_twins::twin;
use super::level_step::{find_level_steps, level_gain, raised_ground};
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::score_test::linearized::Linearized;
use crate::diagnose::score_test::scan::ScoreScan;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{LEVEL_MIN_STAYS, RAISED_LEVEL_MIN_GAIN};
use crate::sim::SimError;

/// Fitted and held-out recordings of `state` that may hover; none where the ground steps already,
/// or where a lag of sensor or drive puts everything far off.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn raised_recordings(
    workspace: &Workspace,
    state: &ModelState,
) -> Result<(Vec<usize>, Vec<usize>), SimError> {
    let step = raised_ground().spec;
    let steps = state.train.model.effects.iter().any(|e| e.spec == step);
    let known = workspace.required_effect.as_ref();
    if steps || known.is_some_and(|known| twin(known.start.spec.id).is_some()) {
        return Ok((Vec::new(), Vec::new()));
    }
    let train = workspace.may_hover(&workspace.train, raised_in_fit(&state.train, 0)?);
    let held_out = match (&workspace.held_out, &state.held_out) {
        (Some(side), Some(fitted)) => {
            let locked = fitted.problem.space.len();
            workspace.may_hover(side, raised_in_fit(fitted, locked)?)
        }
        _ => Vec::new(),
    };
    Ok((train, held_out))
}

/// Recordings with a raised ground in a fit, its first `locked` unknowns fixed.
fn raised_in_fit(fitted: &Fitted, locked: usize) -> Result<Vec<usize>, SimError> {
    let segments = &fitted.point.segments;
    let stays = |k: usize| {
        let own = segments.iter().zip(&fitted.point.used);
        own.filter(|(s, used)| **used && s.starts_held && s.recording == k)
            .count()
    };
    let mut asked: Vec<usize> = (0..fitted.problem.data.len()).collect();
    asked.retain(|k| stays(*k) >= LEVEL_MIN_STAYS);
    if asked.is_empty() {
        return Ok(asked);
    }
    let linear = Linearized::new(fitted)?;
    let products = linear.segment_grams(&fitted.model, &[raised_ground()])?;
    let Some(base) = ScoreScan::assemble(&linear, &products, 1).projector_with_locked(locked)
    else {
        return Ok(Vec::new());
    };
    let gain = |k: usize| {
        let score = level_gain(&linear, &base, &products, k).filter(|p| p.theta > 0.0);
        score.map_or(0.0, |p| p.gain)
    };
    let mut higher: Vec<(usize, f64)> = asked.into_iter().map(|k| (k, gain(k))).collect();
    higher.retain(|(_, gain)| *gain > RAISED_LEVEL_MIN_GAIN);
    if higher.is_empty() {
        return Ok(Vec::new());
    }
    let steps = find_level_steps(&linear, &fitted.model, locked, &[])?;
    let step = steps.iter().fold(0.0f64, |most, s| most.max(s.gain));
    higher.retain(|(_, gain)| *gain > step - RAISED_LEVEL_MIN_GAIN);
    Ok(higher.into_iter().map(|(k, _)| k).collect())
}

#[cfg(test)]
mod tests {
    use super::super::raised_level::*;
    use crate::diagnose::test_support::{QUIET, parts_of, stepping, workspace};

    /// Which of three recordings lie higher where the ground of the second and the third is as
    /// given: by how much, and since when.
    fn higher(second: (f64, f64), third: (f64, f64)) -> Vec<usize> {
        let on = |(by, since): (f64, f64), drive: &str, duration: f64| {
            let drives = [(drive, duration)];
            parts_of(&stepping(by, since), &drives, 25e3, 150e-9)
        };
        let plain = (0.0, -1e9);
        let parts = [
            on(plain, "square:40Hz:8V", 0.1),
            on(second, "square:15Hz:8V", 0.3),
            on(third, "sine:50Hz:8V", 0.1),
        ];
        let fit = workspace(&parts.concat()).baseline(&stepping(plain.0, plain.1), &QUIET);
        raised_in_fit(&fit.unwrap(), 0).unwrap()
    }

    #[test]
    fn a_recording_with_raised_ground_is_found() {
        const BEFORE_RECORDING: f64 = -1e9;
        let by = 0.25e-6;
        assert!(higher((0.0, BEFORE_RECORDING), (0.0, BEFORE_RECORDING)).is_empty());
        assert_eq!(higher((0.0, BEFORE_RECORDING), (by, BEFORE_RECORDING)), [2]);
        // Raised in a part of one recording only: a step.
        assert!(higher((by, 0.15), (0.0, BEFORE_RECORDING)).is_empty());
    }
}
