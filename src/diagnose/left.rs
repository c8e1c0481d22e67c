//! What is not explained: by the mean square of what is left, by forces without a name, by single
//! stretches, by a flight that does not go on, or by what improves the fitted recordings alone.

use super::bench::Fitted;
use super::continuity::{Breaks, joins};
use super::evidence::Evidence;
use super::explain::{Stand, Trial, Weighed};
use super::options::DiagnoseError;
use super::refusal::CARRIED;
use super::result::Left;
use super::{kin, locate};

/// Fall of chi2 by forces without a name from which something is left.
const NAMELESS: f64 = 60.0;
/// A single stretch this far above the others, in units of what chance leaves.
const LOCAL: f64 = 8.0;
/// Chi2 per value from which recordings are far off.
const FAR: f64 = 3.0;
/// Standard deviations by which the flight does not go on from stretch to stretch from which
/// something is left.
pub const BROKEN: f64 = 6.5;

/// Chi2 above the floor, all together.
pub fn excess(fitted: &Fitted) -> f64 {
    let rows = fitted.point.rows as f64;
    (fitted.cost - 1.03 * rows).max(0.0)
}

/// Whether the effects named leave the fitted recordings so far off that so many `more`, each as
/// good as the best of them, would not carry what is missing, nor would laws of other form.
///
/// # Errors
/// [`DiagnoseError`] if the model makes no sense.
pub fn is_beyond(stand: &Stand, more: usize) -> Result<bool, DiagnoseError> {
    let gains = stand.named.iter().map(|n| n.gain.0);
    let best = gains.clone().fold(0.0, f64::max);
    let rest = excess(&stand.train);
    let whole = gains.clone().sum::<f64>() + rest;
    let carried = gains.sum::<f64>() + more as f64 * best;
    let far = !stand.misread && stand.train.per_value() > FAR;
    if stand.named.is_empty() || !far || carried > CARRIED * whole {
        return Ok(false);
    }
    let formal = kin::gain(&stand.train, &stand.specs())?;
    log::debug!(
        "named so far carry {:.0} of {whole:.0}, their kin {formal:.0}",
        whole - rest
    );
    Ok(carried + formal < CARRIED * whole)
}

/// What is not explained yet, if there is anything.
pub fn whats_left(stand: &Stand, evidence: &Evidence, broken: f64, floor: f64) -> Option<Left> {
    let worst = stand
        .held_out
        .iter()
        .map(Fitted::per_value)
        .fold(stand.train.per_value(), f64::max);
    log::debug!(
        "worst {worst:.4}, joint {:.1} by {:?}, broken {broken:.1}",
        evidence.joint,
        evidence.strongest
    );
    if worst > floor {
        return Some(Left::Mean(worst));
    }
    if evidence.joint > NAMELESS {
        let what = evidence.strongest.map_or("state", |s| s.0.symbol());
        return Some(Left::Force(what, evidence.joint));
    }
    let local = locate::most_local(&stand.train)
        .max(stand.held_out.as_ref().map_or(0.0, locate::most_local));
    if local > LOCAL {
        return Some(Left::Stretch(local));
    }
    (broken > BROKEN).then_some(Left::Joins(broken))
}

/// What improves the fitted recordings by far more than chance, and those kept out not at all.
pub fn unproved(weighed: &[Weighed]) -> Option<Left> {
    let trials = weighed.iter().filter_map(|w| Some((w, w.trial.as_ref()?)));
    let of = |(w, t): (&Weighed, &Trial)| {
        log::debug!("{}: {:.0}, {:.0} kept out", w.spec.id, t.gain, t.held_gain);
        t.unproved().then_some((w.spec.name, t.gain))
    };
    let most = trials.filter_map(of).max_by(|a, b| a.1.total_cmp(&b.1));
    most.map(|(name, gain)| Left::Unproved(name, gain))
}

/// By how much the flight of both sides does not go on from stretch to stretch.
pub fn breaks(stand: &Stand) -> Result<Breaks, DiagnoseError> {
    let train = joins(&stand.train)?;
    let Some(held) = &stand.held_out else {
        return Ok(train);
    };
    let held = joins(held)?;
    Ok(Breaks {
        sigmas: (train.sigmas + held.sigmas) / std::f64::consts::SQRT_2,
        rise: train.rise + held.rise,
    })
}
