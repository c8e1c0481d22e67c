//! Films that a search starts from: weak ones of several thicknesses. Strength and thickness
//! compensate each other along a curved valley of the cost, and a film that is too strong would
//! hold the mass where it is.

use crate::model::Model;

/// Thicknesses of the film at contact that are tried, as shares of `dp`.
pub(crate) const START_GAP_SHARES: [f64; 3] = [0.15, 0.05, 0.5];
/// Damping by the film at contact at first, as a share of the slowest mode's frequency.
const START_DAMPING_SHARE: f64 = 0.1;

/// Coefficient at contact, `Cs / (gp - dp)^3`, of a film that hardly damps \[N s/m\].
pub(crate) fn weak_film(model: &Model) -> f64 {
    let structure = model.structure();
    let modes = structure.modes.iter().map(|m| m.omega());
    let slowest = modes.fold(f64::INFINITY, f64::min).max(1.0);
    START_DAMPING_SHARE * slowest / structure.mobility()
}
