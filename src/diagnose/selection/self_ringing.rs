//! Modes that nothing excites: what rings by itself starts anew in each segment, and passes for a
//! mode with free initial states.

use super::refit::parameters_with;
use crate::diagnose::comparison::trial::{CandidateFit, CandidateScore, ModelState};
use crate::diagnose::data::side::Split;
use crate::diagnose::discrepancy::impact_ring::ImpactExcitations;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, simulated};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    EXCITED_MODE_MIN_SHARE, EXCITED_RING_MIN_GAINS, EXCITED_RING_MIN_SHARE, HELD_GAIN,
    STEADY_VIBRATION_SHARE, TRAIN_GAIN,
};
use crate::model::effects::ActiveEffect;
use crate::sim::SimError;

/// Factor on the shapes of a mode that is not excited; the excitation scales with its square.
const UNDRIVEN_FACTOR: f64 = 1e-3;

/// Relative tolerance of that frequency.
const FREQUENCY_TOLERANCE: f64 = 0.03;

/// Iterations of the fit with such a mode.
const UNDRIVEN_FIT_STEPS: usize = 8;

/// Frequency of a further mode that nothing excites \[Hz\], if `trial`, a fit with one more effect
/// than `state`, is of one. Drive and impacts excite the modes of a device. What rings by itself
/// starts anew in each segment, and passes for a mode with free initial states. From the proof
/// mass alone this is hardly distinguishable, and not tested.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn is_self_excited(
    workspace: &Workspace,
    state: &ModelState,
    trial: &CandidateFit,
    control: &DiagnoseControl<'_>,
) -> Result<Option<f64>, DiagnoseError> {
    let fitted = &trial.train;
    let data = &fitted.problem.data;
    let alone = data.iter().any(|d| d.recording.cantilever.is_none());
    if alone || !trial.hypothesis.start.spec.adds_modes() || control.cancelled() {
        return Ok(None);
    }
    let mode = |e: &ActiveEffect| Some(e.values[e.spec.facts.modes?.frequency]);
    let Some(frequency) = fitted.model.effects.iter().find_map(mode) else {
        return Ok(None);
    };
    if is_driven(workspace, state, trial, frequency)? {
        return Ok(None);
    }
    let mut still = fitted.model.clone();
    let mut shapes = Vec::new();
    for effect in &mut still.effects {
        let Some(layout) = effect.spec.facts.modes else {
            continue;
        };
        let all = effect.spec.parameters.iter().zip(&mut effect.values);
        for (i, (parameter, value)) in all.enumerate() {
            if i % layout.per_mode >= layout.first_shape {
                *value *= UNDRIVEN_FACTOR;
                shapes.push(format!("{}.{}", effect.spec.id, parameter.id));
            }
        }
    }
    let (mut free, bounds) = parameters_with(state, &trial.hypothesis);
    free.retain(|id| !shapes.contains(id));
    let sketch = workspace.fit_subset(&still, &free, &bounds, fitted, control);
    // What rings by itself continues unchanged; where it does not, a fit to all segments is
    // pointless.
    if let Ok(sketch) = &sketch
        && sketch.is_lost_compared_to(fitted)
    {
        return Ok(None);
    }
    let unmoved =
        sketch.and_then(|sketch| workspace.fit_all_from(sketch, UNDRIVEN_FIT_STEPS, control));
    // A failed simulation is no evidence against the mode.
    let Some(unmoved) = simulated(unmoved)? else {
        return Ok(None);
    };
    let by_motion = unmoved.cost - fitted.cost;
    log::debug!("that the modes are moved brings {by_motion:.1}");
    let least = TRAIN_GAIN.max(EXCITED_MODE_MIN_SHARE * trial.gain);
    Ok((by_motion < least).then_some(frequency))
}

/// The vibration of the base among `scores`, if it is significant.
pub fn significant_vibration(scores: &[CandidateScore]) -> Option<CandidateFit> {
    let own = scores.iter().find(|w| w.spec.is_base_sinusoid())?;
    let held = |t: &CandidateFit| t.held_out.is_none() || t.held_gain > HELD_GAIN;
    let trial = own.fit.as_ref();
    trial.filter(|t| held(t) && !t.is_insignificant()).cloned()
}

/// Whether the `vibration` of the base explains the data as well as `ringing`, a mode that rings
/// by itself.
pub fn explains_as_well(vibration: &CandidateFit, ringing: &CandidateFit) -> bool {
    vibration.worth() > STEADY_VIBRATION_SHARE * ringing.worth()
}

/// Whether the residuals of `state` contain, on both splits, a ring at `frequency` \[Hz\] in phase
/// with impacts and jumps of the drive that is not too small a part of the gain of `trial`.
fn is_driven(
    workspace: &Workspace,
    state: &ModelState,
    trial: &CandidateFit,
    frequency: f64,
) -> Result<bool, SimError> {
    let near = |side: &Split, fitted: &Fitted| -> Result<f64, SimError> {
        let ring = ImpactExcitations::new(side, fitted)?
            .best_near(frequency, FREQUENCY_TOLERANCE * frequency);
        Ok(ring.map_or(0.0, |ring| ring.gain))
    };
    let train = near(&workspace.train, &state.train)?;
    let held_out = match (&workspace.held_out, &state.held_out) {
        (Some(side), Some(fitted)) => Some(near(side, fitted)?),
        _ => None,
    };
    log::debug!(
        "in phase with its excitation {train:.1} of {:.1}, held out {held_out:?} of {:.1}",
        trial.gain,
        trial.held_gain
    );
    Ok(train
        > EXCITED_RING_MIN_GAINS
            .0
            .max(EXCITED_RING_MIN_SHARE * trial.gain)
        && held_out.is_none_or(|gain| {
            gain > EXCITED_RING_MIN_GAINS
                .1
                .max(EXCITED_RING_MIN_SHARE * trial.held_gain)
        }))
}
