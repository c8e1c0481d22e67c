//! What is not explained: by the mean square of what is left, by forces without a name, by single
//! stretches, by a flight that does not go on, or by what improves the fitted recordings alone.

use crate::diagnose::comparison::trial::{CandidateFit, CandidateScore, ModelState};
use crate::diagnose::diagnosis::Inadequacy;
use crate::diagnose::discrepancy::missing_force::MissingForces;
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::discrepancy::segment_joins::{JoinBreaks, join_breaks};
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{ANY_FORCE_MIN_GAIN, JOINS_MAX_Z, SEGMENT_MAX_Z};

/// What is not explained yet, if there is anything.
pub fn whats_left(
    stand: &ModelState,
    evidence: &MissingForces,
    broken: f64,
    floor: f64,
) -> Option<Inadequacy> {
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
        return Some(Inadequacy::Mean(worst));
    }
    if evidence.joint > ANY_FORCE_MIN_GAIN {
        let what = evidence.strongest.map_or("state", |s| s.0.symbol());
        return Some(Inadequacy::Force(what, evidence.joint));
    }
    let local = residual_map::largest_segment_excess(&stand.train).max(
        stand
            .held_out
            .as_ref()
            .map_or(0.0, residual_map::largest_segment_excess),
    );
    if local > SEGMENT_MAX_Z {
        return Some(Inadequacy::Stretch(local));
    }
    (broken > JOINS_MAX_Z).then_some(Inadequacy::Joins(broken))
}

/// What improves the fitted recordings by far more than chance, and those kept out not at all.
pub fn fails_held_out(weighed: &[CandidateScore]) -> Option<Inadequacy> {
    let trials = weighed.iter().filter_map(|w| Some((w, w.trial.as_ref()?)));
    let of = |(w, t): (&CandidateScore, &CandidateFit)| {
        log::debug!("{}: {:.0}, {:.0} kept out", w.spec.id, t.gain, t.held_gain);
        t.fails_held_out().then_some((w.spec.name, t.gain))
    };
    let most = trials.filter_map(of).max_by(|a, b| a.1.total_cmp(&b.1));
    most.map(|(name, gain)| Inadequacy::Unproved(name, gain))
}

/// By how much the flight of both sides does not go on from stretch to stretch.
pub fn breaks(stand: &ModelState) -> Result<JoinBreaks, DiagnoseError> {
    let train = join_breaks(&stand.train)?;
    let Some(held) = &stand.held_out else {
        return Ok(train);
    };
    let held = join_breaks(held)?;
    Ok(JoinBreaks {
        sigmas: (train.sigmas + held.sigmas) / std::f64::consts::SQRT_2,
        rise: train.rise + held.rise,
    })
}

#[cfg(test)]
mod tests {
    use crate::diagnose::selection::stopping::falls_short;

    #[test]
    fn what_two_more_like_the_best_may_carry_is_looked_for() {
        assert!(!falls_short(&[100.0], 2, 200.0, 0.0));
        assert!(falls_short(&[50.0], 2, 250.0, 0.0));
        assert!(!falls_short(&[50.0], 2, 250.0, 100.0));
        // Fewer are left to be looked for, and less is left.
        assert!(falls_short(&[60.0, 30.0], 1, 150.0, 0.0));
        assert!(!falls_short(&[60.0, 30.0], 1, 80.0, 0.0));
        // Nothing has been found yet.
        assert!(!falls_short(&[], 3, 1e6, 0.0));
    }
}
