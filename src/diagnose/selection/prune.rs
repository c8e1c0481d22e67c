//! Backward elimination: effects that a later one has made superfluous.

use super::refit::refit;
use crate::diagnose::comparison::significance::is_insignificant;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    CLEARLY_NEEDED_RATIO, CONFIRMING_HELD_GAIN, HELD_GAIN, OWN_MODE_FREQUENCY_SHARE, TRAIN_GAIN,
    UNFORESEEN_GAIN_RATIO,
};
use crate::model::Model;
use crate::model::effects::ActiveEffect;

/// Whether a further mode in `model` lies near one of the device's own.
fn is_near_own_mode(model: &Model) -> bool {
    let near = |f: f64| {
        let own = ["f1", "f2"]
            .iter()
            .filter(|id| **id == "f1" || model.has_cantilever);
        own.filter_map(|id| model.get(id))
            .any(|own| (f - own).abs() < OWN_MODE_FREQUENCY_SHARE * own)
    };
    let frequency = |e: &ActiveEffect| Some(e.values[e.spec.facts.modes?.frequency]);
    model.effects.iter().find_map(frequency).is_some_and(near)
}

/// Removes effects that a later one has made superfluous, and the latest one if it only continued
/// where the fit before it had stopped.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn backward_eliminate(
    workspace: &Workspace,
    state: &mut ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    let mut k = 0;
    while k < state.named.len() {
        if control.cancelled() {
            break;
        }
        // The latest one is tested where it brought little, or far more than predicted:
        // the fit before it may have stopped early.
        let n = &state.named[k];
        let stands_in = n.spec.adds_modes() && is_near_own_mode(&state.train.model);
        let foreseen = !stands_in && n.gain.0 < UNFORESEEN_GAIN_RATIO * n.hypothesis.predicted_gain;
        if k + 1 == state.named.len() && foreseen && n.gain.0 > CLEARLY_NEEDED_RATIO * TRAIN_GAIN {
            break;
        }
        // Each was the best of its round: removing it would lose at least what the next
        // ones brought.
        let latest = state.named.last().map_or(0.0, |n| n.gain.0);
        let own = state.named[k].gain.0;
        let later = state.named[k].hypothesis.estimated_on_held_out.is_some();
        if later
            || latest > CLEARLY_NEEDED_RATIO * TRAIN_GAIN && own > CLEARLY_NEEDED_RATIO * latest
        {
            k += 1;
            continue;
        }
        let mut without = state.clone();
        let dropped = without.named.remove(k);
        let mut start: Model = state.train.model.clone();
        start.effects.retain(|e| e.spec != dropped.spec);
        let Some((train, held_out)) = refit(workspace, &start, &without, state, control)? else {
            k += 1;
            continue;
        };
        let lost = train.cost - state.train.cost;
        let held_lost = match (&held_out, &state.held_out) {
            (Some(after), Some(before)) => after.cost - before.cost,
            _ => HELD_GAIN,
        };
        if is_insignificant(&dropped.hypothesis, lost, held_lost)
            || held_lost < CONFIRMING_HELD_GAIN
        {
            without.train = train;
            without.held_out = held_out;
            *state = without;
        } else {
            k += 1;
        }
    }
    Ok(())
}
