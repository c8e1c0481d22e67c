//! Which parameters the re-tuning of the baseline may move, and how far.

use super::fitted::Bound;
use crate::diagnose::thresholds::KNOWN_MAX_Z;
use crate::model::Model;
use crate::model::preset::known_value::KnownValue;

/// Largest factor by which a mode's frequency may be off.
const MAX_FREQUENCY_FACTOR: f64 = 1.5;
/// Largest factor by which a mode's damping may be off.
const MAX_DAMPING_FACTOR: f64 = 20.0;
/// A damping ratio may always reach this value, whatever its nominal one.
const MIN_DAMPING_BOUND: f64 = 0.3;
/// Largest factor by which a mode's shape may be off.
const MAX_SHAPE_FACTOR: f64 = 3.0;

/// Ids of the parameters that re-tuning may move if nothing else is chosen: those of the baseline that
/// event-free segments determine, and how the readings and the drive take part in the modes. What
/// effects the model has already is held: a missing force must not hide in them.
pub(crate) fn free_parameters(model: &Model, lone: bool) -> Vec<String> {
    use crate::model::parameter::ParameterId as P;
    let own = [
        P::Eta,
        P::Dp,
        P::Zeta1,
        P::Zeta2,
        P::Cs,
        P::Gp,
        P::F1,
        P::F2,
        P::ShapeC1,
        P::ShapeC2,
        P::ShapeP2,
        P::DriveP,
    ];
    // Without the cantilever's reading its shapes are not determined.
    let seen = |p: &P| !lone || !matches!(p, P::ShapeC1 | P::ShapeC2 | P::ShapeP2);
    own.into_iter()
        .filter(|p| model.uses(*p) && seen(p))
        .filter(|p| *p != P::F1 || model.parameters[P::F1] > 0.0)
        .map(|p| p.spec().id.to_owned())
        .collect()
}

/// Bounds of the structure's parameters. A structure that may become any other would absorb what
/// is missing, or move to modes that no reading could show.
pub(crate) fn structure_bounds(model: &Model) -> Vec<Bound> {
    use crate::model::parameter::ParameterId as P;
    let near = |id: P, factor: f64| {
        let value = model.parameters[id];
        (id.spec().id.to_owned(), (value / factor, value * factor))
    };
    let frequencies = [P::F1, P::F2].map(|id| near(id, MAX_FREQUENCY_FACTOR));
    let dampings = [P::Zeta1, P::Zeta2].map(|id| {
        let (id, (least, most)) = near(id, MAX_DAMPING_FACTOR);
        (id, (least, most.max(MIN_DAMPING_BOUND)))
    });
    // Shapes may have either sign: so may the drive's share in a mode.
    let shapes = [P::ShapeC1, P::ShapeC2, P::ShapeP2].map(|id| {
        let most = MAX_SHAPE_FACTOR * model.parameters[id].abs();
        (id.spec().id.to_owned(), (-most, most))
    });
    frequencies
        .into_iter()
        .chain(dampings)
        .chain(shapes)
        .collect()
}

/// Bounds of what is known beforehand: a missing force must not hide in a value that is known not to
/// be so.
pub(crate) fn known_bounds(known: &[KnownValue]) -> impl Iterator<Item = Bound> {
    known.iter().map(|k| {
        let most = KNOWN_MAX_Z * k.std_error;
        (k.id.clone(), (k.value - most, k.value + most))
    })
}
