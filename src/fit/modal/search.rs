//! Modes one by one, as long as each gains more than chance would.

use std::sync::Arc;
use std::time::Duration;

use super::error::ModalError;
use super::frequency_domain::search::{candidates, worst_local_excess};
use super::result::ModalOptions;
use super::sweeps::first_spectra;
use super::thresholds::{MAX_ZETA, MIN_MODE_GAIN};
use super::time_domain::data::Data;
use super::time_domain::kernel::Pole;
use super::time_domain::least_squares::{
    Effort, Linear, Setup, Solution, gain, refine, residuals, sigma_of, solve_linear,
};
use crate::fit::solve::levenberg_marquardt::{Control, Progress};
use crate::model::unit::format_quantity;

/// Starts that are tried for each further mode.
const STARTS: usize = 3;
/// What a start is refined with: near enough to tell which start is best.
const START_EFFORT: Effort = Effort {
    iterations: 15,
    least_gain: 1.0,
};
/// Two poles are the same up to this share of their width.
const SAME_POLE_SHARE: f64 = 0.1;

/// Tells how far the identification is: modes or rounds done of those at most, and what is left of the
/// readings in units of their noise.
pub(super) fn report(
    control: &Control<'_>,
    stage: &'static str,
    (done, most): (usize, usize),
    misfit: f64,
) {
    (control.progress)(&Progress {
        stage,
        iteration: done,
        expected: most,
        misfit,
        values: Vec::new(),
        remaining: Duration::ZERO,
        doubts: Arc::from(Vec::new()),
    });
}

/// What a fit leaves of the readings over their noise, of the worse one; 0 where no noise is known.
pub(super) fn misfit(linear: &Linear, noise: [Option<f64>; 2]) -> f64 {
    let ratio = |(sigma, noise): (f64, Option<f64>)| noise.filter(|n| *n > 0.0).map(|n| sigma / n);
    let ratios = sigma_of(linear).into_iter().zip(noise).filter_map(ratio);
    ratios.fold(0.0, f64::max)
}

/// Adds modes one by one, as long as each gains more than chance would.
pub(super) fn find_modes(
    data: &mut Data,
    band: (f64, f64),
    noise: [Option<f64>; 2],
    options: &ModalOptions,
    control: &Control<'_>,
) -> Result<Solution, ModalError> {
    let singular = || ModalError::Singular {
        reason: "the readings hold too few samples".to_owned(),
    };
    let empty = Setup {
        poles: &[],
        film_shares: &[],
    };
    let linear = solve_linear(&empty, data).ok_or_else(singular)?;
    let mut found = Solution {
        poles: Vec::new(),
        linear,
    };
    while found.poles.len() < options.max_modes {
        report(
            control,
            "modes of the sweep",
            (found.poles.len(), options.max_modes),
            misfit(&found.linear, noise),
        );
        let left = first_spectra(data, &residuals(data, &found, &[]));
        let mut best: Option<Solution> = None;
        for candidate in candidates(&left, band, STARTS) {
            let mut poles = found.poles.clone();
            poles.push(candidate.pole);
            let cancelled = || control.cancelled();
            let trial = refine(data, &poles, &[], false, START_EFFORT, &cancelled);
            if control.cancelled() {
                return Err(ModalError::Cancelled);
            }
            let is_better = |t: &Solution| {
                is_mode_of_its_own(t)
                    && best
                        .as_ref()
                        .is_none_or(|b| gain(&b.linear, &t.linear) > 0.0)
            };
            if let Some(trial) = trial.filter(is_better) {
                best = Some(trial);
            }
        }
        let Some(best) = best.filter(|b| is_significant(data, &found, b)) else {
            break;
        };
        found = best;
    }
    if found.poles.is_empty() {
        return Err(ModalError::NoMode {
            from: format_quantity(band.0, "Hz", 3),
            to: format_quantity(band.1, "Hz", 3),
        });
    }
    Ok(found)
}

/// Whether the last pole is a resonance, and none of the others again.
fn is_mode_of_its_own(found: &Solution) -> bool {
    let Some((new, others)) = found.poles.split_last() else {
        return false;
    };
    let is_double = |other: &Pole| {
        let width = SAME_POLE_SHARE * new.zeta.min(other.zeta);
        (new.omega / other.omega).ln().abs() < width
            && (new.zeta / other.zeta).ln().abs() < SAME_POLE_SHARE
    };
    !found.poles.iter().any(|p| p.zeta > MAX_ZETA) && !others.iter().any(is_double)
}

/// Whether the last pole of `better` gains more than chance.
fn is_significant(data: &Data, worse: &Solution, better: &Solution) -> bool {
    let Some(new) = better.poles.last() else {
        return false;
    };
    let readings = better.linear.rows.iter().filter(|r| **r > 0).count();
    let unknowns = 2 + readings * (1 + 2 * data.stretches.len());
    // Noise of one colour counts by what it has at the resonance.
    let left = first_spectra(data, &residuals(data, better, &[]));
    let excess = worst_local_excess(&left, *new);
    gain(&worse.linear, &better.linear) / excess > MIN_MODE_GAIN + unknowns as f64
}
