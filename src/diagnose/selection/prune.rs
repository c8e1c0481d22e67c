//! Names that a later one has made needless.

use super::refit::refit;
use crate::diagnose::comparison::significance::is_insignificant;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError};
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    CLEARLY_NEEDED_RATIO, HELD_GAIN, OWN_MODE_FREQUENCY_SHARE, TRAIN_GAIN, UNFORESEEN_GAIN_RATIO,
};
use crate::model::Model;

/// Whether a further mode in `model` lies so near one of the device's own.
fn is_near_own_mode(model: &Model) -> bool {
    let near = |f: f64| {
        let own = ["f1", "f2"]
            .iter()
            .filter(|id| **id == "f1" || model.has_cantilever);
        own.filter_map(|id| model.get(id))
            .any(|own| (f - own).abs() < OWN_MODE_FREQUENCY_SHARE * own)
    };
    model.get("extra_mode.f").is_some_and(near)
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
        let stands_in = n.spec.id == "extra_mode" && is_near_own_mode(&stand.train.model);
        let foreseen = !stands_in && n.gain.0 < UNFORESEEN_GAIN_RATIO * n.hypothesis.predicted_gain;
        if k + 1 == stand.named.len() && foreseen && n.gain.0 > CLEARLY_NEEDED_RATIO * TRAIN_GAIN {
            break;
        }
        // Each was the best of its round: without it at least what the next ones brought
        // would be lost.
        let latest = stand.named.last().map_or(0.0, |n| n.gain.0);
        let own = stand.named[k].gain.0;
        let later = stand.named[k].hypothesis.estimated_on_held_out.is_some();
        if later
            || latest > CLEARLY_NEEDED_RATIO * TRAIN_GAIN && own > CLEARLY_NEEDED_RATIO * latest
        {
            k += 1;
            continue;
        }
        let mut without = stand.clone();
        let dropped = without.named.remove(k);
        let mut start: Model = stand.train.model.clone();
        start.effects.retain(|e| e.spec != dropped.spec);
        let Some((train, held_out)) = refit(workspace, &start, &without, stand, control)? else {
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
