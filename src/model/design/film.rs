//! The gas film under a rectangular plate, by Reynolds' equation.

use std::f64::consts::PI;

use super::error::{DesignError, positive};

/// Odd terms of the series; the tenth is below 1e-6 of the first.
const SERIES_TERMS: usize = 10;

/// `Cs` [N m^2 s] of a plate of two sides \[m\] in a gas of `viscosity` [Pa s]: the force of the
/// incompressible film is `F = -Cs v / h^3`, with
/// `Cs = mu a b^3 (1 - 192/pi^5 (b/a) sum tanh(n pi a / (2 b)) / n^5)` over odd `n`, `b` the shorter
/// side (M. Bao, H. Yang, Sens. Actuators A 136 (2007) 3, eq. 24).
///
/// # Errors
/// [`DesignError::Value`] for a side or viscosity that is not above 0.
///
/// # Examples
/// ```
/// use impactscope::model::design::{AIR_VISCOSITY, plate_film_coefficient};
///
/// // The paper's plate; a long one is a strip with Cs = mu a b^3.
/// let plate = plate_film_coefficient((150e-6, 100e-6), AIR_VISCOSITY)?;
/// assert!((plate / 1.5e-21 - 1.0).abs() < 0.1);
/// let strip = plate_film_coefficient((1.0, 1e-3), AIR_VISCOSITY)?;
/// assert!((strip / (AIR_VISCOSITY * 1e-9) - 1.0).abs() < 1e-3);
/// # Ok::<(), impactscope::model::design::DesignError>(())
/// ```
pub fn plate_film_coefficient(sides: (f64, f64), viscosity: f64) -> Result<f64, DesignError> {
    positive("plate", sides.0, "m")?;
    positive("plate", sides.1, "m")?;
    positive("viscosity", viscosity, "Pa s")?;
    let (long, short) = (sides.0.max(sides.1), sides.0.min(sides.1));
    let term = |i: usize| {
        let n = (2 * i + 1) as f64;
        (n * PI * long / (2.0 * short)).tanh() / n.powi(5)
    };
    let series: f64 = (0..SERIES_TERMS).map(term).sum();
    let share = 1.0 - 192.0 / PI.powi(5) * short / long * series;
    Ok(viscosity * long * short.powi(3) * share)
}
