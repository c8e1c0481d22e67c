//! The distance of a given model from recordings, as the proof measures it.

use super::proof::distance_of;
use crate::diagnose::data::screening::screen;
use crate::diagnose::diagnosis::Distance;
use crate::diagnose::discrepancy::residual_map;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::shooting::clock_skew::{fitted_skews, median_skew};
use crate::diagnose::shooting::workspace::Workspace;
use crate::fit::Part;
use crate::model::Model;

/// How far a model is from one recording between its impacts.
#[derive(Debug, Clone, PartialEq)]
pub struct StretchMisfit {
    /// Distance over all its stretches.
    pub distance: Distance,
    /// Noise of the proof mass's reading \[m\], as common to all recordings as the data allow.
    pub noise: f64,
    /// Samples that are compared.
    pub samples: usize,
}

/// Distances of `model`, its parameters held, from `parts`, in their order: over the stretches
/// between contact events, each from a free initial state, with clocks and offsets estimated. The
/// same as the proof's of a diagnosed model on the same recordings.
///
/// # Errors
/// [`DiagnoseError`] if a recording or the model cannot be used.
pub fn evaluate(
    model: &Model,
    parts: &[Part],
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
) -> Result<Vec<StretchMisfit>, DiagnoseError> {
    let screened = screen(model, parts, &[])?;
    let workspace = Workspace::new(model, &screened.train, &[], options)?;
    let mut fitted = workspace.fit_states(&workspace.train, model, 0.0, control)?;
    // A short recording does not tell its clock by itself: it starts from that of most.
    let clocks = median_skew(&fitted.problem, &fitted.point);
    let again = workspace.fit_states(&workspace.train, model, clocks, control)?;
    if again.cost < fitted.cost {
        fitted = again;
    }
    log::debug!("clocks {:?}", fitted_skews(&fitted.problem, &fitted.point));
    let samples = residual_map::samples(&fitted)?;
    let one = |(k, data): (usize, &crate::fit::problem::Data)| {
        let own: Vec<_> = samples
            .iter()
            .filter(|s| s.recording == k)
            .copied()
            .collect();
        StretchMisfit {
            distance: distance_of(&own),
            noise: data.sigmas.xp,
            samples: own.iter().filter(|s| s.miss_p.is_finite()).count(),
        }
    };
    Ok(fitted.problem.data.iter().enumerate().map(one).collect())
}
