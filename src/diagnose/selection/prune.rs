//! Names that a later one has made needless.

use super::refit::refitted;
use crate::diagnose::comparison::significance::{HELD_GAIN, TRAIN_GAIN, is_insignificant};
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::workspace::Workspace;
use crate::model::Model;
use crate::model::effects::ActiveEffect;

/// An earlier effect that brought so many times more than a later one is not asked again
/// whether it is needed.
const SURE: f64 = 4.0;
/// Times its promise from which what an effect brought may be owed to the fit before it.
const UNFORESEEN: f64 = 4.0;

/// Share of a frequency of the device's own from which a further mode may only stand for a wrong
/// shape or damping of that one.
const NEAR: f64 = 0.05;

/// Whether a further mode in `model` lies so near one of the device's own.
fn beside_its_own(model: &Model) -> bool {
    let near = |f: f64| {
        let own = ["f1", "f2"]
            .iter()
            .filter(|id| **id == "f1" || model.has_cantilever);
        own.filter_map(|id| model.get(id))
            .any(|own| (f - own).abs() < NEAR * own)
    };
    let frequency = |e: &ActiveEffect| Some(e.values[e.spec.facts.modes?.frequency]);
    model.effects.iter().find_map(frequency).is_some_and(near)
}

/// Drops effects that a later one has made needless, and a latest one that only went on where
/// the fit before it had stopped.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn backward_eliminate(
    workspace: &Workspace,
    stand: &mut ModelState,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    let mut k = 0;
    while k < stand.named.len() {
        if control.cancelled() {
            break;
        }
        // The latest one is asked where it brought little, or far more than was promised: the fit
        // before may have stopped halfway, and this one have gone on for it.
        let n = &stand.named[k];
        let stands_in = n.spec.adds_modes() && beside_its_own(&stand.train.model);
        let foreseen = !stands_in && n.gain.0 < UNFORESEEN * n.hypothesis.predicted_gain;
        if k + 1 == stand.named.len() && foreseen && n.gain.0 > SURE * TRAIN_GAIN {
            break;
        }
        // Each was the best of its round: without it at least what the next ones brought
        // would be lost.
        let latest = stand.named.last().map_or(0.0, |n| n.gain.0);
        let own = stand.named[k].gain.0;
        let later = stand.named[k].hypothesis.estimated_on_held_out.is_some();
        if later || latest > SURE * TRAIN_GAIN && own > SURE * latest {
            k += 1;
            continue;
        }
        let mut without = stand.clone();
        let dropped = without.named.remove(k);
        let mut start: Model = stand.train.model.clone();
        start.effects.retain(|e| e.spec != dropped.spec);
        let Some((train, held_out)) = refitted(workspace, &start, &without, stand, control)? else {
            k += 1;
            continue;
        };
        let lost = train.cost - stand.train.cost;
        let held_lost = match (&held_out, &stand.held_out) {
            (Some(after), Some(before)) => after.cost - before.cost,
            _ => HELD_GAIN,
        };
        if is_insignificant(&dropped.hypothesis, lost, held_lost) || held_lost < 0.5 * HELD_GAIN {
            without.train = train;
            without.held_out = held_out;
            *stand = without;
        } else {
            k += 1;
        }
    }
    Ok(())
}
