//! Mismatch of whole runs: recordings simulated from one start to their end. Stretches start anew
//! every few periods, which hides what adds up from each to the next, such as a small loss or a
//! frequency that depends on the amplitude.

use rayon::prelude::*;

use super::segment_joins::joined;
use crate::diagnose::data::robust_loss::LEAST_SQUARES;
use crate::diagnose::shooting::fitted::Fitted;
use crate::fit::segment::Segment;
use crate::sim::SimError;

/// Iterations of the fit of a run's start.
const START_FIT_STEPS: usize = 8;

/// Sum of squares of each recording, in units of the noise, beyond that of noise alone, from its best
/// start. `None` for one that is not one uninterrupted flight: impacts make later motion a matter of
/// chance.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn excess_chi2(fitted: &Fitted) -> Result<Vec<Option<f64>>, SimError> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let one = |k: usize| -> Option<f64> {
        let run = uninterrupted(&point.segments, k)?;
        let first = point.segments.iter().position(|s| s.recording == k)?;
        let nuisances = problem.nuisances_of(&point.x, k);
        let refined = problem.refine(
            &run,
            &states[first],
            &simulator,
            &nuisances,
            run.locals.clone(),
            LEAST_SQUARES,
            START_FIT_STEPS,
        );
        let values = refined.residuals.len().saturating_sub(run.locals.len());
        let excess = (refined.cost - values as f64).max(0.0);
        excess.is_finite().then_some(excess)
    };
    Ok((0..problem.data.len()).into_par_iter().map(one).collect())
}

/// All segments of recording `k` as one, if nothing happens between or within them.
fn uninterrupted(segments: &[Segment], k: usize) -> Option<Segment> {
    let mut own = segments.iter().filter(|s| s.recording == k);
    let mut run = own.next().filter(|s| flies_free(s))?.clone();
    for next in own {
        if !flies_free(next) || next.samples.start != run.samples.end {
            return None;
        }
        run = joined(&run, next);
    }
    Some(run)
}

fn flies_free(segment: &Segment) -> bool {
    !segment.starts_held && segment.joints.is_empty()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::whole_runs::*;
    use crate::diagnose::options::DiagnoseOptions;
    use crate::diagnose::shooting::workspace::Workspace;
    use crate::diagnose::test_support::{self, QUIET};
    use crate::fit::Part;
    use crate::model::preset::Preset;
    use crate::recording::Recording;

    /// Excess of a ring-down of 60 s, read with an error of 0.1 mm that looks like chance, whose
    /// frequency rises with the square of the amplitude by this share.
    fn of_a_ring_down(hardening: f64) -> f64 {
        let (omega, zeta): (f64, f64) = (8.6, 2e-3);
        let (mut phase, interval) = (0.0, 0.01);
        let mut x = Vec::new();
        for i in 0..6000 {
            let amplitude = (-zeta * omega * interval * f64::from(i)).exp();
            phase += interval * omega * (1.0 + hardening * amplitude * amplitude);
            let spread = (f64::from(i) * 12.9898).sin() * 43758.5453;
            x.push(0.1 * amplitude * phase.cos() + 3.4e-4 * (spread - spread.floor() - 0.5));
        }
        let time = (0..6000).map(|i| interval * f64::from(i)).collect();
        let part = Part::whole(Arc::new(
            Recording::new("ring-down", time, None, x, None).unwrap(),
        ));
        let model = Preset::embedded("oscillator").unwrap().model;
        let workspace = Workspace::new(&model, &[part], &[], &DiagnoseOptions::default()).unwrap();
        let fitted = workspace.baseline(&model, &QUIET).unwrap();
        excess_chi2(&fitted).unwrap()[0].unwrap()
    }

    #[test]
    fn a_frequency_that_depends_on_the_amplitude_adds_up_over_a_run() {
        let right = of_a_ring_down(0.0);
        assert!(right < 3000.0, "{right}");
        let hardening = of_a_ring_down(5e-3);
        assert!(hardening > 30.0 * right.max(1000.0), "{right} {hardening}");
    }

    #[test]
    fn recordings_with_contacts_have_no_whole_run() {
        let paper = Preset::embedded("paper").unwrap().model;
        let workspace =
            test_support::workspace_of(&paper, &[("square:40Hz:8V", 0.06)], 25e3, 20e-9);
        let fitted = workspace.baseline(&paper, &QUIET).unwrap();
        assert_eq!(excess_chi2(&fitted).unwrap(), [None]);
    }
}
