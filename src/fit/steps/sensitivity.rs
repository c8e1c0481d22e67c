//! Step 5, sensitivity (Table 2): everything identified again with the contact distance
//! `dp` taken to be 20 um more, beside the original.

use crate::fit::{Control, FitError, FitOptions, FitResult, Part, fit};
use crate::model::Model;
use crate::model::parameter::ParameterId;

/// By how much `dp` is shifted [m].
pub const SHIFT: f64 = 20e-6;

/// The rows of Table 2.
pub const ROWS: [ParameterId; 5] = [
    ParameterId::Alpha,
    ParameterId::Ca,
    ParameterId::Ca0,
    ParameterId::Cs,
    ParameterId::Gp,
];

/// Both identifications.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    /// With `dp` as it is in the model.
    pub original: FitResult,
    /// With `dp` shifted.
    pub altered: FitResult,
}

/// Identifies twice. `dp` is kept fixed, the film is as thick at contact at the start, and
/// each reading's zero is free.
///
/// # Errors
/// [`FitError`] if the recordings do not allow it.
pub fn sensitivity(
    model: &Model,
    parts: &[Part],
    options: &FitOptions,
    control: &Control<'_>,
) -> Result<Sensitivity, FitError> {
    let mut options = options.clone();
    options.free.retain(|id| id != "dp");
    let original = fit(model, parts, &[], &options, control)?;
    let mut shifted = original.model.clone();
    for id in [ParameterId::Dp, ParameterId::Gp] {
        let value = shifted.parameters[id];
        shifted.parameters.set(id, value + SHIFT);
    }
    let altered = fit(&shifted, parts, &[], &options, control)?;
    Ok(Sensitivity { original, altered })
}
